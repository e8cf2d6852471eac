"""Values of two versions of a type: samples of one, and a comparison after reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from random import Random
from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.tools.diff.changes import Wire

RANGES = {
    "octet": (0, 255),
    "uint8": (0, 255),
    "int8": (-128, 127),
    "short": (-(1 << 15), (1 << 15) - 1),
    "unsigned short": (0, (1 << 16) - 1),
    "long": (-(1 << 31), (1 << 31) - 1),
    "unsigned long": (0, (1 << 32) - 1),
    "long long": (-(1 << 63), (1 << 63) - 1),
}
_MAX_ITEMS = 5
"""Longer than every bound of random definitions."""


def sample(descriptor: Descriptor, random: Random) -> Any:
    """Return a value, often an extreme one; no part of it is the initial value."""
    descriptor = plain(descriptor)
    match descriptor:
        case PrimitiveDescriptor("boolean"):
            return random.random() < 0.7
        case PrimitiveDescriptor("char"):
            return chr(random.randint(1, 255))
        case PrimitiveDescriptor("float" | "double"):
            return random.choice((1.5, -2.25, 1024.0))
        case PrimitiveDescriptor(name):
            low, high = RANGES[name]
            number = random.choice((low or high, high, random.randint(low, high)))
            return number or 1
        case StringDescriptor(bound=bound):
            length = random.randint(1, bound or _MAX_ITEMS)
            return "".join(random.choice("abcxyz") for _ in range(length))
        case SequenceDescriptor(element, bound):
            count = random.choice((1, 2, min(bound or _MAX_ITEMS, _MAX_ITEMS)))
            return _items(element, min(count, bound or count), random)
        case ArrayDescriptor(element, (length,)):
            return _items(element, length, random)
        case EnumDescriptor(members=members):
            return descriptor.class_(random.choice(members)[1])
        case StructDescriptor(members=members):
            return descriptor.class_(
                *(
                    (
                        None
                        if m.optional and random.random() < 0.3
                        else sample(m.type, random)
                    )
                    for m in members
                )
            )
        case UnionDescriptor(branches=branches):
            branch = random.choice(branches)
            label = random.choice(branch.labels)
            if random.random() < 0.1:
                return descriptor.class_(99, None)
            return descriptor.class_(label, sample(branch.type, random))
    raise AssertionError(descriptor)


def _items(element: Descriptor, count: int, random: Random) -> Any:
    items = [sample(element, random) for _ in range(count)]
    match plain(element):
        case PrimitiveDescriptor("octet" | "uint8"):
            return bytes(items)
        case PrimitiveDescriptor("char"):
            return "".join(items)
    return items


class Reading:
    """Compares values that one version wrote with those that the other read.

    `names` maps names of parts of the writer to those of the reader, by the type's name.
    """

    def __init__(self, wire: Wire, names: Mapping[tuple[str, str], str]) -> None:
        self._wire = wire
        self._names = names

    def same(
        self, writer: Descriptor, written: Any, reader: Descriptor, read: Any, top: bool
    ) -> bool:
        """Compare a written value with the one read."""
        writer, reader = plain(writer), plain(reader)
        match writer, reader:
            case PrimitiveDescriptor(a), PrimitiveDescriptor(b):
                octets = {"octet", "uint8"}
                is_same = a == b or {a, b} == octets
                return is_same and bool(written == read)
            case StringDescriptor(), StringDescriptor():
                return bool(written == read)
            case SequenceDescriptor(a), SequenceDescriptor(b):
                return self._items(a, written, b, read)
            case ArrayDescriptor(a), ArrayDescriptor(b):
                return self._items(a, written, b, read)
            case EnumDescriptor(), EnumDescriptor():
                name = self._name(writer.name, written.name)
                return bool(name == read.name)
            case StructDescriptor(), StructDescriptor():
                return self._struct(writer, written, reader, read, top)
            case UnionDescriptor(), UnionDescriptor():
                return self._union(writer, written, reader, read)
        return False

    def _items(self, a: Descriptor, written: Any, b: Descriptor, read: Any) -> bool:
        return len(written) == len(read) and all(
            self.same(a, x, b, y, False) for x, y in zip(written, read, strict=True)
        )

    def _name(self, of: str, name: str) -> str:
        return self._names.get((of.rpartition("::")[2], name), name)

    def _struct(
        self,
        writer: StructDescriptor,
        written: Any,
        reader: StructDescriptor,
        read: Any,
        top: bool,
    ) -> bool:
        kinds = {writer.extensibility, reader.extensibility}
        sent = {self._name(writer.name, m.name): m for m in writer.members}
        wanted = {m.name: m for m in reader.members}
        if kinds == {"mutable"}:
            pass
        elif kinds == {"appendable"} and self._evolves(top):
            both = min(len(sent), len(wanted))
            if [*sent][:both] != [*wanted][:both]:
                return False
        elif [*sent] != [*wanted]:
            return False
        initial = reader.class_()
        return all(
            (
                self._member(sent[name], written, member, read)
                if name in sent
                else getattr(read, member.attribute)
                == getattr(initial, member.attribute)
            )
            for name, member in wanted.items()
        )

    def _evolves(self, top: bool) -> bool:
        return self._wire is Wire.XCDR2 or (self._wire is Wire.XCDR1 and top)

    def _member(
        self, a: MemberDescriptor, written: Any, b: MemberDescriptor, read: Any
    ) -> bool:
        x, y = getattr(written, a.attribute), getattr(read, b.attribute)
        if x is None or y is None:
            return x is y
        return self.same(a.type, x, b.type, y, False)

    def _union(
        self, writer: UnionDescriptor, written: Any, reader: UnionDescriptor, read: Any
    ) -> bool:
        if written.discriminator != read.discriminator:
            return False
        a, b = (d.branch(written.discriminator) for d in (writer, reader))
        if a is None or b is None:
            kinds = {writer.extensibility, reader.extensibility}
            opened = kinds == {"mutable"} or (
                kinds == {"appendable"} and self._wire is Wire.XCDR2
            )
            return a is b or opened
        return self._branch(writer, a, written, b, read)

    def _branch(
        self,
        writer: UnionDescriptor,
        a: BranchDescriptor,
        written: Any,
        b: BranchDescriptor,
        read: Any,
    ) -> bool:
        if self._name(writer.name, a.name) != b.name:
            return False
        return self.same(a.type, written.value, b.type, read.value, False)


def samples(descriptor: Descriptor, random: Random, count: int) -> Iterator[Any]:
    """Yield `count` values."""
    return (sample(descriptor, random) for _ in range(count))
