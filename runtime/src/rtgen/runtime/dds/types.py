"""Types of topics for cyclonedds, created from the descriptors of generated types.

They give the topic its type information (DDS-XTypes 1.3, 7.6.3.2) and its key; samples are
serialized by rtgen's codecs only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

from cyclonedds import idl
from cyclonedds.idl import types

from rtgen.facts.member_ids import hashed_id
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)

t: Any = types
"""Its annotations are generic in a way that type checkers do not support."""

_PRIMITIVES: dict[str, Any] = {
    "boolean": bool,
    "octet": t.byte,
    "char": t.char,
    "wchar": t.wchar,
    "int8": t.int8,
    "uint8": t.uint8,
    "short": t.int16,
    "unsigned short": t.uint16,
    "long": t.int32,
    "unsigned long": t.uint32,
    "long long": t.int64,
    "unsigned long long": t.uint64,
    "float": t.float32,
    "double": t.float64,
}
_CHARACTERS = (PrimitiveDescriptor("char"), PrimitiveDescriptor("wchar"))
_MADE: dict[tuple[int, bool], tuple[Any, Any]] = {}
"""Classes by the identity of their descriptor, which is kept alive with them, and `ros2`."""


def idl_class(type_: type[Any], *, ros2: bool = False) -> Any:
    """Return the class of cyclonedds for a generated struct or union.

    `ros2`: a wstring is a sequence of 32-bit numbers, as on the networks of ROS 2. Raises
    MediumError for a type that cyclonedds does not support, or cannot describe: other wstrings,
    long double, fixed, any, maps, valuetypes, objects, bitsets, mutable unions, recursive types.
    """
    class_ = _Maker(ros2).named(type_._descriptor_)
    try:
        class_.__idl__.fill_type_data()
    except Exception as error:  # cyclonedds raises no narrower class
        raise _unsupported(type_._descriptor_, str(error)) from error
    return class_


class _Maker:
    def __init__(self, ros2: bool) -> None:
        self._ros2 = ros2
        self._under_way: list[str] = []

    def named(self, descriptor: Any) -> Any:
        """Return the class of a named type, which is created once."""
        cached = _MADE.get((id(descriptor), self._ros2))
        if cached is not None:
            return cached[1]
        if descriptor.name in self._under_way:
            raise _unsupported(descriptor, "it is part of itself")
        self._under_way.append(descriptor.name)
        class_ = self._make_class(descriptor)
        self._under_way.pop()
        _MADE[id(descriptor), self._ros2] = descriptor, class_
        return class_

    def _make_class(self, descriptor: Any) -> Any:
        name = str(descriptor.name)
        python_name = name.replace("::", "_")
        class_: Any
        match descriptor:
            case StructDescriptor(members=members):
                fields = {m.name: self._member(m) for m in members}
                class_ = idl.make_idl_struct(
                    python_name, name, fields, field_annotations=_annotations(members)
                )
                if members and all(m.id == hashed_id(m.name) for m in members):
                    class_.__idl_annotations__["autoid"] = "hash"
            case UnionDescriptor(switch=switch, branches=branches):
                if descriptor.extensibility == "mutable":
                    raise _unsupported(descriptor, "mutable unions are not")
                class_ = idl.make_idl_union(
                    python_name,
                    name,
                    {b.name: self._branch(b, switch) for b in branches},
                    self.type(switch),
                )
            case EnumDescriptor(members=members, bound=bound):
                class_ = idl.make_idl_enum(python_name, name, dict(members))
                class_.__idl_annotations__["bit_bound"] = bound
                return class_
            case FlagsDescriptor(members=members, bound=bound):
                return _bitmask(python_name, name, members, bound)
            case _:
                raise _unsupported(descriptor, "only data types are")
        class_.__idl_annotations__["extensibility"] = descriptor.extensibility
        return class_

    def _member(self, member: Any) -> Any:
        type_ = self.type(member.type)
        # cyclonedds supports this form only.
        return Optional[type_] if member.optional else type_  # noqa: UP045

    def _branch(self, branch: Any, switch: Descriptor) -> Any:
        type_ = self.type(branch.type)
        if branch.default and not branch.labels:
            return t.default[type_]
        if branch.default:
            raise _unsupported(branch, "a default branch with labels is not")
        labels: list[Any] = [*branch.labels]
        switch = plain(switch)
        if isinstance(switch, EnumDescriptor):
            class_ = self.named(switch)
            labels = [class_(int(label)) for label in labels]
        elif switch in _CHARACTERS:
            labels = [ord(label) for label in labels]  # as in type objects
        return t.case[labels, type_]

    def type(self, descriptor: Descriptor) -> Any:
        """Return the annotation of a type."""
        descriptor = plain(descriptor)
        match descriptor:
            case PrimitiveDescriptor(name) if name in _PRIMITIVES:
                return _PRIMITIVES[name]
            case StringDescriptor(wide=False, bound=bound):
                return str if bound is None else t.bounded_str[bound]
            case StringDescriptor(wide=True, bound=bound) if self._ros2:
                bounds = () if bound is None else (bound,)
                return t.sequence[(t.uint32, *bounds)]
            case SequenceDescriptor(element=element, bound=None):
                return t.sequence[self.type(element)]
            case SequenceDescriptor(element=element, bound=bound):
                return t.sequence[self.type(element), bound]
            case ArrayDescriptor(element=element, dimensions=dimensions):
                idl_type = self.type(element)
                for length in reversed(dimensions):
                    idl_type = t.array[idl_type, length]
                return idl_type
            case LinkDescriptor():
                raise _unsupported(descriptor, "it is part of itself")
            case (
                StructDescriptor()
                | UnionDescriptor()
                | EnumDescriptor()
                | FlagsDescriptor()
            ):
                return self.named(descriptor)
        raise _unsupported(descriptor, "cyclonedds does not have it")


def _annotations(members: Any) -> dict[str, dict[str, Any]]:
    annotations: dict[str, dict[str, Any]] = {}
    for member in members:
        entry: dict[str, Any] = {"id": member.id}
        if member.key:
            entry["key"] = True
        if member.must_understand:
            entry["must_understand"] = True
        annotations[member.name] = entry
    return annotations


def _bitmask(python_name: str, name: str, members: Any, bound: int) -> Any:
    meta: Any = type(idl.IdlBitmask)
    namespace = meta.__prepare__(python_name, (idl.IdlBitmask,), typename=name)
    # The bound must be known when the positions are checked.
    namespace["__idl_annotations__"]["bit_bound"] = bound
    for flag, place in members:
        namespace["__annotations__"][flag] = bool
        namespace["__idl_field_annotations__"][flag] = {"position": place}
    return dataclass(meta(python_name, (idl.IdlBitmask,), namespace))


def _unsupported(what: Any, why: str) -> MediumError:
    name = getattr(what, "name", None) or str(what)
    return MediumError(f"{name} cannot be sent over DDS: {why}")
