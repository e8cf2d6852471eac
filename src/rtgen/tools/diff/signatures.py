"""Compares signatures and types of CDL files; function ids are positions in the text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, TypeVar

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.layouts.signature_digest import signature_text
from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.compiler.matching import Matching, matching
from rtgen.compiler.model.c_types import CType
from rtgen.compiler.model.tecs import (
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
    TecsUnit,
)
from rtgen.compiler.model.types import ScopedName
from rtgen.tools.diff.c_types import Octets, length_text, named, structs_in
from rtgen.tools.diff.changes import Change, change
from rtgen.tools.diff.items import (
    Fact,
    Group,
    by_name,
    differing,
    fact_changes,
    is_reordered,
    item_changes,
    part_changes,
)
from rtgen.tools.diff.kinds import signatures as kinds
from rtgen.tools.diff.versions import Version

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


_STRUCTS = Group(
    "struct", kinds.STRUCT_ADDED, kinds.STRUCT_REMOVED, kinds.STRUCT_RENAMED
)
_OTHERS = Group("", kinds.STRUCT_ADDED, kinds.STRUCT_REMOVED)
_PARAMETERS = Group("parameter", kinds.PARAMETER_ADDED, kinds.PARAMETER_REMOVED)
_PARAMETER_FACTS = (
    Fact(
        kinds.PARAMETER_DIRECTION, "{name} is {now}, was {was}", lambda p: p.direction
    ),
    Fact(kinds.ALLOCATOR, "{name} has another allocator", lambda p: p.allocator),
    Fact(kinds.NULLABLE, "{name} is {no}nullable", lambda p: p.sizes.nullable),
)
_LENGTHS = {
    "size_is": kinds.SIZE_IS,
    "count_is": kinds.COUNT_IS,
    "string": kinds.STRING,
}


class TecsSide:
    """The signatures of one version, and the octets of their types.

    `numbers` is the same dictionary for both versions (`Octets`).
    """

    def __init__(self, version: Version, numbers: dict[object, int]) -> None:
        self.signatures: dict[ScopedName, Signature] = {}
        self.structs: dict[ScopedName, TecsStruct] = declared(version, TecsStruct)
        self._octets: dict[ScopedName, Octets] = {}
        self._units: dict[ScopedName, TecsUnit] = {}
        everywhere: dict[ScopedName, TecsStruct] = {}
        for unit in version.model.tecs:
            known = unit.structs
            octets = Octets(known, numbers)
            everywhere.update(known)
            for each in unit.declarations:
                if isinstance(each, Signature) and each.name not in self.signatures:
                    self.signatures[each.name] = each
                    self._octets[each.name] = octets
                    self._units[each.name] = unit
                    # Those of C headers count if they travel.
                    types = (type_ for f in each.functions for type_ in _types_of(f))
                    names = (n for type_ in types for n in structs_in(type_, known))
                    self.structs.update((name, known[name]) for name in names)
        self.everywhere = Octets(everywhere, numbers)

    def members(self, struct: TecsStruct) -> object:
        """Return the names and octets of a struct's members."""
        octets = self.everywhere
        return tuple((m.name, octets.of(m.type), m.sizes) for m in struct.members)

    def octets(self, signature: Signature) -> Octets:
        """Return the octets of a signature's types."""
        return self._octets[signature.name]

    def digest(self, signature: Signature) -> str:
        """Return the text of the digest by which peers compare their signatures."""
        return signature_text(self._units[signature.name], signature)

    def messages(self, signature: Signature) -> object:
        """Return the names of a signature's functions, and what determines their messages."""
        octets = self.octets(signature)
        return tuple((each.name, octets.function(each)) for each in signature.functions)


class TecsSides:
    """The signatures of two versions; `renamed` are those with other names."""

    def __init__(self, old: Version, new: Version) -> None:
        numbers: dict[object, int] = {}
        self.old, self.new = TecsSide(old, numbers), TecsSide(new, numbers)
        self.found = matching(
            self.old.signatures,
            self.new.signatures,
            self.old.messages,
            self.new.messages,
        )
        self.renamed = {a.name: b.name for a, b in self.found.renamed}

    def same(self, old: ScopedName, new: ScopedName) -> bool:
        """Return whether a signature has another name only, or another one its digest."""
        one, other = self.old.signatures.get(old), self.new.signatures.get(new)
        if self.renamed.get(old, old) == new or one is None or other is None:
            return self.renamed.get(old, old) == new
        return self.old.digest(one) == self.new.digest(other)


def _types_of(function: TecsFunction) -> Iterator[CType]:
    yield function.returns
    for parameter in function.parameters:
        yield parameter.type


@dataclass(frozen=True, slots=True)
class _Types:
    """Compares types; `names` are new names of structs, `reported` new structs with changes.

    If `reported` is None, changes of structs are reported elsewhere.
    """

    old: Octets
    new: Octets
    names: Names
    reported: frozenset[ScopedName] | None = None

    def alike(self, old: CType, new: CType) -> bool:
        """Return whether values have equal octets, or their structs' changes are reported."""
        if self.old.of(old) == self.new.of(new):
            return True
        if named(old, self.names) != named(new, {}):
            return False
        return self.reported is None or not self.reported.isdisjoint(
            structs_in(new, self.new.structs)
        )


def compare_signatures(
    old: Version, new: Version, sides: TecsSides | None = None
) -> Iterator[Change]:
    """Yield the changes of signatures, structs, typedefs, enums and constants."""
    sides = sides or TecsSides(old, new)
    before, after = sides.old, sides.new
    structs = matching(before.structs, after.structs, before.members, after.members)
    names = {a.name: b.name for a, b in (*structs.pairs, *structs.renamed)}
    types = _Types(before.everywhere, after.everywhere, names)
    yield from item_changes(_STRUCTS, structs, attrgetter("scoped"))
    reported: set[ScopedName] = set()
    for one, other in (*structs.pairs, *structs.renamed):
        for each in _struct(one, other, types):
            if each.wires:
                reported.add(other.name)
            yield each
    yield from _types(old, new, types)
    digests = {after.digest(each) for each in sides.found.added}
    for signature in sides.found.removed:
        text = f"signature {signature.scoped} is removed"
        wires = () if before.digest(signature) in digests else None
        yield change(
            *(kinds.SIGNATURE_REMOVED, signature.scoped, text, signature.span, None),
            wires=wires,
        )
    for signature in sides.found.added:
        text = f"signature {signature.scoped} is added"
        yield change(
            kinds.SIGNATURE_ADDED, signature.scoped, text, None, signature.span
        )
    for gone, come in sides.found.renamed:
        text = f"signature {come.scoped} was called {gone.scoped}"
        yield change(kinds.SIGNATURE_RENAMED, come.scoped, text, gone.span, come.span)
    for gone, come in (*sides.found.pairs, *sides.found.renamed):
        octets = before.octets(gone), after.octets(come)
        compared = _Types(*octets, names, frozenset(reported))
        yield from _Signatures(gone, come, compared).compare()


def _types(old: Version, new: Version, types: _Types) -> Iterator[Change]:
    """Yield the changes of typedefs, enums and constants."""
    typedefs = matching(declared(old, TecsTypedef), declared(new, TecsTypedef))
    for one, other in typedefs.pairs:
        if not types.alike(one.type, other.type):
            text = f"typedef {other.scoped} is {other.type}, was {one.type}"
            yield change(kinds.TYPEDEF, other.scoped, text, one.span, other.span)
    enums = matching(declared(old, TecsEnum), declared(new, TecsEnum))
    for before, after in enums.pairs:
        if (before.members, before.bits) != (after.members, after.bits):
            text = f"enum {after.scoped} has other names, numbers or bits"
            yield change(kinds.ENUM, after.scoped, text, before.span, after.span)
    constants = matching(declared(old, TecsConst), declared(new, TecsConst))
    for first, second in constants.pairs:
        if first.value != second.value or not types.alike(first.type, second.type):
            text = f"constant {second.scoped} is {second.value}, was {first.value}"
            yield change(kinds.CONST, second.scoped, text, first.span, second.span)
    others: tuple[Matching[ScopedName, Any], ...] = (typedefs, enums, constants)
    for found in others:
        yield from item_changes(_OTHERS, found, attrgetter("scoped"))


_Part = TypeVar("_Part", TecsMember, TecsParameter)


def _renamed(
    old: Sequence[_Part], new: Sequence[_Part], types: _Types
) -> dict[str, str]:
    """Return the new names of parts with unchanged place and type, by old name."""
    before, after = {p.name for p in old}, {p.name for p in new}
    return {
        a.name: b.name
        for a, b in zip(old, new, strict=False)
        if a.name not in after and b.name not in before and types.alike(a.type, b.type)
    }


def _struct(old: TecsStruct, new: TecsStruct, types: _Types) -> Iterator[Change]:
    renamed = _renamed(old.members, new.members, types)
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
        if not types.alike(one.type, member.type):
            text = f"member {name} has the type {member.type}, had {one.type}"
            yield change(kinds.STRUCT_MEMBER_TYPE, name, text, *spans)
        if _sizes_text(one.sizes, renamed) != _sizes_text(member.sizes, {}):
            text = f"member {name} has other size specifiers"
            yield change(kinds.STRUCT_MEMBER_SIZES, name, text, *spans)
    if is_reordered([*before], [*after]):
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
    def __init__(self, old: Signature, new: Signature, types: _Types) -> None:
        self._old, self._new, self._types = old, new, types

    def compare(self) -> Iterator[Change]:
        old, new = self._old, self._new
        spans = (old.span, new.span)
        if (old.context, old.callback) != (new.context, new.callback):
            text = f"signature {new.scoped} has another context or callback"
            yield change(kinds.SIGNATURE_CONTEXT, new.scoped, text, *spans)
        if old.deviate != new.deviate:
            text = f"signature {new.scoped} is {'' if new.deviate else 'no longer '}deviate"
            yield change(kinds.SIGNATURE_DEVIATE, new.scoped, text, *spans)
        found = matching(
            by_name(old.functions),
            by_name(new.functions),
            self._types.old.function,
            self._types.new.function,
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
        # An error code as result omits the outs.
        errors = is_error_code(old.returns), is_error_code(new.returns)
        alike = errors[0] == errors[1] and self._types.alike(old.returns, new.returns)
        if not alike or str(old.returns) != str(new.returns):
            text = f"function {name} returns {new.returns}, did {old.returns}"
            kind = kinds.PARAMETER_ALIAS if alike else kinds.FUNCTION_RESULT
            yield change(kind, name, text, *spans)
        renamed = _renamed(old.parameters, new.parameters, self._types)
        before = {renamed.get(p.name, p.name): p for p in old.parameters}
        after = {p.name: p for p in new.parameters}
        yield from part_changes(
            _PARAMETERS, kinds.PARAMETERS_REORDERED, before, after, name, spans
        )
        for key, parameter in after.items():
            if key in before:
                yield from self._parameter(
                    before[key], parameter, f"{name}({key})", renamed
                )

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
        alike = self._types.alike(old.type, new.type)
        if not alike or str(old.type) != str(new.type):
            text = f"parameter {name} has the type {new.type}, had {old.type}"
            kind = kinds.PARAMETER_ALIAS if alike else kinds.PARAMETER_TYPE
            yield change(kind, name, text, *spans)
        yield from fact_changes(_PARAMETER_FACTS, old, new, name, spans, "parameter")
        yield from _sizes(old.sizes, new.sizes, name, spans, renamed)

    def _sub(self, function: TecsFunction) -> str:
        return f"{self._new.scoped}.{function.name}"


def _sizes(
    old: Sizes,
    new: Sizes,
    name: str,
    spans: tuple[Span, Span],
    renamed: Mapping[str, str],
) -> Iterator[Change]:
    before, after = _lengths(old, renamed), _lengths(new, {})
    for key, was, now in differing(before, after):
        text = f"parameter {name} has {key} {now}, had {was}"
        yield change(_LENGTHS[key], name, text, *spans)
    if old.max_size != new.max_size:
        lowered = new.max_size is not None and (
            old.max_size is None or new.max_size < old.max_size
        )
        kind = kinds.MAX_SIZE_LOWERED if lowered else kinds.MAX_SIZE_RAISED
        text = f"parameter {name} holds at most {new.max_size}, did {old.max_size}"
        yield change(kind, name, text, *spans)


def _lengths(sizes: Sizes, renamed: Mapping[str, str]) -> dict[str, str]:
    lengths = {key: length_text(getattr(sizes, key), renamed) for key in _LENGTHS}
    return lengths | {"string": "unsized"} if sizes.unsized_string else lengths
