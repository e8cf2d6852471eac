"""Properties of connectors: their names and values, as in OpenRTM-aist 2.0.

RTC 1.0 leaves them to implementations.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from enum import StrEnum
from functools import cache
from math import isfinite
from typing import Final

from rtgen.facts.topic_properties import TRANSPORTS, Check

PROFILE_ATTRIBUTES: Final[Mapping[str, str]] = {
    "dataport.dataflow_type": "dataflowType",
    "dataport.interface_type": "interfaceType",
    "dataport.subscription_type": "subscriptionType",
    "dataport.data_type": "dataType",
}
"""Properties that are attributes of a connector in an RtsProfile (RtsProfile 0.2)."""


class Dataflow(StrEnum):
    """Who moves a sample: the writer, or the reader when it reads (`dataport.dataflow_type`)."""

    PUSH = "push"
    PULL = "pull"


class Subscription(StrEnum):
    """When a pushed sample is delivered (`dataport.subscription_type`)."""

    FLUSH = "flush"
    NEW = "new"
    PERIODIC = "periodic"


class PushPolicy(StrEnum):
    """Which of the waiting samples `new` and `periodic` deliver at a time."""

    ALL = "all"
    FIFO = "fifo"
    SKIP = "skip"
    NEW = "new"


class FullPolicy(StrEnum):
    """Policy of a write to a full buffer (`dataport.buffer.write.full_policy`)."""

    OVERWRITE = "overwrite"
    DO_NOTHING = "do_nothing"
    BLOCK = "block"


class EmptyPolicy(StrEnum):
    """Policy of a read from an empty buffer (`dataport.buffer.read.empty_policy`)."""

    READBACK = "readback"
    DO_NOTHING = "do_nothing"
    BLOCK = "block"


IO_MODES: Final[Mapping[str, Subscription]] = {
    **{str(each): each for each in Subscription},
    "block": Subscription.FLUSH,
    "nonblock": Subscription.NEW,
}
"""Subscription types for the values of `dataport.io_mode` (OpenRTM 2)."""

OWN_PORT: Final = "rtgen.own_port"
"""Property of a connector with a port, `INSTANCE.PORT`, that only the behaviour defines."""

OVERRIDE: Final = "rtgen.openrtm."
"""Prefix of properties that apply to the target openrtm only."""

ALLOW: Final = "rtgen.allow."
"""Prefix of properties that allow a finding about their connector, by its code; the value is the
reason.
"""

STRICTNESS: Final = "port.connection.strictness"
MARSHALING: Final = "dataport.marshaling_type"
ROS_SET: Final = "dataport.ros2.set"
"""Members with constants of a connector's ROS 2 messages, as in `set` of `[ros2.topics]`."""
ON_LOSS: Final = "port.connection.on_loss"
DATA_ON_LOSS: Final = "dataport.qos.on_loss"
"""What happens to a component that has lost the process of a peer; of data and service
connectors.
"""
PUSH_RATE: Final = "dataport.publisher.push_rate"

_IO_MODE = "dataport.io_mode"
_SUBSCRIPTION_TYPE = "dataport.subscription_type"
_ENDS = ("", "inport.", "outport.")
_ADDRESS_PREFIX = "dataport.corba_cdr."
_PREFIXES = ("dataport.", "port.")
_INTEGER = re.compile(r"[0-9]{1,18}")

IGNORED: Final = (_ADDRESS_PREFIX, "rtgen.")
"""Prefixes of properties that the embedded runtime ignores: addresses, and other targets."""


def _one_of(*words: str) -> Check:
    expectation = " or ".join(words)
    return lambda text: None if text in words else expectation


def _integer(minimum: int) -> Check:
    def check(text: str) -> str | None:
        if _INTEGER.fullmatch(text) and int(text) >= minimum:
            return None
        return f"an integer, at least {minimum}"

    return check


def _number(expectation: str, *, positive: bool) -> Check:
    def check(text: str) -> str | None:
        try:
            value = float(text)
        except ValueError:
            return expectation
        fits = isfinite(value) and (value > 0 if positive else value >= 0)
        return None if fits else expectation

    return check


def _flag(text: str) -> str | None:
    return None if text.upper() in ("YES", "NO") else "YES or NO"


def _byte_orders(text: str) -> str | None:
    is_valid = all(order.strip() in ("little", "big") for order in text.split(","))
    return None if is_valid else "little or big, in order of wish"


def _marshaling(text: str) -> str | None:
    if text == "cdr":
        return None
    from rtgen.facts.ros_marshaling import parse

    return None if parse(text) else "cdr or ros2:PACKAGE/TYPE"


def _constants(text: str) -> str | None:
    from rtgen.facts.adapter_constants import parsed

    try:
        parsed(text)
    except ValueError:
        return '"MEMBER" = VALUE, ... as in rtgen.toml'
    return None


def _text(_: str) -> None:
    return None


_SECONDS = _number("a time in seconds, 0 or more", positive=False)
_BUFFER_PROPERTIES: Mapping[str, Check] = {
    "length": _integer(1),
    "write.full_policy": _one_of(*FullPolicy),
    "write.timeout": _SECONDS,
    "read.empty_policy": _one_of(*EmptyPolicy),
    "read.timeout": _SECONDS,
}

DATA: Final[Mapping[str, Check]] = {
    "dataport.interface_type": _one_of(
        *("corba_cdr", "direct", "shared_memory", "data_service", "csp_channel"),
        *TRANSPORTS,
    ),
    "dataport.dataflow_type": _one_of(*Dataflow, "duplex"),
    _SUBSCRIPTION_TYPE: _one_of(*Subscription),
    _IO_MODE: _one_of(*IO_MODES),
    **{f"dataport.{end}data_type": _text for end in _ENDS},
    "dataport.publisher.push_policy": _one_of(*PushPolicy),
    "dataport.publisher.skip_count": _integer(0),
    PUSH_RATE: _number("a rate in Hz, above 0", positive=True),
    **{
        f"dataport.{end}buffer.{key}": check
        for end in _ENDS
        for key, check in _BUFFER_PROPERTIES.items()
    },
    ROS_SET: _constants,
    "dataport.serializer.cdr.endian": _byte_orders,
    **{f"dataport.{end}marshaling_type": _marshaling for end in _ENDS},
    "dataport.fan_in": _integer(1),
    "dataport.fan_out": _integer(1),
    "dataport.allow_dup_connection": _flag,
}
"""The properties of data connectors in OpenRTM, without those of topics."""

QOS: Final[Mapping[str, Check]] = {
    "dataport.qos.reliability": _one_of("reliable", "best_effort"),
    "dataport.qos.durability": _one_of("volatile", "transient_local"),
    "dataport.qos.history": _one_of("keep_last", "keep_all"),
    "dataport.qos.depth": _integer(1),
    "dataport.qos.deadline": _number("a time in seconds, above 0", positive=True),
    "dataport.qos.lease": _number("a time in seconds, above 0", positive=True),
    DATA_ON_LOSS: _one_of("continue", "error"),
}
"""Quality of service between processes, named as in DDS 1.4, 2.2.3."""

PLAIN_DATA: Final[Mapping[str, Check]] = {
    **DATA,
    **QOS,
    "dataport.dataflow_type": _one_of(*Dataflow),
}
"""The properties of data connectors in the embedded runtime, without those of topics: no `duplex`,
but QoS between processes.
"""


@cache
def stated_data() -> Mapping[str, Check]:
    """Return the properties of data connectors that a system file can have."""
    from rtgen.facts.ros_qos_words import CHECKS

    return {**DATA, **CHECKS, **QOS}


@cache
def embedded_data() -> Mapping[str, Check]:
    """Return the properties of data connectors in the embedded runtime."""
    return {**stated_data(), **PLAIN_DATA}


SERVICE: Final[Mapping[str, Check]] = {
    STRICTNESS: _one_of("strict", "best_effort"),
    ON_LOSS: _one_of("continue", "error"),
}
"""The properties of service connectors, besides the pairs of interfaces."""


def violation(table: Mapping[str, Check], key: str, text: str) -> str | None:
    """Return the expected form of a property in the table; None if the text is valid.

    Leading and trailing space is ignored.
    """
    return table[key](text.strip())


def subscriptions(properties: Mapping[str, str]) -> dict[str, Subscription]:
    """Return the subscription of each property that names a valid one."""
    by_name: dict[str, Subscription] = {}
    for key in (_IO_MODE, _SUBSCRIPTION_TYPE):
        text = properties.get(key, "").strip()
        if text in (IO_MODES if key == _IO_MODE else tuple(Subscription)):
            by_name[key] = IO_MODES[text]
    return by_name


def is_contradictory(properties: Mapping[str, str]) -> bool:
    """Return whether `dataport.io_mode` and `dataport.subscription_type` contradict each other."""
    return len(set(subscriptions(properties).values())) > 1


def lacks_push_rate(properties: Mapping[str, str]) -> bool:
    """Return whether a connection is periodic, but has no push rate."""
    periodic = Subscription.PERIODIC in subscriptions(properties).values()
    return periodic and PUSH_RATE not in properties


def push_rate(properties: Mapping[str, str]) -> float | None:
    """Return the samples per second of a periodic connection; None for others."""
    text = properties.get(PUSH_RATE, "")
    if Subscription.PERIODIC not in subscriptions(properties).values():
        return None
    if not text or violation(PLAIN_DATA, PUSH_RATE, text) is not None:
        return None
    return float(text)


def is_pair(key: str) -> bool:
    """Return whether a property of a service connector pairs a consumer with a provider."""
    return ".required." in key


def own_properties(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return those of a connector's properties that are OpenRTM's."""
    return {key: text for key, text in pairs if not is_foreign(key)}


def embedded_properties(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return those of a connector's properties that a run heeds: OpenRTM's, and what it allows."""
    return {k: t for k, t in pairs if k.startswith(ALLOW) or not is_foreign(k)}


def is_foreign(key: str) -> bool:
    """Return whether a property is not OpenRTM's: an editor's own, or an address that it saved."""
    own = key.startswith(_PREFIXES) or is_pair(key)
    return not own or key.startswith(_ADDRESS_PREFIX)
