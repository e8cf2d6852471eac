"""Random values of ROS 2 types, and values as a node of rclpy tells them."""

from __future__ import annotations

import math
import random
import struct
from typing import Any

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.ros2.types import blank

LETTERS = "abc XYZ_09é表ソ😀"
FILLER = "structure_needs_at_least_one_member"
"""The member of messages without fields, which rclpy does not have."""


class Values:
    """Random values of ROS 2 types."""

    def __init__(self, drawn: random.Random) -> None:
        self._drawn = drawn

    def of(self, descriptor: Any) -> Any:
        drawn = self._drawn
        match plain(descriptor):
            case StructDescriptor(members=members) as struct_:
                values = {m.attribute: self.of(m.type) for m in members}
                if FILLER in values:
                    values[FILLER] = 0  # no field in rclpy
                return struct_.class_(**values)
            case ArrayDescriptor(element=element, dimensions=(length,)):
                return self._many(element, length)
            case SequenceDescriptor(element=element, bound=bound):
                return self._many(element, drawn.randint(0, min(bound or 4, 4)))
            case StringDescriptor(bound=bound):
                most = min(bound or 12, 12)
                text = "".join(drawn.choices(LETTERS, k=drawn.randint(0, most)))
                while bound is not None and len(text.encode()) > bound:
                    text = text[:-1]
                return text
            case PrimitiveDescriptor(name="boolean"):
                return drawn.random() < 0.5
            case PrimitiveDescriptor(name="float"):
                limit = FLOAT_LIMITS["float"]
                number = drawn.choice((1.0, limit)) * drawn.uniform(-1, 1)
                return struct.unpack("<f", struct.pack("<f", number))[0]
            case PrimitiveDescriptor(name="double"):
                return drawn.choice((math.pi, 1e300)) * drawn.uniform(-1, 1)
            case PrimitiveDescriptor(name="octet"):
                return drawn.randrange(256)
            case PrimitiveDescriptor(name=name):
                lowest, highest = INTEGER_RANGES[name]
                return drawn.choice((lowest, highest, drawn.randint(lowest, highest)))
        raise AssertionError(descriptor)

    def _many(self, element: Any, count: int) -> Any:
        values = [self.of(element) for _ in range(count)]
        match plain(element):
            case PrimitiveDescriptor(name="octet" | "uint8"):
                return bytes(values)
        return values


def told(value: Any) -> Any:
    """Return a value as the node of rclpy tells it."""
    if hasattr(value, "_descriptor_"):
        return {
            m.name: told(getattr(value, m.attribute))
            for m in value._descriptor_.members
            if m.name != FILLER
        }
    if isinstance(value, (str, bool, int, float)):
        return value
    return [told(each) for each in value]


def value_of(descriptor: Any, told: Any) -> Any:
    """Return the value that is told; members that are not told are blank."""
    match plain(descriptor):
        case StructDescriptor(members=members) as struct_:
            return struct_.class_(
                **{
                    m.attribute: (
                        value_of(m.type, told[m.name])
                        if m.name in told
                        else blank(m.type)
                    )
                    for m in members
                }
            )
        case ArrayDescriptor(element=element) | SequenceDescriptor(element=element):
            match plain(element):
                case PrimitiveDescriptor(name="octet" | "uint8"):
                    return bytes(told)
            return [value_of(element, each) for each in told]
    return told
