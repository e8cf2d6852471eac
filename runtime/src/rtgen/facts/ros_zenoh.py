"""Key expressions, liveliness tokens and attachments of rmw_zenoh (its design document, Jazzy)."""

from __future__ import annotations

import struct
from typing import Final, NamedTuple

from rtgen.facts.ros_names import GID_SIZE, dds_type
from rtgen.facts.ros_qos import Durability, History, Liveliness, Profile, Reliability

ADMIN: Final = "@ros2_lv"
NODE, PUBLISHER, SUBSCRIPTION, SERVICE, CLIENT = "NN", "MP", "MS", "SS", "SC"
"""Kinds of entities in tokens."""

_DEFAULT: Final = Profile(42)
"""The profile whose values rmw_zenoh omits from tokens (qos.cpp)."""
_SECOND: Final = 10**9
_TOKEN_PARTS: Final = 13
_ATTACHMENT: Final = struct.Struct(f"<qqB{GID_SIZE}s")


class Entity(NamedTuple):
    """Content of the token of a publisher, subscription, service or client.

    `type` is that of a topic, or of the service itself (`std_srvs/srv/Trigger`).
    """

    kind: str
    name: str
    type: str
    type_hash: str
    qos: Profile


class Node(NamedTuple):
    """A node, with its session and its number in it."""

    domain: int
    session: str
    number: int
    name: str
    namespace: str = "/"
    enclave: str = "/"


class Attachment(NamedTuple):
    """Attachment of each sample, request and reply. `time` is in nanoseconds since 1970."""

    sequence: int
    time: int
    gid: bytes


def key_expression(domain: int, name: str, type_: str, type_hash: str) -> str:
    """Return `<domain>/<name>/<type>/<hash>` for a topic or a service."""
    return f"{domain}/{name.strip('/')}/{dds_type(type_)}/{type_hash}"


def mangled(name: str) -> str:
    """Escape a name for use as one part of a token: `/` becomes `%`."""
    return name.replace("/", "%") or "%"


def node_token(node: Node) -> str:
    """Return the liveliness token of a node."""
    return "/".join((*_node(node, node.number), NODE, *_place(node)))


def entity_token(node: Node, number: int, entity: Entity) -> str:
    """Return the liveliness token of an entity; `number` is unique in its session."""
    parts = (
        *_node(node, number),
        entity.kind,
        *_place(node),
        mangled(entity.name),
        dds_type(entity.type),
        entity.type_hash,
        qos_text(entity.qos),
    )
    return "/".join(parts)


def tokens_of(domain: int, kind: str, name: str, type_: str) -> str:
    """Return the key expression of the tokens of all entities of a topic of one kind."""
    ends = "*", "*", "*", kind, "*", "*", "*", mangled(name), dds_type(type_), "*", "*"
    return "/".join((ADMIN, str(domain), *ends))


def parse_entity(token: str) -> tuple[str, Profile]:
    """Return the qualified name of the node of an entity, and the profile in its token.

    Raises ValueError.
    """
    parts = token.split("/")
    if len(parts) != _TOKEN_PARTS:
        raise ValueError("is not the token of an entity")
    space, node = parts[7:9]
    return f"{space.replace('%', '/').rstrip('/')}/{node}", parse_qos(parts[-1])


def _node(node: Node, number: int) -> tuple[str, ...]:
    return ADMIN, str(node.domain), node.session, str(node.number), str(number)


def _place(node: Node) -> tuple[str, ...]:
    return mangled(node.enclave), mangled(node.namespace), node.name


def qos_text(qos: Profile) -> str:
    """Return `reliability:durability:history,depth:deadline:lifespan:liveliness,lease`.

    Each duration is `seconds,nanoseconds`; rmw_zenoh's defaults are omitted.
    """

    def differs(key: str) -> str:
        value, default = getattr(qos, key), getattr(_DEFAULT, key)
        return "" if value == default else str(int(value))

    def duration(value: int | None) -> str:
        return "," if value is None else f"{value // _SECOND},{value % _SECOND}"

    return ":".join(
        (
            differs("reliability"),
            differs("durability"),
            f"{differs('history')},{differs('depth')}",
            duration(qos.deadline),
            duration(qos.lifespan),
            f"{differs('liveliness')},{duration(qos.lease)}",
        )
    )


def parse_qos(text: str) -> Profile:
    """Parse the text made by `qos_text`. Raises ValueError."""
    reliability, durability, history, deadline, lifespan, liveliness = text.split(":")
    kept, depth = history.split(",")
    alive, *lease = liveliness.split(",")
    return Profile(
        depth=int(depth) if depth else _DEFAULT.depth,
        reliability=(
            Reliability(int(reliability)) if reliability else _DEFAULT.reliability
        ),
        durability=Durability(int(durability)) if durability else _DEFAULT.durability,
        history=History(int(kept)) if kept else _DEFAULT.history,
        deadline=_duration(deadline.split(",")),
        lifespan=_duration(lifespan.split(",")),
        liveliness=Liveliness(int(alive)) if alive else _DEFAULT.liveliness,
        lease=_duration(lease),
    )


def _duration(parts: list[str]) -> int | None:
    seconds, nanoseconds = parts
    if not seconds and not nanoseconds:
        return None
    return int(seconds or 0) * _SECOND + int(nanoseconds or 0)


def attachment(value: Attachment) -> bytes:
    """Encode an attachment (33 octets). Raises ValueError for a gid of another size."""
    if len(value.gid) != GID_SIZE:
        raise ValueError(f"a gid has {GID_SIZE} octets")
    return _ATTACHMENT.pack(value.sequence, value.time, GID_SIZE, value.gid)


def parse_attachment(octets: bytes) -> Attachment:
    """Decode an attachment. Raises ValueError."""
    if len(octets) != _ATTACHMENT.size or octets[16] != GID_SIZE:
        raise ValueError("is not an attachment of rmw_zenoh")
    sequence, time, _, gid = _ATTACHMENT.unpack(octets)
    return Attachment(sequence, time, gid)
