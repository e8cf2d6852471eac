"""Checkpoints: declared state of a component, kept in a file that outlives its process.

A file has two slots, which are written in turn: a process that is killed while it writes leaves the
checkpoint before. They are mapped into memory, so that a checkpoint costs no system call.
"""

from __future__ import annotations

import mmap
import struct
from pathlib import Path
from typing import Any, Generic, TypeVar
from urllib.parse import quote
from zlib import crc32

from rtgen.runtime.errors import CheckpointError
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.marshalling.errors import CdrError

T = TypeVar("T", bound=DataType)

LONGEST = 1 << 16
"""The longest state [octets of CDR]."""

_CHECK = struct.Struct("<I")
_HEAD = struct.Struct("<QII")
"""Number of the checkpoint, digest of its type, length of its octets; a check sum stands before."""
_ROOM = _CHECK.size + _HEAD.size + LONGEST


class CheckpointFile:
    """The last checkpoint of a component. Raises CheckpointError if the file cannot be used."""

    def __init__(self, path: Path) -> None:
        try:
            if not path.exists() or path.stat().st_size != 2 * _ROOM:
                # Written, not only sized: a full disk has to be noticed here.
                path.write_bytes(bytes(2 * _ROOM))
            with path.open("r+b") as file:
                self._map = mmap.mmap(file.fileno(), 2 * _ROOM)
        except OSError as error:
            raise CheckpointError(f"{path}: {error.strerror}") from error
        self._number, self._type, self._octets = max(
            (self._slot(each) for each in range(2)), key=lambda slot: slot[0]
        )

    def _slot(self, index: int) -> tuple[int, int, bytes]:
        """Number, type and octets of a slot; number 0 if it holds no checkpoint."""
        start = index * _ROOM
        body = start + _CHECK.size
        [check] = _CHECK.unpack_from(self._map, start)
        number, digest, length = _HEAD.unpack_from(self._map, body)
        end = body + _HEAD.size + min(length, LONGEST)
        if not number or length > LONGEST or crc32(self._map[body:end]) != check:
            return 0, 0, b""
        return number, digest, self._map[body + _HEAD.size : end]

    def read(self) -> tuple[int, bytes] | None:
        """Digest of the type and octets of the checkpoint that was there at the start."""
        return (self._type, self._octets) if self._octets else None

    def write(self, digest: int, octets: bytes) -> None:
        """Replace the checkpoint."""
        self._number += 1
        body = _HEAD.pack(self._number, digest, len(octets)) + octets
        start = self._number % 2 * _ROOM
        whole = _CHECK.pack(crc32(body)) + body
        self._map[start : start + len(whole)] = whole


class CheckpointFolder:
    """A folder with the checkpoints of the components of a system, a file for each.

    Raises CheckpointError if it cannot be made.
    """

    def __init__(self, path: Path) -> None:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CheckpointError(f"{path}: {error.strerror}") from error
        self._path = path

    def file(self, instance: str) -> CheckpointFile:
        """Return the file of a component. Raises CheckpointError."""
        return CheckpointFile(self._path / f"{quote(instance, safe='')}.checkpoint")


class Checkpoint(Generic[T]):
    """The state that a component declares with `Component.add_checkpoint`.

    It is kept where a system has a folder for it (`rtgen run --supervise`, `--checkpoints`), from
    the component's initialization on; otherwise `save` does nothing.
    """

    __slots__ = ("_digest", "_file", "_instance", "_restored", "_type")

    def __init__(self, type_: type[T], instance: str) -> None:
        self._type = type_
        self._instance = instance
        self._digest = crc32(repr(type_._descriptor_).encode())
        self._file: CheckpointFile | None = None
        self._restored: T | None = None

    @property
    def is_kept(self) -> bool:
        """Whether `save` keeps a state; components that save in each tick look at it first."""
        return self._file is not None

    def save(self, state: T) -> None:
        """Keep a state in place of the last one.

        Raises CdrError if it does not fit its type, CheckpointError beyond `LONGEST` octets.
        """
        file = self._file
        if file is None:
            return
        octets = state.to_cdr()
        if len(octets) > LONGEST:
            raise CheckpointError(
                f"a checkpoint has {LONGEST} octets at most, not {len(octets)}"
            )
        file.write(self._digest, octets)

    def restored(self) -> T | None:
        """Return the last state of the process before, the first time; None without one, and
        later.
        """
        state, self._restored = self._restored, None
        return state

    def open(self, file: CheckpointFile) -> None:
        """Keep states in a file from now on, and read the one that is there."""
        self._file = file
        self._restored = self._read(file)

    def close(self) -> None:
        """Keep no more states."""
        self._file = None

    def _read(self, file: CheckpointFile) -> T | None:
        found = file.read()
        if found is None:
            return None
        digest, octets = found
        try:
            if digest == self._digest:
                return self._type.from_cdr(octets)
            why: Any = "it is of another definition"
        except CdrError as error:
            why = error
        log.warning("%s: its checkpoint is not used: %s", self._instance, why)
        return None
