"""Compares the types of two versions, and determines which types each change breaks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from rtgen.compiler.inspection.facts import kind_of
from rtgen.compiler.matching import matching
from rtgen.compiler.model import (
    Bitmask,
    Bitset,
    Const,
    Declaration,
    Enum,
    ExceptionDecl,
    Extensibility,
    Native,
    ScopedName,
    Struct,
    Typedef,
    Union,
)
from rtgen.tools.diff.changes import Change, Kind, User, Wire, change, in_wire_order
from rtgen.tools.diff.enums import compare_bitmasks, compare_bitsets, compare_enums
from rtgen.tools.diff.kinds import types as kinds
from rtgen.tools.diff.member_facts import value_facts, value_text
from rtgen.tools.diff.structs import (
    Compared,
    Found,
    StructSide,
    compare_structs,
    struct_side,
)
from rtgen.tools.diff.type_expressions import (
    COMPOSITE,
    ENCODINGS,
    NO_WIRES,
    Pair,
    TypeExpressions,
    shape,
)
from rtgen.tools.diff.unions import UnionSide, compare_unions, union_side
from rtgen.tools.diff.versions import Version

_TYPES = (*COMPOSITE, Typedef, Const, Native)

Broken = Mapping[ScopedName, frozenset[Wire]]
"""Types of the new version whose values are not read as equal, with the encodings concerned."""


@dataclass(slots=True)
class TypeChanges:
    """The changes of types; `names` maps old declarations to new ones, `broken` is their sum.

    `between` returns what breaks if a value of one declaration is read as one of another.
    """

    changes: list[Change] = field(default_factory=list)
    names: dict[ScopedName, ScopedName] = field(default_factory=dict)
    broken: dict[ScopedName, frozenset[Wire]] = field(default_factory=dict)
    between: Callable[[Pair], frozenset[Wire]] = field(default=lambda _: NO_WIRES)


def compare_declarations(old: Version, new: Version) -> TypeChanges:
    """Compare structs, unions, enums, bit sets, typedefs, exceptions and constants."""
    return _Declarations(old, new).compare()


class _Declarations:
    def __init__(self, old: Version, new: Version) -> None:
        self._old, self._new = old, new
        self._result = TypeChanges()
        self._matched: list[tuple[Declaration, Declaration]] = []
        self._compared: dict[Pair, Compared] = {}

    def compare(self) -> TypeChanges:
        self._match()
        types = TypeExpressions(self._old.model, self._new.model, self._result.names)
        for old, new in self._matched:
            self._facts(old, new)
            if isinstance(old, COMPOSITE) and type(old) is type(new):
                self._ensure((old.name, new.name), types)
            elif type(old) is type(new):
                self._other(old, new, types)
        _Assembly(self._old, self._new, self._compared, self._result).run()

        def between(pair: Pair) -> frozenset[Wire]:
            self._ensure(pair, types)
            return self._total(pair)

        self._result.between = between
        return self._result

    def _match(self) -> None:
        """Fill `names`: types by name, renamed ones by shape, types that they use first."""
        old = {n: d for n, d in self._old.written.items() if isinstance(d, _TYPES)}
        new = {n: d for n, d in self._new.written.items() if isinstance(d, _TYPES)}
        names = self._result.names
        for declaration in self._old.model.declarations:
            if self._is_declared(declaration.name):
                names[declaration.name] = declaration.name
        while True:
            before = len(names)
            found = matching(
                old,
                new,
                lambda d: shape(d, names) if d.name in old else shape(d, {}),
            )
            for gone, come in found.renamed:
                names[gone.name] = come.name
            if len(names) == before:
                break
        self._matched = [*found.pairs, *found.renamed]
        for gone, come in found.renamed:
            text = f"{come.scoped} was called {gone.scoped}"
            self._add(kinds.TYPE_RENAMED, come.scoped, text, gone, come)
        for declaration in found.removed:
            if not isinstance(self._new.written.get(declaration.name), Declaration):
                text = f"{_word(declaration)} {declaration.scoped} is removed"
                self._add(
                    kinds.TYPE_REMOVED, declaration.scoped, text, declaration, None
                )
        for declaration in found.added:
            text = f"{_word(declaration)} {declaration.scoped} is added"
            self._add(kinds.TYPE_ADDED, declaration.scoped, text, None, declaration)

    def _is_declared(self, name: ScopedName) -> bool:
        try:
            self._new.model.find(name)
        except KeyError:
            return False
        return True

    def _add(
        self,
        kind: Kind,
        subject: str,
        text: str,
        old: Declaration | None,
        new: Declaration | None,
    ) -> None:
        self._result.changes.append(
            change(
                kind,
                subject,
                text,
                None if old is None else old.span,
                None if new is None else new.span,
            )
        )

    def _facts(self, old: Declaration, new: Declaration) -> None:
        """Compare the facts common to all declarations."""
        if type(old) is not type(new):
            text = f"{new.scoped} is declared as {_word(new)}, was as {_word(old)}"
            self._add(kinds.TYPE_KIND, new.scoped, text, old, new)
            self._result.broken[new.name] = ENCODINGS
            return
        if old.name == new.name and old.repository_id != new.repository_id:
            ids = f"{new.repository_id}, had {old.repository_id}"
            text = f"{new.scoped} has the repository id {ids}"
            self._add(kinds.REPOSITORY_ID, new.scoped, text, old, new)
        if isinstance(old, Struct | Union) and isinstance(new, Struct | Union):
            if self._old.is_xcdr2(old) != self._new.is_xcdr2(new):
                now = "XCDR2" if self._new.is_xcdr2(new) else "CDR"
                text = f"values of {new.scoped} are written in {now} by to_cdr"
                self._add(kinds.REPRESENTATION, new.scoped, text, old, new)
            if old.nested != new.nested:
                text = f"{new.scoped} is {'' if new.nested else 'no longer '}@nested"
                self._add(kinds.NESTED, new.scoped, text, old, new)
        if isinstance(old, Struct) and isinstance(new, Struct):
            base = old.base and self._result.names.get(old.base, old.base)
            if base != new.base:
                shown = "::".join(new.base) if new.base else "none"
                text = f"{new.scoped} has the base {shown}"
                self._add(kinds.BASE, new.scoped, text, old, new)
        for kind, text in value_facts(old, new, new.scoped):
            self._add(kind, new.scoped, text, old, new)

    def _other(
        self, old: Declaration, new: Declaration, types: TypeExpressions
    ) -> None:
        match old, new:
            case Typedef(), Typedef():
                verdict = types.compare(old.type, new.type)
                if verdict.kind is not None:
                    text = f"typedef {new.scoped} is {new.type}, was {old.type}"
                    wires = verdict.wires
                    if verdict.replaced:
                        self._ensure(verdict.replaced, types)
                        wires |= self._total(verdict.replaced)
                    alias = verdict.kind is kinds.MEMBER_ALIAS
                    kind = kinds.MEMBER_ALIAS if alias else kinds.TYPEDEF
                    self._result.changes.append(
                        change(kind, new.scoped, text, old.span, new.span, wires=wires)
                    )
                    if wires:
                        self._result.broken[new.name] = frozenset(wires)
            case Const(), Const():
                if old.value != new.value:
                    text = (
                        f"constant {new.scoped} is {value_text(new.value)}, "
                        f"was {value_text(old.value)}"
                    )
                    self._add(kinds.CONST_VALUE, new.scoped, text, old, new)
                elif types.compare(old.type, new.type).kind not in (
                    *(None, kinds.MEMBER_ALIAS),
                ):
                    text = (
                        f"constant {new.scoped} is of type {new.type}, was {old.type}"
                    )
                    self._add(kinds.CONST_TYPE, new.scoped, text, old, new)

    def _ensure(self, pair: Pair, types: TypeExpressions) -> None:
        """Compare a pair and the pairs reachable from it, once."""
        waiting = [pair]
        while waiting:
            each = waiting.pop()
            if each not in self._compared:
                self._compared[each] = self._parts(each, types)
                waiting += sorted(self._compared[each].pairs)

    def _total(self, pair: Pair) -> frozenset[Wire]:
        return totals(self._compared, pair)

    def _parts(self, pair: Pair, types: TypeExpressions) -> Compared:
        old, new = self._old.model.find(pair[0]), self._new.model.find(pair[1])
        match old, new:
            case (Struct() | ExceptionDecl()), (Struct() | ExceptionDecl()):
                return compare_structs(
                    _struct(old, self._old), _struct(new, self._new), types
                )
            case Union(), Union():
                return compare_unions(
                    _union(old, self._old), _union(new, self._new), types
                )
            case Enum(), Enum():
                return compare_enums(old, new)
            case Bitmask(), Bitmask():
                return compare_bitmasks(old, new)
            case Bitset(), Bitset():
                return compare_bitsets(old, new, self._old.model, self._new.model)
        raise AssertionError(pair)


def _struct(declaration: Struct | ExceptionDecl, version: Version) -> StructSide:
    extensibility = Extensibility.FINAL
    if isinstance(declaration, Struct):
        extensibility = version.representations.extensibility(declaration)
    return struct_side(
        declaration, version.model.find, extensibility, version.cdr.is_unset
    )


def _union(declaration: Union, version: Version) -> UnionSide:
    extensibility = version.representations.extensibility(declaration)
    return union_side(declaration, version.model, extensibility)


def reachable(compared: Mapping[Pair, Compared], start: Pair) -> list[Pair]:
    """Return the pairs inside a pair, itself first."""
    seen = {start: None}
    waiting = [start]
    while waiting:
        for each in sorted(compared[waiting.pop()].pairs):
            if each not in seen:
                seen[each] = None
                waiting.append(each)
    return list(seen)


def totals(compared: Mapping[Pair, Compared], start: Pair) -> frozenset[Wire]:
    """Return what breaks if values of the pair are inside other types."""
    return frozenset().union(
        *(f.nested for p in reachable(compared, start) for f in compared[p].found)
    )


class _Assembly:
    """Turns the findings about pairs into changes, with the types that they break."""

    def __init__(
        self,
        old: Version,
        new: Version,
        compared: Mapping[Pair, Compared],
        result: TypeChanges,
    ) -> None:
        self._old, self._new = old, new
        self._compared = compared
        self._result = result

    def run(self) -> None:
        wires: dict[object, dict[ScopedName, frozenset[Wire]]] = defaultdict(dict)
        roots = [p for p in self._compared if self._is_matched(p)]
        changed = {p for p, c in self._compared.items() if c.found}
        for root in roots:
            for pair in reachable(self._compared, root):
                if pair in changed:
                    for found in self._compared[pair].found:
                        broken = self._effective(root, pair, found)
                        if broken:
                            known = wires[found.key].get(root[1], NO_WIRES)
                            wires[found.key][root[1]] = known | broken
        for pair in roots:
            for found in self._compared[pair].found:
                if found.own:
                    self._report(pair, found, wires.get(found.key, {}))

    def _is_matched(self, pair: Pair) -> bool:
        return self._result.names.get(pair[0]) == pair[1]

    def _effective(self, root: Pair, pair: Pair, found: Found) -> frozenset[Wire]:
        """Return what a change inside `pair` breaks for values of `root`."""
        top, nested = found.top, found.nested
        if found.replaced is not None:
            top = nested = found.nested | totals(self._compared, found.replaced)
        wires = top if root == pair else nested
        old, new = root
        effective = set(wires & {Wire.XCDR1, Wire.XCDR2})
        headed = self._old.has_headers(old), self._new.has_headers(new)
        if headed == (True, True):
            cdr = Wire.XCDR1 in wires
        elif headed == (False, False):
            cdr = Wire.CDR in wires
        else:
            cdr = bool(top | nested)
        if cdr:
            effective.add(Wire.CDR)
        if not (self._old.has_xcdr(old) and self._new.has_xcdr(new)):
            effective -= {Wire.XCDR1, Wire.XCDR2}
        return frozenset(effective)

    def _report(
        self, pair: Pair, found: Found, broken: Mapping[ScopedName, frozenset[Wire]]
    ) -> None:
        """Add a change; the place of a missing part is that of its declaration."""
        for name, wires in broken.items():
            known = self._result.broken.get(name, NO_WIRES)
            self._result.broken[name] = known | wires
        made = change(
            found.kind,
            found.subject,
            found.message,
            found.old or self._old.model.find(pair[0]).span,
            found.new or self._new.model.find(pair[1]).span,
            wires=(*found.other, *(w for each in broken.values() for w in each)),
            breaks=found.breaks,
        )
        users = tuple(
            User("type", "::".join(name), in_wire_order(wires))
            for name, wires in sorted(broken.items())
        )
        self._result.changes.append(made._replace(users=users))


def _word(declaration: Declaration) -> str:
    kind = kind_of(declaration)
    return {"const": "constant", "native": "native type"}.get(kind, kind)
