"""Speed of the navigation pipeline in simulated time, relative to real time.

    python benchmarks/pipeline.py

Five figures: the system as specified; the same system with empty behaviours (same ports, rates and
connections), which is the runtime's share; the difference, which is the share of the behaviours
with their ports' traffic; and the system as specified with a log of all samples, as `rtgen run
--log` writes it, and with a recording, as `--record` writes it.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

from tables import Arguments, Results

from rtgen import runtime
from rtgen.compiler.model import System
from rtgen.compiler.project import load
from rtgen.compiler.systems.reading import read_file
from rtgen.runtime import RTC_OK, Component, ReturnCode_t
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

ROOT = Path(__file__).resolve().parent.parent
SYSTEM = Path("specs/navigation/rh3_goal.xml")
GOAL = 100.0
SECONDS = 10
"""Simulated time of a round [s]; the robot is under way throughout."""
LOGGED = "with a log"
RECORDED = "with a recording"


class IdleFactories(Factories):
    """The same components with empty callbacks."""

    def __getitem__(self, type_name: str) -> Callable[[str], Component]:
        kind = super().__getitem__(type_name)
        assert isinstance(kind, type)
        callbacks = [name for name in vars(Component) if name.startswith("on_")]
        # A callback that a component does not define is not called.
        own = [n for n in callbacks if getattr(kind, n) is not getattr(Component, n)]
        body = dict.fromkeys(own, _nothing)
        return type(type_name, (kind,), {**body, "on_initialize": lambda self: RTC_OK})


def _nothing(self: Component, *ec_id: int) -> ReturnCode_t:
    return RTC_OK


def ratio(profile: System, factories: Factories, form: str = "") -> float:
    """Return simulated over real time of one run."""
    with (
        TemporaryDirectory() as folder,
        McapWriter(Path(folder, "run.mcap")) as recording,
        assemble(profile, factories, runtime.SimulatedClock(), (), ()) as system,
        TemporaryFile("w", encoding="utf-8") as log,
    ):
        if form == LOGGED:
            system.add_listener(runtime.JsonLinesRecorder(log))
        elif form == RECORDED:
            Recorder(system, recording)
        begun = time.perf_counter()
        system.run(SECONDS * runtime.SECOND)
        return SECONDS / (time.perf_counter() - begun)


def main() -> None:
    """Print the ratios and shares."""
    chosen = Arguments(__doc__, rounds=5).parse_args()
    os.chdir(ROOT)
    profile, diagnostics, _ = read_file(SYSTEM)
    if profile is None:
        raise SystemExit("\n".join(d.message for d in diagnostics))
    project = load()
    kinds = {
        "as specified": Factories(project),
        "idle behaviours": IdleFactories(project),
    }
    ratios: dict[str, list[float]] = {name: [] for name in (*kinds, LOGGED, RECORDED)}
    for _ in range(chosen.rounds):
        for name, factories in kinds.items():
            ratios[name].append(ratio(profile, factories))
        for form in (LOGGED, RECORDED):
            ratios[form].append(ratio(profile, kinds["as specified"], form))
    medians = {name: statistics.median(values) for name, values in ratios.items()}
    whole, idle = (medians[name] for name in kinds)
    with Results(__file__, chosen) as results:
        columns = ("times real time", ".1f"), ("more time", "+.0%")
        title = f"{SECONDS} s of {profile.name} (goal {GOAL:g}, at least 50)"
        table = results.table("ratios", title, *columns)
        table.add("as specified", whole, None)
        table.add("idle behaviours: the runtime's share", idle, whole / idle - 1)
        for form in (LOGGED, RECORDED):
            table.add(form, medians[form], whole / medians[form] - 1)


if __name__ == "__main__":
    main()
