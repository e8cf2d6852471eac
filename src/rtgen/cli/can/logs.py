"""Records of a bus: files that python-can reads and writes, by their suffix."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.cli.can.common import require_python_can
from rtgen.cli.common import Refusal
from rtgen.diagnostics import ToolError

if TYPE_CHECKING:
    from can import Message
    from can.io.generic import MessageWriter

KINDS = {".log": "candump log", ".asc": "Vector ASC", ".blf": "Vector BLF"}
"""Suffix to kind of record."""


def check_kind(path: Path) -> None:
    """Raises Refusal for a suffix that is none of a record's."""
    if path.suffix.lower() not in KINDS:
        known = ", ".join(f"{suffix} ({kind})" for suffix, kind in KINDS.items())
        raise Refusal(f"{path}: the suffix tells the kind of record: {known}")


@contextmanager
def writer(path: Path) -> Iterator[MessageWriter]:
    """A record to be written, complete at the end. Raises Refusal, ToolError."""
    require_python_can()
    check_kind(path)
    from can import Logger

    try:
        with Logger(path) as made:
            yield made
    except OSError as error:
        reason = error.strerror or error
        raise ToolError(f"cannot write {path}: {reason}") from error


def read(path: Path) -> Iterator[Message]:
    """The messages of a record. Raises Refusal if it is none, ToolError if it cannot be read."""
    require_python_can()
    check_kind(path)
    return _read(path)


def _read(path: Path) -> Iterator[Message]:
    import struct
    import zlib

    from can import LogReader
    from can.io.blf import BLFParseError

    found = 0
    bad = (ValueError, IndexError, struct.error, zlib.error, BLFParseError)
    try:
        with LogReader(path) as reader:
            for message in reader:
                found += 1
                yield message
    except OSError as error:
        reason = error.strerror or error
        raise ToolError(f"cannot read {path}: {reason}") from error
    except bad as error:
        kind = KINDS[path.suffix.lower()]
        after = f"after {found} frames " if found else ""
        reason_ = " ".join(str(error).split())
        raise Refusal(f"{path}: {after}this is no {kind}: {reason_}") from error
