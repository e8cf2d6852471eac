"""Converts a recording of a run into a bag of ROS 2: samples become messages of topics."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from rtgen.compiler.project.ros2 import Ros2Settings, TopicEntry
from rtgen.facts import ros_names
from rtgen.facts.connector_properties import MARSHALING
from rtgen.facts.ros_marshaling import DEFAULT_TOPIC, messages_for, parse
from rtgen.facts.ros_qos import PROFILES, Profile
from rtgen.facts.ros_qos_words import profiles, topic_of
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.ros2.marshaling import ConstantError, constant_of, marshaling
from rtgen.runtime.ros2.types import encoded
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.recording import messages, ros_messages
from rtgen.tools.recording.bag_files import Recording
from rtgen.tools.recording.bag_metadata import profiles_of
from rtgen.tools.recording.bag_writer import BagWriter
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.mcap_reader import Channel, Message
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.schema_types import (
    message_classes,
    named_type_of,
    type_of,
)

Convert = Callable[[bytes], bytes | None]
"""Function that returns a message of ROS 2; None for a sample without counterpart in it."""

_DEFAULT: Final = PROFILES["default"]
_OTHER: Final = re.compile(r"[^A-Za-z0-9_/]+")


@dataclass(frozen=True, slots=True)
class _Topic:
    """A topic of samples: its name, the class of its messages, offered QoS."""

    name: str
    type: type[Any]
    profiles: tuple[Profile, ...]
    convert: Convert


@dataclass(slots=True)
class Exported:
    """What was exported: the number of messages of each topic, and the ports left out.

    `left_out` are types of samples by port; `without` counts samples without counterpart.
    """

    counts: dict[str, int] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    without: dict[str, int] = field(default_factory=dict)


def export(recorded: Recording, settings: Ros2Settings, path: Path) -> Exported:
    """Write a bag of what a recording has; `path` is as for `BagWriter`.

    Raises RecordingError; then nothing is written.
    """
    if path.exists():
        raise RecordingError(f"{path} exists already", hint="a bag is a new folder")
    exporter = _Exporter(recorded, settings)
    try:
        with BagWriter(path) as writer:
            if METADATA in recorded.metadata:
                kept = ("clock", "start")
                own = recorded.metadata[METADATA]
                writer.describe({key: own[key] for key in kept if key in own})
            exporter.write(writer)
    except BaseException:
        _remove(path)
        raise
    if not exporter.done.counts:
        _remove(path)
        names = ", ".join(exporter.done.left_out) or "none"
        raise RecordingError(
            f"{recorded.path} has no samples that are messages of ROS 2",
            hint=f"ports with other types: {names}; an adapter or marshaling_type converts them",
        )
    return exporter.done


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


class _Exporter:
    def __init__(self, recorded: Recording, settings: Ros2Settings) -> None:
        self.done = Exported()
        self._recorded = recorded
        self._namespace = settings.namespace
        self._entries: dict[str, list[TopicEntry]] = {}
        for entry in settings.topics:
            port = f"{entry.instance}.{entry.port}"
            self._entries.setdefault(port, []).append(entry)
        self._joined: dict[str, messages.Connection] = {}
        self._topics: dict[Channel, list[_Topic]] = {}

    def write(self, writer: BagWriter) -> None:
        for message in self._recorded.messages():
            channel = message.channel
            kind = channel.get("kind")
            if kind == "connection":
                self._connect(message)
            elif kind in ("", "sample"):
                if channel not in self._topics:
                    self._topics[channel] = [*self._topics_of(channel)]
                for topic in self._topics[channel]:
                    self._put(writer, topic, message)

    def _put(self, writer: BagWriter, topic: _Topic, message: Message) -> None:
        try:
            octets = topic.convert(message.data)
        except CdrError as error:
            where = f"{self._recorded.path}: {message.channel.topic}"
            raise RecordingError(f"{where}: {error}") from error
        if octets is None:
            without = self.done.without
            without[topic.name] = without.get(topic.name, 0) + 1
            return
        writer.topic(topic.name, topic.type, topic.profiles)
        writer.message(topic.name, message.time, octets)
        self.done.counts[topic.name] = self.done.counts.get(topic.name, 0) + 1

    def _connect(self, message: Message) -> None:
        try:
            change = deserialize(messages.Connection, message.data)
        except CdrError as error:
            raise RecordingError(f"{self._recorded.path}: {error}") from error
        if change.connected:
            self._joined[change.name] = change
        else:
            self._joined.pop(change.name, None)
        self._topics.clear()

    def _topics_of(self, channel: Channel) -> Iterable[_Topic]:
        """Return the topics of a channel's samples."""
        name = channel.schema.name.replace("::", "/")
        is_message = ros_messages.scoped(name) is not None and channel.encoding == "cdr"
        if not channel.get("kind"):
            if is_message:
                offered = profiles_of(channel.get("offered_qos_profiles"))
                yield self._plain(channel, channel.topic, offered or (_DEFAULT,))
            else:
                self.done.left_out[channel.topic] = channel.schema.name or "json"
            return
        port = f"{channel.get('instance')}.{channel.get('port')}"
        entries = {entry.topic: entry for entry in self._bound(port)}
        for entry in entries.values():
            if entry.message is not None:
                yield self._marshaled(channel, entry)
            elif is_message:
                topic = self._qualified(entry.topic)
                yield self._plain(channel, topic, (entry.profile,))
        if not entries and is_message:
            yield self._plain(channel, _topic_of(port), (_DEFAULT,))
        elif not entries:
            self.done.left_out[port] = channel.schema.name or "json"

    def _bound(self, port: str) -> Iterable[TopicEntry]:
        """Return the entries of a port, and those of ports that it is connected to."""
        yield from self._entries.get(port, ())
        for each in self._joined.values():
            if each.source != port:
                continue
            properties = {p.name: p.value for p in each.properties}
            message = parse(properties.get(MARSHALING, ""))
            if message is not None:
                yield TopicEntry(
                    instance="",
                    port="",
                    topic=topic_of(properties) or DEFAULT_TOPIC,
                    profile=profiles(properties)[0],
                    span=None,
                    message=message,
                )
            yield from self._entries.get(each.target, ())

    def _qualified(self, name: str) -> str:
        try:
            return ros_names.qualified(name, self._namespace)
        except ValueError as error:
            raise RecordingError(f"the topic {error}") from error

    def _plain(
        self, channel: Channel, name: str, offered: tuple[Profile, ...]
    ) -> _Topic:
        """Return the topic of samples that are messages."""
        type_ = type_of(channel.schema)
        if channel.schema.encoding in ros_messages.ENCODINGS:
            return _Topic(name, type_, offered, bytes)
        # Texts of 16-bit characters have another form in ROS 2.
        return _Topic(
            name, type_, offered, lambda data: encoded(deserialize(type_, data))
        )

    def _marshaled(self, channel: Channel, entry: TopicEntry) -> _Topic:
        """Return the topic of samples that are converted to messages."""
        assert entry.message is not None
        own = channel.schema.name
        if entry.message not in messages_for(own) or channel.encoding != "cdr":
            raise RecordingError(
                f"{channel.topic} has samples of {own}, which cannot go as {entry.message}"
            )
        data = named_type_of(channel.schema)
        shipped = ros_messages.shipped_model(entry.message)
        message = message_classes(shipped)[entry.message]
        try:
            constants = tuple(
                constant_of(message, path, value) for path, value, _ in entry.constants
            )
        except ConstantError as error:
            raise RecordingError(f"{entry.topic}: {error}", error.hint) from error
        conversion = marshaling(data, message, lambda _: None, constants)

        def convert(octets: bytes) -> bytes | None:
            value = deserialize(data, octets)
            try:
                return encoded(conversion.to_message(value))
            except (CdrError, ValueError):
                return None  # as a run with --ros2 does not send it

        topic = self._qualified(entry.topic)
        return _Topic(topic, message, (entry.profile,), convert)


def _topic_of(port: str) -> str:
    """Return the topic of a port without an entry: `/INSTANCE/PORT`, in characters of ROS 2."""
    words = (_OTHER.sub("_", each).strip("_") or "x" for each in port.split(".", 1))
    parts = [re.sub("__+", "_", word) for word in words]
    return "/" + "/".join(f"x{p}" if p[0].isdigit() else p for p in parts)


def summary(done: Exported) -> list[str]:
    """Return what was exported, in words."""
    number = sum(done.counts.values())
    lines = [f"{number} messages of {len(done.counts)} topics"]
    if done.left_out:
        ports = _listed(f"{port} ({type_})" for port, type_ in done.left_out.items())
        lines.append(f"left out, not messages of ROS 2: {ports}")
    if done.without:
        lost = _listed(f"{topic}: {count}" for topic, count in done.without.items())
        lines.append(f"samples without counterpart in their message: {lost}")
    return lines


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
