"""Writes bags of ROS 2: an MCAP file of topics alone, by itself or in a folder with its metadata.

Profile, schemas and metadata are those of rosbag2_storage_mcap, so `ros2 bag`, rosbags,
mcap-ros2-support and Foxglove read it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from rtgen.facts.files import write_atomically
from rtgen.facts.ros_qos import Profile
from rtgen.runtime.closable import Closable
from rtgen.runtime.ros2.types import ros_name, type_hash
from rtgen.tools.recording import ros_messages
from rtgen.tools.recording.bag_metadata import (
    METADATA_FILE,
    METADATA_RECORD,
    TopicInformation,
    file_text,
    information,
    profiles_text,
    record_text,
)
from rtgen.tools.recording.errors import RecordingError, UnavailableError
from rtgen.tools.recording.mcap_writer import METADATA, McapWriter

PROFILE: Final = "ros2"
"""The profile in the header of MCAP files of ROS 2."""
SUFFIX: Final = ".mcap"


class BagWriter(Closable):
    """A bag being written. Its methods can be called from any thread.

    A path that ends in `.mcap` is that of the file itself; any other one that of a new folder, with
    the file `NAME_0.mcap`, and with `metadata.yaml` after `close`.
    """

    def __init__(
        self,
        path: Path,
        compression: str = "zstd",
        longest: int | None = None,
    ) -> None:
        """Create the file. Raises RecordingError, also for a folder that exists."""
        self._folder = None if path.suffix.lower() == SUFFIX else path
        self.file = path
        if self._folder is not None:
            if path.exists():
                raise RecordingError(
                    f"{path} exists already", hint="a bag is a new folder"
                )
            self.file = path / f"{path.name}_0{SUFFIX}"
        self._writer = McapWriter(self.file, compression, longest, profile=PROFILE)
        self._topics: dict[str, tuple[int, TopicInformation]] = {}
        self._schemas: dict[str, int] = {}
        self._span: tuple[int, int] | None = None
        self._is_open = True

    def describe(self, entries: Mapping[str, str]) -> None:
        """Write metadata of rtgen's own, before the first message."""
        self._writer.metadata(METADATA, entries)

    def topic(self, name: str, type_: type[Any], profiles: Sequence[Profile]) -> None:
        """Announce a topic with the class of its messages, and QoS offered by its publishers.

        Raises RecordingError for a class that is not a message, or other than that of the topic.
        """
        with self._writer.lock:
            title = ros_name(type_) or ""
            if (known := self._topics.get(name)) is not None:
                if known[1].type != title:
                    raise RecordingError(
                        f"{name} has messages of {known[1].type} and of {title}"
                    )
                return
            text = ros_messages.message_text(type_._descriptor_, wide=True)
            if text is None:
                raise RecordingError(
                    f"{name}: {type_._descriptor_.name} is not a message of ROS 2"
                )
            if title not in self._schemas:
                self._schemas[title] = self._writer.schema(
                    title, ros_messages.ENCODING, text
                )
            described = TopicInformation(name, title, type_hash(type_), [*profiles])
            entries = {
                "offered_qos_profiles": profiles_text(profiles),
                "topic_type_hash": described.type_hash,
            }
            number = self._writer.channel(name, "cdr", self._schemas[title], entries)
            self._topics[name] = number, described

    def message(self, topic: str, time: int, octets: bytes) -> None:
        """Write a serialized message of an announced topic, received at a time [ns].

        Raises RecordingError if the file cannot be written.
        """
        with self._writer.lock:
            if not self._is_open:
                return
            number, described = self._topics[topic]
            described.count += 1
            first, last = self._span or (time, time)
            self._span = min(first, time), max(last, time)
            self._writer.put(number, time, octets)

    def close(self) -> None:
        """Write what is missing; later messages are ignored."""
        with self._writer.lock:
            if not self._is_open:
                return
            self._is_open = False
            topics = [each for _, each in self._topics.values()]
            described = information(self.file.name, topics, self._span or (0, 0))
            text = record_text(described)
            self._writer.end_chunk()
            self._writer.metadata(METADATA_RECORD, {"serialized_metadata": text})
            self._writer.close()
            if self._folder is not None:
                path = self._folder / METADATA_FILE
                try:
                    write_atomically(path, file_text(described).encode())
                except OSError as error:
                    raise UnavailableError(
                        f"cannot write {path}: {error.strerror}"
                    ) from error
