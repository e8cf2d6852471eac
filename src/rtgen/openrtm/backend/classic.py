"""Selects the part of a model supported by classic IDL (CORBA 2.6) and omniORBpy.

`long double` is not supported.
"""

from __future__ import annotations

from collections.abc import Iterator
from keyword import iskeyword

from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Component,
    Const,
    Declaration,
    Enum,
    ExceptionDecl,
    FixedType,
    Home,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Native,
    Operation,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.declarations import OPAQUE

_UNKNOWN = {
    Primitive.INT8: "`int8`, which IDL has since version 4",
    Primitive.UINT8: "`uint8`, which IDL has since version 4",
    Primitive.LONG_DOUBLE: "`long double`, which omniORBpy has not",
}

_KEYWORD = "a keyword of Python, which breaks omniORBpy's module"

_NO_SWITCH = (Primitive.OCTET, Primitive.WCHAR)
"""Discriminator types that only IDL 4 has."""


class Classic:
    """Decides whether omniidl can compile a declaration, with the reason if not."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._reasons: dict[ScopedName, str] = {}
        self._visited: set[ScopedName] = set()

    def reason(self, name: ScopedName) -> str:
        """Return the reason why a type or interface is unsupported; empty if it is supported.

        A placeholder for an unknown type becomes a placeholder in classic IDL, too.
        """
        if name in self._reasons:
            return self._reasons[name]
        if name in self._visited:
            return ""
        first = not self._visited
        self._visited.add(name)
        problem = next(self._problems(self._model.find(name)), "")
        if problem:
            self._reasons[name] = problem
        if first:
            # Types may depend on each other: none is supported before all have been checked.
            if not problem:
                self._reasons.update(dict.fromkeys(self._visited, ""))
            self._visited.clear()
        return problem

    def _problems(self, declaration: Declaration) -> Iterator[str]:
        if declaration.annotation(OPAQUE) is not None:
            return
        match declaration:
            case Bitset() | Bitmask():
                kind = type(declaration).__name__.lower()
                yield f"`{declaration.scoped}` is a {kind}, which IDL has since version 4"
            case Native():
                yield f"`{declaration.scoped}` is native"
            case Component() | Home():
                yield f"`{declaration.scoped}` is not a type"
            case Enum(members=members):
                if [member.value for member in members] != list(range(len(members))):
                    yield f"`{declaration.scoped}` has enumerators with values of their own"
            case Typedef(type=type_) | Const(type=type_) | ValueBox(type=type_):
                yield from self._in_type(declaration, type_)
            case Struct():
                yield from self._in_struct(declaration)
            case ExceptionDecl(members=members):
                for member in members:
                    yield from self._in_member(declaration, member)
            case Union():
                yield from self._in_union(declaration)
            case Interface():
                yield from self._in_interface(declaration)
            case Valuetype():
                yield from self._in_valuetype(declaration)

    def _in_struct(self, struct: Struct) -> Iterator[str]:
        members = self._model.members(struct)
        if not members:
            yield f"`{struct.scoped}` has no members"
        for member in members:
            if member.optional:
                yield f"`{struct.scoped}` has the optional member `{member.name}`"
            yield from self._in_member(struct, member)

    def _in_member(self, holder: Declaration, member: Member) -> Iterator[str]:
        if member.name == "self":
            yield f"`{holder.scoped}` has a member `self`, which breaks omniORBpy's class"
        yield from self._in_type(holder, member.type)

    def _in_union(self, union: Union) -> Iterator[str]:
        switch = self._model.unalias(union.switch)
        if isinstance(switch, PrimitiveType) and switch.kind in _NO_SWITCH:
            yield f"`{union.scoped}` is switched by `{switch}`, as IDL has it since version 4"
        yield from self._in_type(union, union.switch)
        for case in union.cases:
            yield from self._in_type(union, case.type)

    def _in_interface(self, interface: Interface) -> Iterator[str]:
        if interface.forward:
            yield f"`{interface.scoped}` is declared, but not defined"
        if interface.local or interface.abstract:
            kind = "a local" if interface.local else "an abstract"
            yield f"`{interface.scoped}` is {kind} interface"
        yield from map(self.reason, filter(self.reason, interface.bases))
        yield from self._bases(interface, interface.bases)
        for attribute in interface.attributes:
            if iskeyword(attribute.name):
                named = f"`{interface.scoped}` has the attribute `{attribute.name}`"
                yield f"{named}, {_KEYWORD}"
            yield from self._in_type(interface, attribute.type)
            for name in (*attribute.get_raises, *attribute.set_raises):
                yield from filter(None, (self.reason(name),))
        for operation in interface.operations:
            yield from self._in_operation(interface, operation)

    def _in_operation(
        self, interface: Interface, operation: Operation
    ) -> Iterator[str]:
        for type_ in (operation.returns, *(p.type for p in operation.parameters)):
            yield from self._in_type(interface, type_)
        yield from filter(None, map(self.reason, operation.raises))
        for name in operation.raises:
            if iskeyword(name[-1]):
                called = f"`{operation.name}` of `{interface.scoped}`"
                yield f"{called} raises `{'::'.join(name)}`, {_KEYWORD}"

    def _bases(
        self, holder: Interface | Valuetype, bases: tuple[ScopedName, ...]
    ) -> Iterator[str]:
        for name in bases:
            if iskeyword(name[-1]):
                yield f"`{holder.scoped}` has the base `{'::'.join(name)}`, {_KEYWORD}"

    def _in_valuetype(self, valuetype: Valuetype) -> Iterator[str]:
        if valuetype.forward:
            yield f"`{valuetype.scoped}` is declared, but not defined"
        if valuetype.abstract or valuetype.custom:
            kind = "an abstract" if valuetype.abstract else "a custom"
            yield f"`{valuetype.scoped}` is {kind} valuetype"
        for name in (*valuetype.bases, *valuetype.supports):
            yield from filter(None, (self.reason(name),))
        yield from self._bases(valuetype, (*valuetype.bases, *valuetype.supports))
        for member in valuetype.state:
            yield from self._in_type(valuetype, member.type)

    def _in_type(self, holder: Declaration, type_: Type) -> Iterator[str]:
        match type_:
            case PrimitiveType(kind) if kind in _UNKNOWN:
                yield f"`{holder.scoped}` has {_UNKNOWN[kind]}"
            case MapType():
                yield f"`{holder.scoped}` has a `map`, which IDL has since version 4"
            case FixedType(digits=0):
                yield f"`{holder.scoped}` has a `fixed` without digits"
            case SequenceType(element) | ArrayType(element):
                yield from self._in_type(holder, element)
            case NamedType(name):
                yield from filter(None, (self.reason(name),))
