"""Progress of a run: an observer is notified of stages, of their files, and of results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Final, Protocol


class Observer(Protocol):
    """An observer of a run's stages, which may be nested."""

    def begin(self, stage: str) -> None:
        """Called when a stage begins."""

    def end(self) -> None:
        """Called when the innermost stage ends."""

    def file(self, name: str) -> None:
        """Called when the stage starts to process a file."""

    def note(self, text: str) -> None:
        """Called with a short text about the stage's result."""


_OBSERVER: ContextVar[Observer | None] = ContextVar("observer", default=None)
_UNOBSERVED: Final = nullcontext()


def stage(name: str) -> AbstractContextManager[None]:
    """Return a context manager for the block that is a stage."""
    observer = _OBSERVER.get()
    return _UNOBSERVED if observer is None else _observed(observer, name)


def file(name: str) -> None:
    """Notify the observer that the stage starts to process a file."""
    observer = _OBSERVER.get()
    if observer is not None:
        observer.file(name)


def note(text: str) -> None:
    """Notify the observer of a stage's result, in a few words."""
    observer = _OBSERVER.get()
    if observer is not None:
        observer.note(text)


@contextmanager
def observed(observer: Observer) -> Iterator[None]:
    """Within the block, `observer` is notified of stages."""
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
