"""A writer of recordings that outlives failures of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack
from typing import Any

from rtgen.tools.recording.channels import Writer
from rtgen.tools.recording.errors import RecordingError


class LastingWriter:
    """A writer whose failure ends the recording, and not the run; see `channels.Writer`.

    `failed` is called with the first failure.
    """

    def __init__(self, writer: Writer, failed: Callable[[Exception], None]) -> None:
        self._writer = writer
        self._failed = failed
        self._is_open = True

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Held while a message is put."""
        return self._writer.lock

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """See `Writer`."""
        self._writer.metadata(name, entries)

    def schema(self, name: str, encoding: str, text: str) -> int:
        """See `Writer`."""
        return self._writer.schema(name, encoding, text)

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """See `Writer`."""
        return self._writer.channel(topic, encoding, schema, entries)

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Write a message with a time [ns], unless the recording has ended."""
        with self.lock:
            self.put(channel, time, data)

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Write a message, for a caller that holds the lock, unless the recording has ended."""
        if not self._is_open:
            return
        try:
            self._writer.put(channel, time, data)
        except RecordingError as error:
            self._is_open = False
            self._failed(error)

    def close(self, files: ExitStack) -> None:
        """Write what is left by closing the files of the writer."""
        with self.lock:
            try:
                files.close()
            except RecordingError as error:
                if self._is_open:
                    self._failed(error)
            self._is_open = False
