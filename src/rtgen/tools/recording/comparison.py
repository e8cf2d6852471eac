"""Compares two recordings, source by source."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any

from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.recording.events import Event, Log
from rtgen.tools.recording.selection import source

_WIDEST = 60


@dataclass(slots=True)
class Comparison:
    """Comparison of one source's events: unmatched events of either file, and the difference."""

    waiting: tuple[deque[Event], deque[Event]] = field(
        default_factory=lambda: (deque(), deque())
    )
    counts: list[int] = field(default_factory=lambda: [0, 0])
    same: int = 0
    first: str = ""

    def take(self, side: int, event: Event) -> None:
        """Compare an event with that of the other file, or store it until that is read."""
        self.counts[side] += 1
        if self.first:
            return
        others = self.waiting[1 - side]
        if not others:
            self.waiting[side].append(event)
            return
        pair = (event, others.popleft()) if side == 0 else (others.popleft(), event)
        if pair[0] == pair[1]:
            self.same += 1
        else:
            self.first = _difference(*pair)
            self.waiting[0].clear()
            self.waiting[1].clear()

    def text(self) -> str:
        """Return the difference; empty if there is none."""
        counts = f"{self.counts[0]} and {self.counts[1]} events"
        if self.first:
            return f"{self.first} ({counts})"
        return counts if self.counts[0] != self.counts[1] else ""


def compare(
    one: Log, other: Log, is_selected: Callable[[Mapping[str, Any]], bool]
) -> dict[tuple[str, str], Comparison]:
    """Compare two files in order, by source of events. Raises RecordingError."""
    comparisons: dict[tuple[str, str], Comparison] = {}
    for pair in zip_longest(one.events(is_selected), other.events(is_selected)):
        for side, event in enumerate(pair):
            if event is not None:
                key = event["event"], source(event)
                comparisons.setdefault(key, Comparison()).take(side, event)
    return comparisons


def _difference(one: Event, other: Event) -> str:
    at = f"at {one['t'] / SECOND:.6f} s"
    if one["t"] != other["t"]:
        return f"{at}, and at {other['t'] / SECOND:.6f} s"
    path, left, right = next(_differences(one, other, ""))
    return f"{at}: {path.removeprefix('.')} is {_short(left)}, and {_short(right)}"


def _differences(one: Any, other: Any, path: str) -> Iterator[tuple[str, Any, Any]]:
    if isinstance(one, dict) and isinstance(other, dict):
        for key in [*one, *(key for key in other if key not in one)]:
            yield from _differences(one.get(key), other.get(key), f"{path}.{key}")
    elif isinstance(one, list) and isinstance(other, list):
        for index, (left, right) in enumerate(zip_longest(one, other)):
            yield from _differences(left, right, f"{path}[{index}]")
    elif one != other:
        yield path, one, other


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _WIDEST else f"{text[:_WIDEST]}..."
