"""`rtgen run --supervise`: a process for each group, started again when it dies."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

import time

from rtgen.cli import run as rtgen
from rtgen.cli.common import Refusal
from rtgen.cli.supervision import divided
from rtgen.diagnostics import InputError, Span
from rtgen.model import System, SystemComponent

PLACE = Span("s.xml", 1, 1, 1, 2)


class Supervised:
    """A supervised run of the caller and the counter, in a process of its own."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self._output = folder / f"out-{len(list(folder.iterdir()))}.txt"
        command = [sys.executable, "-m", "rtgen", "run", "calc.xml", "--clock", "real"]
        command += ["--transport", "corba", *arguments]
        paths = [str(folder), str(folder / "generated")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        with self._output.open("w") as output:
            self.process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def text(self) -> str:
        """What it has printed."""
        return self._output.read_text()

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Wait for what is to happen while it runs."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert self.process.poll() is None, self.text
            assert time.monotonic() < deadline, self.text
            time.sleep(0.02)

    def says(self, text: str, times: int = 1) -> None:
        """Wait until it has said that."""
        self.wait_for(lambda: self.text.count(text) >= times)

    def activates(self, name: str, times: int = 1) -> None:
        """Wait until a component has become ACTIVE so often."""
        state = re.compile(rf"{name} \| [0-9.]+ s: {name} ACTIVE")
        self.wait_for(lambda: len(state.findall(self.text)) >= times)

    def end(self) -> int:
        """End it in order; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("supervised") / "project"
    shutil.copytree(Path(__file__).with_name("corba_system"), made)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        assert rtgen(["generate", "-q"]) == 0
    nodes = made / "calc_nodes.py"
    # Each process writes its number down.
    nodes.write_text(
        nodes.read_text().replace(
            "import time\n",
            "import os\nimport sys\nimport time\n"
            "open(f'{sys.argv[sys.argv.index(\"--only\") + 1]}.pid', 'w')"
            ".write(str(os.getpid()))\n",
            1,
        )
    )
    return made


@pytest.fixture
def supervised(folder: Path) -> Iterator[Callable[..., Supervised]]:
    runs: list[Supervised] = []

    def started(*arguments: str) -> Supervised:
        runs.append(Supervised(folder, *arguments))
        return runs[-1]

    yield started
    for each in runs:
        if each.process.poll() is None:
            each.end()


@pytest.mark.once
def test_each_process_that_dies_is_started_again_and_the_run_goes_on(
    supervised: Callable[..., Supervised], folder: Path
) -> None:
    run = supervised("--supervise", "on-failure")
    for number, name in enumerate(("Counter0", "Caller0"), 1):
        for each in ("Counter0", "Caller0"):
            run.activates(each)
        before = int((folder / f"{name}.pid").read_text())
        os.kill(before, signal.SIGKILL)
        run.says(f"{name}: process {before} on ")
        run.says("was ended by SIGKILL; it is started again in 0.5 s", number)
        run.says(f"condition: degraded, without {name}\n")
        run.says("condition: complete\n", number + 1)
        run.activates(name, 2)
        assert int((folder / f"{name}.pid").read_text()) != before
    assert run.end() == 0
    assert re.search(r"Caller0 \| Caller0 +ACTIVE", run.text)


@pytest.mark.once
def test_a_process_that_is_not_started_again(
    supervised: Callable[..., Supervised], folder: Path
) -> None:
    run = supervised("--supervise", "never")
    run.activates("Counter0")
    os.kill(int((folder / "Counter0.pid").read_text()), signal.SIGKILL)
    run.says("was ended by SIGKILL; it is not started again (--supervise never)")
    run.says("condition: failed, without Counter0")
    assert run.end() == 1


@pytest.mark.once
def test_a_group_has_one_process_and_the_run_ends_with_its_time(
    supervised: Callable[..., Supervised], folder: Path
) -> None:
    group = ["--group", "Caller0,Counter0"]
    run = supervised("--supervise", "on-failure", *group, "--until", "0.2")
    assert run.process.wait(PATIENCE) == 0
    assert "Counter0,Caller0 | elapsed [s]  0.2" in run.text


def system(*names: str) -> System:
    parts = [
        SystemComponent(instance=name, type="T", id="", path_uri="", span=PLACE)
        for name in names
    ]
    return System(
        name="s",
        id="",
        file="s.xml",
        abstract="",
        components=tuple(parts),
        connections=(),
    )


def test_groups() -> None:
    whole = system("A0", "B0", "C0", "D0")
    found = divided(whole, ["C0, A0"], ["D0"])
    assert found == [frozenset({"A0", "C0"}), frozenset({"B0"})]
    with pytest.raises(Refusal, match="A0 is in two groups"):
        divided(whole, ["A0", "A0,B0"], [])
    with pytest.raises(InputError):
        divided(whole, ["E0"], [])
    with pytest.raises(InputError):
        divided(whole, ["D0"], ["D0"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--supervise", "never"], "--supervise needs --clock real and --transport"),
        (["--group", "Caller0"], "--group needs --supervise"),
        (
            ["--supervise", "never", "--log", "x.jsonl"],
            "--supervise does not go with --log",
        ),
    ],
)
def test_options_that_do_not_go_together(
    folder: Path,
    arguments: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(folder)
    assert rtgen(["run", "calc.xml", *arguments]) == 2
    assert message in capsys.readouterr().err
