"""Connector properties by OpenRTM's names, read once, when the connection is made."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

from rtgen.runtime.buffers import BufferSettings, EmptyPolicy, FullPolicy
from rtgen.runtime.errors import ConnectorPropertyError

E = TypeVar("E", bound=StrEnum)


class Dataflow(StrEnum):
    """Who moves a sample: the writer, or the reader when it reads."""

    PUSH = "push"
    PULL = "pull"


class Subscription(StrEnum):
    """When a pushed sample is delivered."""

    FLUSH = "flush"
    NEW = "new"
    PERIODIC = "periodic"


class PushPolicy(StrEnum):
    """Which of the waiting samples `new` and `periodic` deliver at a time."""

    ALL = "all"
    FIFO = "fifo"
    SKIP = "skip"
    NEW = "new"


_IO_MODES = {"block": Subscription.FLUSH, "nonblock": Subscription.NEW}
_INTERFACE_TYPES = (
    "corba_cdr",
    "direct",
    "shared_memory",
    "data_service",
    "csp_channel",
)
_BUFFER_KEYS = (
    "length",
    "write.full_policy",
    "write.timeout",
    "read.empty_policy",
    "read.timeout",
)
_KEYS = (
    "dataport.interface_type",
    "dataport.dataflow_type",
    "dataport.subscription_type",
    "dataport.io_mode",
    "dataport.publisher.push_policy",
    "dataport.publisher.skip_count",
    "dataport.publisher.push_rate",
    *(
        f"dataport.{end}buffer.{key}"
        for end in ("", "inport.", "outport.")
        for key in _BUFFER_KEYS
    ),
    "dataport.serializer.cdr.endian",
    *(
        f"dataport.{end}{key}"
        for end in ("", "inport.", "outport.")
        for key in ("data_type", "marshaling_type")
    ),
    "dataport.fan_in",
    "dataport.fan_out",
    "dataport.allow_dup_connection",
)
IGNORED = ("dataport.corba_cdr.", "rtgen.")
"""How properties begin that mean nothing here: addresses, and what other targets are told."""


@dataclass(frozen=True, slots=True)
class ConnectorSettings:
    """What the properties of a data connection say; `push_rate` in Hz, 0.0 if not periodic."""

    inport_buffer: BufferSettings
    outport_buffer: BufferSettings
    dataflow: Dataflow
    subscription: Subscription
    push_policy: PushPolicy
    skip_count: int
    push_rate: float
    fan_in: int | None
    fan_out: int | None
    allow_duplicate: bool


def parse(properties: Mapping[str, str]) -> ConnectorSettings:
    """Reads the properties of a data connection.

    Interface, byte order and marshalling are checked and have no effect, since both ends are in
    one process; `dataport.data_type` informs only; addresses (`dataport.corba_cdr.*`), which
    system editors save, and what other targets are told (`rtgen.*`) are left alone.
    Raises ConnectorPropertyError.
    """
    return _Reader(properties).settings()


class _Reader:
    def __init__(self, properties: Mapping[str, str]) -> None:
        self._texts = {key: str(value).strip() for key, value in properties.items()}

    def settings(self) -> ConnectorSettings:
        for key in self._texts:
            self._check_key(key)
        self._among("dataport.interface_type", _INTERFACE_TYPES, "corba_cdr")
        for end in ("", "inport.", "outport."):
            self._among(f"dataport.{end}marshaling_type", ("cdr",), "cdr")
        for order in self._texts.get("dataport.serializer.cdr.endian", "little").split(
            ","
        ):
            if order.strip() not in ("little", "big"):
                self._refuse(
                    "dataport.serializer.cdr.endian", "little or big, in order of wish"
                )
        subscription = self._subscription()
        return ConnectorSettings(
            dataflow=self._choice("dataport.dataflow_type", Dataflow.PUSH),
            subscription=subscription,
            push_policy=self._choice("dataport.publisher.push_policy", PushPolicy.NEW),
            skip_count=self._integer("dataport.publisher.skip_count", 0, 0),
            push_rate=self._push_rate(subscription),
            inport_buffer=self._buffer("inport"),
            outport_buffer=self._buffer("outport"),
            fan_in=self._limit("dataport.fan_in"),
            fan_out=self._limit("dataport.fan_out"),
            allow_duplicate=self._flag("dataport.allow_dup_connection"),
        )

    def _check_key(self, key: str) -> None:
        if key in _KEYS or key.startswith(IGNORED):
            return
        near = difflib.get_close_matches(key, _KEYS, 1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ConnectorPropertyError(f"unknown connector property {key!r}{hint}")

    def _refuse(self, key: str, wanted: str) -> None:
        raise ConnectorPropertyError(
            f"connector property {key!r} is {self._texts[key]!r}; it must be {wanted}"
        )

    def _among(self, key: str, values: tuple[str, ...], default: str) -> str:
        text = self._texts.get(key, default)
        if text not in values:
            self._refuse(key, _one_of(values))
        return text

    def _choice(self, key: str, default: E) -> E:
        kind = type(default)
        return kind(self._among(key, tuple(kind), default))

    def _flag(self, key: str) -> bool:
        text = self._texts.get(key, "NO")
        if text.upper() not in ("YES", "NO"):
            self._refuse(key, "YES or NO")
        return text.upper() == "YES"

    def _integer(self, key: str, default: int, minimum: int) -> int:
        text = self._texts.get(key)
        if text is None:
            return default
        if not text.isascii() or not text.isdigit() or int(text) < minimum:
            self._refuse(key, f"an integer, at least {minimum}")
        return int(text)

    def _limit(self, key: str) -> int | None:
        return self._integer(key, 1, 1) if key in self._texts else None

    def _number(
        self, key: str, default: float, wanted: str, *, positive: bool
    ) -> float:
        text = self._texts.get(key)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or value < 0.0 or (positive and value == 0.0):
            self._refuse(key, wanted)
        return value

    def _subscription(self) -> Subscription:
        words = (*Subscription, *_IO_MODES)
        found: dict[str, Subscription] = {}
        for key in ("dataport.io_mode", "dataport.subscription_type"):
            if key in self._texts:
                allowed = words if key == "dataport.io_mode" else tuple(Subscription)
                text = self._among(key, allowed, "")
                found[key] = _IO_MODES.get(text) or Subscription(text)
        if len(set(found.values())) > 1:
            told = " and ".join(f"{key} = {self._texts[key]}" for key in found)
            raise ConnectorPropertyError(
                f"connector properties contradict each other: {told}"
            )
        return next(iter(found.values()), Subscription.FLUSH)

    def _push_rate(self, subscription: Subscription) -> float:
        key = "dataport.publisher.push_rate"
        if subscription is not Subscription.PERIODIC:
            return 0.0
        if key not in self._texts:
            raise ConnectorPropertyError(
                f"subscription 'periodic' needs the property {key!r}"
            )
        return self._number(key, 0.0, "a rate in Hz, above 0", positive=True)

    def _buffer(self, end: str) -> BufferSettings:
        def key(name: str) -> str:
            own = f"dataport.{end}.buffer.{name}"
            return own if own in self._texts else f"dataport.buffer.{name}"

        seconds = "a time in seconds, 0 or more"
        return BufferSettings(
            length=self._integer(key("length"), 8, 1),
            full_policy=self._choice(key("write.full_policy"), FullPolicy.OVERWRITE),
            write_timeout=self._number(
                key("write.timeout"), 1.0, seconds, positive=False
            ),
            empty_policy=self._choice(key("read.empty_policy"), EmptyPolicy.READBACK),
            read_timeout=self._number(
                key("read.timeout"), 1.0, seconds, positive=False
            ),
        )


def _one_of(values: tuple[str, ...]) -> str:
    return " or ".join(str(value) for value in values)
