"""Selects events of recordings, and reports what cannot be read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rtgen.compiler.diagnostics import ToolError
from rtgen.tools.kit.console import Console
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_reader import McapFile


@contextmanager
def reported() -> Iterator[None]:
    """Convert errors of recordings to ToolError within the block."""
    try:
        yield
    except RecordingError as error:
        raise ToolError(str(error), hint=error.hint) from error


def say_losses(console: Console, log: Log | McapFile) -> None:
    """Print what could not be read of a log, of which all events were read."""
    for loss in log.losses():
        console.say(f"{log.path}: {loss}")


def choice(
    names: Sequence[str], kinds: Sequence[str]
) -> Callable[[Mapping[str, Any]], bool]:
    """Return a predicate of events, by kind, and by instance, port or bus."""

    def wanted(event: Mapping[str, Any]) -> bool:
        if kinds and event["event"] not in kinds:
            return False
        return not names or not {*_names(event)}.isdisjoint(names)

    return wanted


def source(event: Mapping[str, Any]) -> str:
    """Return the source of an event: `INSTANCE.PORT`, an instance, a bus; empty for the run."""
    names = [*_names(event)]
    return names[-1] if names else ""


def _names(event: Mapping[str, Any]) -> Iterator[str]:
    instance, port, bus = (
        str(event.get(key, "")) for key in ("instance", "port", "bus")
    )
    yield from filter(None, (instance, bus))
    if port:
        yield f"{instance}.{port}" if instance else port
