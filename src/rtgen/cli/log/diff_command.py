"""The command `rtgen log diff`: compares two recordings, source by source."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any

import click

from rtgen.cli.common import NO, OK, Console, with_console, write_out
from rtgen.cli.log.common import choice, reported, say_losses, source, with_choice
from rtgen.recording.events import Event, Log
from rtgen.runtime.timing.clocks import SECOND

_WIDEST = 60


@click.command("diff")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("other", type=click.Path(path_type=Path))
@with_choice
@with_console
def diff_(
    console: Console,
    file: Path,
    other: Path,
    names: tuple[str, ...],
    kinds: tuple[str, ...],
) -> int:
    """Compare the events of FILE and OTHER, MCAP or JSON lines.

    The events of each source (port, bus and so on) are compared in order, and the first difference
    of each source is shown. Only kinds of events that both formats contain are compared. Exit code
    1: the files differ.
    """
    with reported():
        logs = Log(file), Log(other)
        if any(log.mcap is None for log in logs) and not kinds:
            kinds = ("sample", "state")
        compared = compare(*logs, choice(names, kinds))
    for log in logs:
        say_losses(console, log)
    for (kind, name), of in compared.items():
        if text := of.text():
            write_out(f"{kind} {name}: {text}\n".replace(" :", ":"))
    differ = sum(bool(of.text()) for of in compared.values())
    equal = sum(of.same for of in compared.values())
    console.say(f"{equal} events are equal; {differ} of {len(compared)} sources differ")
    return NO if differ else OK


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
    one: Log, other: Log, wanted: Callable[[Mapping[str, Any]], bool]
) -> dict[tuple[str, str], Comparison]:
    """Compare two files in order, by source of events. Raises RecordingError."""
    found: dict[tuple[str, str], Comparison] = {}
    for pair in zip_longest(one.events(wanted), other.events(wanted)):
        for side, event in enumerate(pair):
            if event is not None:
                key = event["event"], source(event)
                found.setdefault(key, Comparison()).take(side, event)
    return found


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
