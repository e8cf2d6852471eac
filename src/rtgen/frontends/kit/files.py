"""The bytes of a file that is given by its path, bounded."""

from __future__ import annotations

from pathlib import Path


class UnreadableError(Exception):
    """A file cannot be read, or is too large; the message says why."""


def read_file(path: Path, limit: int) -> bytes:
    """The bytes of a file. Raises UnreadableError, also beyond `limit` bytes."""
    try:
        with path.open("rb") as stream:
            data = stream.read(limit + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UnreadableError(reason) from None
    if len(data) > limit:
        raise UnreadableError(f"it is larger than {limit:,} bytes")
    return data
