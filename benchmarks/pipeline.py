"""How much faster than real time the navigation pipeline runs in simulated time.

Four figures: the system as specified; the same system with behaviours that do nothing (ports,
rates and connections as they are), which is the runtime's share; the difference, which is that of
the behaviours with their ports' traffic; and the system as specified with a log of all samples, as
`rtgen run --log` writes it.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryFile

from rtgen import runtime
from rtgen.cli.assembly import assemble
from rtgen.cli.factories import Factories
from rtgen.model import System
from rtgen.project import load
from rtgen.runtime import RTC_OK, Component, ReturnCode_t
from rtgen.systems.reading import read_file

ROOT = Path(__file__).resolve().parent.parent
SYSTEM = Path("specs/navigation/rh3_goal.xml")
GOAL = 100.0
ROUNDS = 5
SECONDS = 10
"""Simulated time of a round; the robot is under way all the while."""
LOGGED = "with a log"


class IdleFactories(Factories):
    """The same components with callbacks that do nothing."""

    def __getitem__(self, type_name: str) -> Callable[[str], Component]:
        kind = super().__getitem__(type_name)
        assert isinstance(kind, type)
        callbacks = [name for name in vars(Component) if name.startswith("on_")]
        # A callback that a component leaves out is not called at all.
        own = [n for n in callbacks if getattr(kind, n) is not getattr(Component, n)]
        body = dict.fromkeys(own, _nothing)
        return type(type_name, (kind,), {**body, "on_initialize": lambda self: RTC_OK})


def _nothing(self: Component, *ec_id: int) -> ReturnCode_t:
    return RTC_OK


def ratio(profile: System, factories: Factories, *, logged: bool = False) -> float:
    """Simulated over real time of one run."""
    with (
        assemble(profile, factories, runtime.SimulatedClock(), (), ()) as system,
        TemporaryFile("w", encoding="utf-8") as log,
    ):
        if logged:
            system.add_listener(runtime.JsonLinesRecorder(log))
        begun = time.perf_counter()
        system.run(SECONDS * runtime.SECOND)
        return SECONDS / (time.perf_counter() - begun)


def main() -> None:
    """Prints the ratios and shares."""
    os.chdir(ROOT)
    profile, diagnostics, _ = read_file(SYSTEM)
    if profile is None:
        raise SystemExit("\n".join(d.message for d in diagnostics))
    project = load()
    kinds = {
        "as specified": Factories(project),
        "idle behaviours": IdleFactories(project),
    }
    ratios: dict[str, list[float]] = {name: [] for name in (*kinds, LOGGED)}
    for _ in range(ROUNDS):
        for name, factories in kinds.items():
            ratios[name].append(ratio(profile, factories))
        ratios[LOGGED].append(ratio(profile, kinds["as specified"], logged=True))
    whole, idle, logged = (statistics.median(values) for values in ratios.values())
    rates = ", ".join(
        f"{c.instance} {c.rate:g} Hz" for c in profile.components if c.rate
    )
    print(
        f"Python {sys.version.split()[0]}, median of {ROUNDS} runs of {SECONDS} s: {rates}"
    )
    print(f"as specified     {whole:8.1f} x real time  (goal {GOAL:g}, bound 50)")
    print(f"idle behaviours  {idle:8.1f} x real time")
    print(f"{LOGGED}       {logged:8.1f} x real time  ({whole / logged - 1:+.0%} time)")
    share = whole / idle
    print(
        f"share            runtime {share:.0%}, behaviours and their traffic {1 - share:.0%}"
    )


if __name__ == "__main__":
    main()
