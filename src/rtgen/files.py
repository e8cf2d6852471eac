"""Bounded reading of files; an editor's unsaved texts take precedence over those on the disk."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_OVERLAY: ContextVar[Mapping[str, bytes] | None] = ContextVar("overlay", default=None)


class UnreadableError(Exception):
    """A file that cannot be read, or is too large; the message says why."""


def absolute_path(path: Path | str) -> str:
    """Return the absolute path without `..`. Links are kept: a file's includes are relative to
    it.
    """
    return os.path.normpath(Path.cwd() / path)


@contextmanager
def overlaid(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within the block, `contents` by absolute path replace what is on the disk."""
    token = _OVERLAY.set(contents)
    try:
        yield
    finally:
        _OVERLAY.reset(token)


def is_file(path: Path) -> bool:
    """Return whether the path is a file."""
    return _unsaved(path) is not None or path.is_file()


def read_start(path: Path, limit: int | None = None) -> bytes:
    """Return up to `limit` bytes from the start of a file. Raises OSError, ValueError."""
    data = _unsaved(path)
    if data is not None:
        return data[:limit]
    with path.open("rb") as stream:
        return stream.read(-1 if limit is None else limit)


def read_file(path: Path, limit: int) -> bytes:
    """Return the bytes of a file. Raises UnreadableError, also if there are more than `limit`."""
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
