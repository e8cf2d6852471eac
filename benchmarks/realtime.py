"""Real time: what a tick costs, which are lost, and how exact they are, beside a bare loop.

    python benchmarks/realtime.py [--rounds N] [--seconds S] [--smallest]

1 to 1,000 components that do nothing, at 10 Hz to 1 kHz, each case in a process of its own:
`shared`, rtgen; `own`, rtgen with a thread for each component; `relays`, rtgen with a chain of
components that pass on samples; `loop`, functions in a bare loop with absolute deadlines; `rclpy`,
timers of one node in its executor; `openrtm`, components in the manager of OpenRTM-aist-Python. The
last two where they are installed. Rounds of the kinds alternate; figures are medians of rounds: the
part of a core that the process takes, processor time for each tick, ticks that did not happen, and
how far the intervals between the ticks of one component are from its period (median, 99 %).
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

ENDS = HERE / "realtime_ends.py"
CASES = (
    (1, 10),
    (1, 1000),
    (10, 100),
    (100, 100),
    (100, 1000),
    (1000, 10),
    (1000, 100),
)
SMALLEST = ((1, 100), (3, 100))
FEW = 100
"""Number of components above which kinds with a thread for each are left out."""


class Figures(NamedTuple):
    """Those of one round: `core` and `lost` as parts, times in microseconds."""

    core: float
    tick: float
    lost: float
    jitter: float
    worst: float
    late: float


def kinds(*, smallest: bool) -> Iterator[tuple[str, str, dict[str, str]]]:
    """Yield the kinds that can be measured, with their interpreters and environments."""
    environment = dict(os.environ)
    for kind in ("shared", "own", "relays", "loop"):
        yield kind, sys.executable, environment
    if smallest:
        return
    from media import own_domain
    from ros2_peers import DISTRIBUTIONS, make

    ros2 = make(DISTRIBUTIONS[0])
    if isinstance(ros2, str):
        print(f"rclpy is left out: {ros2}")
    else:
        yield "rclpy", ros2.python, ros2.environment(own_domain())
    if importlib.util.find_spec("OpenRTM_aist") is None:
        print("openrtm is left out: OpenRTM_aist is not installed")
    else:
        yield "openrtm", sys.executable, environment


def measured(
    kind: str,
    python: str,
    environment: dict[str, str],
    case: tuple[int, int],
    seconds: float,
) -> Figures:
    """Run one kind once."""
    command = [python, str(ENDS), kind, *map(str, case), str(seconds)]
    done = subprocess.run(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=600,
    )
    return Figures(**json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """Print a table of all cases."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument(
        "--smallest", action="store_true", help="one short round, without peers"
    )
    options = parser.parse_args()
    if options.smallest:
        options.rounds, options.seconds = 1, 0.2
    every = list(kinds(smallest=options.smallest))
    print(
        "components    Hz  kind      core  us/tick   lost  jitter  99 % [us]  end late [ms]"
    )
    for case in SMALLEST if options.smallest else CASES:
        taken = [k for k in every if case[0] <= FEW or k[0] not in ("own", "openrtm")]
        rounds: dict[str, list[Figures]] = {kind: [] for kind, _, _ in taken}
        for _ in range(options.rounds):
            for kind, python, environment in taken:
                rounds[kind].append(
                    measured(kind, python, environment, case, options.seconds)
                )
        for kind, figures in rounds.items():
            core, tick, lost, jitter, worst, late = map(
                statistics.median, zip(*figures, strict=True)
            )
            print(
                f"{case[0]:10} {case[1]:5}  {kind:7} {core:6.1%} {tick:8.2f} {lost:6.1%}"
                f" {jitter:7.0f} {worst:10.0f} {late / 1000:14.1f}"
            )


if __name__ == "__main__":
    main()
