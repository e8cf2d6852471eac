"""Reads files of sqlite3 as rosbag2 writes them (`.db3`, the default of ROS 2 up to Humble).

A file is data from outside: it is opened for reading, only plain tables are read, and their content
is limited by the size of the file, as that of compressed MCAP files is: its pages can lead to one
another in any way, so that each has any number of rows.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import closing, suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeGuard

from rtgen.facts.files import create_file, open_file
from rtgen.tools.recording.copies import Copy
from rtgen.tools.recording.errors import RecordingError, UnavailableError
from rtgen.tools.recording.mcap_reader import MAX_SIZE, Channel, Message, Work
from rtgen.tools.recording.schemas import Schema

if TYPE_CHECKING:
    import sqlite3

MAGIC: Final = b"SQLite format 3\0"

_TABLES: Final = ("topics", "messages")
_DEFINITIONS: Final = "message_definitions"
_HEAD: Final = 100
_CUT: Final = "the file is shorter than it says"
_TOO_MANY: Final = "its pages lead to more rows than a file of its size has"
_PART: Final = 1 << 20
_MAX_TOPICS: Final = 100_000
_STEP: Final = 1_000
"""Instructions of sqlite3's machine in a step."""
_FREE_STEPS, _OCTETS_PER_STEP = 5_000, 200
"""Steps of a file: any number up to the first, then one for so many octets of its own."""
_GENERATED: Final = (2, 3)
"""Columns that are computed, in `PRAGMA table_xinfo`."""
_METADATA: Final = {
    "offered_qos_profiles": "offered_qos_profiles",
    "type_description_hash": "topic_type_hash",
}
"""Entries of a channel in MCAP, by columns."""


class SqliteFile:
    """A file that can be read several times from the start."""

    def __init__(self, path: Path, copy: Copy | None = None) -> None:
        """Open a file, or its copy. Raises RecordingError if it is missing or not of rosbag2."""
        self.path = path
        self.damaged = 0
        """Number of rows skipped by the last call of `messages`."""
        self.metadata: dict[str, dict[str, str]] = {}
        self._damage = ""
        self._copy = copy
        """The file that sqlite3 reads instead: another one's content, or its whole pages."""
        try:
            with open_file(self._read) as stream:
                self._size = stream.seek(0, 2)
                stream.seek(0)
                whole = _whole_pages(stream.read(_HEAD), self._size)
                self._is_cut = whole is not None
                if whole is not None:
                    self._damage = _CUT
                    self._copy = Copy(path.name)
                    stream.seek(0)
                    with create_file(self._copy.path) as pages:
                        while whole and (part := stream.read(min(whole, _PART))):
                            whole -= pages.write(part)
        except OSError as error:
            raise UnavailableError(f"cannot read {path}: {error.strerror}") from error
        with closing(self._opened()):
            pass

    form = "sqlite3"

    @property
    def _read(self) -> Path:
        return self.path if self._copy is None else self._copy.path

    @property
    def profile(self) -> str:
        """The profile of the messages, as in the header of MCAP files."""
        return "ros2"

    @property
    def is_whole(self) -> bool:
        """Whether the last call of `messages` could read everything."""
        return not self._damage

    @cached_property
    def earliest(self) -> int | None:
        """The time of the earliest message [ns]; None without messages."""
        import sqlite3

        first: int | None = None
        with closing(self._opened()) as connection, suppress(sqlite3.Error, ValueError):
            for (time,) in connection.execute(
                "SELECT timestamp FROM messages NOT INDEXED"
            ):
                if _is_number(time) and (first is None or time < first):
                    first = time
        return first

    def losses(self) -> list[str]:
        """Return what the last call of `messages` could not read, in words."""
        reasons = []
        if self._damage:
            reasons.append(f"cut off: its last messages are missing ({self._damage})")
        if self.damaged:
            reasons.append(f"rows that are not messages, left out: {self.damaged}")
        return reasons

    def messages(self) -> Iterator[Message]:
        """Yield the messages in the order in which they were written."""
        import sqlite3

        self.damaged, self._damage = 0, _CUT if self._is_cut else ""
        work = Work(self.path, self._size)
        with closing(self._opened()) as connection:
            channels = self._channels(connection, work)
            try:
                rows = connection.execute(
                    "SELECT topic_id, timestamp, data FROM messages NOT INDEXED"
                )
                for number, time, data in rows:
                    work.take_record()
                    channel = channels.get(number) if _is_number(number) else None
                    if channel is None or not (
                        _is_number(time) and isinstance(data, bytes)
                    ):
                        self.damaged += 1
                        continue
                    work.take_octets(len(data))
                    yield Message(channel, time, data)
            except (sqlite3.Error, ValueError) as error:
                self._damage = _reason(error)

    def _opened(self) -> sqlite3.Connection:
        """Return a connection to a file that has the tables. Raises RecordingError."""
        try:
            import sqlite3
        except ImportError as error:
            raise RecordingError(
                f"{self.path}: this Python was built without sqlite3"
            ) from error
        # Without its journal beside it nothing is written, not even a lock.
        is_alone = not self._read.with_name(f"{self._read.name}-wal").exists()
        options = "?mode=ro&immutable=1" if is_alone else "?mode=ro"
        connection = None
        try:
            uri = f"{self._read.absolute().as_uri()}{options}"
            connection = sqlite3.connect(uri, uri=True, check_same_thread=False)
            connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_SIZE)
            connection.text_factory = _text
            steps = iter(range(_FREE_STEPS + self._size // _OCTETS_PER_STEP))
            connection.set_progress_handler(lambda: next(steps, None) is None, _STEP)
            connection.execute("PRAGMA trusted_schema=OFF")
            # A file that was cut off is refused without it; nothing is written.
            connection.execute("PRAGMA writable_schema=ON")
            tables = self._tables(connection)
        except (sqlite3.Error, ValueError) as error:
            if connection is not None:
                connection.close()
            raise RecordingError(f"{self.path}: {_reason(error)}") from error
        if not tables.issuperset(_TABLES):
            connection.close()
            raise RecordingError(
                f"{self.path} is not a file of rosbag2: it has no tables of messages and topics"
            )
        return connection

    def _tables(self, connection: sqlite3.Connection) -> set[str]:
        """Return the names of the plain tables among those of rosbag2: none computes values."""
        found = connection.execute(
            "SELECT name, sql FROM sqlite_master WHERE type = 'table' AND name IN (?, ?, ?)",
            (*_TABLES, _DEFINITIONS),
        )
        names = {
            name
            for name, text in found
            if " ".join(str(text).split()).upper().startswith("CREATE TABLE ")
        }
        return {name for name in names if not _computes(connection, name)}

    def _channels(
        self, connection: sqlite3.Connection, work: Work
    ) -> dict[int, Channel]:
        """Return the channels by number. Raises RecordingError."""
        import sqlite3

        try:
            definitions = {}
            if _DEFINITIONS in self._tables(connection):
                for row in self._rows(connection, _DEFINITIONS, work):
                    text = _of(row, "encoded_message_definition")
                    definitions[_of(row, "topic_type")] = text, _of(row, "encoding")
            channels: dict[int, Channel] = {}
            for row in self._rows(connection, "topics", work):
                number = row.get("id")
                if not _is_number(number):
                    continue
                type_ = _of(row, "type")
                schema = Schema(type_, *definitions.get(type_, ("", "")))
                metadata = tuple(
                    (key, str(row[column]))
                    for column, key in _METADATA.items()
                    if row.get(column)
                )
                form = _of(row, "serialization_format")
                channels[number] = Channel(
                    number, _of(row, "name"), form, schema, metadata
                )
        except (sqlite3.Error, ValueError) as error:
            raise RecordingError(f"{self.path}: {_reason(error)}") from error
        return channels

    def _rows(
        self, connection: sqlite3.Connection, table: str, work: Work
    ) -> Iterator[dict[str, Any]]:
        found = connection.execute(f"SELECT * FROM {table}")
        names = [column[0] for column in found.description]
        for count, row in enumerate(found):
            if count >= _MAX_TOPICS:
                raise RecordingError(
                    f"{self.path}: the table {table} has over {_MAX_TOPICS} rows"
                )
            work.take_description(*row)
            yield dict(zip(names, row, strict=True))


def _whole_pages(head: bytes, size: int) -> int | None:
    """Return the octets of whole pages of a file whose last page is cut off; None for others.

    sqlite3 would take what is missing of a page for zeros (sqlite.org/fileformat.html, 1.3).
    """
    if len(head) < _HEAD:
        return None
    (page,) = struct.unpack_from(">H", head, 16)
    (number,) = struct.unpack_from(">I", head, 28)
    page = 1 << 16 if page == 1 else page
    if not page or size >= number * page or size % page == 0:
        return None
    return size - size % page


def _computes(connection: sqlite3.Connection, table: str) -> bool:
    """Return whether a table has columns that are computed when they are read."""
    columns = connection.execute(f"PRAGMA table_xinfo({table})")
    return any(kind in _GENERATED for *_, kind in columns)


def _reason(error: Exception) -> str:
    """Return what sqlite3 says, or that it was stopped."""
    text = str(error)
    return _TOO_MANY if text == "interrupted" else text


def _of(row: dict[str, Any], column: str) -> str:
    value = row.get(column)
    return value if isinstance(value, str) else ""


def _is_number(value: object) -> TypeGuard[int]:
    return isinstance(value, int)


def _text(octets: bytes) -> str:
    return octets.decode("utf-8", "replace")
