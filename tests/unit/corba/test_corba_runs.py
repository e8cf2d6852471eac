"""Systems over omniORB: in one process, in several with a naming service, and what goes wrong."""

from __future__ import annotations

import importlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import programs
import pytest
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

sys.path.insert(0, str(Path(__file__).parents[1] / "types"))

import emitted

from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.transport import CorbaTransport
from rtgen.runtime.services.ports import ServicePort

ROOT = Path(__file__).parents[3]
BOARD = ROOT / "specs" / "tecs" / "rh3_board.xml"
NAVIGATION = ROOT / "specs" / "navigation" / "rh3_goal.xml"


def wait_for(condition: Callable[[], object]) -> Any:
    """What a condition gives, once it is true."""
    deadline = time.monotonic() + PATIENCE
    while not (found := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return found


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A project with a component that calls and one that is called."""
    folder = tmp_path_factory.mktemp("corba") / "project"
    shutil.copytree(Path(__file__).with_name("corba_system"), folder)
    before = Path.cwd()
    os.chdir(folder)
    sys.path[:0] = [str(folder), str(folder / "generated")]
    try:
        assert rtgen(["generate", "-q"]) == 0
        importlib.invalidate_caches()
        yield folder
    finally:
        os.chdir(before)
        sys.path.remove(str(folder))
        sys.path.remove(str(folder / "generated"))


@pytest.fixture(scope="module")
def names() -> Iterator[str]:
    with NameServer() as server:
        yield server.address


class Run:
    """`rtgen run` in a process of its own, in real time, over omniORB."""

    def __init__(
        self, project: Path, *arguments: str, system: Path = Path("calc.xml")
    ) -> None:
        folder = ROOT if system.is_absolute() else project
        self.errors = project / f"errors-{time.monotonic_ns()}.txt"
        self.log = self.errors.with_suffix(".jsonl")
        command = [sys.executable, "-m", "rtgen", "run", str(system), "--clock", "real"]
        command += ["--transport", "corba", "--log", str(self.log), *arguments]
        paths = [str(project), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        with self.errors.open("w", encoding="utf-8") as errors:
            self.process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )

    def error_text(self) -> str:
        """What it wrote to standard error so far."""
        return self.errors.read_text(encoding="utf-8")

    def wait_for(self, text: str) -> None:
        """Waits until it wrote that."""
        wait_for(lambda: self.process.poll() is not None or text in self.error_text())
        assert text in self.error_text(), self.error_text()

    def end(self) -> int:
        """Asks it to end in order; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.code()

    def code(self) -> int:
        """Waits for its end; its exit code."""
        self.output, _ = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode

    def kill(self) -> None:
        """Ends it at once, if it still runs."""
        self.process.kill()
        assert self.process.stdout is not None
        if not self.process.stdout.closed:
            self.process.communicate()

    def samples(self) -> list[dict[str, Any]]:
        """The samples that were written so far."""
        lines = self.log.read_text().split("\n")[:-1]
        events = [json.loads(line) for line in lines]
        return [event for event in events if event["event"] == "sample"]

    def results(self) -> list[tuple[int, str]]:
        """The samples of Caller0."""
        values = [event["value"] for event in self.samples()]
        return [(value["number"], value["error"]) for value in values]


@pytest.fixture
def start(project: Path, names: str) -> Iterator[Callable[..., Run]]:
    """Starts processes, which end with the test."""
    runs: list[Run] = []

    def started(*arguments: str, **more: Path) -> Run:
        runs.append(Run(project, "--nameserver", names, *arguments, **more))
        return runs[-1]

    yield started
    for run in runs:
        run.kill()


@pytest.fixture
def serving(start: Callable[..., Run]) -> Callable[[], Run]:
    """Starts a process with Counter0, and waits until it is ACTIVE."""

    def started() -> Run:
        run = start("--only", "Counter0")
        run.wait_for("Counter0 ACTIVE")
        return run

    return started


class Here:
    """The other side in this process: a system with Caller0, which does not tick."""

    def __init__(self, stack: ExitStack, names: str, timeout: float = 2.0) -> None:
        from calc_nodes import Caller  # type: ignore[import-not-found]

        self.transport = stack.enter_context(
            CorbaTransport(name_server=names, timeout=timeout)
        )
        self.system = stack.enter_context(
            runtime.System(runtime.RealClock(), self.transport)
        )
        self.caller = Caller("Caller0")
        self.system.add(self.caller)

    def connect(self, **properties: str) -> None:
        """Connects the caller with what another process has."""
        names = {key.replace("_", "."): text for key, text in properties.items()}
        self.system.connect(("Caller0", "adding"), ("Counter0", "adding"), names)

    @property
    def adder(self) -> Any:
        """The stub."""
        return self.caller.adder.object


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def here(project: Path, names: str, stack: ExitStack) -> Here:
    return Here(stack, names)


# One process.


def test_simulated_time_is_the_same_by_every_transport(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    reports = []
    for transport in ("direct", "corba"):
        command = ["run", str(BOARD), "--until", "3", "--transport", transport]
        assert rtgen(command) == 0
        report = capfd.readouterr().out
        reports.append(report.partition("wall [s]")[0])
    assert reports[0] == reports[1]
    assert "RefHardRh3Tecs0          ACTIVE    300" in reports[0]


def test_one_process_with_a_naming_service_of_its_own(project: Path) -> None:
    run = Run(project, "--until", "0.5")
    assert run.code() == 0
    assert "naming service: 127.0.0.1:" in run.error_text()
    results = run.results()
    assert len(results) > 10
    assert results[-1] == (len(results), "")


def test_foreign_clients_find_a_provider_by_its_name(
    here: Here, names: str, serving: Callable[[], Run]
) -> None:
    from calcbot.calc import Adder  # type: ignore[import-not-found]
    from omniORB import CORBA

    run = serving()
    url = f"corbaname::{names}#Counter0.adding/Adder"
    orb = CORBA.ORB_init([], CORBA.ORB_ID)
    reference = orb.string_to_object(url)
    assert reference._is_a("IDL:Calc/Adder:1.0")
    assert not reference._non_existent()
    assert here.transport._objects.stub(Adder, reference).add(2, 3) == 5
    assert run.end() == 0
    with pytest.raises(CORBA.BAD_PARAM):
        orb.string_to_object(url)


# Two processes.


def test_two_processes(start: Callable[..., Run]) -> None:
    caller = start("--only", "Caller0", "--until", "1")
    counter = start("--only", "Counter0")
    assert caller.code() == 0, caller.error_text()
    assert counter.end() == 0, counter.error_text()
    results = caller.results()
    assert len(results) > 20
    # Counter0 is ACTIVE before Caller0 is, whichever process was first.
    assert results == [(i + 1, "") for i in range(len(results))]
    assert caller.output.startswith("instance  state   ticks")
    assert "Counter0" not in caller.output


@pytest.mark.slow
def test_the_wheels_of_rh3_in_one_process_and_its_marshaller_in_another(
    start: Callable[..., Run],
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = str(server.getsockname()[1])
    there = "OpaqueRpcCommunication0,MotorBoardMarshaller0"
    rest = (
        "PositionInput0,OmniTo2WD0,Navigation0,PathFollower0,RefHardRh3Tecs0,Odometry0"
    )
    system = BOARD
    marshaller = start(
        *("--only", there, "--set", f"OpaqueRpcCommunication0.port={port}"),
        system=system,
    )
    robot = start(
        *("--only", f"SimulatedMotorBoard0,{rest}", "--until", "3"),
        *("--set", "PositionInput0.01_x=1", "--set", "PositionInput0.01_y=0"),
        *("--set", f"SimulatedMotorBoard0.port={port}"),
        system=system,
    )
    assert robot.code() == 0, robot.error_text()
    assert marshaller.end() == 0, marshaller.error_text()
    lines = dict(line.split(maxsplit=1) for line in robot.output.splitlines() if line)
    assert lines["RefHardRh3Tecs0"].startswith("ACTIVE")
    x = float(robot.output.partition("final pose")[2].strip(" (").partition(",")[0])
    assert x > 0.01, robot.error_text()
    assert "elapsed [s]" in marshaller.output


@pytest.mark.slow
def test_a_client_of_omniidl_stops_the_base_and_lets_it_go(
    start: Callable[..., Run], here: Here, names: str, tmp_path: Path
) -> None:
    file = ROOT / "specs" / "idl" / "RefHardRh3Pro.idl"
    program = tmp_path / "client.py"
    subprocess.run(
        [programs.omniidl(), "-bpython", str(file)], cwd=tmp_path, check=True
    )
    program.write_text(
        "import sys, _GlobalIDL\n"
        "from omniORB import CORBA\n"
        "base = CORBA.ORB_init().string_to_object(sys.argv[1])._narrow(_GlobalIDL.RefHard)\n"
        "getattr(base, sys.argv[2])()\n"
    )
    goal = ("--set", "PositionInput0.01_x=9", "--set", "PositionInput0.01_y=0")
    run = start(*goal, "--until", "100", system=NAVIGATION)

    def asked(operation: str) -> None:
        url = f"corbaname::{names}#RefHardRh30.InventGUIRefHard/RefHard"
        subprocess.run([sys.executable, str(program), url, operation], check=True)

    run.wait_for("PositionInput0 ACTIVE")
    for operation in ("Stop", "Go"):
        time.sleep(1.0)
        asked(operation)
    time.sleep(1.0)
    assert run.end() == 1  # before its time is over
    wheels = [e["value"]["data"] for e in run.samples() if e["port"] == "OutWheelAngle"]
    moving = [one != other for one, other in pairwise(wheels)]
    # Standing, driving, stopped for a while, driving again.
    first = moving.index(True)
    stopped = "".join(map("01".__getitem__, moving[first:]))
    assert "0" * 100 in stopped
    assert stopped.rstrip("0").endswith("1" * 50)


def test_results_exceptions_and_attributes(
    here: Here, serving: Callable[[], Run]
) -> None:
    from calcbot.calc import Refused

    serving()
    here.connect()
    here.transport.await_others(PATIENCE)
    assert here.adder.add(2, 3) == 5
    with pytest.raises(Refused) as caught:
        here.adder.add(0, 13)
    assert caught.value == Refused("unlucky", 13)
    assert here.adder.naps == 0
    here.system.disconnect(here.system.connectors[0])
    with pytest.raises(runtime.ObjectNotExist, match="is not connected"):
        here.adder.add(2, 3)
    here.connect(port_connection_strictness="strict")
    assert here.adder.add(2, 3) == 5


def test_a_provider_that_is_named_by_a_property(
    here: Here, serving: Callable[[], Run]
) -> None:
    serving()
    wish = "Caller0.port.adding.required.Calc::Adder.Adder"
    addresses = ("Caller0", "adding"), ("Counter0", "adding")
    key = "Counter0.port.adding.provided.Calc::Adder.Adder"
    here.system.connect(*addresses, {wish: key})
    assert here.adder.add(2, 3) == 5
    here.system.disconnect(here.system.connectors[0])
    here.system.connect(*addresses, {wish: key[:-5] + "Other"})
    with pytest.raises(runtime.PortTypeError, match="it has: Adder"):
        here.transport.await_others(1.0)
    here.system.disconnect(here.system.connectors[0])
    for properties, message in (
        ({wish: "Counter0.port.other.provided.Calc::Adder.Adder"}, "is not a provider"),
        ({"Caller0.port.adding.required.X.Y": key}, "names no consumer"),
        ({"port.connection.x": "y"}, "unknown connector property"),
    ):
        with pytest.raises(runtime.ConnectorPropertyError, match=message):
            here.system.connect(*addresses, properties)


def test_definitions_that_differ(here: Here, tmp_path: Path) -> None:
    operations = "long add(in long a); void nap(in double seconds);"
    changed = f"module Calc {{ interface Adder {{ {operations} }}; }};"
    other = emitted.emit_text(tmp_path, changed).calc.Adder
    objects, naming = here.transport._objects, here.transport._naming
    assert naming is not None
    reference = objects.serve(other, lambda operation, arguments: None)
    place = ("Counter0", "adding"), "Adder"
    naming.bind(*place, reference)
    here.connect()
    message = (
        r"different definitions of Calc::Adder; the provider has no readonly attribute "
        r"unsigned long naps, long add\(in long a, in long b\) raises \(Calc::Refused\)$"
    )
    with pytest.raises(runtime.PortTypeError, match=message):
        here.transport.await_others(0.0)
    with pytest.raises(runtime.CommunicationFailure, match="different definitions"):
        here.adder.add(2, 3)
    naming.unbind(*place, reference)


def test_nobody_serves_a_port_that_is_connected_meanwhile(here: Here) -> None:
    here.connect()
    for message in ("nobody serves Counter0.adding", "not tried again so soon"):
        with pytest.raises(runtime.ObjectNotExist, match=message):
            here.adder.add(2, 3)


def test_who_is_missing_is_named(here: Here, serving: Callable[[], Run]) -> None:
    assert here.transport.missing == []
    here.connect()
    assert here.transport.missing == ["Counter0"]
    serving()
    wait_for(lambda: not here.transport.missing)


def test_only_ports_that_are_there_reach_other_processes(here: Here) -> None:
    with pytest.raises(runtime.UnknownPortError):
        here.system.connect(("Caller0", "nothing"), ("Counter0", "adding"))
    with pytest.raises(runtime.UnknownComponentError):
        here.system.connect(("Other0", "adding"), ("Counter0", "adding"))
    here.connect()
    with pytest.raises(runtime.DuplicateConnectionError):
        here.system.connect(
            ("Caller0", "adding"), ("Counter0", "adding"), name="another"
        )


def test_samples_go_between_processes(here: Here, names: str, stack: ExitStack) -> None:
    from calc_nodes import Counter

    # Objects of another transport are those of another process, as far as this one knows.
    transport = stack.enter_context(CorbaTransport(name_server=names))
    system = stack.enter_context(runtime.System(runtime.RealClock(), transport))
    counter = Counter("Counter0")
    system.add(counter)
    for each in (here.system, system):
        each.connect(("Counter0", "done"), ("Caller0", "done"), name="data")
    transport.await_others(PATIENCE)
    here.transport.await_others(PATIENCE)
    done = counter.out_ports["done"]
    assert done.write(done.type()) is runtime.PORT_OK
    assert here.caller.in_ports["done"].read() == done.type()
    here.system.disconnect("data")
    assert done.connectors == ()
    assert done.write(done.type()) is runtime.PortStatus.PRECONDITION_NOT_MET


# What goes wrong.


@pytest.mark.slow
def test_a_provider_that_is_not_active(
    project: Path, start: Callable[..., Run]
) -> None:
    timeline = project / "timeline.toml"
    timeline.write_text(
        '[[at]]\nt = 0.4\ndeactivate = "Counter0"\n'
        '[[at]]\nt = 1.6\nactivate = "Counter0"\n'
    )
    caller = start("--only", "Caller0", "--until", "3", "--timeline", str(timeline))
    counter = start("--only", "Counter0", "--timeline", str(timeline))
    assert caller.code() == 0, caller.error_text()
    assert counter.end() == 0
    errors = [error for _, error in caller.results()]
    first = errors.index("ObjectNotExist")
    last = len(errors) - errors[::-1].index("ObjectNotExist")
    assert set(errors[:first]) == set(errors[last:]) == {""}
    assert set(errors) == {"", "ObjectNotExist"}


def test_a_process_that_is_killed_and_started_again(
    here: Here, serving: Callable[[], Run]
) -> None:
    counter = serving()
    here.connect()
    assert here.adder.add(2, 3) == 5
    counter.kill()
    begun = time.monotonic()
    for _ in range(5):
        with pytest.raises(runtime.ServiceError) as caught:
            here.adder.add(2, 3)
        kinds = (runtime.CommunicationFailure, runtime.ObjectNotExist)
        assert isinstance(caught.value, kinds)
    assert time.monotonic() - begun < PATIENCE
    serving()

    def answered() -> bool:
        try:
            return bool(here.adder.add(2, 3) == 5)
        except runtime.CommunicationFailure:
            return False

    wait_for(answered)


@pytest.fixture(params=["an ORB of its own", "a running ORB"])
def orb_before(request: pytest.FixtureRequest) -> Iterator[None]:
    """Perhaps an ORB with another time-out."""
    import omniORB

    if request.param != "a running ORB" or omniORB.orb is not None:
        yield
        return
    options = ["test", "-ORBclientCallTimeOutPeriod", "10000"]
    running = omniORB.CORBA.ORB_init(options, omniORB.CORBA.ORB_ID)
    yield
    running.destroy()


@pytest.mark.usefixtures("orb_before")
def test_a_call_takes_no_longer_than_the_time_out_and_is_sent_once(
    project: Path, names: str, stack: ExitStack, serving: Callable[[], Run]
) -> None:
    serving()
    here = Here(stack, names, timeout=0.3)
    here.connect()
    assert here.adder.add(2, 3) == 5
    with pytest.raises(runtime.CallTimeout):
        here.adder.nap(1.0)
    wait_for(lambda: answers(here) and here.adder.naps == 1)
    here.adder.nap(0.0)
    assert here.adder.naps == 2


@pytest.mark.slow
def test_a_process_ends_though_a_servant_does_not_return(
    project: Path, names: str, stack: ExitStack, serving: Callable[[], Run]
) -> None:
    counter = serving()
    here = Here(stack, names, timeout=0.3)
    here.connect()
    with pytest.raises(runtime.CallTimeout):
        here.adder.nap(3600.0)
    assert counter.end() == 0, counter.error_text()


def answers(here: Here) -> bool:
    """Whether a call comes back."""
    try:
        return bool(here.adder.add(2, 3) == 5)
    except runtime.CommunicationFailure:
        return False


def test_calls_go_on_without_the_naming_service(
    project: Path, stack: ExitStack
) -> None:
    server = NameServer()
    counter = Run(project, "--nameserver", server.address, "--only", "Counter0")
    try:
        counter.wait_for("Counter0 ACTIVE")
        here = Here(stack, server.address)
        here.connect()
        assert here.adder.add(2, 3) == 5
        server.close()
        assert here.adder.add(2, 3) == 5
        assert counter.end() == 0
        for _ in range(2):
            with pytest.raises(runtime.ServiceError):
                here.adder.add(2, 3)
    finally:
        server.close()
        counter.kill()


def test_an_instance_runs_once(
    here: Here, start: Callable[..., Run], serving: Callable[[], Run]
) -> None:
    serving()
    again = start("--only", "Counter0")
    assert again.code() == 3
    assert (
        "Counter0.adding:Adder is served by another process already"
        in again.error_text()
    )
    here.connect()
    assert here.adder.add(2, 3) == 5


@pytest.mark.slow
def test_names_that_lead_nowhere_are_replaced(
    here: Here, serving: Callable[[], Run]
) -> None:
    serving().kill()
    counter = serving()
    here.connect()
    assert here.adder.add(2, 3) == 5
    assert counter.end() == 0


def test_nobody_serves_what_is_called(start: Callable[..., Run]) -> None:
    caller = start("--only", "Caller0", "--wait", "0.2")
    assert caller.code() == 3
    assert "Caller0.adding:Adder waits for Counter0.adding" in caller.error_text()
    assert "start the process that runs it" in caller.error_text()


@pytest.mark.slow
def test_ctrl_c_while_waiting(start: Callable[..., Run]) -> None:
    caller = start("--only", "Caller0")
    caller.wait_for("naming service")
    time.sleep(0.3)
    caller.process.send_signal(signal.SIGINT)
    assert caller.code() == 130


REAL = ["--clock", "real", "--transport", "corba"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--only", "Counter0"], 2, "--only needs --transport corba"),
        (["--transport", "corba", "--only", "Counter0"], 2, "needs --clock real"),
        ([*REAL, "--only", "Counter1"], 2, "no component 'Counter1' in the system"),
        ([*REAL, "--only", "Counter0", "--until", "Caller0=ERROR"], 2, "SYS0009"),
        ([*REAL, "--only", "Counter0", "--set", "Caller0.x=1"], 2, "SYS0009"),
        ([*REAL, "--nameserver", "127.0.0.1:1"], 3, "service answers at 127.0.0.1:1:"),
        ([*REAL, "--nameserver", "127.0.0.1:1"], 3, "hint: start omniNames there"),
        ([*REAL, "--nameserver", "???"], 3, "no naming service answers at ???"),
        ([*REAL, "--nameserver", "localhost:x"], 2, "is not HOST or HOST:PORT"),
        ([*REAL, "--nameserver", "127.0.0.1:65536"], 2, "is not HOST or HOST:PORT"),
        ([*REAL, "--nameserver", ""], 2, "is not HOST or HOST:PORT"),
        ([*REAL, "--call-timeout", "nan"], 2, "nan is not a number of that range"),
        ([*REAL, "--wait", "inf"], 2, "is not in the range"),
    ],
)
def test_refusals(
    project: Path,
    arguments: list[str],
    code: int,
    message: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert rtgen(["run", "calc.xml", *arguments]) == code
    assert message in capfd.readouterr().err


def test_an_address_of_another_machine(start: Callable[..., Run]) -> None:
    # In a process of its own: an ORB that runs already keeps its end point.
    run = start("--endpoint", "203.0.113.1")
    assert run.code() == 3
    assert "omniORB cannot listen at 203.0.113.1" in run.error_text()


def test_a_process_waits_for_data_ports_of_others(
    project: Path, names: str, capfd: pytest.CaptureFixture[str]
) -> None:
    text = (project / "calc.xml").read_text()
    connector = (
        '  <rts:DataPortConnectors rts:connectorId="2" rts:name="data" '
        'rts:dataType="IDL:Calc/Result:1.0" rts:interfaceType="corba_cdr" '
        'rts:dataflowType="push" rts:subscriptionType="flush">\n'
        '    <rts:sourceDataPort rts:componentId="RTC:rtgen:Test:Counter:1.0.0" '
        'rts:instanceName="Counter0" rts:portName="Counter0.done"/>\n'
        '    <rts:targetDataPort rts:componentId="RTC:rtgen:Test:Caller:1.0.0" '
        'rts:instanceName="Caller0" rts:portName="Caller0.done"/>\n'
        "  </rts:DataPortConnectors>\n  <rts:ServicePortConnectors"
    )
    (project / "data.xml").write_text(
        text.replace("  <rts:ServicePortConnectors", connector)
    )
    options = [*REAL, "--nameserver", names, "--only"]
    alone = [*options, "Counter0", "--wait", "1.3", "--until", "0.1"]
    assert rtgen(["run", "data.xml", *alone]) == 3
    errors = capfd.readouterr().err
    assert "waiting for other processes: Caller0\n" in errors
    assert "Counter0.done waits for Caller0.done; the naming service" in errors
    assert "has no Caller0.rtc that answers" in errors
    assert (
        rtgen(["run", "data.xml", *options, "Counter0,Caller0", "--until", "0.1"]) == 0
    )


def test_a_missing_package_is_reported_with_its_extra(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [n for n in sys.modules if n.startswith("rtgen.runtime.corba.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "omniORB", None)
    command = ["run", "calc.xml", "--transport", "corba", "--until", "1"]
    assert rtgen(command) == 3
    errors = capfd.readouterr().err
    assert "--transport corba needs omniORBpy, which is not installed" in errors
    assert "pip install 'rtgen[corba]'" in errors


def test_a_port_that_only_provides_waits_for_nobody(
    project: Path, names: str, stack: ExitStack
) -> None:
    from calc_nodes import Counter

    transport = stack.enter_context(CorbaTransport(name_server=names))
    system = stack.enter_context(runtime.System(runtime.RealClock(), transport))
    counter = Counter("Counter0")
    system.add(counter)
    system.connect(("Counter0", "adding"), ("Caller0", "adding"))
    transport.await_others(0.0)
    assert bool(ServicePort(counter, "adding"))
    system.disconnect(system.connectors[0])
