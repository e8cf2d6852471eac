"""`rtgen run --supervise`: a process for each group, restarted when it dies."""

from __future__ import annotations

import os
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from logged_process import LoggedProcess

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from refrobots import checkpoints
from rtgen.cli import run as rtgen
from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.model import System, SystemComponent
from rtgen.runtime import CheckpointFolder
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.supervision import divided

GOAL = Path(__file__).parents[3] / "specs" / "navigation" / "rh3_goal.xml"
WITH_STATE = ["OmniTo2WD0", "Odometry0", "RefHardRh30"]
"""Components with state that is not sent again."""
OTHERS = ["PathFollower0", "Navigation0", "PositionInput0"]
PLACE = Span("s.xml", 1, 1, 1, 2)


class Supervised(LoggedProcess):
    """A supervised run, in a process of its own."""

    def __init__(
        self, folder: Path, *arguments: str, system: str = "calc.xml", path: str = ""
    ) -> None:
        command = ["-m", "rtgen", "run", system, "--clock", "real"]
        command += ["--transport", "corba", *arguments]
        paths = path or os.pathsep.join([str(folder), str(folder / "generated")])
        log = folder / f"out-{len(list(folder.iterdir()))}.txt"
        super().__init__(command, folder, {**os.environ, "PYTHONPATH": paths}, log)

    def activates(self, name: str, times: int = 1) -> None:
        """Wait until a component has been activated that many times."""
        state = re.compile(rf"{name} \| [0-9.]+ s: {name} ACTIVE")
        self.wait_for(lambda: len(state.findall(self.text)) >= times)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("supervised") / "project"
    shutil.copytree(Path(__file__).with_name("corba_system"), made)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        assert rtgen(["generate", "-q"]) == 0
    nodes = made / "calc_nodes.py"
    # Each process writes its number to a file.
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
        if each.runs:
            each.end()


@pytest.mark.nightly
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


@pytest.mark.sampled(0)
def test_a_process_that_is_not_started_again(
    supervised: Callable[..., Supervised], folder: Path
) -> None:
    run = supervised("--supervise", "never")
    run.activates("Counter0")
    os.kill(int((folder / "Counter0.pid").read_text()), signal.SIGKILL)
    run.says("was ended by SIGKILL; it is not started again (--supervise never)")
    run.says("condition: failed, without Counter0")
    assert run.end() == 1


def test_a_group_has_one_process_and_the_run_ends_with_its_time(
    supervised: Callable[..., Supervised], folder: Path
) -> None:
    group = ["--group", "Caller0,Counter0"]
    run = supervised("--supervise", "on-failure", *group, "--until", "0.2")
    assert run.code() == 0
    assert "Counter0,Caller0 | elapsed [s]  0.2" in run.text


WRITING_DOWN = """
import os, sys
if "--only" in sys.argv:
    name = sys.argv[sys.argv.index("--only") + 1]
    with open(os.path.join(os.path.dirname(__file__), name + ".pid"), "w") as file:
        file.write(str(os.getpid()))
"""


@pytest.mark.nightly
@pytest.mark.longest
def test_rh3_reaches_its_goal_though_each_component_is_killed_once(
    tmp_path: Path,
) -> None:
    (tmp_path / "sitecustomize.py").write_text(WRITING_DOWN)
    kept = tmp_path / "kept"
    arguments = ["--supervise", "on-failure", "--checkpoints", str(kept)]
    for name, value in (("01_x", "1.2"), ("01_y", "0.6"), ("01_th", "0")):
        arguments += ["--set", f"PositionInput0.{name}={value}"]
    run = Supervised(tmp_path, *arguments, system=str(GOAL), path=str(tmp_path))

    def base() -> checkpoints.Base:
        found = CheckpointFolder(kept).file("RefHardRh30").read()
        return checkpoints.Base.from_cdr(found[1]) if found else checkpoints.Base()

    try:
        for name in (*WITH_STATE, *OTHERS):
            run.activates(name)
        for names in (*([name] for name in WITH_STATE), OTHERS):
            # Under way: the wheels have turned since the last process was killed.
            before = base().angles
            run.wait_for(lambda before=before: base().angles != before)
            for name in names:
                os.kill(int((tmp_path / f"{name}.pid").read_text()), signal.SIGKILL)
            for name in names:
                run.activates(name, 2)
        assert run.code() == 0
    finally:
        if run.runs:
            run.end()
    assert run.text.count("was ended by SIGKILL; it is started again") == 6
    position = base().pose.position
    assert abs(position.x - 1.2) < 0.05
    assert abs(position.y - 0.6) < 0.05


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
