"""Checkpoints: declared state of a component, stored in a file that outlives the process.

A file has two slots, which are written alternately, so that a process killed while writing leaves
the previous checkpoint intact. They are memory-mapped: a checkpoint costs no system call.
"""

from __future__ import annotations

import mmap
import struct
from pathlib import Path
from typing import Any, Generic, TypeVar
from urllib.parse import quote
from zlib import crc32

from rtgen.facts.files import check_file
from rtgen.runtime.errors import CheckpointError
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.marshalling.errors import CdrError

T = TypeVar("T", bound=DataType)

MAX_LENGTH = 1 << 16
"""Maximum length of a state [octets of CDR]."""

_CHECK = struct.Struct("<I")
_HEAD = struct.Struct("<QII")
"""Number of the checkpoint, digest of its type, length of its octets; a check sum precedes it."""
_SLOT_SIZE = _CHECK.size + _HEAD.size + MAX_LENGTH


class CheckpointFile:
    """The file with a component's last checkpoint. Raises CheckpointError if it is unusable."""

    def __init__(self, path: Path) -> None:
        try:
            if path.exists():
                check_file(path)
            if not path.exists() or path.stat().st_size != 2 * _SLOT_SIZE:
                # Written, not only extended, so that a full disk is detected here.
                path.write_bytes(bytes(2 * _SLOT_SIZE))
            with path.open("r+b") as file:
                self._map = mmap.mmap(file.fileno(), 2 * _SLOT_SIZE)
        except OSError as error:
            raise CheckpointError(f"{path}: {error.strerror}") from error
        self._number, self._type, self._octets = max(
            (self._slot(each) for each in range(2)), key=lambda slot: slot[0]
        )

    def _slot(self, index: int) -> tuple[int, int, bytes]:
        """Return number, type and octets of a slot; number 0 without a checkpoint."""
        start = index * _SLOT_SIZE
        body = start + _CHECK.size
        [check] = _CHECK.unpack_from(self._map, start)
        number, digest, length = _HEAD.unpack_from(self._map, body)
        end = body + _HEAD.size + min(length, MAX_LENGTH)
        if not number or length > MAX_LENGTH or crc32(self._map[body:end]) != check:
            return 0, 0, b""
        return number, digest, self._map[body + _HEAD.size : end]

    def read(self) -> tuple[int, bytes] | None:
        """Return the digest of the type and the octets of the checkpoint found at the start."""
        return (self._type, self._octets) if self._octets else None

    def write(self, digest: int, octets: bytes) -> None:
        """Replace the checkpoint."""
        self._number += 1
        body = _HEAD.pack(self._number, digest, len(octets)) + octets
        start = self._number % 2 * _SLOT_SIZE
        whole = _CHECK.pack(crc32(body)) + body
        self._map[start : start + len(whole)] = whole


class CheckpointFolder:
    """A folder with a checkpoint file for each component of a system.

    Raises CheckpointError if it cannot be created.
    """

    def __init__(self, path: Path) -> None:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CheckpointError(f"{path}: {error.strerror}") from error
        self._path = path

    def file(self, instance: str) -> CheckpointFile:
        """Return a component's file. Raises CheckpointError."""
        return CheckpointFile(self._path / f"{quote(instance, safe='')}.checkpoint")


class Checkpoint(Generic[T]):
    """State declared by a component with `Component.add_checkpoint`.

    It is stored from the component's initialization on if the system has a folder for it (`rtgen
    run --supervise`, `--checkpoints`); otherwise `save` does nothing.
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
        """Whether `save` stores states; components that save in each tick should check it first."""
        return self._file is not None

    def save(self, state: T) -> None:
        """Store a state, replacing the previous one.

        Raises CdrError if it is not of its type, CheckpointError beyond `MAX_LENGTH` octets.
        """
        file = self._file
        if file is None:
            return
        octets = state.to_cdr()
        if len(octets) > MAX_LENGTH:
            raise CheckpointError(
                f"a checkpoint has {MAX_LENGTH} octets at most, not {len(octets)}"
            )
        file.write(self._digest, octets)

    def restored(self) -> T | None:
        """Return the last state of the previous process; None without one, and in later calls."""
        state, self._restored = self._restored, None
        return state

    def open(self, file: CheckpointFile) -> None:
        """Use a file from now on, and read its checkpoint."""
        self._file = file
        self._restored = self._read(file)

    def close(self) -> None:
        """Stop storing states."""
        self._file = None

    def _read(self, file: CheckpointFile) -> T | None:
        content = file.read()
        if content is None:
            return None
        digest, octets = content
        try:
            if digest == self._digest:
                return self._type.from_cdr(octets)
            why: Any = "it is of another definition"
        except CdrError as error:
            why = error
        log.warning("%s: its checkpoint is not used: %s", self._instance, why)
        return None
