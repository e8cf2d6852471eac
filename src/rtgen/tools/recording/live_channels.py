"""Channels of a run over Foxglove's WebSocket protocol, in place of a file.

Each client has a bounded queue of messages, which drops the oldest if the client is slow.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from foxglove import Channel, Context, Schema


class LiveChannels:
    """Writer of `Recorder` for the clients of a server. Can be used from any thread."""

    def __init__(self, context: Context) -> None:
        self.lock = threading.RLock()
        self._context = context
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._numbers: dict[tuple[str, str, int], int] = {}

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Do nothing: the protocol only has metadata of channels."""

    def schema(self, name: str, encoding: str, text: str) -> int:
        """Announce a schema; return its id."""
        from foxglove import Schema

        with self.lock:
            schema = Schema(name=name, encoding=encoding, data=text.encode())
            self._schemas.append(schema)
            return len(self._schemas)

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel of messages in an encoding; return its id.

        A topic has one channel, independently of the component in whose tick samples are written.
        """
        from foxglove import Channel

        with self.lock:
            key = topic, encoding, schema
            if key in self._numbers:
                return self._numbers[key]
            channel = Channel(
                topic,
                message_encoding=encoding,
                schema=self._schemas[schema - 1] if schema else None,
                context=self._context,
                metadata={k: v for k, v in entries.items() if k != "during"},
            )
            self._channels.append(channel)
            self._numbers[key] = len(self._channels)
            return self._numbers[key]

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Send a message with a time [ns] to the subscribers of its channel."""
        self.put(channel, time, data)

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Send a message, as `message` does."""
        self._channels[channel - 1].log(data, log_time=time)
