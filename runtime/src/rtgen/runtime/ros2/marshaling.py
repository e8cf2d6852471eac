"""Ports whose data are sent as a message of another type: `marshaling_type=ros2:PACKAGE/TYPE`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import msgspec

from rtgen.facts.ros_marshaling import known_conversions
from rtgen.runtime.ros2 import conversions
from rtgen.runtime.ros2.network import Ros2Error
from rtgen.runtime.ros2.types import blank

Convert: TypeAlias = Callable[[Any, Any], None]


class Marshaling(msgspec.Struct, frozen=True):
    """Conversion between a port's data and a message.

    `stamp` sets the time of data whose message has none.
    """

    data: type[Any]
    message: type[Any]
    read: Convert
    write: Convert
    stamp: Callable[[Any], None] | None

    def to_message(self, value: Any) -> Any:
        """Convert a sample to a message. Raises ValueError for a value without counterpart."""
        made = blank(self.message._descriptor_)
        try:
            self.write(value, made)
        except OverflowError as error:
            raise ValueError(str(error)) from error
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
        made.to_cdr(True)  # raises CdrError for values out of range
        return made


def marshaling(
    data: type[Any], message: type[Any], stamp: Callable[[Any], None]
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
    )
