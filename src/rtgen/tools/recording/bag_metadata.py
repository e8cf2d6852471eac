"""Metadata of bags of ROS 2: QoS profiles in YAML, and the file `metadata.yaml` of a folder.

Version 9, which rosbag2 of Jazzy writes; rosbag2_storage/yaml.hpp, qos.cpp and metadata_io.cpp.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import PurePosixPath
from typing import Any, Final, TypeVar

import yaml

from rtgen.facts.ros_qos import (
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
)
from rtgen.tools.recording.errors import RecordingError

METADATA_FILE: Final = "metadata.yaml"
METADATA_RECORD: Final = "rosbag2"
"""Name of the metadata record of an MCAP file that repeats the metadata."""
VERSION: Final = 9
DISTRIBUTION: Final = "jazzy"

_Policy = TypeVar("_Policy", bound=IntEnum)

_ROOT: Final = "rosbag2_bagfile_information"
_FOREVER: Final = {"sec": 9223372036, "nsec": 854775807}
"""`RMW_DURATION_INFINITE`."""
_SECOND: Final = 1_000_000_000
_NEVER: Final = 1 << 62
_MAX_PROFILES: Final = 1 << 16
_MAX_FILES: Final = 100_000
_MAX_DEPTH: Final = 32


@dataclass(slots=True)
class TopicInformation:
    """A topic of a bag: the name and hash of its type, offered QoS, the number of messages."""

    name: str
    type: str
    type_hash: str
    profiles: list[Profile] = field(default_factory=list)
    count: int = 0


def profiles_text(profiles: Sequence[Profile]) -> str:
    """Return profiles as the entry `offered_qos_profiles` of a channel."""
    return _text([_described(profile) for profile in profiles]).rstrip("\n")


def profiles_of(text: str) -> tuple[Profile, ...]:
    """Return the profiles of an entry `offered_qos_profiles`; without what cannot be read.

    Names of policies (version 9) and their numbers (up to version 8) are taken.
    """
    try:
        listed = yaml.load(text[:_MAX_PROFILES], Loader=_Loader)
    except (yaml.YAMLError, RecursionError, ValueError, OverflowError):
        return ()
    if not isinstance(listed, list):
        return ()
    found = (_profile(each) for each in listed if isinstance(each, dict))
    return tuple(each for each in found if each is not None)


def _profile(described: dict[str, Any]) -> Profile | None:
    depth = described.get("depth")
    history = _policy(History, described.get("history"))
    return Profile(
        depth=depth if isinstance(depth, int) and 0 < depth < 1 << 31 else 10,
        reliability=_policy(Reliability, described.get("reliability"))
        or Reliability.RELIABLE,
        durability=_policy(Durability, described.get("durability"))
        or Durability.VOLATILE,
        history=history or History.KEEP_LAST,
        deadline=_nanoseconds(described.get("deadline")),
        lifespan=_nanoseconds(described.get("lifespan")),
        liveliness=_policy(Liveliness, described.get("liveliness"))
        or Liveliness.AUTOMATIC,
        lease=_nanoseconds(described.get("liveliness_lease_duration")),
    )


def _policy(kind: type[_Policy], value: object) -> _Policy | None:
    if isinstance(value, str):
        return kind.__members__.get(value.upper())
    return next((each for each in kind if each == value), None)


def _nanoseconds(described: object) -> int | None:
    if not isinstance(described, dict) or described == _FOREVER:
        return None
    seconds, rest = described.get("sec"), described.get("nsec")
    if not (isinstance(seconds, int) and isinstance(rest, int)):
        return None
    whole = seconds * _SECOND + rest
    return whole if 0 < whole < _NEVER else None


def information(
    file: str, topics: Iterable[TopicInformation], span: tuple[int, int]
) -> dict[str, Any]:
    """Return the metadata of a bag of one MCAP file; `span` are its first and last time [ns]."""
    known = list(topics)
    count = sum(topic.count for topic in known)
    start = {"nanoseconds_since_epoch": span[0]}
    duration = {"nanoseconds": span[1] - span[0]}
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": count,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [*map(_described, topic.profiles)],
                    "type_description_hash": topic.type_hash,
                },
                "message_count": topic.count,
            }
            for topic in known
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file],
        "files": [
            {
                "path": file,
                "starting_time": start,
                "duration": duration,
                "message_count": count,
            }
        ],
        "custom_data": None,
        "ros_distro": DISTRIBUTION,
    }


def record_text(described: dict[str, Any]) -> str:
    """Return metadata as the record of an MCAP file has it.

    Without names of files, which readers take from the file itself: the same run gives the same
    bytes.
    """
    return _text({**described, "relative_file_paths": [], "files": []})


def file_text(described: dict[str, Any]) -> str:
    """Return metadata as the content of `metadata.yaml`."""
    return _text({_ROOT: described})


@dataclass(frozen=True, slots=True)
class Folder:
    """What `metadata.yaml` says of the files of a bag; `compression` is `zstd`, or empty.

    `by_message`: each message is compressed by itself, not a whole file.
    """

    files: tuple[str, ...]
    compression: str
    by_message: bool


def folder_of(name: str, text: str) -> Folder:
    """Return the files of a bag from its `metadata.yaml`, called `name` in errors.

    Raises RecordingError.
    """
    try:
        content = yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = "" if mark is None else f":{mark.line + 1}"
        what = getattr(error, "problem", None) or "no YAML"
        raise RecordingError(f"{name}{line}: {what}") from error
    except (RecursionError, ValueError, OverflowError) as error:
        raise RecordingError(f"{name}: {error}") from error
    described = content.get(_ROOT) if isinstance(content, dict) else None
    if not isinstance(described, dict):
        raise RecordingError(f"{name} has no section {_ROOT}")
    files = described.get("relative_file_paths")
    if not (
        isinstance(files, list)
        and 0 < len(files) <= _MAX_FILES
        and all(isinstance(file, str) and file for file in files)
    ):
        raise RecordingError(f"{name} names no files of the bag (relative_file_paths)")
    for file in files:
        path = PurePosixPath(file)
        if path.is_absolute() or ".." in path.parts or "\0" in file:
            raise RecordingError(f"{name}: the file {file!r} is not in the bag")
    mode = str(described.get("compression_mode") or "").lower()
    form = str(described.get("compression_format") or "").lower()
    if mode in ("", "none"):
        return Folder(tuple(files), "", False)
    if form != "zstd" or mode not in ("file", "message"):
        raise RecordingError(f"{name}: files are compressed by {form!r}, mode {mode!r}")
    return Folder(tuple(files), form, mode == "message")


class _Loader(yaml.SafeLoader):
    """A loader of YAML of limited depth. What aliases share is read once."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            reader: Any = self
            mark = reader.peek_event().start_mark
            raise yaml.MarkedYAMLError(problem="nested too deep", problem_mark=mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node


def _described(profile: Profile) -> dict[str, Any]:
    return {
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": _duration(profile.deadline),
        "lifespan": _duration(profile.lifespan),
        "liveliness": profile.liveliness.name.lower(),
        "liveliness_lease_duration": _duration(profile.lease),
        "avoid_ros_namespace_conventions": False,
    }


def _duration(nanoseconds: int | None) -> dict[str, int]:
    if nanoseconds is None:
        return dict(_FOREVER)
    seconds, rest = divmod(nanoseconds, _SECOND)
    return {"sec": seconds, "nsec": rest}


def _text(content: Any) -> str:
    return yaml.dump(
        content, Dumper=_Dumper, sort_keys=False, default_flow_style=False, width=1000
    )


class _Dumper(yaml.SafeDumper):
    """A dumper without aliases, which not all readers of bags take."""

    def ignore_aliases(self, data: Any) -> bool:
        return True
