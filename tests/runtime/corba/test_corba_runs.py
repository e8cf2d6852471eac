"""Systems over omniORB: in one process, and in several with a naming service."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import programs
import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")


from corba_runs import BOARD, NAVIGATION, ROOT, Here, Run
from free_ports import free_port

from rtgen.cli import run as rtgen

pytestmark = pytest.mark.waits


@pytest.mark.sampled(0)
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
    run = Run(project)
    run.wait_for("Caller0 ACTIVE")
    run.until(lambda: len(run.results()) > 10)
    assert run.end() == 0
    assert "naming service: 127.0.0.1:" in run.error_text()
    results = run.results()
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


def test_two_processes(start: Callable[..., Run]) -> None:
    caller = start("--only", "Caller0")
    counter = start("--only", "Counter0")
    caller.wait_for("Caller0 ACTIVE")
    caller.until(lambda: len(caller.results()) > 20)
    assert caller.end() == 0, caller.error_text()
    assert counter.end() == 0, counter.error_text()
    results = caller.results()
    # Counter0 is ACTIVE before Caller0 is, whichever process was first.
    assert results == [(i + 1, "") for i in range(len(results))]
    assert caller.output.startswith("instance  state   ticks")
    assert "Counter0" not in caller.output


@pytest.mark.nightly
@pytest.mark.slow
def test_the_wheels_of_rh3_in_one_process_and_its_marshaller_in_another(
    start: Callable[..., Run],
) -> None:
    port = str(free_port())
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


@pytest.mark.nightly
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

    def moves() -> str:
        """Return for each tick of the base so far whether the wheels moved."""
        wheels = [
            e["value"]["data"] for e in run.samples() if e["port"] == "OutWheelAngle"
        ]
        return "".join("01"[one != other] for one, other in pairwise(wheels))

    still, driving = "0" * 100, "1" * 50
    run.wait_for("PositionInput0 ACTIVE")
    run.until(lambda: driving in moves())
    asked("Stop")
    run.until(lambda: moves().endswith(still))
    asked("Go")
    run.until(lambda: driving in moves().rpartition(still)[2])
    assert run.end() == 130  # before its time is over
