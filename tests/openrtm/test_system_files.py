"""Files of the target openrtm for a system: scripts, RtsProfile, conf files."""

from __future__ import annotations

import runpy
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import black
import pytest
from rts_rules import broken_rules

from rtgen.cli import run
from rtgen.compiler.frontends.profiles import rts_profile
from rtgen.compiler.model import System
from rtgen.runtime.openrtm import systems
from rtgen.runtime.openrtm.systems import Client, StartError

ROOT = Path(__file__).resolve().parents[2]
SOURCES = {
    path.stem: path
    for path in ROOT.glob("specs/*/*.xml")
    if b"RtsProfile" in path.read_bytes()[:2000]
}


def read(path: Path) -> System:
    result = rts_profile.load(path)
    assert result.diagnostics == ()
    assert result.system is not None
    return result.system


def of_script(reference: Path, name: str) -> systems.System:
    """Return the system in a connect.py."""
    made = runpy.run_path(str(reference / "openrtm" / name / "connect.py"))
    system = made["SYSTEM"]
    assert isinstance(system, systems.System)
    return system


@pytest.mark.parametrize("name", SOURCES)
def test_the_profile_keeps_the_rules_and_says_the_same(
    reference: Path, name: str
) -> None:
    file = reference / "openrtm" / name / f"{name}.xml"
    assert broken_rules(file.read_text(encoding="utf-8")) == []
    made, source = read(file), read(SOURCES[name])
    assert [(c.instance, c.id, c.configuration) for c in made.components] == [
        (c.instance, c.id, c.configuration) for c in source.components
    ]
    possible = [c for c in source.connections if "rtgen.own_port" not in c.places]
    assert sorted(c.name for c in made.connections) == sorted(c.name for c in possible)
    assert {s.instance for s in made.activation} == {
        c.instance for c in made.components
    }


@pytest.mark.parametrize("name", SOURCES)
def test_the_script_says_what_the_profile_says(reference: Path, name: str) -> None:
    script = of_script(reference, name)
    profile = read(reference / "openrtm" / name / f"{name}.xml")
    assert [i.name for i in script.instances] == [
        s.instance for s in profile.activation
    ]
    assert sorted((c.name, c.source, c.target) for c in script.connections) == sorted(
        (c.name, str(c.source), str(c.target)) for c in profile.connections
    )
    known = {c.name: dict(c.properties) for c in profile.connections}
    for connection in script.connections:
        assert dict(connection.properties) == known[connection.name]
    ids = {c.name: c.id for c in profile.connections}
    assert {c.name: c.id or c.name for c in script.connections} == ids
    rates = {c.instance: c.rate for c in profile.components}
    assert {i.name: i.rate for i in script.instances} == rates


def test_ports_have_openrtm_s_names(reference: Path) -> None:
    script = of_script(reference, "rh3_goal")
    ends = {c.target: c.source for c in script.connections}
    assert ends["PositionInput0.status"] == "OmniTo2WD0.status_out"
    assert ends["OmniTo2WD0.goal"] == "PositionInput0.positon"


@pytest.mark.sampled(0)
def test_a_system_saved_by_openrtm_s_tools_runs(
    reference: Path, tmp_path: Path
) -> None:
    """They save OpenRTM's names of ports, sets for tools, and types of both ends."""
    emitted = reference / "openrtm/rh3_goal/rh3_goal.xml"
    text = emitted.read_text(encoding="utf-8")
    types = "".join(
        f'<rtsExt:Properties rtsExt:name="dataport.{end}.data_type" '
        'rtsExt:value="IDL:any:1.0"/>'
        for end in ("inport", "outport")
    )
    text = text.replace(
        "</rts:DataPortConnectors>", f"{types}</rts:DataPortConnectors>"
    )
    sets = "".join(
        f'<rts:ConfigurationSets rts:id="__{name}__"><rts:ConfigurationData '
        f'rts:name="any" rts:data="x>0"/></rts:ConfigurationSets>'
        for name in ("widget", "constraints", "type")
    )
    text = text.replace("<rts:ExecutionContexts", f"{sets}<rts:ExecutionContexts")
    for conf in emitted.parent.glob("*.conf"):
        (tmp_path / conf.name).write_bytes(conf.read_bytes())
    (tmp_path / "saved.xml").write_text(text, encoding="utf-8")
    tracks = []
    for file in (tmp_path / "saved.xml", SOURCES["rh3_goal"]):
        track = tmp_path / "track.csv"
        assert run(["run", str(file), "--until", "3", "--csv", str(track), "-q"]) == 0
        tracks.append(track.read_text())
    assert tracks[0] == tracks[1]
    assert len(set(tracks[0].split())) > 100
    command = ["generate", "specs/navigation", str(tmp_path / "saved.xml")]
    of_script = run(
        [*command, "--target", "openrtm", "-o", str(tmp_path / "out"), "-q"]
    )
    assert of_script == 0
    made = read(tmp_path / "out/generated/openrtm/saved/saved.xml")
    assert {(str(c.source), str(c.target)) for c in made.connections} == {
        (str(c.source), str(c.target)) for c in read(emitted).connections
    }
    conf = (tmp_path / "out/generated/openrtm/saved/Odometry0.conf").read_text()
    assert "__widget__" not in conf


def test_connectors_of_poses_are_new_and_those_of_paths_flush(reference: Path) -> None:
    script = of_script(reference, "rh3_goal")
    found = {
        c.target: c.properties["dataport.subscription_type"] for c in script.connections
    }
    new = {end for end, subscription in found.items() if subscription == "new"}
    assert new == {
        "RefHardRh30.InTargetVelocity",
        "Odometry0.CurrentWheelAngle",
        "OmniTo2WD0.current_position",
        "Navigation0.position",
        "PathFollower0.position",
    }
    assert set(found.values()) == {"new", "flush"}
    for connection in script.connections:
        assert connection.properties["dataport.buffer.read.empty_policy"] == "readback"


def test_providers_are_activated_before_those_that_call_them(reference: Path) -> None:
    order = [i.name for i in of_script(reference, "rh3_board").instances]
    assert order.index("OpaqueRpcCommunication0") < order.index("MotorBoardMarshaller0")
    profile = read(reference / "openrtm" / "rh3_board" / "rh3_board.xml")
    steps = {s.instance: s for s in profile.activation}
    assert "OpaqueRpcCommunication0" in steps["MotorBoardMarshaller0"].after


def test_service_connectors_are_strict_and_name_their_pairs(reference: Path) -> None:
    [connection] = [
        c
        for c in of_script(reference, "rh3_board").connections
        if c.target == "OpaqueRpcCommunication0.service"
    ]
    assert connection.properties == {
        "port.connection.strictness": "strict",
        "MotorBoardMarshaller0.port.communication.required.OpaqueRpc.communication": (
            "OpaqueRpcCommunication0.port.service.provided.OpaqueRpc.communication"
        ),
    }


def test_the_conf_file_has_rate_values_and_what_stands_beside_the_system(
    reference: Path,
) -> None:
    folder = reference / "openrtm" / "rh3_goal"
    odometry = (folder / "Odometry0.conf").read_text(encoding="utf-8")
    assert "\nexec_cxt.periodic.rate: 100.0\n" in odometry
    assert "\nconf.default.lengthOfAxle: 0.464\n" in odometry
    position_input = (folder / "PositionInput0.conf").read_text(encoding="utf-8")
    assert "\nconf.default.01_th: -1.57\n" in position_input


def test_what_a_scale_of_the_rates_changes(reference: Path) -> None:
    [follower] = [
        i
        for i in of_script(reference, "rh3_goal").instances
        if i.name == "PathFollower0"
    ]
    assert follower.per_cycle == {
        "control_cycle": 0.001,
        "max_acc_v": 0.0003,
        "max_acc_w": 0.1,
    }


def test_scripts_can_be_read(reference: Path) -> None:
    for name in SOURCES:
        folder = reference / "openrtm" / name
        for script in ("start.sh", "stop.sh"):
            subprocess.run(["sh", "-n", str(folder / script)], check=True)
        text = (folder / "connect.py").read_text(encoding="utf-8")
        assert black.format_str(text, mode=black.Mode()) == text


def test_a_folder_s_system_has_the_folder_s_name_and_odd_names_are_quoted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "demo.idl").write_text(
        'struct S { long x; };\n@rtc(category="a b", vendor="v")\n'
        "component C { publishes S made; attribute string text; };\n",
        encoding="utf-8",
    )
    folder = tmp_path / "two words"
    folder.mkdir()
    (folder / "system.xml").write_text(
        '<rts:RtsProfile rts:id="RTSystem:v:s:1" '
        'xmlns:rts="http://www.openrtp.org/namespaces/rts">'
        '<rts:Components rts:id="RTC:v:a b:C:1.0.0" rts:instanceName="it\'s $(x)">'
        '<rts:ConfigurationSets rts:id="default">'
        '<rts:ConfigurationData rts:name="text" rts:data="C:\\a&#10;b"/>'
        "</rts:ConfigurationSets></rts:Components></rts:RtsProfile>",
        encoding="utf-8",
    )
    told_ = ["generate", "demo.idl", "two words", "--target", "openrtm", "-q"]
    assert run(told_) == 0
    made = tmp_path / "generated/openrtm/two words"
    script = (made / "start.sh").read_text(encoding="utf-8")
    subprocess.run(["sh", "-n", str(made / "start.sh")], check=True)
    assert "start 'it'\"'\"'s $(x)' C " in script
    [instance] = runpy.run_path(str(made / "connect.py"))["SYSTEM"].instances
    assert instance.name == "it's $(x)"
    assert instance.configuration == {"default": {"text": "C:\\a\nb"}}
    assert run(["check", "demo.idl", "two words", "--target", "openrtm", "-q"]) == 0
    (made / "run").mkdir()
    (made / "run" / "it.pid").write_text("1")
    assert run(["check", "demo.idl", "two words", "--target", "openrtm", "-q"]) == 0


def component_with(*names: str) -> Any:
    ports = [
        SimpleNamespace(get_port_profile=lambda n=name: SimpleNamespace(name=n))
        for name in names
    ]
    return SimpleNamespace(get_ports=lambda: ports)


@pytest.mark.parametrize(
    ("known", "end", "found"),
    [
        (["A0.in", "A0.out"], "A0.out", 1),
        (["A0.out", "A0..out"], "A0..out", 1),
        (["A0.other", "A0.positon"], "A0..positon", 1),
        (["in", ".positon"], "A0..positon", 1),
    ],
)
def test_ports_are_found_by_whatever_openrtm_calls_them(
    known: list[str], end: str, found: int
) -> None:
    client = Client.__new__(Client)
    component = component_with(*known)
    client._components = {"A0": component}
    assert client._port(end) is component.get_ports()[found]
    with pytest.raises(StartError, match="A0 has the ports"):
        client._port("A0.never")


@pytest.mark.parametrize("code", ["RTC_OK", "RTC_ERROR", "PRECONDITION_NOT_MET"])
def test_a_failed_activation_has_its_reason_whatever_openrtm_answers(
    tmp_path: Path, code: str
) -> None:
    """OpenRTM returns PRECONDITION_NOT_MET once the component is in ERROR."""
    states = ["ERROR_STATE", "ERROR_STATE", "INACTIVE_STATE"]
    context = SimpleNamespace(get_component_state=lambda _: states.pop())
    client = Client.__new__(Client)
    client._rtc = SimpleNamespace(
        INACTIVE_STATE="INACTIVE_STATE",
        ACTIVE_STATE="ACTIVE_STATE",
        BAD_PARAMETER="BAD_PARAMETER",
    )
    client._openrtm = SimpleNamespace(activate=lambda _: code)
    client._components = {"A0": SimpleNamespace(get_owned_contexts=lambda: [context])}
    client._run = tmp_path
    client._timeout = 1.0
    (tmp_path / "A0.out").write_text("A0: on_activated: OSError: no paper\n")
    wanted = "A0 cannot be activated: it is in ERROR_STATE: A0: on_activated: OSError"
    with pytest.raises(StartError, match=wanted):
        client._activate("A0")


class CutPort:
    """A port whose next `cuts` connectors are removed as soon as they are made."""

    def __init__(self, name: str, cuts: int) -> None:
        self.name = name
        self.cuts = cuts
        self.made: list[str] = []
        self.connectors: list[Any] = []

    def get_port_profile(self) -> Any:
        return SimpleNamespace(name=self.name, interfaces=[])

    def get_connector_profiles(self) -> list[Any]:
        return self.connectors

    def _is_equivalent(self, other: Any) -> bool:
        return other is self

    def connect(self, profile: Any) -> tuple[str, Any]:
        self.made.append(profile.connector_id)
        self.cuts -= 1
        if self.cuts < 0:
            self.connectors.append(profile)
        return "RTC_OK", profile


def test_a_connector_that_is_removed_at_once_is_made_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An OutPort of OpenRTM removes, by its id, a connector that it could not write to."""
    out, inp = CutPort("A0.out", 1), CutPort("B0.in", 0)
    client = Client.__new__(Client)
    client._timeout = 5.0
    client._rtc = SimpleNamespace(
        RTC_OK="RTC_OK", PROVIDED="PROVIDED", REQUIRED="REQUIRED"
    )
    client._openrtm = SimpleNamespace(
        Properties=lambda: None,
        create_connector=lambda name, _, *ports: SimpleNamespace(
            name=name, ports=ports
        ),
    )
    client._components = {
        "A0": SimpleNamespace(get_ports=lambda: [out]),
        "B0": SimpleNamespace(get_ports=lambda: [inp]),
    }
    connection = systems.Connection("c", "A0.out", "B0.in", {})
    assert client._connect(connection) == []
    assert out.made == ["c", "c"]
    assert client._connect(connection) == []
    assert out.made == ["c", "c"]
    # Removed later: the last check of the connections makes it again.
    out.connectors.clear()
    monkeypatch.setattr(client, "_find", lambda _: None)
    monkeypatch.setattr(client, "_require_active", lambda _: out.connectors.clear())
    steps = list(client.start(systems.System("s", [], [connection])))
    assert steps[-1] == "ready"
    assert out.made == ["c"] * 4
    assert len(out.connectors) == 1
    out.connectors.clear()
    client._timeout, out.cuts = 0.01, 1000
    with pytest.raises(StartError, match="no connector although the call was answered"):
        client._connect(connection)


def joining(consumer: str, provider: str, **properties: str) -> list[str]:
    """Return the output of connect.py for two service ports with one interface each."""
    interfaces = {
        "A0.uses": ("REQUIRED", consumer),
        "B0.serves": ("PROVIDED", provider),
    }
    ports = []
    for name, (polarity, descriptor) in interfaces.items():
        type_name, _, instance_name = descriptor.rpartition(".")
        interface = SimpleNamespace(
            polarity=polarity, type_name=type_name, instance_name=instance_name
        )
        profile = SimpleNamespace(name=name, interfaces=[interface])
        ports.append(SimpleNamespace(get_port_profile=lambda p=profile: p))
    client = Client.__new__(Client)
    client._rtc = SimpleNamespace(PROVIDED="PROVIDED", REQUIRED="REQUIRED")
    client._components = {"A0": None, "B0": None}
    connection = systems.Connection("c", "A0.uses", "B0.serves", properties)
    return client._require_providers(connection, ports)


def test_a_consumer_that_would_stay_empty_is_reported() -> None:
    consumer = "A0.port.uses.required.MyService.s"
    provider = "B0.port.serves.provided.MyService.s"
    strict = {"port.connection.strictness": "strict"}
    assert joining("MyService.s", "MyService.s", **strict) == []
    assert joining("MyService.s", "MyService.s", **strict, **{consumer: provider}) == []
    other = "Simple::MyService.s"
    assert joining("MyService.s", other) == [consumer]
    with pytest.raises(StartError, match=rf"no provider: {consumer}; there are: B0"):
        joining("MyService.s", other, **strict)
    with pytest.raises(StartError, match=r"no provider B0.port.serves.provided.MyS"):
        joining("MyService.s", other, **{consumer: provider})
    with pytest.raises(StartError, match=r"no consumer A0.port.uses.required.MyS"):
        joining(other, "MyService.s", **{consumer: provider})
