"""The rows of the table in docs/life-cycle.md."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

DOCUMENT = Path(__file__).parents[1] / "docs" / "life-cycle.md"
STATES = {"CREATED", "Alone", "INACTIVE", "ACTIVE", "ERROR"}


@dataclass(frozen=True)
class Row:
    """The effect of a request in a state."""

    state: str
    request: str
    fails: str
    answer: str
    callbacks: list[str]
    new_state: str

    def __str__(self) -> str:
        failing = f" {self.fails} fails" if self.fails else ""
        return f"{self.state} {self.request}{failing}".replace(" ", "-")


def read_table() -> list[Row]:
    """Return all rows, in order."""
    rows = []
    for line in DOCUMENT.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and cells[0] in STATES:
            calls = [name.strip() for name in cells[4].split(",") if name.strip()]
            rows.append(Row(*cells[:4], calls, cells[5]))
    return rows
