"""Compares signatures and types of CDL files; function ids are positions in the text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

from rtgen.diagnostics import Span
from rtgen.diff.c_types import c_shape, c_text, length_text
from rtgen.diff.changes import Change, Kind, change
from rtgen.diff.kinds import signatures as kinds
from rtgen.diff.matching import matching
from rtgen.diff.versions import Version
from rtgen.layouts.tdr_messages import is_error_code
from rtgen.model.c_types import CType
from rtgen.model.tecs import (
    Signature,
    Sizes,
    TecsConst,
    TecsDeclaration,
    TecsEnum,
    TecsFunction,
    TecsMember,
    TecsParameter,
    TecsStruct,
    TecsTypedef,
)
from rtgen.model.types import ScopedName

Declared = TypeVar("Declared", bound=TecsDeclaration)
Names = Mapping[ScopedName, ScopedName]


def declared(version: Version, kind: type[Declared]) -> dict[ScopedName, Declared]:
    """Return a version's CDL declarations of a kind, without those of C headers."""
    return {
        d.name: d
        for unit in version.model.tecs
        for d in unit.declarations
        if isinstance(d, kind) and not getattr(d, "from_c", False)
    }


def compare_signatures(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of signatures, structs, typedefs, enums and constants."""
    structs = matching(
        declared(old, TecsStruct), declared(new, TecsStruct), _struct_shape
    )
    names = {a.name: b.name for a, b in (*structs.pairs, *structs.renamed)}
    for struct in structs.removed:
        text = f"struct {struct.scoped} is removed"
        yield change(kinds.STRUCT_REMOVED, struct.scoped, text, struct.span, None)
    for struct in structs.added:
        text = f"struct {struct.scoped} is added"
        yield change(kinds.STRUCT_ADDED, struct.scoped, text, None, struct.span)
    for one, other in structs.renamed:
        text = f"struct {other.scoped} was called {one.scoped}"
        yield change(kinds.STRUCT_RENAMED, other.scoped, text, one.span, other.span)
    for one, other in (*structs.pairs, *structs.renamed):
        yield from _struct(one, other, names)
    yield from _types(old, new, names)
    found = matching(
        declared(old, Signature), declared(new, Signature), _signature_shape
    )
    for signature in found.removed:
        text = f"signature {signature.scoped} is removed"
        yield change(
            kinds.SIGNATURE_REMOVED, signature.scoped, text, signature.span, None
        )
    for signature in found.added:
        text = f"signature {signature.scoped} is added"
        yield change(
            kinds.SIGNATURE_ADDED, signature.scoped, text, None, signature.span
        )
    for before, after in found.renamed:
        text = f"signature {after.scoped} was called {before.scoped}"
        yield change(
            kinds.SIGNATURE_RENAMED, after.scoped, text, before.span, after.span
        )
    for before, after in (*found.pairs, *found.renamed):
        yield from _Signatures(before, after, names).compare()


def _struct_shape(struct: TecsStruct) -> object:
    return tuple((m.name, str(m.type), m.sizes) for m in struct.members)


def _signature_shape(signature: Signature) -> object:
    return tuple((f.name, _function_shape(f)) for f in signature.functions)


def _function_shape(function: TecsFunction) -> object:
    parameters = ((p.direction, str(p.type), p.name) for p in function.parameters)
    return (str(function.returns), tuple(parameters), function.oneway)


def _types(old: Version, new: Version, names: Names) -> Iterator[Change]:
    """Yield the changes of typedefs, enums and constants."""
    typedefs = matching(
        declared(old, TecsTypedef), declared(new, TecsTypedef), lambda _: None
    )
    for one, other in typedefs.pairs:
        if c_shape(one.type, names) != c_shape(other.type, {}):
            text = f"typedef {other.scoped} is {c_text(other.type)}, was {c_text(one.type)}"
            yield change(kinds.TYPEDEF, other.scoped, text, one.span, other.span)
    enums = matching(declared(old, TecsEnum), declared(new, TecsEnum), lambda _: None)
    for before, after in enums.pairs:
        if (before.members, before.bits) != (after.members, after.bits):
            text = f"enum {after.scoped} has other names, numbers or bits"
            yield change(kinds.ENUM, after.scoped, text, before.span, after.span)
    constants = matching(
        declared(old, TecsConst), declared(new, TecsConst), lambda _: None
    )
    for first, second in constants.pairs:
        types = c_shape(first.type, names), c_shape(second.type, {})
        if first.value != second.value or types[0] != types[1]:
            text = f"constant {second.scoped} is {second.value}, was {first.value}"
            yield change(kinds.CONST, second.scoped, text, first.span, second.span)
    for gone in (*typedefs.removed, *enums.removed, *constants.removed):
        text = f"{gone.scoped} is removed"
        yield change(kinds.STRUCT_REMOVED, gone.scoped, text, gone.span, None)
    for come in (*typedefs.added, *enums.added, *constants.added):
        text = f"{come.scoped} is added"
        yield change(kinds.STRUCT_ADDED, come.scoped, text, None, come.span)


_Part = TypeVar("_Part", TecsMember, TecsParameter)


def _renamed(
    old: Sequence[_Part], new: Sequence[_Part], names: Names
) -> dict[str, str]:
    """Return the new names of parts with unchanged place and type, by old name."""
    before, after = {p.name for p in old}, {p.name for p in new}
    return {
        a.name: b.name
        for a, b in zip(old, new, strict=False)
        if a.name not in after
        and b.name not in before
        and c_shape(a.type, names) == c_shape(b.type, {})
    }


def _reordered(old: Sequence[str], new: Sequence[str]) -> bool:
    return [n for n in old if n in new] != [n for n in new if n in old]


def _struct(old: TecsStruct, new: TecsStruct, names: Names) -> Iterator[Change]:
    renamed = _renamed(old.members, new.members, names)
    before = {renamed.get(m.name, m.name): m for m in old.members}
    after = {m.name: m for m in new.members}
    for key, member in before.items():
        if key not in after:
            name = f"{new.scoped}.{member.name}"
            text = f"member {name} is removed"
            yield change(kinds.STRUCT_MEMBER_REMOVED, name, text, member.span, new.span)
    for key, member in after.items():
        name = f"{new.scoped}.{key}"
        if key not in before:
            text = f"member {name} is added"
            yield change(kinds.STRUCT_MEMBER_ADDED, name, text, old.span, member.span)
            continue
        one = before[key]
        spans = (one.span, member.span)
        if one.name != key:
            text = f"member {name} was called {one.name}"
            yield change(kinds.STRUCT_MEMBER_RENAMED, name, text, *spans)
        if c_shape(one.type, names) != c_shape(member.type, {}):
            text = f"member {name} has the type {c_text(member.type)}, had {c_text(one.type)}"
            yield change(kinds.STRUCT_MEMBER_TYPE, name, text, *spans)
        if _sizes_text(one.sizes, renamed) != _sizes_text(member.sizes, {}):
            text = f"member {name} has other size specifiers"
            yield change(kinds.STRUCT_MEMBER_SIZES, name, text, *spans)
    if _reordered([*before], [*after]):
        text = f"the members of struct {new.scoped} are in another order"
        yield change(
            kinds.STRUCT_MEMBERS_REORDERED, new.scoped, text, old.span, new.span
        )


def _sizes_text(sizes: Sizes, renamed: Mapping[str, str]) -> tuple[object, ...]:
    texts = (
        length_text(e, renamed) for e in (sizes.size_is, sizes.count_is, sizes.string)
    )
    return (*texts, sizes.max_size, sizes.unsized_string, sizes.nullable)


class _Signatures:
    def __init__(self, old: Signature, new: Signature, names: Names) -> None:
        self._old, self._new, self._names = old, new, names

    def compare(self) -> Iterator[Change]:
        old, new = self._old, self._new
        if (old.context, old.callback) != (new.context, new.callback):
            text = f"signature {new.scoped} has another context or callback"
            yield change(kinds.SIGNATURE_CONTEXT, new.scoped, text, old.span, new.span)
        if old.deviate != new.deviate:
            text = f"signature {new.scoped} is {'' if new.deviate else 'no longer '}deviate"
            yield change(kinds.SIGNATURE_DEVIATE, new.scoped, text, old.span, new.span)
        found = matching(
            {f.name: f for f in old.functions},
            {f.name: f for f in new.functions},
            lambda f: (f.id, _function_shape(f)),
        )
        last = max((b.id for _, b in (*found.pairs, *found.renamed)), default=0)
        for function in found.removed:
            name = f"{old.scoped}.{function.name}"
            text = f"function {name} (id {function.id}) is removed"
            yield change(kinds.FUNCTION_REMOVED, name, text, function.span, new.span)
        for function in found.added:
            name = self._sub(function)
            inserted = function.id < last or bool(found.removed)
            kind = kinds.FUNCTION_INSERTED if inserted else kinds.FUNCTION_ADDED
            text = f"function {name} is added with the id {function.id}"
            yield change(kind, name, text, old.span, function.span)
        for one, other in found.renamed:
            text = f"function {self._sub(other)} was called {one.name}"
            yield change(
                kinds.FUNCTION_RENAMED, self._sub(other), text, one.span, other.span
            )
        for one, other in (*found.pairs, *found.renamed):
            yield from self._function(one, other)

    def _function(self, old: TecsFunction, new: TecsFunction) -> Iterator[Change]:
        name, spans = self._sub(new), (old.span, new.span)
        if old.id != new.id:
            text = f"function {name} has the id {new.id}, had {old.id}"
            yield change(kinds.FUNCTION_MOVED, name, text, *spans)
        if old.oneway != new.oneway:
            text = f"function {name} is {'oneway' if new.oneway else 'twoway'} now"
            yield change(kinds.FUNCTION_ONEWAY, name, text, *spans)
        if self._result(old.returns, self._names) != self._result(new.returns, {}):
            text = f"function {name} returns {c_text(new.returns)}, did {c_text(old.returns)}"
            yield change(kinds.FUNCTION_RESULT, name, text, *spans)
        elif str(old.returns) != str(new.returns):
            text = f"function {name} returns {c_text(new.returns)}, did {c_text(old.returns)}"
            yield change(kinds.PARAMETER_ALIAS, name, text, *spans)
        renamed = _renamed(old.parameters, new.parameters, self._names)
        before = {renamed.get(p.name, p.name): p for p in old.parameters}
        after = {p.name: p for p in new.parameters}
        for key, parameter in before.items():
            if key not in after:
                text = f"parameter {parameter.name} of {name} is removed"
                yield change(
                    kinds.PARAMETER_REMOVED, name, text, parameter.span, new.span
                )
        for key, parameter in after.items():
            if key not in before:
                text = f"parameter {key} of {name} is added"
                yield change(
                    kinds.PARAMETER_ADDED, name, text, old.span, parameter.span
                )
            else:
                yield from self._parameter(
                    before[key], parameter, f"{name}({key})", renamed
                )
        if _reordered([*before], [*after]):
            text = f"the parameters of {name} are in another order"
            yield change(kinds.PARAMETERS_REORDERED, name, text, *spans)

    @staticmethod
    def _result(type_: CType, names: Names) -> tuple[str, bool]:
        """Return the octets of a result, and whether an E_RPC as result omits the outs."""
        return c_shape(type_, names), is_error_code(type_)

    def _parameter(
        self,
        old: TecsParameter,
        new: TecsParameter,
        name: str,
        renamed: Mapping[str, str],
    ) -> Iterator[Change]:
        spans = (old.span, new.span)
        if old.name != new.name:
            text = f"parameter {name} was called {old.name}"
            yield change(kinds.PARAMETER_RENAMED, name, text, *spans)
        if old.direction is not new.direction:
            text = f"parameter {name} is {new.direction}, was {old.direction}"
            yield change(kinds.PARAMETER_DIRECTION, name, text, *spans)
        types = f"{c_text(new.type)}, had {c_text(old.type)}"
        if c_shape(old.type, self._names) != c_shape(new.type, {}):
            text = f"parameter {name} has the type {types}"
            yield change(kinds.PARAMETER_TYPE, name, text, *spans)
        elif str(old.type) != str(new.type):
            text = f"parameter {name} has the type {types}"
            yield change(kinds.PARAMETER_ALIAS, name, text, *spans)
        yield from _sizes(old.sizes, new.sizes, name, spans, renamed)
        if old.allocator != new.allocator:
            text = f"parameter {name} has another allocator"
            yield change(kinds.ALLOCATOR, name, text, *spans)

    def _sub(self, function: TecsFunction) -> str:
        return f"{self._new.scoped}.{function.name}"


def _sizes(
    old: Sizes,
    new: Sizes,
    name: str,
    spans: tuple[Span, Span],
    renamed: Mapping[str, str],
) -> Iterator[Change]:
    rows: tuple[tuple[Kind, str, str, str], ...] = (
        (
            *(kinds.SIZE_IS, "size_is"),
            *(length_text(old.size_is, renamed), length_text(new.size_is, {})),
        ),
        (
            *(kinds.COUNT_IS, "count_is"),
            *(length_text(old.count_is, renamed), length_text(new.count_is, {})),
        ),
        (
            *(kinds.STRING, "string"),
            *(_string(old, renamed), _string(new, {})),
        ),
    )
    for kind, word, before, after in rows:
        if before != after:
            text = f"parameter {name} has {word} {after}, had {before}"
            yield change(kind, name, text, *spans)
    if old.max_size != new.max_size:
        lowered = new.max_size is not None and (
            old.max_size is None or new.max_size < old.max_size
        )
        kind = kinds.MAX_SIZE_LOWERED if lowered else kinds.MAX_SIZE_RAISED
        text = f"parameter {name} holds at most {new.max_size}, did {old.max_size}"
        yield change(kind, name, text, *spans)
    if old.nullable != new.nullable:
        text = f"parameter {name} is {'' if new.nullable else 'no longer '}nullable"
        yield change(kinds.NULLABLE, name, text, *spans)


def _string(sizes: Sizes, renamed: Mapping[str, str]) -> str:
    return "unsized" if sizes.unsized_string else length_text(sizes.string, renamed)
