"""Names of ROS 2 topics, services and types on the wire.

ROS 2 design, "Topic and Service name mapping to DDS"; rmw_cyclonedds and rmw_zenoh as of Jazzy. ROS
names are fully qualified (`/robot/scan`), types are written as in ROS (`std_msgs/msg/String`).
"""

from __future__ import annotations

import re
from typing import Final, NamedTuple

TOPIC: Final = "rt"
REQUEST: Final = "rq"
REPLY: Final = "rr"
"""Prefixes of DDS topics: of data, requests and replies."""

DISCOVERY_TOPIC: Final = "ros_discovery_info"
"""The DDS topic of rmw_dds_common/msg/ParticipantEntitiesInfo; it has no prefix."""
DISCOVERY_TYPE: Final = "rmw_dds_common/msg/ParticipantEntitiesInfo"
GID_SIZE: Final = 16
"""Length of a middleware identifier in octets (Jazzy)."""

MAINTAINER: Final = re.compile(
    r"\s*(?P<name>[^<>]+?)\s*<(?P<email>[^<>\s]+@[^<>\s]+)>\s*"
)
"""A maintainer of a package: `NAME <EMAIL>`."""

MAX_NAME_LENGTH: Final = 248
"""Maximum length of a fully qualified name: DDS allows 255 characters with prefix and suffix."""
_PART: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_TYPE: Final = re.compile(
    r"(?P<package>[a-z][a-z0-9_]*)/(?:(?P<kind>msg|srv|action)/)?(?P<name>[A-Z]\w*)",
    re.ASCII,
)


def violation(name: str) -> str | None:
    """Return why a text is not the name of a topic or service, relative or with a leading `/`.

    None for a valid name. `~` and `{substitutions}` are not accepted.
    """
    if len(name) > MAX_NAME_LENGTH:
        return f"is longer than {MAX_NAME_LENGTH} characters"
    parts = name.removeprefix("/").split("/")
    if not all(_PART.fullmatch(part) for part in parts):
        return "consists of words of letters, digits and _ between single /"
    if any("__" in part for part in parts):
        return "has no __"
    return None


def node_name(text: str) -> str:
    """Convert the name of a system or a component to one of a node."""
    words = "".join(c if c.isascii() and c.isalnum() else " " for c in text).split()
    name = "_".join(words) or "rtgen"
    return f"rtgen_{name}" if name[0].isdigit() else name


def qualified(name: str, namespace: str = "/") -> str:
    """Qualify a name with its namespace (`scan` in `/robot`: `/robot/scan`). Raises ValueError."""
    space = namespace.strip("/")
    whole = (
        name if name.startswith("/") else f"/{space}/{name}" if space else f"/{name}"
    )
    if why := violation(whole):
        raise ValueError(f"{name!r} {why}")
    return whole


def dds_topic(name: str) -> str:
    """Return the DDS topic of a topic: `/scan` is `rt/scan`."""
    return TOPIC + name


def dds_service_topics(name: str) -> tuple[str, str]:
    """Return the DDS topics of a service: `/add` has `rq/addRequest` and `rr/addReply`."""
    return f"{REQUEST}{name}Request", f"{REPLY}{name}Reply"


def parse_type(text: str) -> str | None:
    """Return the full name of a type: `std_msgs/msg/String` for `std_msgs/String`; None for
    others.
    """
    match = _TYPE.fullmatch(text)
    if match is None:
        return None
    return "/".join((match["package"], match["kind"] or "msg", match["name"]))


def dds_type(name: str) -> str:
    """Return the type's name in DDS: `std_msgs/msg/String` is `std_msgs::msg::dds_::String_`.

    Also for services, whose requests are named like `add/srv/Two_Request`.
    """
    *scope, last = name.split("/")
    return "::".join((*scope, "dds_", f"{last}_"))


def user_data(type_hash: str, **more: str) -> bytes:
    """Return USER_DATA of a reader or writer: `typehash=RIHS01_...;` after other keys."""
    return b"".join(
        f"{key}={value};".encode()
        for key, value in {**more, "typehash": type_hash}.items()
    )


PARTICIPANT_DATA: Final = b"enclave=/;"
"""USER_DATA of a participant."""


def parse_user_data(data: bytes) -> dict[str, str]:
    """Parse the pairs of USER_DATA; malformed pairs are skipped."""
    pairs = (part.partition("=") for part in data.decode("ascii", "replace").split(";"))
    return {key: value for key, equals, value in pairs if equals and key}


def endpoint_id(gid: bytes) -> str:
    """Return `clientid` or `serviceid` of USER_DATA: hexadecimal octets with dots, as
    rmw_cyclonedds.

    The first octet is padded to two characters with a space.
    """
    first, *rest = gid
    return ".".join((f"{first:2x}", *(f"{octet:x}" for octet in rest)))


class RequestId(NamedTuple):
    """Start of a request and its reply: a number of the client, and one of the request."""

    client: int
    sequence: int
