"""Writes MCAP files: in chunks, compressed, the same bytes for the same calls."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from rtgen.recording.errors import RecordingError

COMPRESSIONS: Final = ("zstd", "lz4", "none")
CHUNK: Final = 1 << 18
"""Octets of a chunk before it is compressed, at least; what a kill can lose at most."""

_LIBRARY = "rtgen"


class McapWriter:
    """An MCAP file that is being written. Its methods may be called from any thread.

    A chunk reaches the file as a whole, when it is full or `longest` ns of messages are in it. So
    a file whose writer was killed can be read up to its last whole chunk. Memory holds a chunk and
    its index, and about 200 octets and 20 for each channel of every chunk before it.
    """

    def __init__(
        self, path: str | Path, compression: str = "zstd", longest: int | None = None
    ) -> None:
        """Create the file. Raises RecordingError."""
        if find_spec("mcap") is None:
            raise RecordingError(
                "recordings need mcap, which is not installed",
                hint="pip install 'rtgen[record]'",
            )
        from mcap.writer import CompressionType, Writer

        kinds = CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE
        try:
            self._file = _File(path)
        except OSError as error:
            raise RecordingError(f"cannot write {path}: {error.strerror}") from error
        self._path = path
        self._longest = longest
        self._begun: int | None = None
        self._writer: Any = Writer(
            self._file,  # type: ignore[arg-type]  # what it uses of a stream
            chunk_size=CHUNK,
            compression=kinds[COMPRESSIONS.index(compression)],
        )
        self._writer.start(library=_LIBRARY)
        self._sequences: dict[int, int] = {}
        self._open = True
        self.lock = threading.RLock()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.close()

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Write a metadata record."""
        with self.lock:
            self._writer.add_metadata(name, dict(entries))

    def schema(self, name: str, encoding: str, text: str) -> int:
        """Announce a schema; returns its id."""
        with self.lock:
            number: int = self._writer.register_schema(name, encoding, text.encode())
            return number

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel of messages in an encoding; returns its id."""
        with self.lock:
            channel: int = self._writer.register_channel(
                topic, encoding, schema, dict(entries)
            )
            self._sequences[channel] = 0
            return channel

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Write a message at a time [ns]. Raises RecordingError if the file cannot be written."""
        with self.lock:
            if not self._open:
                return
            number = self._sequences[channel]
            self._sequences[channel] = number + 1 & 0xFFFFFFFF
            try:
                self._writer.add_message(channel, time, data, time, number)
                if self._longest is not None:
                    self._flush_if_late(time)
            except OSError as error:
                raise RecordingError(
                    f"cannot write {self._path}: {error.strerror}"
                ) from error

    def close(self) -> None:
        """Write the last chunk and the summary; messages that come later are ignored."""
        with self.lock:
            if not self._open:
                return
            self._open = False
            try:
                self._writer.finish()
            except OSError as error:
                raise RecordingError(
                    f"cannot write {self._path}: {error.strerror}"
                ) from error
            finally:
                self._file.close()

    def _flush_if_late(self, time: int) -> None:
        assert self._longest is not None
        if self._begun is None:
            self._begun = time
        elif time - self._begun >= self._longest:
            self._begun = None
            self._writer.flush()


class _File:
    """A file without a buffer of its own, so that each chunk is at the system once written."""

    def __init__(self, path: str | Path) -> None:
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        self._at = 0

    def write(self, data: bytes) -> int:
        view = memoryview(data)
        while view:
            written = os.write(self._descriptor, view)
            view = view[written:]
        self._at += len(data)
        return len(data)

    def tell(self) -> int:
        return self._at

    def flush(self) -> None:
        return None

    def close(self) -> None:
        os.close(self._descriptor)
