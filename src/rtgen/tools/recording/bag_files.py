"""Opens recordings by what they are: MCAP, sqlite3, one compressed, or the folder of a bag."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Final, Protocol

from rtgen.facts.extras import installation
from rtgen.facts.files import (
    UnreadableError,
    create_file,
    open_file,
    read_file,
    read_start,
)
from rtgen.tools.recording.bag_metadata import METADATA_FILE, Folder, folder_of
from rtgen.tools.recording.bag_writer import PROFILE
from rtgen.tools.recording.copies import Copy
from rtgen.tools.recording.errors import RecordingError, UnavailableError
from rtgen.tools.recording.mcap_reader import MAGIC as MCAP
from rtgen.tools.recording.mcap_reader import (
    MAX_SIZE,
    McapFile,
    Message,
    Work,
    decompressed,
)
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.sqlite_reader import MAGIC as SQLITE
from rtgen.tools.recording.sqlite_reader import SqliteFile

_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_FILE: Final = re.compile(r"(?!rtgen\.mcap).+?(\d*)\.(mcap|db3)(\.zstd)?", re.ASCII)
"""Files of a bag, with their numbers; rtgen's own events beside them are none."""
_MAX_METADATA: Final = 1 << 25
_PART: Final = 1 << 20


class Recording(Protocol):
    """A recording that can be read several times from the start."""

    @property
    def path(self) -> Path:
        """The file or the folder."""

    @property
    def damaged(self) -> int:
        """Number of chunks or rows skipped by the last call of `messages`."""

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """Metadata of the whole recording, by name."""

    @property
    def form(self) -> str:
        """The form of its files: `mcap`, `sqlite3`."""

    @property
    def profile(self) -> str:
        """The profile of the messages: `ros2` for a bag of ROS 2."""

    @property
    def is_whole(self) -> bool:
        """Whether the writer has completed it."""

    @property
    def earliest(self) -> int | None:
        """The time of the earliest message [ns]; None without messages."""

    def messages(self) -> Iterator[Message]:
        """Yield the messages in the order of the file. Raises RecordingError."""

    def losses(self) -> list[str]:
        """Return what the last call of `messages` could not read, in words."""


def open_recording(path: Path) -> Recording | None:
    """Open a recording; None for a file of another form. Raises RecordingError."""
    try:
        if path.is_dir():
            return BagFolder(path)
        head = read_start(path, len(SQLITE))
    except OSError as error:
        raise UnavailableError(f"cannot read {path}: {error.strerror}") from error
    if head.startswith(_ZSTD):
        return _unpacked(path)
    return _plain_file(path, head)


def start_of(recording: Recording) -> int:
    """Return the clock's time at the start [ns]; for bags of others, that of the first message."""
    text = recording.metadata.get(METADATA, {}).get("start", "")
    if text.isascii() and text.isdecimal():
        return int(text)
    return (recording.profile == PROFILE and recording.earliest) or 0


def _plain_file(
    path: Path, head: bytes, copy: Copy | None = None
) -> McapFile | SqliteFile | None:
    """Return a file by its first octets, which are those of its `copy` if there is one."""
    if head.startswith(MCAP):
        return McapFile(path, copy)
    return SqliteFile(path, copy) if head == SQLITE else None


class BagFolder:
    """The folder of a bag, with one file or several."""

    def __init__(self, path: Path) -> None:
        """Open a folder. Raises RecordingError if it is not that of a bag."""
        self.path = path
        self._is_described = True
        self._missing: list[str] = []
        described = self._described()
        self._by_message = described.by_message
        self._files: list[Recording] = []
        for name in described.files:
            file = path / name
            if not file.exists():
                self._missing.append(name)
                continue
            opened = open_recording(file) if not file.is_dir() else None
            if opened is None:
                raise RecordingError(f"{file} is neither MCAP nor sqlite3")
            self._files.append(opened)
        if not self._files:
            raise RecordingError(f"{path}: the files of the bag are missing")

    @property
    def damaged(self) -> int:
        """Number of chunks or rows skipped by the last call of `messages`."""
        return sum(file.damaged for file in self._files)

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """See `Recording`; a folder has that of its file."""
        return self._files[0].metadata

    @property
    def form(self) -> str:
        """See `Recording`."""
        return self._files[0].form

    @property
    def profile(self) -> str:
        """See `Recording`."""
        return self._files[0].profile

    @property
    def is_whole(self) -> bool:
        """See `Recording`."""
        return (
            self._is_described
            and not self._missing
            and all(file.is_whole for file in self._files)
        )

    @cached_property
    def earliest(self) -> int | None:
        """See `Recording`."""
        times = [file.earliest for file in self._files]
        return min((time for time in times if time is not None), default=None)

    def messages(self) -> Iterator[Message]:
        """See `Recording`."""
        for file in self._files:
            if not self._by_message:
                yield from file.messages()
                continue
            work = Work(file.path, file.path.stat().st_size)
            for message in file.messages():
                try:
                    data = decompressed("zstd", message.data, MAX_SIZE)
                except ValueError as error:
                    raise RecordingError(
                        f"{file.path}: {message.channel.topic}: {error}"
                    ) from error
                work.take_octets(len(data))
                yield replace(message, data=data)

    def losses(self) -> list[str]:
        """See `Recording`."""
        reasons = [
            f"{file.path.name}: {loss}"
            for file in self._files
            for loss in file.losses()
        ]
        if not self._is_described:
            reasons.append(f"no {METADATA_FILE}: the writer was killed")
        return [*reasons, *(f"{name} is missing" for name in self._missing)]

    def _described(self) -> Folder:
        """Return the files, those in the folder if its metadata were not written."""
        path = self.path / METADATA_FILE
        if not path.exists():
            self._is_described = False
            names = [each.name for each in self.path.iterdir()]
            files = sorted((n for n in names if _FILE.fullmatch(n)), key=_number)
            if not files:
                raise RecordingError(
                    f"{self.path} is not a bag of ROS 2: it has no {METADATA_FILE}",
                    hint="`rtgen run --ros2 --record FOLDER` and `ros2 bag record` write one",
                )
            return Folder(tuple(files), "", by_message=False)
        try:
            text = read_file(path, _MAX_METADATA).decode("utf-8", "replace")
        except UnreadableError as error:
            raise UnavailableError(f"cannot read {path}: {error.strerror}") from error
        return folder_of(str(path), text)


def _number(name: str) -> tuple[int, str]:
    """Return the sort key of a file by its number, `run_10.mcap` after `run_9.mcap`."""
    match = _FILE.fullmatch(name)
    return int((match and match[1][-9:]) or 0), name


def _unpacked(path: Path) -> McapFile | SqliteFile:
    """Open a file that is compressed as a whole (`ros2 bag record --compression-mode file`).

    Raises RecordingError.
    """
    try:
        import zstandard
    except ImportError as error:
        raise UnavailableError(
            f"{path} needs zstandard, which is not installed",
            hint=installation("record"),
        ) from error
    copy = Copy(path.stem)
    work = Work(path, path.stat().st_size)
    try:
        with open_file(path) as packed, create_file(copy.path) as stream:
            parts = zstandard.ZstdDecompressor().stream_reader(packed)
            while part := parts.read(_PART):
                work.take_octets(len(part))
                stream.write(part)
    except OSError as error:
        raise UnavailableError(f"cannot read {path}: {error.strerror}") from error
    except zstandard.ZstdError as error:
        raise RecordingError(f"{path}: {error}") from error
    opened = _plain_file(path, read_start(copy.path, len(SQLITE)), copy)
    if opened is None:
        raise RecordingError(f"{path}: its content is neither MCAP nor sqlite3")
    return opened
