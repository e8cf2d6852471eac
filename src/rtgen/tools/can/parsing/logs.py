"""Reads and writes bus logs, in a format chosen by the suffix of the file.

A log that is damaged or cut off is read as far as it is whole, and what is missing is reported.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO, TypeAlias, cast

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.files import check_output, make_folder, open_file
from rtgen.runtime.canopen.wire.frames import MAX_DATA
from rtgen.tools.can.common import counted, require_python_can
from rtgen.tools.can.parsing.candump import message_of_line
from rtgen.tools.kit.exits import Refusal

if TYPE_CHECKING:
    from can import Message
    from can.io.generic import MessageWriter

_MAX_LINE = 1 << 16
"""Maximum octets of a line; a frame of CAN FD takes 150."""
_MAX_END = 1 << 24
"""Maximum octets after these up to the end of the line; zeros of a damaged disk have none."""
_MAX_PLACES = 100_000
"""Number of damaged places without a frame between them after which the rest is not read."""
_SHOWN = 3
"""Number of places that are reported one by one."""
_TRACE_VERSION = re.compile(r";\$FILEVERSION=(\S*)")
_TRACE_VERSIONS = ("1.0", "1.1", "1.3", "2.0", "2.1")
_HALF_OCTET = re.compile(r"\s[0-9A-Fa-f]\s*$")
WRITTEN = {".log": "candump log", ".asc": "Vector ASC", ".blf": "Vector BLF"}
"""Suffix and name of each format that is written."""
READ = {**WRITTEN, ".trc": "PEAK trace"}
"""The same for those that are read. python-can writes no remote frames to a PEAK trace."""

Report: TypeAlias = Callable[[str], object]
"""Called with a line for people about what is missing."""


def check_kind(path: Path, kinds: Mapping[str, str] = WRITTEN) -> None:
    """Raise Refusal for a suffix that is not one of these log formats."""
    if path.suffix.lower() not in kinds:
        choices = ", ".join(f"{suffix} ({kind})" for suffix, kind in kinds.items())
        raise Refusal(f"{path}: the suffix has to name a log format: {choices}")


@contextmanager
def writer(path: Path) -> Iterator[MessageWriter]:
    """Open a log for writing; it is complete on leaving. Raises Refusal, ToolError."""
    require_python_can()
    check_kind(path)
    from can import Logger

    try:
        check_output(path, pipes=False)
        make_folder(path.parent)
        with Logger(path) as logger:
            yield logger
    except OSError as error:
        reason = error.strerror or error
        raise ToolError(f"cannot write {path}: {reason}") from error


def read(
    path: Path, report: Report, *, only_certain: bool = False
) -> Iterator[Message]:
    """Read the messages of a log; what is damaged is left out and reported.

    A frame in a last line without an end may have lost octets: it is reported, and left out if
    `only_certain`. Raises Refusal for a file that is no such log, ToolError if it is unreadable.
    """
    require_python_can()
    check_kind(path, READ)
    return _read(path, report, only_certain=only_certain)


def _read(path: Path, report: Report, *, only_certain: bool) -> Iterator[Message]:
    damage = _Damage(path, report)
    whole = 0
    try:
        with open_file(path) as stream:
            for message in _READERS[path.suffix.lower()](stream, damage):
                if damage.is_at_open_end and message.dlc < MAX_DATA:
                    report(f"{path}: the last line has no end: it may be cut off")
                    if only_certain:
                        continue
                if not message.is_remote_frame and message.dlc != len(message.data):
                    damage.add(f"a frame of {len(message.data)} of its octets")
                    continue
                whole += 1
                damage.end_row()
                yield message
    except OSError as error:
        reason = error.strerror or error
        raise ToolError(f"cannot read {path}: {reason}") from error
    except EndlessError as error:
        damage.give_up(str(error))
    except ValueError as error:
        damage.add(" ".join(str(error).split()))
    if damage.first and not whole:
        kind = READ[path.suffix.lower()]
        raise Refusal(f"{path}: this is not a {kind} file: {damage.first}")
    damage.end()
    if not whole:
        report(f"{path}: there is no frame in it")


class EndlessError(Exception):
    """Damage after which the rest of a log is not read."""


class _Damage:
    """The places of a log that cannot be read. They are reported once there are whole frames."""

    def __init__(self, path: Path, report: Report) -> None:
        self._path = path
        self._report = report
        self._shown: list[str] = []
        self._count = 0
        self._in_a_row = 0
        self.is_at_open_end = False
        """Whether the latest line has no end."""

    @property
    def first(self) -> str:
        """The first place; empty without any."""
        return self._shown[0] if self._shown else ""

    def add(self, place: str) -> None:
        """Add a place, with what is wrong there."""
        self._count += 1
        self._in_a_row += 1
        if self._in_a_row > _MAX_PLACES:
            raise EndlessError(f"the rest after {_MAX_PLACES:,} places without a frame")
        if len(self._shown) < _SHOWN:
            self._shown.append(place)

    def give_up(self, place: str) -> None:
        """Add the place after which nothing is read."""
        self._count += 1
        self._shown = [*self._shown[: _SHOWN - 1], place]

    def end_row(self) -> None:
        """Note a whole frame after the latest place."""
        self._in_a_row = 0

    def end(self) -> None:
        """Report all."""
        for place in self._shown:
            self._report(f"{self._path}: {place}; left out")
        if more := self._count - len(self._shown):
            self._report(f"{self._path}: {counted(more, 'further place')} left out")


class _Lines:
    """The lines of a text file, of limited length; a further iteration continues.

    `head` are lines that it begins with.
    """

    def __init__(
        self, stream: BinaryIO, damage: _Damage, head: Sequence[str] = ()
    ) -> None:
        self._stream = stream
        self._damage = damage
        self._head = head
        self.number = 0
        """That of the latest line."""

    def __iter__(self) -> Iterator[str]:
        if self.number:
            yield from self._head
        while line := self._stream.readline(_MAX_LINE):
            self.number += 1
            end, remaining = line, _MAX_END
            while len(end) == _MAX_LINE:
                end = self._stream.readline(_MAX_LINE)
                remaining -= len(end)
                if remaining < 0:
                    raise EndlessError(f"line {self.number} has no end")
            self._damage.is_at_open_end = not (end or line).endswith(b"\n")
            yield line.decode("utf-8", "replace")

    def leave_out(self, error: Exception) -> None:
        """Add the latest line to the damage."""
        problem = error if isinstance(error, ValueError) else "this is not a frame"
        cut = "cut off, " if self._damage.is_at_open_end else ""
        self._damage.add(f"line {self.number}: {cut}{problem}")

    def close(self) -> None:
        """Do nothing: the file is closed by its owner."""


class _CountedLines(_Lines):
    """Lines with octets of two digits and their number; half an octet at the end is left out."""

    def __iter__(self) -> Iterator[str]:
        for line in super().__iter__():
            if self._damage.is_at_open_end and _HALF_OCTET.search(line):
                self.leave_out(ValueError("half an octet"))
            else:
                yield line


class _TraceLines(_CountedLines):
    """The lines of a PEAK trace. Raises Refusal for versions with columns that are not known."""

    def __iter__(self) -> Iterator[str]:
        for line in super().__iter__():
            version = _TRACE_VERSION.match(line)
            if version is not None and version[1] not in _TRACE_VERSIONS:
                versions = ", ".join(_TRACE_VERSIONS)
                raise Refusal(
                    f"PEAK traces of version {version[1]} are not read, only {versions}"
                )
            yield line


def _candump(stream: BinaryIO, damage: _Damage) -> Iterator[Message]:
    lines = _Lines(stream, damage)
    for line in lines:
        if not line.strip():
            continue
        try:
            message = message_of_line(line)
        except ValueError as error:
            lines.leave_out(error)
            continue
        yield message


def _asc(stream: BinaryIO, damage: _Damage) -> Iterator[Message]:
    from can import ASCReader

    # The last line of its head, which the reader looks for in each iteration.
    lines = _CountedLines(stream, damage, ["internal events logged\n"])
    return _messages(ASCReader(cast(TextIO, lines)), lines)


def _trc(stream: BinaryIO, damage: _Damage) -> Iterator[Message]:
    from can import TRCReader

    class Reader(TRCReader):
        """A reader that does not pass over what it cannot read."""

        def _parse_line(self, line: str) -> Message | None:
            return self._parse_cols(tuple(line.split(maxsplit=self._num_columns)))

    lines = _TraceLines(stream, damage)
    return _messages(Reader(cast(TextIO, lines)), lines)


def _messages(reader: Any, lines: _Lines) -> Iterator[Message]:
    """Read by a reader of python-can, whose iteration ends at a damaged line."""
    begin = -1
    while lines.number > begin:
        begin = lines.number
        try:
            yield from reader
        except (ValueError, IndexError, KeyError) as error:
            lines.leave_out(error)
        else:
            return


def _blf(stream: BinaryIO, damage: _Damage) -> Iterator[Message]:
    from can import BLFReader
    from can.io.blf import BLFParseError

    from rtgen.tools.can.parsing.blf import WholeObjects

    try:
        yield from BLFReader(cast(BinaryIO, WholeObjects(stream, damage.add)))
    except (struct.error, BLFParseError) as error:
        raise ValueError(str(error)) from error


_READERS: dict[str, Callable[[BinaryIO, _Damage], Iterator[Message]]] = {
    ".log": _candump,
    ".asc": _asc,
    ".blf": _blf,
    ".trc": _trc,
}
