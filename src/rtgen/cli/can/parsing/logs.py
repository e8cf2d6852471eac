"""Reads and writes bus logs in python-can's formats, chosen by the suffix of the file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, BinaryIO, TextIO, cast

from rtgen.cli.can.common import require_python_can
from rtgen.cli.common import Refusal
from rtgen.diagnostics import ToolError
from rtgen.files import open_file

if TYPE_CHECKING:
    from can import Message
    from can.io.generic import MessageWriter

_MAX_CONTAINER = 1 << 25
"""Maximum octets of a container of a BLF file; Vector's tools write 128 KiB."""
_MAX_LINE = 1 << 16
"""Maximum characters of a line; a frame of CAN FD takes 150."""
KINDS = {".log": "candump log", ".asc": "Vector ASC", ".blf": "Vector BLF"}
"""Suffix and name of each format."""


def check_kind(path: Path) -> None:
    """Raise Refusal for a suffix that is not a log format."""
    if path.suffix.lower() not in KINDS:
        known = ", ".join(f"{suffix} ({kind})" for suffix, kind in KINDS.items())
        raise Refusal(f"{path}: the suffix has to name a log format: {known}")


@contextmanager
def writer(path: Path) -> Iterator[MessageWriter]:
    """Open a log for writing; it is complete on leaving. Raises Refusal, ToolError."""
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
    """Read the messages of a log.

    Raises Refusal for a malformed log, ToolError if it is unreadable.
    """
    require_python_can()
    check_kind(path)
    return _read(path)


class _Bounded:
    """A file whose reads allocate no more memory than there are octets, whatever size is requested.

    Sizes in a log are not trusted.
    """

    _PIECE = 1 << 20

    def __init__(self, stream: IO[Any]) -> None:
        self._stream = stream

    def read(self, size: int = -1) -> bytes:
        """Like the method of a file."""
        if size <= self._PIECE:
            return bytes(self._stream.read(size))
        parts = []
        while size > 0 and (part := self._stream.read(min(size, self._PIECE))):
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class _Lines:
    """A text file whose lines are limited."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __iter__(self) -> Iterator[str]:
        while line := self._stream.readline(_MAX_LINE + 1):
            if len(line) > _MAX_LINE:
                raise ValueError(f"a line of more than {_MAX_LINE} characters")
            yield line

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _check_containers(path: Path) -> None:
    """Raise ValueError for a container of a BLF file that inflates to more than `_MAX_CONTAINER`.

    python-can inflates a container as a whole, of any size.
    """
    import zlib

    from can.io import blf

    with open_file(path) as stream:
        source = _Bounded(stream)
        size = blf.FILE_HEADER_STRUCT.unpack(source.read(blf.FILE_HEADER_STRUCT.size))[
            1
        ]
        stream.seek(size)
        while head := source.read(blf.OBJ_HEADER_BASE_STRUCT.size):
            _, _, _, size, kind = blf.OBJ_HEADER_BASE_STRUCT.unpack(head)
            data = source.read(max(0, size - blf.OBJ_HEADER_BASE_STRUCT.size))
            stream.seek(size % 4, os.SEEK_CUR)
            if kind != blf.LOG_CONTAINER:
                continue
            method, _ = blf.LOG_CONTAINER_STRUCT.unpack_from(data)
            if method == blf.ZLIB_DEFLATE:
                inflater = zlib.decompressobj()
                inflater.decompress(
                    data[blf.LOG_CONTAINER_STRUCT.size :], _MAX_CONTAINER
                )
                if inflater.unconsumed_tail:
                    raise ValueError(
                        f"a container of more than {_MAX_CONTAINER} octets"
                    )


def _text(stream: BinaryIO) -> TextIO:
    return TextIOWrapper(stream, encoding="utf-8", errors="replace")


def _read(path: Path) -> Iterator[Message]:
    import struct
    import zlib

    from can.io.blf import BLFParseError
    from can.io.generic import BinaryIOMessageReader
    from can.io.player import MESSAGE_READERS

    suffix = path.suffix.lower()
    kind = MESSAGE_READERS[suffix]
    binary = issubclass(kind, BinaryIOMessageReader)
    found = 0
    try:
        if suffix == ".blf":
            _check_containers(path)
        with open_file(path) as stream:
            source = _Bounded(stream) if binary else _Lines(_text(stream))
            for message in kind(cast(Any, source)):
                found += 1
                yield message
    except OSError as error:
        reason = error.strerror or error
        raise ToolError(f"cannot read {path}: {reason}") from error
    except (ValueError, IndexError, struct.error, zlib.error, BLFParseError) as error:
        after = f"after {found} frames " if found else ""
        said = " ".join(str(error).split())
        raise Refusal(
            f"{path}: {after}this is not a {KINDS[suffix]} file: {said}"
        ) from error
