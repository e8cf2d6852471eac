"""The values of a quantity over time, which tools write as CSV or draw."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

Number: TypeAlias = float | int


@dataclass(slots=True)
class Curve:
    """Values over time [s]; `unit` is empty if the definition has none."""

    name: str
    unit: str = ""
    times: list[float] = field(default_factory=list)
    values: list[Number] = field(default_factory=list)

    @property
    def title(self) -> str:
        """The name with the unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def add(self, time: float, value: Number) -> None:
        """Append a value."""
        self.times.append(time)
        self.values.append(value)
