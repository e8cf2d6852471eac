"""Whole-process times of the command line on the reference build, beside omniidl.

Cold: empty cache, no compiled bytecode of anything (rtgen, libraries, standard library), new
output folder. Warm: cache and bytecode there, tree unchanged. Median of five, interleaved.
"""

from __future__ import annotations

import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ROUNDS = 5
RTGEN = [sys.executable, "-m", "rtgen"]
GOALS = {"cold generate": (4.0, 200.0), "warm check": (0.5, 200.0)}
"""Bounds: seconds, and MB of peak memory."""


@dataclass(slots=True)
class Figures:
    """Wall times in seconds, peak memory in MB."""

    times: list[float] = field(default_factory=list)
    peak: float = 0.0


def measure(
    command: list[str], environment: Mapping[str, str], figures: Figures
) -> None:
    """Runs a command to its end and notes its time and memory; a failure ends the benchmark."""
    start = time.perf_counter()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    actions = [(os.POSIX_SPAWN_DUP2, nowhere, 1), (os.POSIX_SPAWN_DUP2, nowhere, 2)]
    process = os.posix_spawn(command[0], command, environment, file_actions=actions)
    _, status, usage = os.wait4(process, 0)
    elapsed = time.perf_counter() - start
    os.close(nowhere)
    if os.waitstatus_to_exitcode(status) != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    figures.times.append(elapsed)
    figures.peak = max(figures.peak, usage.ru_maxrss / 1024)


def commands(
    folder: Path,
) -> dict[str, Callable[[int], tuple[list[str], dict[str, str]]]]:
    """What is measured: name to the command and environment of a round."""
    shared = os.environ | {"RTGEN_CACHE_DIR": str(folder / "cache")}

    def cold(number: int) -> tuple[list[str], dict[str, str]]:
        fresh = {
            "RTGEN_CACHE_DIR": str(folder / f"cache{number}"),
            "PYTHONPYCACHEPREFIX": str(folder / f"bytecode{number}"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return [
            *RTGEN,
            "generate",
            "-o",
            str(folder / f"out{number}"),
        ], os.environ | fresh

    found: dict[str, Callable[[int], tuple[list[str], dict[str, str]]]] = {
        "empty interpreter": lambda _: ([sys.executable, "-c", ""], shared),
        "rtgen --version": lambda _: ([*RTGEN, "--version"], shared),
        "warm check": lambda _: ([*RTGEN, "check"], shared),
        "check --no-cache": lambda _: ([*RTGEN, "check", "--no-cache"], shared),
        "cold generate": cold,
    }
    omniidl = shutil.which(
        "omniidl", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    )
    if omniidl is not None:
        dump = [omniidl, "-bdump", "-I", "specs/idl"]
        files = [str(f) for f in sorted(Path("specs/idl").glob("*.idl"))]
        found["omniidl -bdump (types only)"] = lambda _: ([*dump, *files], shared)
    else:
        print("omniidl: not found, so no peer (pip install jeteve-omniorb)")
    return found


def main() -> None:
    """Prints median, least and ratio to the empty interpreter, and peak memory."""
    os.chdir(ROOT)
    figures: dict[str, Figures] = {}
    with tempfile.TemporaryDirectory() as temporary:
        measured = commands(Path(temporary))
        for number in range(-1, ROUNDS):  # the first round warms cache and bytecode up
            for name, command in measured.items():
                known = figures.setdefault(name, Figures())
                measure(*command(number), Figures() if number < 0 else known)
    base = statistics.median(figures["empty interpreter"].times)
    print(f"Python {sys.version.split()[0]}, median of {ROUNDS}")
    print(f"{'':<30}{'median':>10}{'least':>10}{'x empty':>10}{'peak':>10}")
    for name, known in figures.items():
        median = statistics.median(known.times)
        goal = GOALS.get(name)
        told = "" if goal is None else f"  (bounds: {goal[0]:g} s, {goal[1]:g} MB)"
        print(
            f"{name:<30}{median:>8.3f} s{min(known.times):>8.3f} s{median / base:>10.1f}"
            f"{known.peak:>7.0f} MB{told}"
        )


if __name__ == "__main__":
    main()
