"""The bytes of files: those on the disk, or unsaved texts of an editor in their place; bounded."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_OVERLAY: ContextVar[Mapping[str, bytes] | None] = ContextVar("overlay", default=None)


class UnreadableError(Exception):
    """A file cannot be read, or is too large; the message says why."""


def absolute_path(path: Path | str) -> str:
    """The path from the root, without `..`; links are kept, so a file's includes lie beside it."""
    return os.path.normpath(Path.cwd() / path)


@contextmanager
def overlaid(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within it `contents`, by absolute path, stand for what is on the disk."""
    token = _OVERLAY.set(contents)
    try:
        yield
    finally:
        _OVERLAY.reset(token)


def is_file(path: Path) -> bool:
    """Whether there is a file of that path."""
    return _unsaved(path) is not None or path.is_file()


def read_start(path: Path, limit: int | None = None) -> bytes:
    """The first `limit` bytes of a file, or all of them. Raises OSError, ValueError."""
    data = _unsaved(path)
    if data is not None:
        return data[:limit]
    with path.open("rb") as stream:
        return stream.read(-1 if limit is None else limit)


def read_file(path: Path, limit: int) -> bytes:
    """The bytes of a file. Raises UnreadableError, also beyond `limit` bytes."""
    try:
        data = read_start(path, limit + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UnreadableError(reason) from None
    if len(data) > limit:
        raise UnreadableError(f"it is larger than {limit:,} bytes")
    return data


def _unsaved(path: Path) -> bytes | None:
    contents = _OVERLAY.get()
    return contents.get(absolute_path(path)) if contents else None
