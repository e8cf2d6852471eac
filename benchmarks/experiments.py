"""Speed of the joint experiments in simulated time, relative to real time.

    python benchmarks/experiments.py

Each runs as `rtgen run` does it, without pictures. The bound is 50 times real time.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

from tables import Arguments, Results

from rtgen import runtime
from rtgen.compiler.project import load
from rtgen.compiler.systems import conditions, timeline
from rtgen.compiler.systems.reading import read_file
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

ROOT = Path(__file__).resolve().parent.parent
EXPERIMENTS = Path("specs/experiments")
NAMES = ("interchange", "two_robots", "chain", "leader_exchange", "one_to_four")
BOUND = 50.0


def ratio(name: str) -> tuple[float, float]:
    """Return the simulated seconds of one experiment, and how many of them ran in each second."""
    folder = EXPERIMENTS / name
    profile, diagnostics, _ = read_file(folder / "system.xml")
    if profile is None:
        raise SystemExit("\n".join(d.message for d in diagnostics))
    plan = timeline.load(folder / "timeline.toml", profile)
    text = dict(profile.properties)["rtgen.run.until"]
    end = conditions.condition(text, profile, None).limit
    assert end is not None
    factories = Factories(load())
    clock = runtime.SimulatedClock()
    with assemble(profile, factories, clock, (), plan.steps) as system:
        begun = time.perf_counter()
        system.run(end)
        taken = time.perf_counter() - begun
    seconds = end / runtime.SECOND
    return seconds, seconds / taken


def main() -> None:
    """Print the ratios; exit with 1 if one is below the bound."""
    chosen = Arguments(__doc__, rounds=3).parse_args()
    os.chdir(ROOT)
    slow = False
    with Results(__file__, chosen) as results:
        columns = ("simulated [s]", ".0f"), ("times real time", ".0f")
        table = results.table("ratios", f"experiment (at least {BOUND:g})", *columns)
        for name in NAMES[:1] if chosen.smallest else NAMES:
            runs = [ratio(name) for _ in range(chosen.rounds)]
            best = max(found for _, found in runs)
            slow |= best < BOUND
            table.add(name, runs[0][0], best)
    sys.exit(slow and not chosen.smallest)


if __name__ == "__main__":
    main()
