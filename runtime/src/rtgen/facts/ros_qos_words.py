"""Words for QoS of ROS 2: those of rtgen.toml, and the properties of connectors.

The properties are rtgen's own (`dataport.ros2.reliability`) and those of OpenRTM-aist's transports:
in Python `dataport.ros2.writer_qos.*`, `reader_qos.*` (ext/transport/ROS2Transport/
ROS2TopicManager.py), which OpenSplice has, too, also under the name of the middleware; in C++
`dataport.fast-rtps.publisher.qos.*`, `subscriber.qos.*` (src/ext/transport/FastRTPS).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from enum import IntEnum
from functools import cache, partial
from math import inf
from typing import Any, Final, NamedTuple

from rtgen.facts.ros_qos import (
    PROFILES,
    SECOND,
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
    misfits,
    values_of,
    word,
)
from rtgen.facts.topic_properties import TRANSPORTS, Check

MAX_DEPTH: Final = 1_000_000
_MAX_SECONDS: Final = (1 << 31) - 1
"""DDS's longest time; it stands for an infinite one (DDS 1.4, 2.3.2)."""

KINDS: Final[Mapping[str, tuple[IntEnum, ...]]] = {
    "history": tuple(History),
    "reliability": tuple(Reliability),
    "durability": (Durability.TRANSIENT_LOCAL, Durability.VOLATILE),
    "liveliness": (Liveliness.AUTOMATIC, Liveliness.MANUAL_BY_TOPIC),
}
TIMES: Final = ("deadline", "lifespan", "lease")
POLICIES: Final = ("depth", *KINDS, *TIMES)
"""The policies of a profile, as they are called in rtgen.toml."""

EXPECTED: Final[Mapping[str, str]] = {
    "qos": f"a profile: {', '.join(PROFILES)}",
    "depth": f"a number of messages from 1 to {MAX_DEPTH}",
    **{name: " or ".join(map(word, values)) for name, values in KINDS.items()},
    **dict.fromkeys(TIMES, "a time in seconds, above 0, or inf for none"),
}
"""What each word takes."""


def value_of(name: str, value: Any) -> Any:
    """Return the value in a profile of what rtgen.toml states; a profile for `qos`.

    Raises ValueError with what the word takes.
    """
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if isinstance(value, str):
        kinds = PROFILES if name == "qos" else _by_word(name)
        if value in kinds:
            return kinds[value]
    elif name == "depth" and isinstance(value, int) and is_number:
        if 1 <= value <= MAX_DEPTH:
            return value
    elif name in TIMES and is_number:
        if value == inf:
            return None
        if 0 < value < _MAX_SECONDS and (time := round(value * SECOND)):
            return time
    raise ValueError(EXPECTED[name])


def words(name: str) -> Collection[str]:
    """Return the words that a policy takes; empty for a number."""
    return PROFILES if name == "qos" else _by_word(name)


def _by_word(name: str) -> Mapping[str, IntEnum]:
    return {word(kind): kind for kind in KINDS.get(name, ())}


def of_text(name: str, text: str) -> Any:
    """Return `value_of` what the text of a property states. Raises ValueError."""
    number: type[int | float] | None = int if name == "depth" else None
    number = float if name in TIMES else number
    try:
        value = text.strip() if number is None else number(text)
    except ValueError:
        raise ValueError(EXPECTED[name]) from None
    return value_of(name, value)


def profile_of(values: Mapping[str, Any]) -> Profile:
    """Return the profile of values by their words, made by `value_of`."""
    base: Profile = values.get("qos", PROFILES["default"])
    return base._replace(**{k: v for k, v in values.items() if k != "qos"})


def has_idle_depth(values: Mapping[str, Any]) -> bool:
    """Return whether the depth of an end has no effect beside its history."""
    return values.get("history") is History.KEEP_ALL and "depth" in values


WHY_IDLE: Final = ("history = keep_all keeps every message", "remove one of them")
"""Why such a depth has no effect, and what to do."""


class Statement(NamedTuple):
    """A value that a property states of the publisher, the subscription, or of both (None)."""

    key: str
    writes: bool | None
    policy: str
    value: Any


class _Property(NamedTuple):
    """A property: which ends and policy it is for; `unit` [ns] of a part of OpenRTM's times."""

    writes: bool | None
    policy: str
    read: Callable[[str], Any]
    unit: int = 0


_UNSTATED: Final = object()
"""A value that leaves a policy as it is without the property."""
_NODES: Final = (("writer_qos", "publisher", True), ("reader_qos", "subscriber", False))
_TIMES: Final = {
    "deadline.period": "deadline",
    "lifespan.duration": "lifespan",
    "liveliness.lease_duration": "lease",
}
_BEYOND = re.compile(r"[0-9]{1,10}")


@cache
def _kind(policy: str) -> Callable[[str], Any]:
    """Return a function that reads DDS's constants (DDS 1.4, 2.3.3), as OpenRTM spells them."""
    known: dict[str, Any] = {
        f"{kind.name}_{policy.upper()}_QOS": kind for kind in KINDS[policy]
    }
    short = {kind.name: kind for kind in KINDS[policy]} if policy == "history" else {}
    default = f"SYSTEM_DEFAULT_{policy.upper()}_QOS"
    silent = dict.fromkeys(("", "SYSTEM_DEFAULT_QOS", default), _UNSTATED)

    def read(text: str) -> Any:
        found = {**known, **short, **silent}.get(text.strip())
        if found is None:
            raise ValueError(" or ".join(known))
        return found

    return read


def _count(text: str) -> Any:
    if _BEYOND.fullmatch(text.strip()) is None:
        raise ValueError("an integer, at least 0")
    return int(text)


def _depth(text: str) -> Any:
    number = _count(text)
    return value_of("depth", number) if number else _UNSTATED


def _openrtm() -> Iterator[tuple[str, _Property]]:
    for transport in TRANSPORTS:
        for node, _, writes in _NODES:
            at = f"dataport.{transport}.{node}"
            yield from _node(at, f"{at}.history", "sec", writes=writes)
    for _, node, writes in _NODES:
        at = f"dataport.fast-rtps.{node}"
        yield from _node(
            f"{at}.qos", f"{at}.topic.historyQos", "seconds", writes=writes
        )


def _node(
    qos: str, history: str, second: str, *, writes: bool
) -> Iterator[tuple[str, _Property]]:
    for policy in KINDS:
        at = history if policy == "history" else f"{qos}.{policy}"
        yield f"{at}.kind", _Property(writes, policy, _kind(policy))
    yield f"{history}.depth", _Property(writes, "depth", _depth)
    for name, policy in _TIMES.items():
        for part, unit in ((second, SECOND), ("nanosec", 1)):
            yield f"{qos}.{name}.{part}", _Property(writes, policy, _count, unit)


_BETWEEN_PROCESSES: Final = "dataport.qos."
_DDS: Final = ("reliability", "durability", "history", "depth", "deadline", "lease")
"""Policies of the properties for connections between processes, and those that are topics."""
_PROPERTIES: Final[Mapping[str, _Property]] = {
    **{
        f"dataport.ros2.{policy}": _Property(None, policy, partial(of_text, policy))
        for policy in ("qos", *POLICIES)
    },
    **{
        f"{_BETWEEN_PROCESSES}{policy}": _Property(
            None, policy, partial(of_text, policy)
        )
        for policy in _DDS
    },
    **dict(_openrtm()),
}


def _check(read: Callable[[str], Any], text: str) -> str | None:
    try:
        read(text)
    except ValueError as error:
        return str(error)
    return None


def _any(text: str) -> str | None:
    return None


CHECKS: Final[Mapping[str, Check]] = {
    **{
        key: partial(_check, each.read)
        for key, each in _PROPERTIES.items()
        if not key.startswith(_BETWEEN_PROCESSES)
    },
    **{f"dataport.{name}.topic": _any for name in TRANSPORTS},
    **{f"dataport.fast-rtps.{node}.name": _any for _, node, _ in _NODES},
    **{
        f"dataport.{name}.{node}.avoid_ros_namespace_conventions": _any
        for name in TRANSPORTS
        for node, _, _ in _NODES
    },
}
"""The properties of topics, with what they take; names of ends, and of topics without ROS 2's
prefixes, have no effect.
"""


def topic_of(properties: Mapping[str, str]) -> str | None:
    """Return the topic that a connector states."""
    stated = (properties.get(f"dataport.{name}.topic", "") for name in TRANSPORTS)
    return next((text.strip() for text in stated if text.strip()), None)


def statements(properties: Mapping[str, str]) -> list[Statement]:
    """Return what properties state of the QoS of a topic, without invalid values.

    `dataport.qos.*` concern a topic if the connector is one.
    """
    is_topic = properties.get("dataport.marshaling_type", "").strip() not in ("", "cdr")
    found: list[Statement] = []
    times: dict[tuple[bool | None, str, str], tuple[str, int]] = {}
    for key in properties:
        stated = _PROPERTIES.get(key)
        if stated is None or (key.startswith(_BETWEEN_PROCESSES) and not is_topic):
            continue
        writes, policy, read, unit = stated
        try:
            value = read(properties[key])
        except ValueError:
            continue
        if unit:
            at = writes, policy, key.rpartition(".")[0]
            before = times.get(at, ("", 0))[1]
            times[at] = key, before + value * unit
        elif value is not _UNSTATED:
            found.append(Statement(key, writes, policy, value))
    for (writes, policy, _), (key, time) in times.items():
        if time:
            endless = time >= _MAX_SECONDS * SECOND
            found.append(Statement(key, writes, policy, None if endless else time))
    return sorted(found, key=lambda each: each.key)


def profiles(properties: Mapping[str, str]) -> tuple[Profile, Profile]:
    """Return the profiles of the publisher and the subscription of a connector."""
    found = statements(properties)
    writer, reader = (profile_of(_of_end(found, writes=w)) for w in (True, False))
    return writer, reader


def _of_end(found: list[Statement], *, writes: bool) -> dict[str, Any]:
    return {s.policy: s.value for s in found if s.writes in (None, writes)}


def problems(properties: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    """Yield key, message and hint for properties that contradict each other."""
    found = statements(properties)
    seen: set[tuple[str, str]] = set()
    for writes in (True, False):
        by_policy: dict[str, Statement] = {}
        for each in (s for s in found if s.writes in (None, writes)):
            first = by_policy.setdefault(each.policy, each)
            if first.value != each.value and (first.key, each.key) not in seen:
                seen.add((first.key, each.key))
                message = (
                    f"`{each.key}` is {properties[each.key]!r}, but `{first.key}` is"
                )
                yield each.key, f"{message} {properties[first.key]!r}", "state one of them"
        values = _of_end(found, writes=writes)
        if has_idle_depth(values) and ("depth", "") not in seen:
            seen.add(("depth", ""))
            why, hint = WHY_IDLE
            key = by_policy["depth"].key
            yield key, f"`{key}` has no effect: {why}", hint
    if not found or seen:
        return
    writer, reader = profiles(properties)
    unfit = misfits(writer, reader)
    if unfit:
        key = next(
            s.key for s in found if s.policy in (unfit[0].policy, "qos", "liveliness")
        )
        message = f"nothing would go from one end to the other: {values_of(unfit)}"
        yield key, message, "give both ends the same values"
