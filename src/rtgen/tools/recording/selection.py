"""Selects events of recordings, and reports what cannot be read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.systems.rules import OBSERVABLE, RECORDING, UNREAD
from rtgen.tools.kit.console import Console
from rtgen.tools.recording.bag_files import Recording
from rtgen.tools.recording.errors import RecordingError, UnavailableError
from rtgen.tools.recording.events import Log

_NEAR = 3
_ALIKE = 0.8
"""Ratio of further names: those of one namespace are alike in any case."""


@contextmanager
def reported(*files: Path) -> Iterator[None]:
    """Convert errors of recordings to InputError within the block, naming the only file.

    Raises ToolError for those of the environment.
    """
    try:
        yield
    except UnavailableError:
        raise
    except RecordingError as error:
        text = str(error)
        if len(files) == 1 and str(files[0]) not in text:
            text = f"{files[0]}: {text}"
        raise InputError([RECORDING.at(None, text, hint=error.hint)]) from error


def say_losses(console: Console, log: Log | Recording) -> None:
    """Warn of what could not be read of a log, of which all events were read."""
    losses = [UNREAD.at(None, f"{log.path}: {loss}") for loss in log.losses()]
    if losses:
        console.findings(losses)


class Choice:
    """A predicate of events, by kind, and by instance, port, topic or bus."""

    def __init__(self, names: Sequence[str] = (), kinds: Sequence[str] = ()) -> None:
        self._names = names
        self._kinds = kinds
        self._seen: set[str] = set()

    def __call__(self, event: Mapping[str, Any]) -> bool:
        """Return whether an event, or what is known of it, is chosen."""
        if not self._names:
            return not self._kinds or event["event"] in self._kinds
        names = {*_names(event)}
        self._seen |= names
        if self._kinds and event["event"] not in self._kinds:
            return False
        return not names.isdisjoint(self._names)

    def check(self, *files: Path) -> None:
        """Raise InputError for chosen names that no event had."""
        where = " and ".join(map(str, files))
        unknown = [
            OBSERVABLE.at(
                None,
                f"{where}: there is no event of {name}",
                hint=near_names(name, self._seen),
            )
            for name in self._names
            if name not in self._seen
        ]
        if unknown:
            raise InputError(unknown)


def near_names(name: str, known: Iterable[str]) -> str:
    """Return a hint that names those of a recording's ports and topics that are like `name`."""
    names = sorted(known)
    last = name.rpartition("/")[2]
    alike = [each for each in names if last and each.rpartition("/")[2] == last]
    near = [
        *alike,
        *get_close_matches(name, names, n=1),
        *get_close_matches(name, names, n=_NEAR, cutoff=_ALIKE),
    ]
    if not near:
        return "`rtgen log info` lists the ports and topics"
    return f"did you mean {' or '.join([*dict.fromkeys(near)][:_NEAR])}?"


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
