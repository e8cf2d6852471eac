"""Values whose type is known only at run time, and base classes of generated valuetypes."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar, Self, TypeVar

import msgspec
from msgspec.structs import force_setattr

from rtgen.runtime.marshalling.descriptors import (
    ANY,
    NULL,
    UNKNOWN,
    BoxDescriptor,
    Descriptor,
    ExceptionDescriptor,
    PrimitiveDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    register,
)
from rtgen.runtime.marshalling.errors import Buffer

_T = TypeVar("_T")


def encoded(descriptor: Any, value: object, little_endian: bool) -> bytes:
    """Encode a value by its descriptor. Raises CdrError."""
    from rtgen.runtime.marshalling.dynamic import values as dynamic

    return dynamic.encoded(descriptor, value, little_endian)


def decoded(descriptor: Any, data: Buffer, little_endian: bool) -> Any:
    """Decode a value by its descriptor. Raises CdrError."""
    from rtgen.runtime.marshalling.dynamic import values as dynamic

    return dynamic.decoded(descriptor, data, little_endian)


class Dynamic:
    """Codec of types that are marshalled by interpreting their descriptors."""

    __slots__ = ()

    _descriptor_: ClassVar[Any]

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """Return the value as a CDR body; raises CdrError."""
        return encoded(self.described(), self, little_endian)

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """Return the value of a CDR body; raises CdrError."""
        value: Self = decoded(cls._descriptor_, data, little_endian)
        return value

    def described(self) -> Any:
        """Return the descriptor of the value."""
        return self._descriptor_

    def _snapshot_(self) -> Self:
        return deepcopy(self)


class AnyValue(Dynamic, msgspec.Struct, frozen=True):
    """Content of an `any`: a value with its type."""

    _descriptor_: ClassVar[Descriptor] = ANY

    type: Descriptor = NULL
    value: Any = None

    def __post_init__(self) -> None:
        described = getattr(self.type, "_descriptor_", None)
        if described is not None:
            force_setattr(self, "type", described)

    def __deepcopy__(self, memo: dict[int, Any]) -> AnyValue:
        return AnyValue(self.type, deepcopy(self.value, memo))

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return (AnyValue.from_cdr, (self.to_cdr(),))


class DynamicValue(Dynamic, msgspec.Struct):
    """A struct or exception without a generated type: `members` by name."""

    type: StructDescriptor | ExceptionDescriptor
    members: dict[str, Any]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.members[name]
        except KeyError:
            raise AttributeError(name) from None

    def described(self) -> Descriptor:
        """Return the descriptor of the value."""
        return self.type

    def __deepcopy__(self, memo: dict[int, Any]) -> DynamicValue:
        return DynamicValue(self.type, deepcopy(self.members, memo))


class DynamicUnion(Dynamic, msgspec.Struct):
    """A union without a generated type."""

    type: UnionDescriptor
    discriminator: Any
    value: Any

    def described(self) -> Descriptor:
        """Return the descriptor of the value."""
        return self.type


class Value(Dynamic):
    """Base class of generated valuetypes, which are compared by identity, since they are shared."""

    __slots__ = ()

    _descriptor_: ClassVar[ValueDescriptor]

    def __init_subclass__(cls) -> None:
        if "_descriptor_" in cls.__dict__:
            register(cls, cls._descriptor_)


class Box(Dynamic):
    """Base class of generated boxed values: a value with an identity, so that it can be shared."""

    __slots__ = ()

    _descriptor_: ClassVar[BoxDescriptor]
    value: Any

    def __init_subclass__(cls) -> None:
        if "_descriptor_" in cls.__dict__:
            register(cls, cls._descriptor_)


def implementation(cls: type[_T]) -> type[_T]:
    """Return a class decorator: `cls` becomes the class of received values of its valuetype."""
    descriptor = cls._descriptor_  # type: ignore[attr-defined]
    register(cls, descriptor)
    return cls


class DynamicState(Value):
    """A valuetype without a generated type: its state is in `members`, by name."""

    __slots__ = ("members", "type")

    def __init__(self, type_: ValueDescriptor) -> None:
        self.type = type_
        self.members: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        if name in ("members", "type"):
            raise AttributeError(name)
        try:
            return self.members[name]
        except KeyError:
            raise AttributeError(name) from None

    def described(self) -> ValueDescriptor:
        """Return the descriptor of the value."""
        return self.type


class DynamicBox(Box):
    """A boxed value without a generated type."""

    __slots__ = ("type", "value")

    def __init__(self, type_: BoxDescriptor, value: Any = None) -> None:
        self.type = type_
        self.value = value

    def described(self) -> BoxDescriptor:
        """Return the descriptor of the value."""
        return self.type


UNKNOWN.update(
    {
        PrimitiveDescriptor: AnyValue,
        StructDescriptor: DynamicValue,
        ExceptionDescriptor: DynamicValue,
        UnionDescriptor: DynamicUnion,
        ValueDescriptor: DynamicState,
        BoxDescriptor: DynamicBox,
    }
)
