"""Compares structs and exceptions member by member, matching as each encoding's readers do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    Declaration,
    ExceptionDecl,
    Extensibility,
    Member,
    Struct,
    Type,
)
from rtgen.tools.diff.changes import Break, Kind, Wire
from rtgen.tools.diff.kinds import types as kinds
from rtgen.tools.diff.member_facts import member_facts
from rtgen.tools.diff.type_expressions import (
    ENCODINGS,
    NO_WIRES,
    Pair,
    TypeExpressions,
    Verdict,
)

XCDR = frozenset((Wire.XCDR1, Wire.XCDR2))
ONLY_XCDR1 = frozenset((Wire.XCDR1,))


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """A change of a type, before its context is known.

    `top` are the encodings that break if the type is the top-level one, `nested` those inside other
    types, `other` what else breaks. `replaced` adds the encodings that break between two
    declarations. `own`: the change is in the compared declaration, not in its base.
    """

    kind: Kind
    subject: str
    message: str
    old: Span | None
    new: Span | None
    top: frozenset[Wire] = NO_WIRES
    nested: frozenset[Wire] = NO_WIRES
    other: frozenset[Wire] = NO_WIRES
    replaced: Pair | None = None
    breaks: tuple[Break, ...] | None = None
    own: bool = True

    @property
    def key(self) -> tuple[str, Span | None, Span | None]:
        """Identifies the change, independently of the type through which it was found."""
        return (self.subject, self.old, self.new)


@dataclass(slots=True)
class Compared:
    """The changes between two declarations, and the pairs of declarations inside them."""

    found: list[Found] = field(default_factory=list)
    pairs: set[Pair] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class Field:
    """A member, possibly inherited, with its id; `owner` is the scoped name of its struct."""

    name: str
    type: Type
    optional: bool
    id: int
    key: bool
    must_understand: bool
    member: Member
    owner: str


@dataclass(frozen=True, slots=True)
class StructSide:
    """A struct of one version with all its members."""

    declaration: Struct | ExceptionDecl
    extensibility: Extensibility
    fields: tuple[Field, ...]

    @property
    def span(self) -> Span:
        """The place of its name."""
        return self.declaration.span


def compare_structs(
    old: StructSide, new: StructSide, types: TypeExpressions
) -> Compared:
    """Return the changes of a struct or exception."""
    return _Structs(old, new, types).compare()


class _Structs:
    def __init__(
        self, old: StructSide, new: StructSide, types: TypeExpressions
    ) -> None:
        self._old, self._new, self._types = old, new, types
        self._result = Compared()
        both = {old.extensibility, new.extensibility}
        self._mutable = both == {Extensibility.MUTABLE}
        self._appendable = both == {Extensibility.APPENDABLE}
        self._subject = new.declaration.scoped

    def compare(self) -> Compared:
        self._result.found += self._headers()
        names = self._renamed()
        before = [names.get(f.name, f.name) for f in self._old.fields]
        after = {f.name: i for i, f in enumerate(self._new.fields)}
        common = [(i, after[name]) for i, name in enumerate(before) if name in after]
        gone = [i for i, name in enumerate(before) if name not in after]
        come = [j for j, f in enumerate(self._new.fields) if f.name not in before]
        self._unpaired(gone, come, common)
        self._order(common)
        for i, j in common:
            self._member(self._old.fields[i], self._new.fields[j])
        return self._result

    def _headers(self) -> Iterator[Found]:
        old, new = self._old.extensibility, self._new.extensibility
        if old is not new:
            mutable = Extensibility.MUTABLE in (old, new)
            wires = ENCODINGS if mutable else frozenset((Wire.XCDR2,))
            yield Found(
                kind=kinds.EXTENSIBILITY,
                subject=self._subject,
                message=f"{self._subject} is {new}, was {old}",
                old=self._old.span,
                new=self._new.span,
                top=wires,
                nested=wires,
            )

    def _renamed(self) -> dict[str, str]:
        """Return the new names of renamed members, by old name."""
        old, new = self._old.fields, self._new.fields
        gone = {f.name for f in old} - {f.name for f in new}
        come = {f.name for f in new} - {f.name for f in old}
        if self._mutable:
            by_id = {f.id: f for f in new}
            candidates = [(f, by_id[f.id]) for f in old if f.id in by_id]
        else:
            candidates = list(zip(old, new, strict=False))
        return {
            a.name: b.name
            for a, b in candidates
            if a.name in gone and b.name in come and self._alike(a, b)
        }

    def _alike(self, old: Field, new: Field) -> bool:
        verdict = self._types.compare(old.type, new.type)
        return verdict.keeps_octets and old.optional == new.optional

    def _unpaired(
        self,
        gone: Sequence[int],
        come: Sequence[int],
        common: Sequence[tuple[int, int]],
    ) -> None:
        """Compare members that are in only one version."""
        old, new = self._old.fields, self._new.fields
        last_old = max((i for i, _ in common), default=-1)
        last_new = max((j for _, j in common), default=-1)
        straight = all(i == j for i, j in common)
        one_sided = not (gone and come)
        reused = {old[i].id for i in gone} & {new[j].id for j in come}
        for i in gone:
            member = old[i]
            at_end = straight and one_sided and i > last_old
            top, nested = self._missing(member, at_end, reused)
            self._report(
                kinds.MEMBER_REMOVED,
                member,
                f"member {_named(member)} is removed",
                member.member.span,
                None,
                (top, nested),
            )
        for j in come:
            member = new[j]
            at_end = straight and one_sided and j > last_new
            top, nested = self._missing(member, at_end, reused)
            later = [
                f for f in new[j + 1 :] if f.name not in {new[k].name for k in come}
            ]
            kind, where = kinds.MEMBER_ADDED, ""
            if self._mutable and member.id in reused:
                kind, where = (
                    kinds.MEMBER_ID_REUSED,
                    f" with the id {member.id} of a removed one",
                )
            elif later:
                kind, where = kinds.MEMBER_INSERTED, f" before {later[0].name}"
            self._report(
                kind,
                member,
                f"member {_named(member)} is added{where}",
                None,
                member.member.span,
                (top, nested),
            )

    def _missing(
        self, member: Field, at_end: bool, reused: set[int]
    ) -> tuple[frozenset[Wire], frozenset[Wire]]:
        """Return what breaks if one version does not have the member: top-level, and nested."""
        if self._mutable:
            needed = member.must_understand or member.key or member.id in reused
            wires = XCDR if needed else NO_WIRES
            return wires, wires
        if self._appendable and at_end:
            classic = frozenset((Wire.CDR,))
            return classic, classic | ONLY_XCDR1
        return ENCODINGS, ENCODINGS

    def _order(self, common: Sequence[tuple[int, int]]) -> None:
        places = [j for _, j in common]
        if places != sorted(places):
            wires = NO_WIRES if self._mutable else ENCODINGS
            self._result.found.append(
                Found(
                    kind=kinds.MEMBERS_REORDERED,
                    subject=self._subject,
                    message=f"the members of {self._subject} are in another order",
                    old=self._old.span,
                    new=self._new.span,
                    top=wires,
                    nested=wires,
                )
            )

    def _member(self, old: Field, new: Field) -> None:
        spans = (old.member.span, new.member.span)
        if old.name != new.name:
            text = f"member {_named(new)} was called {old.name}"
            self._report(kinds.MEMBER_RENAMED, new, text, *spans)
        verdict = self._types.compare(old.type, new.type)
        self._result.pairs |= verdict.pairs
        if verdict.kind is not None:
            self._typed(old, new, verdict)
        if old.optional != new.optional:
            now = "optional" if new.optional else "required"
            text = f"member {_named(new)} is {now} now"
            wires = XCDR if self._mutable else ENCODINGS
            self._report(kinds.OPTIONAL, new, text, *spans, (wires, wires))
        if old.id != new.id and not self._positional_id(old, new):
            text = f"member {_named(new)} has the id {new.id}, had {old.id}"
            wires = NO_WIRES
            if self._mutable:
                wires = XCDR
            elif old.optional and new.optional:
                wires = ONLY_XCDR1
            self._report(kinds.MEMBER_ID, new, text, *spans, (wires, wires))
        if old.key != new.key:
            verb = "joins" if new.key else "leaves"
            text = f"member {_named(new)} {verb} the key"
            self._report(kinds.KEY, new, text, *spans, other=frozenset((Wire.KEY,)))
        for kind, text in member_facts(old.member, new.member, _named(new)):
            self._report(kind, new, text, *spans)

    def _positional_id(self, old: Field, new: Field) -> bool:
        """Return whether the ids depend on positions only, and no reader uses them."""
        written = old.member.id is not None or new.member.id is not None
        return not written and not self._mutable and not (old.optional and new.optional)

    def _typed(self, old: Field, new: Field, verdict: Verdict) -> None:
        kind = verdict.kind
        assert kind is not None
        text = f"member {_named(new)} has the type {new.type}, had {old.type}"
        encodings = verdict.wires & ENCODINGS
        self._report(
            kind,
            new,
            text,
            old.member.span,
            new.member.span,
            (encodings, encodings),
            other=verdict.wires - ENCODINGS,
            replaced=verdict.replaced,
        )

    def _report(
        self,
        kind: Kind,
        member: Field,
        message: str,
        old: Span | None,
        new: Span | None,
        wires: tuple[frozenset[Wire], frozenset[Wire]] = (NO_WIRES, NO_WIRES),
        other: frozenset[Wire] = NO_WIRES,
        replaced: Pair | None = None,
    ) -> None:
        owners = (self._old.declaration.scoped, self._new.declaration.scoped)
        self._result.found.append(
            Found(
                kind=kind,
                subject=f"{member.owner}.{member.name}",
                message=message,
                old=old,
                new=new,
                top=wires[0],
                nested=wires[1],
                other=other,
                replaced=replaced,
                own=member.owner in owners,
            )
        )


def _named(member: Field) -> str:
    return f"{member.owner}.{member.name}"


def struct_side(
    declaration: Struct | ExceptionDecl,
    find: Callable[[tuple[str, ...]], Declaration],
    extensibility: Extensibility,
    is_unset: Callable[[Declaration, Member], bool],
) -> StructSide:
    """Return the struct with all members and their ids, inherited ones first."""
    chain = [declaration]
    while isinstance(chain[-1], Struct) and chain[-1].base is not None:
        base = find(chain[-1].base)
        assert isinstance(base, Struct), "the front end saw to it"
        chain.append(base)
    fields: list[Field] = []
    following = 0
    for each in reversed(chain):
        for member in each.members:
            number = following if member.id is None else member.id
            following = number + 1
            fields.append(
                Field(
                    name=member.name,
                    type=member.type,
                    optional=member.optional or is_unset(each, member),
                    id=number,
                    key=member.key,
                    must_understand=member.must_understand,
                    member=member,
                    owner=each.scoped,
                )
            )
    return StructSide(declaration, extensibility, tuple(fields))
