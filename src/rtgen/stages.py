"""The stages of a run, which an observer may follow: their times, and the file in work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Final, Protocol


class Observer(Protocol):
    """Follows the stages of a run. Stages may lie within each other."""

    def begin(self, stage: str) -> None:
        """A stage begins."""

    def end(self) -> None:
        """The stage that began last ends."""

    def file(self, name: str) -> None:
        """The stage begins to work on a file."""

    def note(self, text: str) -> None:
        """What the stage has found, in a few words."""


_OBSERVER: ContextVar[Observer | None] = ContextVar("observer", default=None)
_UNOBSERVED: Final = nullcontext()


def stage(name: str) -> AbstractContextManager[None]:
    """Within it a stage runs."""
    observer = _OBSERVER.get()
    return _UNOBSERVED if observer is None else _observed(observer, name)


def file(name: str) -> None:
    """The stage begins to work on a file."""
    observer = _OBSERVER.get()
    if observer is not None:
        observer.file(name)


def note(text: str) -> None:
    """The stage has found this."""
    observer = _OBSERVER.get()
    if observer is not None:
        observer.note(text)


@contextmanager
def observed(observer: Observer) -> Iterator[None]:
    """Within it `observer` follows the stages."""
    token = _OBSERVER.set(observer)
    try:
        yield
    finally:
        _OBSERVER.reset(token)


@contextmanager
def _observed(observer: Observer, name: str) -> Iterator[None]:
    observer.begin(name)
    try:
        yield
    finally:
        observer.end()
