"""Systems over omniORB: failures and refusals."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from patience import PATIENCE, until

pytest.importorskip("omniORB", reason="omniORBpy is not installed")


import omniORB
from corba_runs import REAL, Here, Run
from omniORB import CORBA

from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming

pytestmark = pytest.mark.waits


@pytest.mark.nightly
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

    until(answered)


@pytest.mark.sampled(0)
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


@pytest.mark.sampled(0)
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


@pytest.mark.nightly
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
    caller.wait_for("waiting for other processes")
    caller.process.send_signal(signal.SIGINT)
    assert caller.code() == 130, caller.error_text()


def test_ctrl_c_within_a_request_to_the_naming_service() -> None:
    """omniORBpy replaces the KeyboardInterrupt of a call by an error of its own."""

    class Root:
        def resolve(self, path: object) -> object:
            raise CORBA.UNKNOWN(omniORB.UNKNOWN_PythonException)

    naming = object.__new__(Naming)
    naming.address, naming._root = "127.0.0.1", Root()
    with pytest.raises(KeyboardInterrupt):
        naming.providers(("Caller0", "calc"))


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
    # In a process of its own: a running ORB keeps its end point.
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


def test_a_naming_service_ends_with_its_process_though_that_is_killed() -> None:
    program = (
        "import sys; from rtgen.runtime.corba.name_server import NameServer\n"
        "print(NameServer().address, flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", program]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:
        host, _, port = process.stdout.readline().strip().partition(":")
        socket.create_connection((host, int(port))).close()
        process.kill()

    def is_gone() -> bool:
        try:
            socket.create_connection((host, int(port))).close()
        except ConnectionRefusedError:
            return True
        return False

    until(is_gone)


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
    assert "pip install ./runtime '.[corba]' in a clone of rtgen" in errors
