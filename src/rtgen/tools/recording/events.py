"""Events of a recording or of a log, in the form of a log's lines.

`rtgen run --log` writes JSON lines, `--record` MCAP. Both are read as dictionaries: `t` [ns since
the start], `event`, and further keys of the event; samples have `instance`, `port`, `value`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from io import TextIOWrapper
from pathlib import Path
from typing import Any, TypeAlias

from rtgen.facts.files import open_file, read_start
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.system.json_printers import plain
from rtgen.tools.kit.member_units import Units
from rtgen.tools.recording.bag_files import Recording, open_recording, start_of
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.mcap_reader import Channel, Message
from rtgen.tools.recording.schema_types import decoder, type_of
from rtgen.tools.recording.schemas import ENCODINGS, Schema

Event: TypeAlias = dict[str, Any]

_MAX_LINE = 1 << 26
_SUFFIXES = {".mcap": "MCAP", ".db3": "sqlite3", ".zstd": "compressed by zstd"}


@dataclass(slots=True)
class Decoders:
    """Decoders of messages, one for each schema."""

    _types: dict[Schema, Any] = field(default_factory=dict)
    _known: dict[Channel, Callable[[bytes], Any]] = field(default_factory=dict)

    def value(self, message: Message) -> Any:
        """Return the content of a message as JSON. Raises RecordingError."""
        channel = message.channel
        decode = self._known.get(channel)
        if decode is None:
            decode = self._known[channel] = self._decoder(channel)
        try:
            return decode(message.data)
        except (CdrError, ValueError) as error:
            raise RecordingError(f"{channel.topic}: {error}") from error
        except RecursionError:
            raise RecordingError(
                f"{channel.topic}: a value is nested too deep"
            ) from None

    def _decoder(self, channel: Channel) -> Callable[[bytes], Any]:
        if channel.encoding == "json":
            return json.loads
        if channel.encoding != "cdr" or channel.schema.encoding not in ENCODINGS:
            schema = channel.schema.encoding or "no schema"
            raise RecordingError(
                f"{channel.topic}: no decoder for {channel.encoding} with {schema}",
                hint=f"rtgen reads cdr with {', '.join(filter(None, ENCODINGS))}, and json",
            )
        type_ = self._types.get(channel.schema)
        if type_ is None:
            type_ = self._types[channel.schema] = type_of(channel.schema)
        decode = decoder(channel.schema)
        return lambda data: plain(decode(type_, data))


class Log:
    """A file recorded by `rtgen run`, in either form."""

    def __init__(self, path: str | Path) -> None:
        """Open a file. Raises RecordingError if it is unreadable or in neither form."""
        self.path = Path(path)
        self.recording = open_recording(self.path)
        self._is_cut = False
        self.units: dict[tuple[str, str], Units] = {}
        """Units of members by instance and port, for samples read so far."""
        if self.recording is not None:
            return
        head = read_start(self.path, 1)
        if (suffix := self.path.suffix.lower()) in _SUFFIXES:
            form = _SUFFIXES[suffix]
            what = f"is not {form}, as its suffix says" if head else "is empty"
            raise RecordingError(
                f"{path} {what}", hint="rtgen run --record FILE.mcap writes a recording"
            )
        if head not in (b"{", b""):
            raise RecordingError(
                f"{path} is not a recording: neither MCAP nor JSON lines, and no bag of ROS 2",
                hint="rtgen run --record FILE.mcap or --log FILE writes one",
            )

    @property
    def start(self) -> int:
        """The clock's time at the start [ns]: 0 in simulated time, and in files of others.

        For bags of others, that of the first message.
        """
        return 0 if self.recording is None else start_of(self.recording)

    def losses(self) -> list[str]:
        """Return what could not be read of the file, in words, after all events were read."""
        if self.recording is not None:
            return self.recording.losses()
        return ["cut off in its last line"] if self._is_cut else []

    def events(
        self, is_selected: Callable[[Mapping[str, str]], bool] = lambda entry: True
    ) -> Iterator[Event]:
        """Yield all events in order; `is_selected` gets `event`, `instance` and `port`."""
        if self.recording is None:
            return (event for event in self._lines() if is_selected(event))
        return self._decoded(self.recording, is_selected)

    def heads(self) -> Iterator[Event]:
        """Yield each event without its content; samples of MCAP with the name of their `type`."""
        if self.recording is None:
            yield from self._lines()
            return
        start = self.start
        latest: dict[Channel, Event] = {}
        for message in self.recording.messages():
            channel = message.channel
            if channel not in latest:
                latest[channel] = _head(channel) | {"type": channel.schema.name}
            yield latest[channel] | {"t": message.time - start}

    def _decoded(
        self, file: Recording, is_selected: Callable[[Mapping[str, str]], bool]
    ) -> Iterator[Event]:
        decoders = Decoders()
        start = self.start
        heads: dict[Channel, Event | None] = {}
        for message in file.messages():
            channel = message.channel
            if channel not in heads:
                head = _head(channel)
                heads[channel] = head if is_selected(head) or _is_shared(head) else None
                address = channel.get("instance"), channel.get("port")
                self.units[address] = _units(channel)
            channel_head = heads[channel]
            if channel_head is not None:
                value = decoders.value(message)
                inside = (
                    {"value": value} if channel_head["event"] == "sample" else value
                )
                if not isinstance(inside, dict):
                    raise RecordingError(f"{channel.topic}: a message is not an object")
                event = {"t": message.time - start, **channel_head, **_written(inside)}
                if not _is_shared(channel_head) or is_selected(event):
                    yield event

    def _lines(self) -> Iterator[Event]:
        with TextIOWrapper(open_file(self.path), "utf-8", "replace") as stream:
            for number, line in enumerate(
                iter(lambda: stream.readline(_MAX_LINE), ""), 1
            ):
                try:
                    event = json.loads(line)
                except ValueError as error:
                    if not line.endswith("\n"):
                        self._is_cut = True  # the writer was killed
                        return
                    message = f"{self.path}:{number}: no JSON: {error}"
                    raise RecordingError(message) from error
                except RecursionError:
                    message = f"{self.path}:{number}: a value is nested too deep"
                    raise RecordingError(message) from None
                if not (
                    isinstance(event, dict)
                    and isinstance(event.get("t"), int)
                    and isinstance(event.get("event"), str)
                ):
                    raise RecordingError(f"{self.path}:{number}: no line of a log")
                yield event


def _head(channel: Channel) -> Event:
    """Return the part of an event that its channel determines.

    Channels of other writers are samples of a topic.
    """
    kind = channel.get("kind")
    if not kind:
        return {"event": "sample", "instance": "", "port": channel.topic}
    keys = {
        "sample": ("instance", "port"),
        "frame": ("bus",),
        "call": ("instance",),
    }
    return {"event": kind, **{key: channel.get(key) for key in keys.get(kind, ())}}


def units_by_path(channel: Channel) -> Mapping[str, str]:
    """Return the units of the members of a channel's samples, by paths with dots."""
    try:
        units = json.loads(channel.get("units") or "{}")
    except (ValueError, RecursionError):
        units = {}
    by_path = units if isinstance(units, dict) else {}
    return {path: str(unit) for path, unit in by_path.items()}


def _units(channel: Channel) -> Units:
    by_path = units_by_path(channel)
    return lambda path: by_path.get(".".join(path), "")


def _is_shared(head: Event) -> bool:
    """Return whether the events of a channel contain their instances."""
    return "instance" not in head and "bus" not in head


def _written(inside: Event) -> Event:
    """Return an event as in a log: with a reason only if it is not empty."""
    if inside.get("reason") == "":
        return {key: value for key, value in inside.items() if key != "reason"}
    return inside
