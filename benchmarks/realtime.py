"""Real time: what a tick costs, which are lost, and how exact they are, beside a bare loop.

    python benchmarks/realtime.py [--seconds S]

1 to 1,000 components that do nothing, at 10 Hz to 1 kHz, each case in a process of its own:
`shared`, rtgen; `own`, rtgen with a thread for each component; `relays`, rtgen with a chain of
components that pass on samples; `loop`, functions in a bare loop with absolute deadlines that, as
contexts do, makes up for the latest missed tick alone: what it loses, the machine loses; `rclpy`,
timers of one node in its executor; `openrtm`, components in the manager of OpenRTM-aist-Python. The
last two where they are installed. Rounds of the kinds alternate; figures are medians of rounds: the
part of a core that the process takes, processor time for each tick, ticks that did not happen, and
how far the intervals between the ticks of one component are from its period (median, 99 %).
"""

from __future__ import annotations

import statistics
from pathlib import Path

from kinds import of_openrtm, of_rclpy, of_rtgen
from tables import Arguments, Results

ENDS = Path(__file__).with_name("realtime_ends.py")
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
COLUMNS = ("core", "tick", "lost", "jitter", "worst", "late")
"""Figures of one round: `core` and `lost` as parts, times in microseconds."""


def main() -> None:
    """Print a table of all cases."""
    parser = Arguments(__doc__, rounds=3)
    parser.add_argument("--seconds", type=float, default=3.0)
    chosen = parser.parse_args()
    kinds = [*of_rtgen("shared", "own", "relays", "loop")]
    if chosen.smallest:
        chosen.seconds = 0.2
    else:
        kinds += [*of_rclpy(), *of_openrtm()]
    with Results(__file__, chosen) as results:
        table = results.table(
            "ticks",
            "components, rate, kind",
            ("of a core", ".1%"),
            ("µs a tick", ".2f"),
            ("lost", ".1%"),
            ("jitter, median [µs]", ".0f"),
            ("99 % [µs]", ".0f"),
            ("end late [ms]", ".1f"),
        )
        for count, rate in SMALLEST if chosen.smallest else CASES:
            taken = [
                k for k in kinds if count <= FEW or k.name not in ("own", "openrtm")
            ]
            rounds = [
                [k.figures(ENDS, count, rate, chosen.seconds) for k in taken]
                for _ in range(chosen.rounds)
            ]
            for kind, each in zip(taken, zip(*rounds, strict=True), strict=True):
                *figures, late = (
                    statistics.median(one[column] for one in each) for column in COLUMNS
                )
                title = f"{count:,} at {rate:,} Hz, {kind.name}"
                table.add(title, *figures, late / 1000)


if __name__ == "__main__":
    main()
