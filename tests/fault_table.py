"""The tested faults, each with its outcome, its time bound, and its tests.

    python tests/fault_table.py > docs/faults.md

Tests compare with `bound(name)`; `test_table_of_faults.py` checks that each test exists and that
the page is up to date.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
_TABLE = Path(__file__).parent / "faults.toml"
_HEAD = """# Faults

*For those who must know what a failure does to the robot, and in what time.*

What a user sees in case of a fault, the time bound, and the effect on the data. Each row is
covered by the tests that it names; most run in simulated time, where a bound is exact. Tests over
DDS, Zenoh and CORBA wait longer for a state: leases and time-outs are the configured ones.
This page is generated from `tests/faults.toml` by `python tests/fault_table.py`.
"""


@dataclass(frozen=True, slots=True)
class Fault:
    """A row. `seconds` is the bound if tests compare with it."""

    section: str
    fault: str
    state: str
    bound: str
    data: str
    tests: tuple[str, ...]
    name: str = ""
    seconds: float | None = None


def faults() -> list[Fault]:
    """Return all rows, in the order of the page."""
    sections = tomllib.loads(_TABLE.read_text("utf-8"))["section"]
    return [
        Fault(
            section=section["title"],
            **{**row, "tests": tuple(row["tests"])},
        )
        for section in sections
        for row in section["fault"]
    ]


def bound(name: str) -> int:
    """Return the bound of the row of that name [ns]."""
    [seconds] = [row.seconds for row in faults() if row.name == name]
    assert seconds is not None
    return round(seconds * 1e9)


def page() -> str:
    """Return the text of docs/faults.md."""
    lines = [_HEAD]
    section = ""
    for row in faults():
        if row.section != section:
            section = row.section
            lines += [
                f"## {section}\n",
                "| fault | what a user sees | bound | data | tests |",
            ]
            lines.append("|---|---|---|---|---|")
        tests = "<br>".join(f"`{test.removeprefix('tests/')}`" for test in row.tests)
        cells = (row.fault, row.state, row.bound, row.data, tests)
        lines.append(f"| {' | '.join(cells)} |")
    text = "\n".join(lines) + "\n"
    return text.replace("|\n## ", "|\n\n## ")


if __name__ == "__main__":
    print(page(), end="")
