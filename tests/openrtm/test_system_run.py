"""Systems started, connected and stopped by their scripts, a process for each component."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import middleware
import openrtm_peers as peers
import pytest
from free_ports import free_port
from openrtm_lab import Lab
from patience import until

from rtgen.cli import run

ROOT = Path(__file__).resolve().parents[2]
DOUBLED = 42

PROJECT = """\
[sources]
paths = ["parts"]

[output]
package = "workshop"
skeletons = "src/hands"
"""

DEFINITIONS = """\
module Workshop {
    struct Reading { long count; };
    interface Doubler { long twice(in long x); };
};

@rtc(category="Demo", vendor="me", rate=50.0)
component Source {
    uses Workshop::Doubler Doubler;
    publishes Workshop::Reading reading;
    @default(0) attribute long number;
    @default(2.0) attribute double each_time;
};

@rtc(category="Demo", vendor="me", rate=100.0)
component Worker {
    provides Workshop::Doubler Doubler;
    consumes Workshop::Reading reading;
    @name("reading") publishes Workshop::Reading passed_on;
};

@rtc(category="Demo", vendor="me", rate=20.0)
component Sink {
    consumes Workshop::Reading reading;
    @default("nothing") attribute string file;
    @default("nothing") attribute string prefix;
};
"""

BEHAVIOURS = {
    "source": '''
from rtgen.runtime import RTC_OK, ReturnCode_t
from workshop.components.source import SourceBase
from workshop.workshop import Reading


class Source(SourceBase):
    """Has its number doubled, and sends it."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.reading.write(Reading(self.Doubler.object.twice(self.config.number)))
        return RTC_OK
''',
    "worker": '''
from rtgen.runtime import RTC_OK, ReturnCode_t
from workshop.components.worker import WorkerBase
from workshop import workshop


class Doubler(workshop.Doubler):
    def twice(self, x: int) -> int:
        return 2 * x


class Worker(WorkerBase):
    """Doubles, and hands on what comes."""

    def on_initialize(self) -> ReturnCode_t:
        self.Doubler.set_servant(Doubler())
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        while self.reading.is_new():
            self.passed_on.write(self.reading.read())
        return RTC_OK
''',
    "sink": '''
import time

from rtgen.runtime import RTC_OK, ReturnCode_t
from workshop.components.sink import SinkBase


class Sink(SinkBase):
    """Writes down what came last; its activation takes longer than OpenRTM waits."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        time.sleep(0.7)
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        if self.reading.is_new():
            config = self.config
            text = f"{config.prefix} {self.reading.read_newest().count}"
            (self.folder / config.file).write_text(text)
        return RTC_OK
''',
}

FAILING = """
    def on_activated(self, ec_id: int) -> ReturnCode_t:
        raise OSError("no paper")
"""


def component(kind: str, more: str = "") -> str:
    return (
        f'<rts:Components rts:id="RTC:me:Demo:{kind}:1.0.0" rts:instanceName="{kind}0">'
        f"{more}</rts:Components>\n"
    )


def value(name: str, text: str) -> str:
    return (
        '<rts:ConfigurationSets rts:id="default">'
        f'<rts:ConfigurationData rts:name="{name}" rts:data="{text}"/>'
        "</rts:ConfigurationSets>"
    )


def connector(kind: str, source: str, target: str) -> str:
    ends = (("source", source), ("target", target))
    inner = "".join(
        f'<rts:{end}{kind}Port rts:instanceName="{name.partition(".")[0]}" '
        f'rts:portName="{name}"/>'
        for end, name in ends
    )
    return f"<rts:{kind}PortConnectors>{inner}</rts:{kind}PortConnectors>\n"


SYSTEM = (
    '<rts:RtsProfile rts:id="RTSystem:me:line:1.0.0" rts:version="0.2" '
    'xmlns:rts="http://www.openrtp.org/namespaces/rts" '
    'xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">\n'
    + component("Source", value("number", str(DOUBLED // 2)))
    + component("Worker")
    + component("Sink", value("file", "seen.txt"))
    + connector("Data", "Source0.reading", "Worker0.reading")
    + connector("Data", "Worker0.reading", "Sink0.reading")
    + connector("Service", "Source0.Doubler", "Worker0.Doubler")
    + '<rtsExt:Properties rtsExt:name="rtgen.openrtm.per_cycle" '
    'rtsExt:value="Source0.each_time"/>\n</rts:RtsProfile>\n'
)


FOREIGN = SYSTEM.replace(
    'rts:instanceName="Worker0">',
    'rts:instanceName="Worker0" rts:pathUri="localhost/lab.host_cxt/Worker0.rtc">',
    1,
).replace(
    "</rts:RtsProfile>",
    '<rtsExt:Properties rtsExt:name="rtgen.foreign" rtsExt:value="Worker0"/>'
    "</rts:RtsProfile>",
)


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the project, generated and completed."""
    folder = tmp_path_factory.mktemp("workshop")
    written = {
        "rtgen.toml": PROJECT,
        "parts/workshop.idl": DEFINITIONS,
        "parts/line.xml": SYSTEM,
        "parts/mixed.xml": FOREIGN,
        "parts/Sink.conf": "conf.default.prefix: it is\n",
        **{f"src/hands/{name}.py": text for name, text in BEHAVIOURS.items()},
    }
    for name, text in written.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    (folder / "src/hands/__init__.py").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "--target", "openrtm", "-q"]) == 0
    return folder


def script(
    file: Path, environment: dict[str, str], *arguments: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(file), *arguments],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def processes(folder: Path) -> list[int]:
    """Return the processes that start.sh has started."""
    return [int(file.read_text()) for file in folder.glob("run/*.pid")]


def is_alive(session: int) -> bool:
    try:
        os.killpg(session, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def ended(rtm_environment: dict[str, str]) -> Iterator[Callable[[Path], None]]:
    """Stop the system in a folder after the test, however the test ends."""
    folders: list[Path] = []
    yield folders.append
    for folder in folders:
        left = processes(folder)
        script(folder / "stop.sh", rtm_environment)
        for session in left:
            if is_alive(session):
                os.killpg(session, signal.SIGKILL)


def found(rtm: Any, manager: Any, place: str, name: str) -> Any:
    rtc = import_module("RTC")
    naming = rtm.CorbaNaming(manager.getORB(), place)
    return naming.resolve(f"{name}.rtc")._narrow(rtc.RTObject)


def values(component: Any) -> dict[str, str]:
    """Return the active parameters as a client sees them."""
    active = component.get_configuration().get_active_configuration_set()
    return {v.name: v.value.value() for v in active.configuration_data}


@pytest.mark.sampled(1)
def test_a_system_runs(
    rtm: Any,
    manager: Any,
    lab: Lab,
    workshop: Path,
    rtm_environment: dict[str, str],
    ended: Callable[[Path], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = workshop / "generated/openrtm/line"
    ended(folder)
    place = f"127.0.0.1:{free_port()}"
    options = ["--nameserver", place, "--rate-scale", "0.5"]
    # The programs beside the interpreter have priority over others of their names.
    others = workshop / "others"
    others.mkdir()
    for name in ("omniidl", "omniNames"):
        (others / name).write_text("#!/bin/sh\nexit 9\n", encoding="utf-8")
        (others / name).chmod(0o755)
    plain = {**rtm_environment, "PATH": f"{others}:/usr/local/bin:/usr/bin:/bin"}
    started = script(folder / "start.sh", plain, *options)
    assert started.returncode == 0, started.stderr
    lines = started.stdout.splitlines()
    assert lines[-1] == "ready"
    order = [line.split()[0] for line in lines if line.endswith(" ACTIVE")]
    assert order.index("Worker0") < order.index("Source0")
    running = processes(folder)
    assert len(running) == 4  # the naming service is one of them
    seen = workshop / "parts/seen.txt"
    until(lambda: seen.is_file() and seen.read_text() == f"it is {DOUBLED}")

    peers.load_stubs(folder.parent / "Source/stubs")
    source = found(rtm, manager, place, "Source0")
    assert source.get_owned_contexts()[0].get_rate() == 25.0
    assert float(values(source)["each_time"]) == 4.0

    # The second time nothing is left to do; a second start is refused.
    again = script(folder / "connect.py", rtm_environment, "--nameserver", place)
    assert again.returncode == 0, again.stderr
    assert again.stdout.splitlines()[-1] == "ready"
    # Connectors have the ids of the system. Connections with other ports are cut.
    [out] = [
        port
        for port in source.get_ports()
        if port.get_port_profile().name == "Source0.reading"
    ]
    [profile] = out.get_connector_profiles()
    assert profile.connector_id == profile.name == "Source0.reading_Worker0.reading"
    assert str(out.disconnect(profile.connector_id)) == "RTC_OK"
    sample = import_module("Workshop").Reading(0)
    stray = lab.in_port(sample, "reading").getPortRef()
    foreign = rtm.create_connector(profile.name, rtm.Properties(), out, stray)
    foreign.connector_id = profile.connector_id
    assert str(out.connect(foreign)[0]) == "RTC_OK"
    again = script(folder / "connect.py", rtm_environment, "--nameserver", place)
    assert again.returncode == 0, again.stderr
    [profile] = out.get_connector_profiles()
    assert not any(port._is_equivalent(stray) for port in profile.ports)

    second = script(folder / "start.sh", rtm_environment, "--nameserver", place)
    assert second.returncode == 3
    assert "runs already" in second.stderr
    assert all(map(is_alive, running))

    # stop.sh uses the interpreter of start.sh.
    forgotten = {**rtm_environment, "PYTHON": "/nowhere/python3"}
    stopped = script(folder / "stop.sh", forgotten)
    assert stopped.returncode == 0
    assert stopped.stderr == ""
    assert "Sink0 ended" in stopped.stdout
    assert not any(map(is_alive, running))
    assert processes(folder) == []
    monkeypatch.chdir(workshop)
    assert run(["check", "--target", "openrtm", "-q"]) == 0


@pytest.mark.sampled(0)
def test_a_component_that_others_run(
    workshop: Path,
    rtm_environment: dict[str, str],
    naming_service: str,
    ended: Callable[[Path], None],
) -> None:
    folder = workshop / "generated/openrtm/mixed"
    ended(folder)
    assert not (folder / "Worker0.conf").exists()
    options = ["--nameserver", naming_service, "--timeout"]
    failed = script(folder / "start.sh", rtm_environment, *options, "1")
    assert failed.returncode == 3
    missing = "Worker0 (foreign, at localhost/lab.host_cxt/Worker0.rtc)"
    assert missing in failed.stderr
    module = folder.parent / "Worker"
    subprocess.run(
        ["sh", "./idlcompile.sh"], cwd=module, env=rtm_environment, check=True
    )
    settings = {
        "corba.nameservers": naming_service,
        "naming.formats": "lab.host_cxt/%n.rtc",
    }
    command = ["Worker.py", "--instance_name=Worker0", "-f", "rtc.conf"]
    with middleware.launched(command, settings, rtm_environment, module):
        started = script(folder / "start.sh", rtm_environment, *options, "60")
        assert started.returncode == 0, started.stderr
        assert "Worker0 ACTIVE" in started.stdout
        assert not (folder / "run/Worker0.pid").exists()
        stopped = script(folder / "stop.sh", rtm_environment)
        assert "Worker0 goes on: others have started it" in stopped.stdout
        assert "Source0 ended" in stopped.stdout


@pytest.mark.sampled(0)
def test_a_system_that_does_not_come_up_leaves_nothing(
    workshop: Path,
    rtm_environment: dict[str, str],
    naming_service: str,
    ended: Callable[[Path], None],
) -> None:
    folder = workshop / "generated/openrtm/line"
    ended(folder)
    right = (folder / "connect.py").read_text(encoding="utf-8")
    # Another interface of the provider, then another port.
    mapping = re.compile(
        r'"(Worker0\.port\.Doubler\.provided\.Workshop::Doubler\.)Doubler"'
    )
    for pattern, wrong, why in (
        (
            mapping,
            r'"\1Halver"',
            "a consumer finds no provider "
            "Worker0.port.Doubler.provided.Workshop::Doubler.Halver; "
            "there are: Worker0.port.Doubler.provided.Workshop::Doubler.Doubler",
        ),
        (re.compile('"Sink0.reading"'), '"Sink0.writing"', "Sink0 has the ports"),
    ):
        changed, count = pattern.subn(wrong, right)
        assert count == 1
        (folder / "connect.py").write_text(changed, encoding="utf-8")
        options = ["--nameserver", naming_service]
        started = script(folder / "start.sh", rtm_environment, *options)
        assert started.returncode == 3
        assert "ready" not in started.stdout
        assert why in started.stderr
        assert processes(folder) == []
    (folder / "connect.py").write_text(right, encoding="utf-8")
    behaviour = workshop / "src/hands/sink.py"
    behaviour.write_text("import nothing_of_this_name\n", encoding="utf-8")
    started = script(
        folder / "start.sh", rtm_environment, "--nameserver", naming_service
    )
    behaviour.write_text(BEHAVIOURS["sink"], encoding="utf-8")
    assert started.returncode == 3
    assert "the process of Sink0 has ended: ModuleNotFoundError" in started.stderr
    assert processes(folder) == []


@pytest.mark.sampled(0)
def test_a_component_that_fails_when_it_is_activated_is_reported(
    workshop: Path,
    rtm_environment: dict[str, str],
    naming_service: str,
    ended: Callable[[Path], None],
) -> None:
    folder = workshop / "generated/openrtm/line"
    ended(folder)
    behaviour = workshop / "src/hands/sink.py"
    behaviour.write_text(BEHAVIOURS["sink"] + FAILING, encoding="utf-8")
    # Files older than the IDL are generated anew.
    stubs = folder.parent / "Sink/stubs"
    stubs.mkdir(exist_ok=True)
    os.utime(stubs, (0, 0))
    started = script(
        folder / "start.sh", rtm_environment, "--nameserver", naming_service
    )
    behaviour.write_text(BEHAVIOURS["sink"], encoding="utf-8")
    assert started.returncode == 3
    assert "ready" not in started.stdout
    assert "Sink0" in started.stderr
    assert "is in ERROR_STATE: OSError: no paper" in started.stderr
    # OpenRTM's log, including the forwarded reason, is not printed a second time.
    assert (folder / "run/Sink0.out").read_text().count("Traceback") == 1
    assert stubs.stat().st_mtime > 0
    assert list(stubs.glob("*_idl.py"))
    assert processes(folder) == []


def test_what_is_not_there_is_waited_for_as_long_as_configured(
    workshop: Path, rtm_environment: dict[str, str], naming_service: str
) -> None:
    connect = workshop / "generated/openrtm/line/connect.py"
    options = ["--nameserver", naming_service, "--timeout", "0.2"]
    completed = script(connect, rtm_environment, *options)
    assert completed.returncode == 3
    assert "Sink0, Source0, Worker0" in completed.stderr
    nowhere = f"127.0.0.1:{free_port()}"
    completed = script(connect, rtm_environment, "--nameserver", nowhere)
    assert completed.returncode == 3
    assert "no naming service" in completed.stderr


def test_a_naming_service_elsewhere_is_not_started(
    workshop: Path, rtm_environment: dict[str, str]
) -> None:
    folder = workshop / "generated/openrtm/line"
    elsewhere = f"127.0.0.2:{free_port()}"
    completed = script(
        folder / "start.sh", rtm_environment, f"--nameserver={elsewhere}"
    )
    assert completed.returncode == 3
    assert f"no naming service answers at {elsewhere}" in completed.stderr
    assert script(folder / "start.sh", rtm_environment, "--what").returncode == 2
    for wrong in ("--timeout=soon", "--rate-scale=0", "--nameserver=127.0.0.1:x"):
        completed = script(folder / "start.sh", rtm_environment, wrong)
        assert completed.returncode == 2
        assert "usage: start.sh" in completed.stderr
    completed = script(folder / "connect.py", rtm_environment, "--rate-scale", "nan")
    assert completed.returncode == 2
    assert "nan is not a number above 0" in completed.stderr
    bare = {**rtm_environment, "PYTHONPATH": ""}
    if not middleware.REAL:
        completed = script(folder / "start.sh", bare)
        assert completed.returncode == 3
        assert "does not have OpenRTM_aist" in completed.stderr
    nobody = {**rtm_environment, "PYTHON": "/nowhere/python3"}
    assert script(folder / "start.sh", nobody).returncode == 3


def test_an_interpreter_without_rtgen_is_reported(workshop: Path) -> None:
    connect = workshop / "generated/openrtm/line/connect.py"
    completed = subprocess.run(
        [sys.executable, "-I", "-S", str(connect)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert completed.returncode == 3
    assert "cannot import rtgen" in completed.stderr
    assert "Traceback" not in completed.stderr


@pytest.mark.nightly
@pytest.mark.waits
@pytest.mark.slow
@pytest.mark.longest
def test_six_processes_drive_to_the_goal(
    rtm: Any,
    manager: Any,
    lab: Lab,
    reference: Path,
    rtm_environment: dict[str, str],
    tmp_path: Path,
    ended: Callable[[Path], None],
) -> None:
    """The base has reached the goal when PositionInput has no more commands and enters ERROR."""
    rtc = import_module("RTC")
    generated = tmp_path / "generated"
    generated.symlink_to(reference)
    (tmp_path / "src").symlink_to(ROOT / "src")
    folder = generated / "openrtm/rh3_goal"
    ended(folder)
    place = f"127.0.0.1:{free_port()}"
    options = ["--nameserver", place, "--rate-scale", "0.5"]
    started = script(folder / "start.sh", rtm_environment, *options)
    assert started.returncode == 0, started.stderr
    peers.load_stubs(generated / "openrtm/Odometry/stubs")
    at_rest = rtc.Pose2D(rtc.Point2D(0.0, 0.0), 0.0)
    sample = import_module("IIS").TimedPose2D(rtc.Time(0, 0), [], at_rest, [])
    port = lab.in_port(sample, "pose")
    lab.activate(lab.made[-1])
    lab.tick(lab.made[-1])
    ports = found(rtm, manager, place, "Odometry0").get_ports()
    [source] = [
        p for p in ports if p.get_port_profile().name == "Odometry0.OdometryPosition"
    ]
    assert (
        rtm.connect("look", rtm.Properties(), source, port.getPortRef()) == rtc.RTC_OK
    )
    position_input = found(rtm, manager, place, "PositionInput0")
    until(lambda: rtm.get_state(position_input)[1] != rtc.ACTIVE_STATE, 400.0)
    assert rtm.get_state(position_input)[1] == rtc.ERROR_STATE
    while port.isNew():
        sample = port.read()
    position, heading = sample.data.position, sample.data.heading
    assert (position.x, position.y) == pytest.approx((3.4, 7.7), abs=0.1)
    assert heading == pytest.approx(-1.57, abs=0.1)
