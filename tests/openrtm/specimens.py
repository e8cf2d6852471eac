"""Values of any type determined by a number, for processes that do not communicate."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)

COUNT = 3
"""Number of specimens of a type to test: enums, unions and lengths vary."""

_MAX_VALUES = {
    "octet": 0xFF,
    "short": 0x7FFF,
    "unsigned short": 0xFFFF,
    "long": 0x7FFFFFFF,
    "unsigned long": 0xFFFFFFFF,
    "long long": 0x7FFFFFFFFFFFFFFF,
    "unsigned long long": 0x7FFFFFFFFFFFFFFF,
}


def specimen(descriptor: Descriptor, number: int) -> Any:
    """Return the n-th value of a type; the same in every process."""
    return _value(descriptor, itertools.count(number))


def _value(descriptor: Descriptor, numbers: Iterator[int]) -> Any:
    match descriptor:
        case PrimitiveDescriptor(name):
            return _primitive(name, next(numbers))
        case StringDescriptor(wide, bound):
            text = f"n° {next(numbers)}" if wide else f"番号 {next(numbers)}"
            return text if bound is None else "a" * min(bound, 2)
        case SequenceDescriptor(element, bound):
            length = next(numbers) % 3
            return _row(element, min(length, bound or length), numbers)
        case ArrayDescriptor(element, (length,)):
            return _row(element, length, numbers)
        case ArrayDescriptor(element, (length, *rest)):
            inner = ArrayDescriptor(element, tuple(rest))
            return [_value(inner, numbers) for _ in range(length)]
        case EnumDescriptor(members=members):
            return descriptor.class_(members[next(numbers) % len(members)][1])
        case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
            return descriptor.class_(*[_value(each.type, numbers) for each in fields])
        case UnionDescriptor(branches=branches):
            labelled = [branch for branch in branches if branch.labels]
            branch = labelled[next(numbers) % len(labelled)]
            return descriptor.class_(branch.labels[0], _value(branch.type, numbers))
        case AliasDescriptor() | LinkDescriptor():
            return _value(plain(descriptor), numbers)
    raise NotImplementedError(f"a specimen of {descriptor}")


def _primitive(name: str, number: int) -> Any:
    if name in _MAX_VALUES:
        negative = number % 3 == 1 and not name.startswith(("unsigned", "octet"))
        return (
            -number
            if negative
            else (_MAX_VALUES[name] - number if number % 3 else number)
        )
    match name:
        case "float" | "double":
            return number + 0.25
        case "boolean":
            return number % 2 == 1
        case "char":
            return chr(0xE0 + number % 16)
        case "wchar":
            return chr(0x3042 + number % 16)
    raise NotImplementedError(f"a specimen of {name}")


def _row(element: Descriptor, length: int, numbers: Iterator[int]) -> Any:
    items = [_value(element, numbers) for _ in range(length)]
    match plain(element):
        case PrimitiveDescriptor("octet"):
            return bytes(items)
        case PrimitiveDescriptor("char"):
            return "".join(items)
    return items
