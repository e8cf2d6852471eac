"""The supervisor: processes that die, hang, flood and fork, and signals at any time."""

from __future__ import annotations

import os
import random
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from logged_process import LoggedProcess
from seeds import cases

pytestmark = [
    pytest.mark.waits,
    pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals"),
]

SUPERVISE = """
import signal
import sys
from rtgen.tools.kit.console import Console
from rtgen.tools.running import supervision
from rtgen.tools.running.supervision import Policy, Supervisor, Worker

supervision._FIRST_DELAY = supervision._MAX_DELAY = 0.05
supervision._SHUTDOWN_TIMEOUT = {patience}
supervision._INSISTING = 0.0
workers = [
    Worker(f"P{{n}}", [sys.executable, "-Sc", code], False, {limit})
    for n, code in enumerate(sys.argv[1:])
]
console = Console("text", False, False)
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda *_: None)  # what comes after the end
code = Supervisor(workers, Policy(True, 2), console).run()
print("over", flush=True)
sys.exit(code)
"""
WRITES = "import os; open(f'{os.getpid()}.pid', 'w').close();"
"""A child tells its number."""
SLEEPS = f"{WRITES} import time; print('ready', flush=True); time.sleep(1000)"
DEAF = f"import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); {SLEEPS}"
FORKS = f"{WRITES} import os; os.fork(); {SLEEPS}"

Start = Callable[..., LoggedProcess]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    runs: list[LoggedProcess] = []

    def started(
        *children: str, patience: float = 20.0, limit: float = 1e9
    ) -> LoggedProcess:
        script = SUPERVISE.format(patience=patience, limit=limit)
        command = ["-c", script, *children]
        log = tmp_path / f"log-{len(runs)}.txt"
        runs.append(LoggedProcess(command, tmp_path, dict(os.environ), log))
        return runs[-1]

    yield started
    for run in runs:
        if run.runs:
            run.end()


def living(folder: Path) -> list[int]:
    """Return the processes that have told their numbers and run."""
    found = [int(path.stem) for path in folder.glob("*.pid")]
    return [number for number in found if _lives(number)]


def _lives(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{number}/stat")
    return not (
        state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z"
    )


def test_a_process_that_dies_at_once_has_so_many_restarts(
    start: Start, tmp_path: Path
) -> None:
    run = start(f"{WRITES} raise SystemExit(3)", f"{WRITES} raise SystemExit(3)")
    assert run.code() == 1
    for name in ("P0", "P1"):
        assert run.text.count(f"{name}: process") == 3
    assert run.text.count("it is not started again after 2 restarts") == 2
    assert "condition: failed, without P0, P1\n" in run.text
    assert len([*tmp_path.glob("*.pid")]) == 6


def test_a_process_whose_time_is_over_is_not_started_again(
    start: Start, tmp_path: Path
) -> None:
    run = start(f"{WRITES} raise SystemExit(1)", limit=0.0)
    assert run.code() == 1
    assert "ended with exit code 1; its time was over" in run.text
    assert len([*tmp_path.glob("*.pid")]) == 1


def test_a_process_that_ignores_the_end_is_killed(start: Start, tmp_path: Path) -> None:
    run = start(DEAF, SLEEPS, patience=0.2)
    run.says("ready", 2)
    assert run.end() == 0
    assert living(tmp_path) == []


def test_a_further_signal_ends_what_ignores_the_first(
    start: Start, tmp_path: Path
) -> None:
    run = start(DEAF, SLEEPS, patience=1e6)
    run.says("ready", 2)
    run.process.send_signal(signal.SIGTERM)
    run.wait_for(lambda: len(living(tmp_path)) == 1)
    run.process.send_signal(signal.SIGINT)
    assert run.code() == 0
    assert living(tmp_path) == []


@pytest.mark.sampled(1)
@pytest.mark.parametrize("code", [FORKS, f"{WRITES} import os; os.fork(); {DEAF}"])
def test_what_a_process_has_started_ends_with_it(
    start: Start, tmp_path: Path, code: str
) -> None:
    run = start(code, patience=0.2)
    run.says("ready", 2)
    assert run.end() == 0
    assert living(tmp_path) == []


def test_what_a_dead_process_has_started_ends_before_it_is_started_again(
    start: Start, tmp_path: Path
) -> None:
    dies = f"{WRITES} import os\nif os.fork(): os._exit(1)\n{SLEEPS}"
    run = start(dies)
    assert run.code() == 1
    assert run.text.count("P0: process") == 3
    assert living(tmp_path) == []


def test_a_process_outside_its_group_does_not_hold_the_end_up(
    start: Start, tmp_path: Path
) -> None:
    leaves = (
        "import os, time\nif os.fork(): os._exit(0)\nos.setsid()\n"
        "while not os.path.exists('over'): time.sleep(0.05)"
    )
    run = start(leaves)
    try:
        assert run.code() == 0
    finally:
        (tmp_path / "over").touch()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("text", ["x", "\\x1b[2J\\0"])
def test_a_process_that_floods_is_printed_in_lines(start: Start, text: str) -> None:
    run = start(f"import sys; sys.stdout.write('{text}' * 200_000)")
    assert run.code() == 0
    lines = run.text.splitlines()
    assert max(map(len, lines)) <= 10_000 + len("P0 | ")
    assert run.text.count("x") in (0, 200_000)
    assert "\x1b" not in run.text


@pytest.mark.random
def test_signals_at_any_time_leave_no_process_behind(
    start: Start, tmp_path: Path
) -> None:
    for number in cases(4):
        drawn = random.Random(number)
        before = {*tmp_path.glob("*.pid")}
        run = start(SLEEPS, DEAF, SLEEPS, f"{WRITES} raise SystemExit(1)", patience=0.1)
        wanted = drawn.randrange(1, 5)
        run.wait_for(
            lambda before=before, wanted=wanted: (
                len({*tmp_path.glob("*.pid")} - before) >= wanted
            )
        )
        while "over" not in run.text:
            run.process.send_signal(drawn.choice((signal.SIGTERM, signal.SIGINT)))
        run.code()  # of a signal, if one came after the end of the run
        assert living(tmp_path) == []
        assert "Traceback" not in run.text
