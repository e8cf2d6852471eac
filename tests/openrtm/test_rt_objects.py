"""Components of the embedded runtime as RTObjects, beside those of OpenRTM, controlled by it."""

from __future__ import annotations

import ast
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from openrtm_lab import Lab, resolved
from patience import PATIENCE, until


class Process:
    """The process with rtgen's components; see `rt_object_process`."""

    def __init__(self, naming_service: str, folder: Path, log: Path) -> None:
        script = Path(__file__).with_name("rt_object_process.py")
        command = [sys.executable, str(script), naming_service, str(folder)]
        self._log = log
        with log.open("w") as errors:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        assert self._answer() == "ready", log.read_text()

    def __call__(self, expression: str) -> Any:
        """Return the value of an expression in the process."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{expression}\n")
        self._process.stdin.flush()
        answer = self._answer()
        assert answer, self.log
        return ast.literal_eval(answer)

    def _answer(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    @property
    def log(self) -> str:
        """The log of the process."""
        return self._log.read_text()

    def close(self) -> None:
        """End the process in order."""
        assert self._process.stdin is not None
        with self._process:
            self._process.stdin.close()
            assert self._process.wait(PATIENCE) == 0, self.log


@pytest.fixture(scope="module")
def process(
    manager: Any, naming_service: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Process]:
    folder = tmp_path_factory.mktemp("ours")
    made = Process(naming_service, folder, folder / "log.txt")
    yield made
    made.close()


@pytest.fixture
def there(process: Process, openrtm: str) -> Iterator[Process]:
    """Yield the process in its initial state, except for parameters."""
    assert process("ours.got.clear()") is None
    yield process
    process("[system.disconnect(c) for c in system.connectors]")
    process("system.deactivate('Ours0').name")
    until(lambda: not process("ours.is_active"))


def rt_object(lab: Lab, naming_service: str, name: str) -> Any:
    """Return a component as OpenRTM finds it."""
    import RTC

    naming = lab.rtm.CorbaNaming(lab.manager.getORB(), naming_service)
    found = naming.resolve(name)._narrow(RTC.RTObject)
    assert found is not None
    return found


def ports(component: Any) -> dict[str, Any]:
    """Return the port services of a component by their names."""
    return {
        port.get_port_profile().name.partition(".")[2]: port
        for port in component.get_ports()
    }


def texts(properties: Any) -> dict[str, str]:
    return {each.name: each.value.value() for each in properties}


def joined(lab: Lab, first: Any, second: Any, **properties: str) -> str:
    """Let OpenRTM connect two port services; give the id."""
    import RTC

    asked = lab.rtm.Properties()
    for key, value in properties.items():
        asked.setProperty("dataport." + key.replace("__", "."), value)
    before = {each.connector_id for each in first.get_connector_profiles()}
    assert lab.rtm.connect("wire", asked, first, second) == RTC.RTC_OK
    after = {each.connector_id for each in first.get_connector_profiles()}
    (found,) = after - before
    return str(found)


@pytest.fixture
def ours(there: Process, lab: Lab, naming_service: str) -> Any:
    """Return the component as OpenRTM sees it."""
    return rt_object(lab, naming_service, "Ours0.rtc")


def test_a_profile_has_what_the_component_has(ours: Any) -> None:
    profile = ours.get_component_profile()
    assert (profile.instance_name, profile.type_name) == ("Ours0", "Ours")
    assert (profile.category, profile.vendor) == ("tests", "labs")
    assert sorted(each.name for each in profile.port_profiles) == [
        *("Ours0.asking", "Ours0.data", "Ours0.positon", "Ours0.said")
    ]
    port = ports(ours)["data"].get_port_profile()
    assert texts(port.properties)["dataport.data_type"] == "IDL:RTC/TimedLong:1.0"
    assert port.owner._is_equivalent(ours)
    (interface,) = ports(ours)["said"].get_port_profile().interfaces
    assert (interface.instance_name, interface.type_name) == ("echo", "Facts::Echo")
    assert ours._is_a("IDL:omg.org/RTC/RTObject:1.0")
    assert ours._is_a("IDL:openrtm.aist.go.jp/OpenRTM/DataFlowComponent:1.0")
    assert not ours._is_a("IDL:omg.org/RTC/PortService:1.0")


def test_the_life_cycle_is_that_of_the_runtime(
    ours: Any, there: Process, lab: Lab
) -> None:
    import RTC

    (context,) = ours.get_owned_contexts()

    def becomes(state: Any) -> None:
        until(lambda: context.get_component_state(ours) == state)

    assert context.is_running()
    assert context.get_rate() == 200.0
    assert context.activate_component(ours) == RTC.RTC_OK
    becomes(RTC.ACTIVE_STATE)
    assert context.activate_component(ours) == RTC.PRECONDITION_NOT_MET
    there("setattr(ours, 'fails', True)")
    becomes(RTC.ERROR_STATE)
    there("setattr(ours, 'fails', False)")
    assert context.reset_component(ours) == RTC.RTC_OK
    becomes(RTC.INACTIVE_STATE)
    assert context.set_rate(100.0) == RTC.RTC_OK
    assert there("system.context('Ours0').get_rate()") == 100.0
    assert context.set_rate(200.0) == RTC.RTC_OK
    assert context.get_profile().owner._is_equivalent(ours)
    foreign = lab.component().getObjRef()
    assert context.activate_component(foreign) == RTC.BAD_PARAMETER
    assert ours.is_alive(context)
    assert ours.get_context_handle(context) == 0
    assert ours.exit() == RTC.UNSUPPORTED


def test_configuration_sets(ours: Any, there: Process) -> None:
    import SDOPackage
    from omniORB import any as anys

    configuration = ours.get_configuration()

    def a_set(name: str, parameter: str, text: str) -> Any:
        value = SDOPackage.NameValue(parameter, anys.to_any(text))
        return SDOPackage.ConfigurationSet(name, "", [value])

    there("system.activate('Ours0').name")
    assert configuration.set_configuration_set_values(a_set("default", "gain", "3.5"))
    until(lambda: there("ours.values.gain") == 3.5)
    assert configuration.add_configuration_set(a_set("fast", "gain", "9.0"))
    sets = configuration.get_configuration_sets()
    assert [each.id for each in sets] == ["default", "fast"]
    assert there("ours.values.gain") == 3.5
    assert configuration.activate_configuration_set("fast")
    until(lambda: there("ours.values.gain") == 9.0)
    assert configuration.get_active_configuration_set().id == "fast"
    for wrong in (a_set("default", "gain", "many"), a_set("default", "other", "1")):
        with pytest.raises(SDOPackage.InvalidParameter):
            configuration.set_configuration_set_values(wrong)
    with pytest.raises(SDOPackage.InvalidParameter):
        configuration.activate_configuration_set("slow")


@pytest.mark.parametrize(
    ("flow", "kind"),
    [("push", "flush"), ("push", "new"), ("push", "periodic"), ("pull", "flush")],
)
@pytest.mark.parametrize("endian", ["little", "big"])
def test_samples_both_ways(
    ours: Any, there: Process, lab: Lab, flow: str, kind: str, endian: str
) -> None:
    import RTC

    settings = {
        "dataflow_type": flow,
        "subscription_type": kind,
        "interface_type": "corba_cdr",
        "serializer__cdr__endian": endian,
        **({"publisher__push_rate": "500"} if kind == "periodic" else {}),
    }
    theirs = lab.out_port(RTC.TimedLong(RTC.Time(0, 0), 0), "theirs")
    joined(lab, theirs.getPortRef(), ports(ours)["data"], **settings)
    there("system.activate('Ours0').name")
    until(lambda: there("ours.is_active"))
    assert theirs.write(RTC.TimedLong(RTC.Time(1, 2), 41))
    # OpenRTM sends a sample again in each period.
    until(lambda: set(there("ours.got")) == {41})

    target = lab.in_port(RTC.TimedLong(RTC.Time(0, 0), 0), "target")
    identity = joined(lab, ports(ours)["positon"], target.getPortRef(), **settings)
    assert there("ours.out.write(long(data=-7)).name") == "PORT_OK"
    if flow == "push":
        until(target.isNew)
    assert target.read().data == -7
    assert ports(ours)["positon"].disconnect(identity) == RTC.RTC_OK
    assert there("len(ours.out.connectors)") == 0
    assert target.getPortRef().get_connector_profiles() == []


def test_services_both_ways(ours: Any, there: Process, lab: Lab, facts: Any) -> None:
    import Facts__POA
    import RTC

    class Echo(Facts__POA.Echo):  # type: ignore[misc, name-defined]
        def say(self, text: str) -> str:
            return text + "!"

    port = lab.rtm.CorbaPort("service")
    assert port.registerProvider("echo", "Facts::Echo", Echo())
    needed = lab.rtm.CorbaConsumer(interfaceType=facts.Echo)
    asking = lab.rtm.CorbaPort("asking")
    assert asking.registerConsumer("echo", "Echo", needed)
    other = lab.component()
    assert other.addPort(port)
    assert other.addPort(asking)
    lab.activate(other)
    lab.tick(other)
    identity = joined(lab, ports(ours)["asking"], port.getPortRef())
    assert there("ours.asked.object.say('a')") == "a!"
    # The name of the type differs: `Echo` without its scope.
    joined(lab, ports(ours)["said"], asking.getPortRef())
    there("system.activate('Ours0').name")
    until(lambda: there("ours.is_active"))
    assert needed._ptr().say("b") == "bb"
    with pytest.raises(facts.Refused):
        needed._ptr().say("refused")
    assert ports(ours)["asking"].disconnect(identity) == RTC.RTC_OK
    assert not there("ours.asked.connected")


def test_ports_of_the_system_are_joined_within_it(
    ours: Any, there: Process, lab: Lab, naming_service: str
) -> None:
    import RTC

    other = rt_object(lab, naming_service, "Other0.rtc")
    first, second = ports(ours)["positon"], ports(other)["data"]
    identity = joined(lab, first, second, subscription_type="new")
    assert there("[(c.name, c.target.owner) for c in system.connectors]") == [
        ("wire", "Other0")
    ]
    (shown,) = second.get_connector_profiles()
    assert shown.connector_id == identity
    assert texts(shown.properties)["dataport.subscription_type"] == "new"
    assert [port._is_equivalent(first) for port in shown.ports] == [True, False]
    assert second.disconnect(identity) == RTC.RTC_OK
    assert there("len(system.connectors)") == 0
    name = there("system.connect(('Ours0', '.positon'), ('Other0', 'data')).name")
    (shown,) = first.get_connector_profiles()
    assert shown.connector_id == name
    assert first.disconnect_all() == RTC.RTC_OK
    assert there("len(system.connectors)") == 0


def test_what_does_not_fit_is_refused(ours: Any, there: Process, lab: Lab) -> None:
    import RTC

    words = lab.out_port(RTC.TimedString(RTC.Time(0, 0), ""), "words")
    asked = lab.rtm.Properties()
    asked.setProperty("dataport.data_type", "IDL:RTC/TimedString:1.0")
    code = lab.rtm.connect("wire", asked, ports(ours)["data"], words.getPortRef())
    assert code != RTC.RTC_OK
    assert "IDL:RTC/TimedString:1.0, not IDL:RTC/TimedLong:1.0" in there.log
    assert there("len(system.connectors)") == 0
    assert ports(ours)["data"].disconnect("unknown") == RTC.BAD_PARAMETER


def test_a_lost_peer_ends_the_connection(ours: Any, there: Process, lab: Lab) -> None:
    import RTC

    target = lab.in_port(RTC.TimedLong(RTC.Time(0, 0), 0), "target")
    joined(lab, ports(ours)["positon"], target.getPortRef())
    (profile,) = ports(ours)["positon"].get_connector_profiles()
    ior = texts(p for p in profile.properties if p.name.endswith("inport_ior"))
    poa, orb = lab.manager.getPOA(), lab.manager.getORB()
    reference = orb.string_to_object(ior["dataport.corba_cdr.inport_ior"])
    poa.deactivate_object(poa.reference_to_id(reference))
    assert there("ours.out.write(long(data=1)).name") == "CONNECTION_LOST"
    until(lambda: there("len(ours.out.connectors)") == 0)
    assert ports(ours)["positon"].get_connector_profiles() == []


def found_by_name(lab: Lab, naming_service: str, port: Any) -> tuple[str, str]:
    """Return instance and port of a component of OpenRTM, once it is in the naming service."""
    name = port.getPortRef().get_port_profile().name
    instance, _, own = name.partition(".")
    resolved(lab.rtm, naming_service, f"{instance}.rtc")
    return instance, own


def test_the_system_connects_itself_with_components_of_openrtm(
    ours: Any, there: Process, lab: Lab, naming_service: str
) -> None:
    import RTC

    def zero() -> Any:
        return RTC.TimedLong(RTC.Time(0, 0), 0)

    target, source = lab.in_port(zero(), "target"), lab.out_port(zero(), "source")
    to = found_by_name(lab, naming_service, target)
    from_ = found_by_name(lab, naming_service, source)
    new = {"dataport.subscription_type": "new"}
    there(f"system.connect(('Ours0', '.positon'), {to}, {new}, 'to').name")
    there(f"system.connect({from_}, ('Ours0', 'data'), {{}}, 'from').name")
    assert there("refused(transport.await_others, 30)") == ""
    (shown,) = ports(ours)["positon"].get_connector_profiles()
    assert (shown.name, shown.connector_id) == ("to", "to")
    assert texts(shown.properties)["dataport.subscription_type"] == "new"
    there("system.activate('Ours0').name")
    until(lambda: there("ours.is_active"))
    assert there("ours.out.write(long(data=5)).name") == "PORT_OK"
    until(target.isNew)
    assert target.read().data == 5
    assert source.write(RTC.TimedLong(RTC.Time(0, 0), 6))
    until(lambda: there("ours.got") == [6])
    there("system.disconnect('to')")
    assert target.getPortRef().get_connector_profiles() == []
    there("system.disconnect('from')")
    assert there("len(system.connectors)") == 0


def test_what_is_missing_at_the_other_end_is_said(
    ours: Any, there: Process, lab: Lab, naming_service: str
) -> None:
    import RTC

    word = lab.in_port(RTC.TimedString(RTC.Time(0, 0), ""), "word")
    to = found_by_name(lab, naming_service, word)

    def error(instance: str, port: str) -> Any:
        address = instance, port
        there(f"system.connect(('Ours0', '.positon'), {address}, {{}}, 'to').name")
        found = there("refused(transport.await_others, 0.1)")
        there("system.disconnect('to')")
        return found

    assert error("Nobody0", "x") == (
        "TransportError: Ours0..positon waits for Nobody0.x; "
        f"the naming service {naming_service} has no Nobody0.rtc that answers"
    )
    assert error(*to) == (
        f"PortTypeError: Ours0..positon and {'.'.join(to)} have different types: "
        "IDL:RTC/TimedLong:1.0 and IDL:RTC/TimedString:1.0"
    )
    assert error(to[0], "other") == (
        f"PortTypeError: {to[0]}.other is not a DataInPort; {to[0]} has: word"
    )


def shell(naming_service: str, tool: str, *arguments: str) -> str:
    """Return the output of a tool of rtshell."""
    code = f"import sys; from rtshell.{tool} import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code, *arguments],
        env={**os.environ, "RTCTREE_NAMESERVERS": naming_service},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.sampled(1)
@pytest.mark.peer
@pytest.mark.skipif(
    importlib.util.find_spec("rtshell") is None, reason="rtshell-aist is not installed"
)
def test_rtshell_works_with_components_of_ours(
    ours: Any, there: Process, naming_service: str, tmp_path: Path
) -> None:
    root = f"/{naming_service}"
    first, second = f"{root}/Ours0.rtc", f"{root}/Other0.rtc"

    def rt(tool: str, *arguments: str) -> str:
        return shell(naming_service, tool, *arguments)

    assert "Ours0.rtc" in rt("rtls", f"{root}/")
    assert "IDL:RTC/TimedLong:1.0" in rt("rtcat", "-l", first)
    rt("rtact", first)
    until(lambda: there("ours.is_active"))
    rt("rtconf", first, "set", "gain", "4.5")
    until(lambda: there("ours.values.gain") == 4.5)
    rt("rtcon", f"{first}:positon", f"{second}:data")
    assert there("len(ours.out.connectors)") == 1
    file = str(tmp_path / "system.xml")
    rt("rtcryo", "-o", file, naming_service)
    rt("rtteardown", file)
    assert there("len(ours.out.connectors)") == 0
    rt("rtresurrect", file)
    assert there("len(ours.out.connectors)") == 1
    rt("rtdis", first)
    assert there("len(ours.out.connectors)") == 0
    rt("rtdeact", first)
    until(lambda: not there("ours.is_active"))
