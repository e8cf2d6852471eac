"""Hand-written data types like generated ones, and a component with configurable callbacks."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    InPort,
    OutPort,
    ReturnCode_t,
    System,
)
from rtgen.runtime.marshalling.descriptors import (
    MemberDescriptor,
    PrimitiveDescriptor,
    StructDescriptor,
)

SECOND = 1_000_000_000
MS = 1_000_000


def placeless(reason: str) -> str:
    """Return the reason of a failure without its place, which must be a line of the tests."""
    before, after = re.split(r" \(tests/[^ ]+\.py:\d+\)", reason)
    return before + after


@dataclass(slots=True)
class Time:
    _descriptor_: ClassVar[StructDescriptor]
    sec: int = 0
    nsec: int = 0

    def _snapshot_(self) -> Time:
        return Time(self.sec, self.nsec)

    def to_cdr(self, little_endian: bool = True) -> bytes:
        return struct.pack("<II", self.sec, self.nsec)

    @classmethod
    def from_cdr(cls, data: Any, little_endian: bool = True) -> Time:
        return cls(*struct.unpack("<II", data))


@dataclass(slots=True)
class TimedLong:
    _descriptor_: ClassVar[StructDescriptor]
    tm: Time = field(default_factory=Time)
    data: int = 0

    def _snapshot_(self) -> TimedLong:
        return TimedLong(self.tm._snapshot_(), self.data)

    def to_cdr(self, little_endian: bool = True) -> bytes:
        return struct.pack("<IIi", self.tm.sec, self.tm.nsec, self.data)

    @classmethod
    def from_cdr(cls, data: Any, little_endian: bool = True) -> TimedLong:
        sec, nsec, value = struct.unpack("<IIi", data)
        return cls(Time(sec, nsec), value)


class TwinOfTimedLong(TimedLong):
    """The same IDL type as a class of another generated package."""


@dataclass(slots=True)
class TimedList:
    _descriptor_: ClassVar[StructDescriptor]
    data: list[int] = field(default_factory=list)

    def _snapshot_(self) -> TimedList:
        return TimedList(self.data[:])

    def to_cdr(self, little_endian: bool = True) -> bytes:
        return bytes(self.data)

    @classmethod
    def from_cdr(cls, data: Any, little_endian: bool = True) -> TimedList:
        return cls(list(data))


_LONG = PrimitiveDescriptor("long")
_ULONG = PrimitiveDescriptor("unsigned long")
Time._descriptor_ = StructDescriptor(
    "IDL:RTC/Time:1.0",
    "Time",
    (MemberDescriptor("sec", _ULONG), MemberDescriptor("nsec", _ULONG)),
)
TimedLong._descriptor_ = StructDescriptor(
    "IDL:RTC/TimedLong:1.0",
    "TimedLong",
    (MemberDescriptor("tm", Time._descriptor_), MemberDescriptor("data", _LONG)),
)
TimedList._descriptor_ = StructDescriptor(
    "IDL:RTC/TimedList:1.0",
    "TimedList",
    (MemberDescriptor("data", PrimitiveDescriptor("octet")),),
)


class OtherTimedLong(TimedLong):
    """The repository id of TimedLong with another structure."""

    _descriptor_: ClassVar[StructDescriptor] = StructDescriptor(
        "IDL:RTC/TimedLong:1.0",
        "TimedLong",
        (MemberDescriptor("tm", Time._descriptor_), MemberDescriptor("data", _ULONG)),
    )


class Actor(Component):
    """A component with configurable `on_execute`; records its callbacks on request."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Actor", rate=1000.0)

    def __init__(
        self,
        name: str,
        execute: Callable[[], ReturnCode_t | None] | None = None,
        *,
        inputs: tuple[str, ...] = (),
        outputs: tuple[str, ...] = (),
        type_: type[Any] = TimedLong,
    ) -> None:
        super().__init__(name)
        self.execute = execute
        self.inputs: dict[str, InPort[Any]] = {
            n: self.add_in_port(n, type_) for n in inputs
        }
        self.outputs: dict[str, OutPort[Any]] = {
            n: self.add_out_port(n, type_) for n in outputs
        }

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        code = self.execute() if self.execute is not None else None
        return RTC_OK if code is None else code


def activated(
    system: System, *components: Component, rate_hz: float | None = None
) -> System:
    """Add the components and request their activation."""
    for component in components:
        system.add(component, rate_hz)
        assert system.activate(component.instance_name) is RTC_OK
    return system


def joined(
    properties: dict[str, str] | None = None, system: System | None = None
) -> tuple[System, OutPort[Any], InPort[Any]]:
    """Return a writer and a reader with one connection between them, named `c`."""
    system = system or System()
    writer, reader = Actor("writer", outputs=("out",)), Actor("reader", inputs=("in",))
    activated(system, writer, reader)
    system.connect(("writer", "out"), ("reader", "in"), properties, "c")
    return system, writer.outputs["out"], reader.inputs["in"]


def long(value: int) -> TimedLong:
    return TimedLong(data=value)


def drained(port: InPort[Any]) -> list[Any]:
    """Return the data of all unread samples, oldest first."""
    values = []
    while port.is_new():
        values.append(port.read().data)
    return values
