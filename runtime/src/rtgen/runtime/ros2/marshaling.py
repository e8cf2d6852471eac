"""Ports whose data are sent as a message of another type: `marshaling_type=ros2:PACKAGE/TYPE`."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from operator import attrgetter
from typing import Any, TypeAlias

import msgspec

from rtgen.facts.adapter_constants import (
    AdapterConstant,
    Shape,
    is_octets,
    shown,
    takes,
)
from rtgen.facts.primitives import NUMBERS
from rtgen.facts.ros_marshaling import known_conversions
from rtgen.runtime.forms import to_numpy
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.ros2 import conversions
from rtgen.runtime.ros2.conversions import Convert
from rtgen.runtime.ros2.network import Ros2Error
from rtgen.runtime.ros2.types import blank

Constant: TypeAlias = tuple[Callable[[Any], Any], str, Callable[[], Any]]
"""The struct of a member, found in the whole value; the member's attribute; and its value."""


class ConstantError(ValueError):
    """A constant for an unknown member, or of another type; `hint` says what fits."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.hint = hint


class Marshaling(msgspec.Struct, frozen=True):
    """Conversion between a port's data and a message.

    `stamp` sets the time of data whose message has none, `constants` members of what is converted.
    """

    data: type[Any]
    message: type[Any]
    read: Convert
    write: Convert
    stamp: Callable[[Any], None] | None
    constants: tuple[Constant, ...] = ()

    def to_message(self, value: Any) -> Any:
        """Convert a sample to a message. Raises ValueError for a value without counterpart."""
        made = blank(self.message._descriptor_)
        try:
            self.write(value, made)
        except OverflowError as error:
            raise ValueError(str(error)) from error
        self._set(made)
        return made

    def of_message(self, message: Any) -> Any:
        """Convert a message to a sample. Raises ValueError, CdrError for an impossible value."""
        made = self.data()
        try:
            self.read(message, made)
        except OverflowError as error:
            raise ValueError(str(error)) from error
        if self.stamp is not None:
            self.stamp(made)
        self._set(made)
        made.to_cdr(True)  # raises CdrError for values out of range
        return made

    def _set(self, made: Any) -> None:
        for owner, name, value in self.constants:
            setattr(owner(made), name, value())


def marshaling(
    data: type[Any],
    message: type[Any],
    stamp: Callable[[Any], None],
    constants: tuple[Constant, ...] = (),
) -> Marshaling:
    """Return the conversion of two classes. Raises Ros2Error if there is none."""
    own = str(data._descriptor_.name)
    ros = str(message._descriptor_.name).replace("::", "/")
    found = known_conversions().get((own.rpartition("::")[2], ros))
    if found is None:
        raise Ros2Error(f"{own} cannot go as {ros}")
    return Marshaling(
        data,
        message,
        getattr(conversions, found.read),
        getattr(conversions, found.write),
        None if found.stamped else stamp,
        constants,
    )


def constant_of(type_: type[Any], path: str, value: AdapterConstant) -> Constant:
    """Return the constant of a member, by its path of names (`header.frame_id`).

    Raises ConstantError for an unknown member, or a value of another type.
    """
    descriptor = plain(type_._descriptor_)
    attributes: list[str] = []
    for name in path.split("."):
        if not isinstance(descriptor, StructDescriptor):
            outer = ".".join(path.split(".")[: len(attributes)])
            raise ConstantError(
                f"{outer!r} of {type_._descriptor_.name} is not a struct"
            )
        members = {member.name: member for member in descriptor.members}
        if name not in members:
            close = get_close_matches(name, members, n=1)
            hint = f"did you mean {close[0]!r}?" if close else ", ".join(members)
            raise ConstantError(f"{descriptor.name} has no member {name!r}", hint)
        attributes.append(members[name].attribute)
        descriptor = plain(members[name].type)
    shape = _shape(descriptor)
    if not takes(shape, value):
        raise ConstantError(f"{path!r} is {descriptor}, which is not {shown(value)}")
    *outer_ones, last = attributes
    owner = attrgetter(".".join(outer_ones)) if outer_ones else _itself
    return owner, last, _maker(descriptor, value, path)


def _itself(value: Any) -> Any:
    return value


def _maker(descriptor: Any, value: AdapterConstant, path: str) -> Callable[[], Any]:
    """Return a function for a value that its receiver may change."""
    if not isinstance(value, tuple):
        return lambda: value
    if is_octets(_shape(descriptor)):
        octets = bytes(value)  # type: ignore[arg-type]
        return lambda: octets
    if descriptor.numeric == "numpy":
        import numpy

        item = numpy.dtype(NUMBERS[str(plain(descriptor.element))].code).type
        return lambda: to_numpy(value, item, path)
    return lambda: list(value)


def _shape(descriptor: Any) -> Shape:
    match plain(descriptor):
        case SequenceDescriptor(element=element, bound=bound):
            return Shape("sequence", bound, _shape(element))
        case ArrayDescriptor(element=element, dimensions=(length,)):
            return Shape("array", length, _shape(element))
        case StringDescriptor(wide=wide, bound=bound):
            return Shape("wstring" if wide else "string", bound)
        case PrimitiveDescriptor(name=name):
            return Shape(name)
    return Shape("")
