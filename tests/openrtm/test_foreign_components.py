"""Systems with a component that rtgen does not run: one of OpenRTM, in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import middleware
import pytest
from openrtm_lab import until
from patience import PATIENCE

from rtgen.cli import run as rtgen

ROOT = Path(__file__).resolve().parents[2]
GOAL = ROOT / "specs" / "navigation" / "rh3_goal.xml"
CALC = ROOT / "tests" / "unit" / "corba" / "corba_system"
NEAR = {'"01_x" rts:data="3.4"': '"01_x" rts:data="0.2"'}
NEAR |= {'"01_y" rts:data="7.7"': '"01_y" rts:data="0"'}
NEAR |= {'"01_th" rts:data="-1.57"': '"01_th" rts:data="0"'}


class Process:
    """A process whose output goes to a file."""

    def __init__(
        self, command: list[str], folder: Path, environment: dict[str, str], log: Path
    ) -> None:
        self._log = log
        with log.open("w") as output:
            self.process = subprocess.Popen(
                [sys.executable, *command],
                cwd=folder,
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def text(self) -> str:
        """What it has printed."""
        return self._log.read_text()

    def says(self, text: str, times: int = 1) -> None:
        """Wait until it has said that so many times."""
        until(
            lambda: self.text.count(text) >= times or self.process.poll() is not None,
            PATIENCE,
        )
        assert self.text.count(text) >= times, self.text

    def end(self, number: int = signal.SIGTERM) -> int:
        """End it; its exit code."""
        self.process.send_signal(number)
        return self.code()

    def code(self) -> int:
        """Its exit code, once it has ended."""
        return self.process.wait(PATIENCE)


@pytest.fixture(scope="module")
def stubs(
    tmp_path_factory: pytest.TempPathFactory, rtm_folders: list[Path]
) -> dict[str, str]:
    """The environment of foreign processes, with the stubs of their own types."""
    folder = tmp_path_factory.mktemp("stubs")
    types = middleware.DATA_TYPES
    files = [types / "intellirobot.idl", CALC / "calc.idl"]
    middleware.compile_idl(folder, files, [types])
    return middleware.environment([folder, *rtm_folders])


@pytest.fixture
def launch(
    tmp_path: Path, naming_service: str, stubs: dict[str, str]
) -> Iterator[Callable[..., Process]]:
    """Starts processes: foreign ones by their kind, and `rtgen run`."""
    made: list[Process] = []

    def launched(
        *what: str, formats: str = "%n.rtc", folder: Path = ROOT, path: str = ""
    ) -> Process:
        log = tmp_path / f"{len(made)}.txt"
        if what[0] == "run":
            command = ["-m", "rtgen", *what, "--clock", "real", "--transport", "corba"]
            environment = {**os.environ, "PYTHONPATH": path}
        else:
            script = str(Path(__file__).with_name("foreign_process.py"))
            command, environment = [script, what[0], naming_service, formats], stubs
        made.append(Process(command, folder, environment, log))
        return made[-1]

    yield launched
    for each in made:
        if each.process.poll() is None:
            each.end(signal.SIGKILL)


def near_goal(folder: Path, path: str = "", marked: bool = True) -> str:
    """RH3 with a goal that is near, whose operator is foreign and at a path."""
    text = GOAL.read_text()
    changes = dict(NEAR)
    if path:
        changes['"localhost/PositionInput0.rtc"'] = f'"{path}"'
    if marked:
        own = '<rtsExt:Properties rtsExt:name="rtgen.foreign" rtsExt:value="PositionInput0"/>'
        changes["</rts:RtsProfile>"] = f"{own}</rts:RtsProfile>"
    for old, new in changes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    system = folder / "rh3.xml"
    system.write_text(text)
    return str(system)


@pytest.mark.once
def test_rh3_reaches_its_goal_with_a_foreign_operator_that_comes_late_and_is_killed(
    launch: Callable[..., Process], naming_service: str, tmp_path: Path, openrtm: str
) -> None:
    # By its path, below another naming service than that of the run.
    system = near_goal(tmp_path, f"{naming_service}/lab.host_cxt/PositionInput0.rtc")
    ours = launch("run", system)
    ours.says("waiting for other processes: PositionInput0")
    formats = "lab.host_cxt/%n.rtc"
    operator = launch("operator", formats=formats)
    operator.says("going")
    operator.end(signal.SIGKILL)
    ours.says("warning[SYS0024]: PositionInput0 is lost: its process does not answer")
    again = launch("operator", formats=formats)
    ours.says("PositionInput0 is there again")
    again.says("FINISH")
    assert ours.end() == 0
    found = next(line for line in ours.text.splitlines() if "final pose" in line)
    x, y, theta = (float(text) for text in found.partition("(")[2][:-1].split(","))
    assert abs(x - 0.2) < 0.05
    assert abs(y) < 0.05
    assert abs(theta) < 0.1


def test_a_foreign_component_that_is_absent(
    launch: Callable[..., Process], naming_service: str, tmp_path: Path, openrtm: str
) -> None:
    system = near_goal(tmp_path, marked=False)
    options = ["--foreign", "PositionInput0", "--nameserver", naming_service]
    ours = launch("run", system, *options, "--wait", "0.1")
    assert ours.code() == 3
    assert (
        "no process runs PositionInput0, which rtgen does not run: the naming service "
        f"{naming_service} has no PositionInput0.rtc, nor is anything at "
        "localhost/PositionInput0.rtc, that answers" in ours.text
    )


def test_a_foreign_component_of_another_type(
    launch: Callable[..., Process], naming_service: str, tmp_path: Path, openrtm: str
) -> None:
    mistaken = launch("mistaken")
    mistaken.says("ready")
    ours = launch("run", near_goal(tmp_path), "--nameserver", naming_service)
    assert ours.code() == 2
    assert (
        "error[SYS0003]: OmniTo2WD0.goal and PositionInput0..positon have different types: "
        "IDL:IIS/TimedPose2D:1.0 and IDL:RTC/TimedLong:1.0" in ours.text
    )


def test_a_foreign_component_without_a_parameter(
    launch: Callable[..., Process], naming_service: str, tmp_path: Path, openrtm: str
) -> None:
    system = Path(near_goal(tmp_path))
    system.write_text(system.read_text().replace('"01_x"', '"09_x"'))
    operator = launch("operator")
    operator.says("ready")
    ours = launch("run", str(system), "--nameserver", naming_service)
    assert ours.code() == 2
    assert (
        "error[SYS0004]: PositionInput0 has no parameter 09_x; it has: 01_th, 01_x, 01_y, input"
        in ours.text
    )


def test_a_foreign_component_provides_a_service(
    launch: Callable[..., Process],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for file in CALC.iterdir():
        if file.is_file():
            (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert rtgen(["generate", "-q"]) == 0
    adder = launch("adder", formats="%h.host_cxt/%n.rtc")
    adder.says("ready")
    options = ["--foreign", "Counter0", "--nameserver", naming_service]
    path = os.pathsep.join([str(tmp_path), str(tmp_path / "generated")])
    ours = launch(
        *("run", "calc.xml", *options, "--log", "log.jsonl"), folder=tmp_path, path=path
    )
    log = tmp_path / "log.jsonl"
    until(lambda: log.exists() and '"number": 5' in log.read_text(), PATIENCE)
    adder.end(signal.SIGKILL)
    ours.says("Counter0 is lost")
    again = launch("adder", formats="%h.host_cxt/%n.rtc")
    again.says("ready")
    ours.says("Counter0 is there again")
    size = log.stat().st_size
    until(lambda: '"error": ""' in log.read_text()[size:], PATIENCE)
    assert ours.end() == 0
