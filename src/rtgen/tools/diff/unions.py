"""Compares unions: the branch that each discriminator selects, before and after."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    Case,
    ConstantValue,
    Enum,
    EnumeratorName,
    Extensibility,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Union,
)
from rtgen.tools.diff.changes import Kind, Wire
from rtgen.tools.diff.enums import renamed_members
from rtgen.tools.diff.kinds import types as kinds
from rtgen.tools.diff.member_facts import member_facts, value_text
from rtgen.tools.diff.structs import XCDR, Compared, Found
from rtgen.tools.diff.type_expressions import (
    ENCODINGS,
    NO_WIRES,
    TypeExpressions,
    Verdict,
)

_DEFAULT = "default"

Label = bool | int | str


@dataclass(frozen=True, slots=True)
class UnionSide:
    """A union of one version: its branches by label, with their ids."""

    union: Union
    extensibility: Extensibility
    labels: Mapping[Label, Case]
    default: Case | None
    ids: Mapping[str, int]

    def selects(self, label: Label) -> Case | None:
        """Return the branch of a discriminator."""
        return (
            self.default if label == _DEFAULT else self.labels.get(label, self.default)
        )


def union_side(union: Union, model: Model, extensibility: Extensibility) -> UnionSide:
    """Return the union with its labels as numbers, texts or names of enumerators."""
    labels: dict[Label, Case] = {}
    ids = {}
    following = 1
    for case in union.cases:
        for label in case.labels:
            labels[_plain(label)] = case
        ids[case.name] = following = following if case.id is None else case.id
        following += 1
    default = next((c for c in union.cases if c.default), None)
    universe = _universe(union, model)
    if universe is not None and universe <= labels.keys():
        default = None
    return UnionSide(union, extensibility, labels, default, ids)


def _plain(label: ConstantValue) -> Label:
    if isinstance(label, EnumeratorName):
        return f"::{label.name[-1]}"
    return label if isinstance(label, bool | int) else str(label)


def _universe(union: Union, model: Model) -> set[Label] | None:
    """Return all discriminators, if they can be enumerated."""
    type_ = model.unalias(union.switch)
    if isinstance(type_, NamedType):
        declaration = model.find(type_.name)
        if isinstance(declaration, Enum):
            return {f"::{m.name}" for m in declaration.members}
    if type_ == PrimitiveType(Primitive.BOOLEAN):
        return {False, True}
    return None


def compare_unions(old: UnionSide, new: UnionSide, types: TypeExpressions) -> Compared:
    """Return the changes of a union."""
    return _Unions(old, new, types).compare()


def _with_labels_of(
    old: UnionSide, new: UnionSide, types: TypeExpressions
) -> UnionSide:
    """Return the old union with the new names of renamed enumerators in its labels."""
    enums = types.enums(old.union.switch, new.union.switch)
    names = renamed_members(*enums) if enums else {}
    if not names:
        return old

    def named(label: ConstantValue) -> ConstantValue:
        if not isinstance(label, EnumeratorName):
            return label
        last = label.name[-1]
        return EnumeratorName((*label.name[:-1], names.get(last, last)))

    cases = {
        c.name: replace(c, labels=tuple(map(named, c.labels))) for c in old.union.cases
    }
    return UnionSide(
        replace(old.union, cases=tuple(cases.values())),
        old.extensibility,
        {_plain(each): c for c in cases.values() for each in c.labels},
        None if old.default is None else cases[old.default.name],
        old.ids,
    )


class _Unions:
    def __init__(self, old: UnionSide, new: UnionSide, types: TypeExpressions) -> None:
        old = _with_labels_of(old, new, types)
        self._old, self._new, self._types = old, new, types
        self._name = new.union.scoped
        self._result = Compared()
        both = {old.extensibility, new.extensibility}
        self._mutable = both == {Extensibility.MUTABLE}
        self._open = self._open_wires(both)

    @staticmethod
    def _open_wires(both: set[Extensibility]) -> frozenset[Wire]:
        """Return the encodings whose readers accept a discriminator without a branch."""
        if both == {Extensibility.MUTABLE}:
            return XCDR
        if both == {Extensibility.APPENDABLE}:
            return frozenset((Wire.XCDR2,))
        return NO_WIRES

    def compare(self) -> Compared:
        old, new = self._old, self._new
        spans = (old.union.span, new.union.span)
        if old.extensibility is not new.extensibility:
            mutable = Extensibility.MUTABLE in (old.extensibility, new.extensibility)
            wires = ENCODINGS if mutable else frozenset((Wire.XCDR2,))
            text = f"{self._name} is {new.extensibility}, was {old.extensibility}"
            self._add(kinds.EXTENSIBILITY, self._name, text, *spans, wires)
        switch = self._types.compare(old.union.switch, new.union.switch)
        self._result.pairs |= switch.pairs
        if switch.kind is not None:
            text = f"{self._name} switches on {new.union.switch}, did on {old.union.switch}"
            alias = switch.kind is kinds.MEMBER_ALIAS
            kind = kinds.MEMBER_ALIAS if alias else kinds.SWITCH
            self._add(kind, self._name, text, *spans, switch.wires, switch)
        names = self._renamed()
        before = {names.get(c.name, c.name): c for c in old.union.cases}
        after = {c.name: c for c in new.union.cases}
        for name, case in before.items():
            if name in after:
                self._case(case, after[name])
        labels = dict.fromkeys((*old.labels, *new.labels, _DEFAULT))
        moved = dict(self._moved(labels, names))
        for name, case in before.items():
            if name not in after:
                wires = self._of(case, old, moved) | self._reused(case, old, new)
                text = f"branch {self._name}.{case.name} is removed"
                self._add(
                    kinds.CASE_REMOVED, self._sub(case), text, case.span, None, wires
                )
        for name, case in after.items():
            if name not in before:
                wires = self._of(case, new, moved) | self._reused(case, new, old)
                text = f"branch {self._name}.{name} is added"
                self._add(
                    kinds.CASE_ADDED, self._sub(case), text, None, case.span, wires
                )
            else:
                self._labels(before[name], case, moved)
        return self._result

    def _renamed(self) -> dict[str, str]:
        """Return the new names of branches with unchanged labels, id and type, by old name."""
        old, new = self._old, self._new
        gone = {c.name for c in old.union.cases} - {c.name for c in new.union.cases}
        found = {}
        for case in old.union.cases:
            if case.name not in gone:
                continue
            for other in new.union.cases:
                same = (
                    other.name not in {c.name for c in old.union.cases}
                    and set(map(_plain, case.labels)) == set(map(_plain, other.labels))
                    and case.default == other.default
                    and (not self._mutable or old.ids[case.name] == new.ids[other.name])
                )
                if same and self._types.compare(case.type, other.type).keeps_octets:
                    found[case.name] = other.name
        return found

    def _moved(
        self, labels: Mapping[Label, None], names: Mapping[str, str]
    ) -> Iterator[tuple[Label, frozenset[Wire]]]:
        """Yield the discriminators that select another branch, and what that breaks."""
        for label in labels:
            old, new = self._old.selects(label), self._new.selects(label)
            if old is None and new is None:
                continue
            if old is None or new is None:
                yield label, ENCODINGS - self._open
            elif names.get(old.name, old.name) != new.name:
                yield label, ENCODINGS

    def _of(
        self, case: Case, side: UnionSide, moved: Mapping[Label, frozenset[Wire]]
    ) -> frozenset[Wire]:
        """Return what breaks by the moved discriminators that select the branch."""
        wires = (w for label, w in moved.items() if side.selects(label) is case)
        return frozenset().union(*wires)

    def _reused(self, case: Case, side: UnionSide, other: UnionSide) -> frozenset[Wire]:
        """Return what breaks if the other version has another branch with the id."""
        if not self._mutable:
            return NO_WIRES
        number = side.ids[case.name]
        for each in other.union.cases:
            if other.ids[each.name] == number:
                first, second = (case, each) if side is self._old else (each, case)
                verdict = self._types.compare(first.type, second.type)
                return XCDR if verdict.kind is not None else NO_WIRES
        return NO_WIRES

    def _labels(
        self, old: Case, new: Case, moved: Mapping[Label, frozenset[Wire]]
    ) -> None:
        wires = self._of(old, self._old, moved) | self._of(new, self._new, moved)
        before, after = ({_plain(x) for x in c.labels} for c in (old, new))
        name, spans = self._sub(new), (old.span, new.span)
        if before != after:
            lost = ", ".join(_label(x) for x in old.labels if _plain(x) not in after)
            more = ", ".join(_label(x) for x in new.labels if _plain(x) not in before)
            parts = [f"gains {more}"] * bool(more) + [f"loses {lost}"] * bool(lost)
            text = f"branch {name} {' and '.join(parts)}"
            self._add(kinds.CASE_LABELS, name, text, *spans, wires)
        elif old.default != new.default:
            now = "is" if new.default else "is no longer"
            text = f"branch {name} {now} the default"
            self._add(kinds.CASE_DEFAULT, name, text, *spans, wires)

    def _case(self, old: Case, new: Case) -> None:
        name, spans = self._sub(new), (old.span, new.span)
        if old.name != new.name:
            text = f"branch {name} was called {old.name}"
            self._add(kinds.CASE_RENAMED, name, text, *spans)
        verdict = self._types.compare(old.type, new.type)
        self._result.pairs |= verdict.pairs
        if verdict.kind is not None:
            text = f"branch {name} has the type {new.type}, had {old.type}"
            self._add(verdict.kind, name, text, *spans, verdict.wires, verdict)
        before, after = self._old.ids[old.name], self._new.ids[new.name]
        written = old.id is not None or new.id is not None
        if before != after and (self._mutable or written):
            text = f"branch {name} has the id {after}, had {before}"
            wires = XCDR if self._mutable else NO_WIRES
            self._add(kinds.CASE_ID, name, text, *spans, wires)
        for kind, text in member_facts(old, new, f"branch {name}"):
            self._add(kind, name, text, *spans)

    def _sub(self, case: Case) -> str:
        return f"{self._name}.{case.name}"

    def _add(
        self,
        kind: Kind,
        subject: str,
        message: str,
        old: Span | None,
        new: Span | None,
        wires: frozenset[Wire] = NO_WIRES,
        verdict: Verdict | None = None,
    ) -> None:
        encodings = wires & ENCODINGS
        self._result.found.append(
            Found(
                kind=kind,
                subject=subject,
                message=message,
                old=old,
                new=new,
                top=encodings,
                nested=encodings,
                other=wires - ENCODINGS,
                replaced=None if verdict is None else verdict.replaced,
            )
        )


def _label(value: ConstantValue) -> str:
    return value_text(value)
