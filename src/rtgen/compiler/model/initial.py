"""The values with which members start, and which readers give to members that were not sent.

DDS-XTypes 1.3, 7.2.2.4.4.4.9 and Table 9: the default of the member, else that of its type. That of
a struct is its members' own; optional members are absent; a union has the discriminator's, and the
branch that it selects. Each target prints these; the runtime has them in its classes and
descriptors.
"""

from __future__ import annotations

from rtgen.compiler.model import (
    Case,
    ConstantValue,
    Enum,
    EnumeratorName,
    InitialValue,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Type,
    Union,
)


def default_of(
    model: Model, type_: Type, own: InitialValue | None = None
) -> InitialValue | None:
    """Return the value of `@default`: a member's own, else that of the nearest typedef.

    None: the member starts with the implicit value of its type.
    """
    while own is None and (typedef := model.typedef(type_)) is not None:
        own, type_ = typedef.initial, typedef.type
    return own


def discriminator(model: Model, union: Union) -> ConstantValue:
    """Return the discriminator with which a union starts."""
    value = default_of(model, union.switch)
    if value is not None:
        assert not isinstance(value, tuple)
        return value
    switch = model.unalias(union.switch)
    match switch:
        case NamedType(name):
            enum = model.find(name)
            assert isinstance(enum, Enum)
            return enumerator(enum)
        case PrimitiveType(Primitive.BOOLEAN):
            return False
        case PrimitiveType(Primitive.CHAR | Primitive.WCHAR):
            return "\0"
    return 0


def enumerator(enum: Enum) -> EnumeratorName:
    """Return the name of the enumerator with which an enum starts."""
    return EnumeratorName((*enum.name[:-1], enum.initial.name))


def selected(model: Model, union: Union) -> Case | None:
    """Return the branch with which a union starts; None if it starts without one."""
    label = discriminator(model, union)
    for case in union.cases:
        if label in case.labels:
            return case
    return next((case for case in union.cases if case.default), None)
