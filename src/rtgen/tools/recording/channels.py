"""Channels of a recording, or of a live view, by which samples and events are written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any, Final, NamedTuple, Protocol

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import Descriptor
from rtgen.runtime.marshalling.layouts.formats import Format, UnsupportedError
from rtgen.runtime.marshalling.layouts.trees import parts, tree_of
from rtgen.runtime.system.json_printers import json_printer
from rtgen.runtime.xcdr import Representation, representation_of
from rtgen.tools.recording.schemas import Schema, schema_of

LAYOUT: Final = "1"
"""Version of the layout of channels and metadata."""

_SCOPED = re.compile(r"[A-Za-z_]\w*(::[A-Za-z_]\w*)*", re.ASCII)

Encoder = Callable[[Any], bytes]


class Writer(Protocol):
    """Destination of a recording: an MCAP file, or the clients of a live view."""

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Held while a message is put."""

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Write metadata of the whole recording."""

    def schema(self, name: str, encoding: str, text: str) -> int:
        """Announce a schema; return its id."""

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel of messages in an encoding; return its id."""

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Write a message with a time [ns]."""

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Write a message, for a caller that holds the lock."""


class Encoding(NamedTuple):
    """The number of a schema, the name of an encoding, and what encodes values by it."""

    schema: int
    name: str
    encode: Encoder


class Channels:
    """Announces channels, with their schemas, to a writer when they are first used."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._encodings: dict[Any, Encoding] = {}
        self._schemas: dict[Schema, int] = {}
        self._of_events: dict[str, int] = {}

    def put(
        self,
        topic: str,
        kind: str,
        value: Any,
        now: Callable[[], int],
        **entries: str,
    ) -> None:
        """Write an event of a topic at the time [ns] that `now` returns. Raises RecordingError."""
        with self._writer.lock:
            schema, encoding, encode = self.encoding(type(value))
            channel = self._of_events.get(topic)
            if channel is None:
                channel = self._writer.channel(
                    topic, encoding, schema, {"kind": kind, **entries}
                )
                self._of_events[topic] = channel
            self._writer.message(channel, now(), encode(value))

    def of_port(
        self, instance: str, port: str, type_: Any, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel for samples of a port; return its number."""
        encoding = self.encoding(type_)
        named = {
            "kind": "sample",
            "instance": instance,
            "port": port,
            "type": type_._descriptor_.repository_id,
            **entries,
        }
        return self._writer.channel(
            topic_of(instance, port), encoding.name, encoding.schema, named
        )

    def encoding(self, type_: Any) -> Encoding:
        """Return how values of a type are encoded: CDR, else JSON."""
        encoding = self._encodings.get(type_)
        if encoding is None:
            encode = cdr_encoder(type_)
            if encode is None:
                encoding = Encoding(0, "json", _json_encoder(type_))
            else:
                schema = self._schema(schema_of(type_._descriptor_))
                encoding = Encoding(schema, "cdr", encode)
            self._encodings[type_] = encoding
        return encoding

    def _schema(self, schema: Schema) -> int:
        if schema not in self._schemas:
            number = self._writer.schema(schema.name, schema.encoding, schema.text)
            self._schemas[schema] = number
        return self._schemas[schema]


def unit_entries(unit: str, members: Mapping[str, str]) -> dict[str, str]:
    """Return the entries of a channel for the unit of a port, and for those of its members."""
    entries = {"unit": unit}
    if members:
        entries["units"] = json.dumps(dict(members), ensure_ascii=False)
    return {name: text for name, text in entries.items() if text}


def topic_of(instance: str, port: str) -> str:
    """Return the topic of a port."""
    return f"/{instance}/{port}"


def cdr_encoder(type_: Any) -> Encoder | None:
    """Return an encoder of payloads with encapsulation header; None if XCDR cannot encode the type.

    Version 1 of XCDR, or version 2 if the type requires it (DDS-XTypes 1.3, 7.6.3.1).
    """
    descriptor: Descriptor = type_._descriptor_
    if not _SCOPED.fullmatch(str(getattr(descriptor, "name", ""))):
        return None
    version = 2 if getattr(descriptor, "representation", 0) == 2 else 1
    kind: Representation = representation_of(type_, version)
    header = bytes((0, kind, 0, 0))
    try:
        for part in parts(descriptor):
            tree_of(part, Format(version))
    except UnsupportedError:
        return None
    body = compiled("to_cdr", descriptor, Format(version))

    def encode(value: Any) -> bytes:
        octets: bytes = header + body(value, True)
        return octets

    return encode


def _json_encoder(type_: Any) -> Encoder:
    printed = json_printer(type_)
    return lambda value: printed(value).encode()
