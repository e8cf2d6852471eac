"""A data port's write and read in one process, compared with `collections.deque`.

    python benchmarks/ports.py

Rounds are interleaved; medians and ratios are printed. The deque
passes a reference; the port passes a snapshot, through a ring buffer that counts losses. Values are
checked as `System(check_values=...)` says, by default the first ones. Processes with `rtgen-speed`,
if it is built (`python tests/speed.py`), and processes without it take turns.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from tables import Arguments, Results

from refrobots import iis
from rtgen.facts.value_checks import CheckValues
from rtgen.runtime import (
    RTC_OK,
    SECOND,
    Component,
    ComponentProfile,
    ReturnCode_t,
    System,
)

CALLS = 20_000
BUILT = Path(__file__).resolve().parent.parent / "build" / "speed"
CODECS = ("c", "python")
DEQUE = "deque append and popleft"


class Idle(Component):
    """A component without behaviour."""

    profile = ComponentProfile("Idle")

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return RTC_OK


def per_call(function: Callable[[], None]) -> float:
    """Return the processor time of one of CALLS repetitions inside `function` [ns]."""
    start = time.thread_time_ns()
    function()
    return (time.thread_time_ns() - start) / CALLS


def sample(elements: int) -> iis.TimedVelocity2D:
    """Return a TimedVelocity2D with that many ids and errors."""
    value = iis.TimedVelocity2D(id=list(range(elements)), error=[0.5] * elements)
    value.data.vx = 0.3
    return value


def port_case(
    value: iis.TimedVelocity2D, check: CheckValues = CheckValues.FIRST
) -> Callable[[], None]:
    """Return write and read over a connection in simulated time."""
    system = System(check_values=check)
    writer, reader = Idle("writer"), Idle("reader")
    out = writer.add_out_port("velocity", iis.TimedVelocity2D)
    port = reader.add_in_port("InTargetVelocity", iis.TimedVelocity2D)
    system.add(writer)
    system.add(reader)
    system.connect(("writer", "velocity"), ("reader", "InTargetVelocity"))

    def run() -> None:
        write, read = out.write, port.read
        for _ in range(CALLS):
            write(value)
            read()

    return run


def snapshot_case(value: iis.TimedVelocity2D) -> Callable[[], None]:
    """Return the copying of a value alone."""

    def run() -> None:
        snapshot = value._snapshot_
        for _ in range(CALLS):
            snapshot()

    return run


def deque_case(value: iis.TimedVelocity2D) -> Callable[[], None]:
    """Return the comparison: a bounded deque."""
    samples: deque[iis.TimedVelocity2D] = deque(maxlen=8)

    def run() -> None:
        append, popleft = samples.append, samples.popleft
        for _ in range(CALLS):
            append(value)
            popleft()

    return run


def scheduler_share() -> float:
    """Return the scheduler's nanoseconds for a tick: empty ticks less calls of `on_execute`."""
    system = System()
    components = [Idle(f"Idle{number}") for number in range(6)]
    for component in components:
        system.add(component, 1000.0)
        system.activate(component.instance_name)
    system.run(until_ns=SECOND // 1000)
    ticks = len(components) * 1000
    start = time.thread_time_ns()
    system.run(until_ns=system.time + SECOND)
    whole = time.thread_time_ns() - start
    start = time.thread_time_ns()
    for _ in range(1000):
        for component in components:
            component.on_execute(0)
    return (whole - (time.thread_time_ns() - start)) / ticks


def medians(rounds: int) -> dict[str, float]:
    """Return the median of the rounds of each case in this process [us]."""
    cases = {DEQUE: deque_case(sample(0))}
    for elements in (0, 3):
        value = sample(elements)
        label = f"TimedVelocity2D, {elements} ids and errors"
        cases[f"port write and read, {label}"] = port_case(value)
        for check in (CheckValues.NEVER, CheckValues.ALWAYS):
            cases[f"  checked {check}, {label}"] = port_case(value, check)
        cases[f"  of that the snapshot, {label}"] = snapshot_case(value)
    times: dict[str, list[float]] = {name: [] for name in cases}
    shares: list[float] = []
    for _ in range(rounds):
        for name, case in cases.items():
            times[name].append(per_call(case))
        shares.append(scheduler_share())
    times["scheduler, for each tick in simulated time"] = shares
    return {name: statistics.median(found) / 1000 for name, found in times.items()}


def in_a_process(codec: str, rounds: int) -> dict[str, float]:
    """Return the medians of a process with this codec."""
    path = os.pathsep.join(filter(None, (str(BUILT), os.environ.get("PYTHONPATH"))))
    answer = subprocess.run(
        [sys.executable, __file__, "--rounds", str(rounds), "--figures"],
        env={**os.environ, "RTGEN_CODEC": codec, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    found: dict[str, float] = json.loads(answer.stdout)
    return found


def main() -> None:
    """Print the table."""
    parser = Arguments(__doc__, rounds=21)
    parser.add_argument(
        "--figures", action="store_true", help="print those of this process as JSON"
    )
    chosen = parser.parse_args()
    if chosen.figures:
        print(json.dumps(medians(chosen.rounds)))
        return
    codecs = CODECS if BUILT.exists() else CODECS[1:]
    turns = min(chosen.rounds, 3)
    found: dict[str, list[dict[str, float]]] = {codec: [] for codec in codecs}
    for _ in range(turns):
        for codec in codecs:
            found[codec].append(in_a_process(codec, chosen.rounds // turns))
    with Results(__file__, chosen) as results:
        columns = [
            (f"in {codec.title()} [µs]", ".3f") if of == "µs" else (of, ".1f")
            for codec in codecs
            for of in ("µs", "times the deque")
        ]
        table = results.table("calls", "call", *columns)
        for name in found["python"][0]:
            row = []
            for codec in codecs:
                figure = min(turn[name] for turn in found[codec])
                row += [figure, figure / min(turn[DEQUE] for turn in found[codec])]
            table.add(name, *row)


if __name__ == "__main__":
    main()
