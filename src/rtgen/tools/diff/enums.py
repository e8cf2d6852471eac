"""Compares enums, bitmasks and bitsets: the number or bit of each name."""

from __future__ import annotations

from collections.abc import Container, Iterator

from rtgen.compiler.model import (
    Bitmask,
    Bitset,
    Enum,
    Enumerator,
    Model,
    Primitive,
    PrimitiveType,
)
from rtgen.tools.diff.changes import Kind, Wire
from rtgen.tools.diff.kinds import types as kinds
from rtgen.tools.diff.member_facts import defaults
from rtgen.tools.diff.structs import XCDR, Compared, Found
from rtgen.tools.diff.type_expressions import ENCODINGS, NO_WIRES


def compare_enums(old: Enum, new: Enum) -> Compared:
    """Return the changes of an enum; in classic CDR it always has 4 octets."""
    name = new.scoped
    result = Compared()
    if old.bound != new.bound:
        wires = XCDR if _octets(old.bound) != _octets(new.bound) else NO_WIRES
        result.found.append(_bound(old, new, wires))
    renamed = renamed_members(old, new)
    after = {m.name: m for m in new.members}
    before = {renamed.get(m.name, m.name): m for m in old.members}
    for key, member in before.items():
        subject = f"{name}.{member.name}"
        if key not in after:
            text = f"enumerator {subject} ({member.value}) is removed"
            result.found.append(
                _found(kinds.ENUMERATOR_REMOVED, subject, text, member, None, ENCODINGS)
            )
            continue
        other = after[key]
        subject = f"{name}.{other.name}"
        if other.name != member.name:
            text = f"enumerator {subject} was called {member.name}"
            result.found.append(
                _found(kinds.ENUMERATOR_RENAMED, subject, text, member, other)
            )
        if other.value != member.value:
            text = f"enumerator {subject} is {other.value}, was {member.value}"
            result.found.append(
                _found(kinds.ENUMERATOR_NUMBER, subject, text, member, other, ENCODINGS)
            )
    for key, member in after.items():
        if key not in before:
            subject = f"{name}.{key}"
            text = f"enumerator {subject} ({member.value}) is added"
            result.found.append(
                _found(kinds.ENUMERATOR_ADDED, subject, text, None, member, ENCODINGS)
            )
    return result


def compare_bitmasks(old: Bitmask, new: Bitmask) -> Compared:
    """Return the changes of a bitmask, whose readers keep unknown flags."""
    name = new.scoped
    result = Compared()
    if old.bound != new.bound:
        result.found.append(_bound(old, new, ENCODINGS))
    renamed = renamed_members(old, new)
    after = {m.name: m for m in new.members}
    before = {renamed.get(m.name, m.name): m for m in old.members}
    taken = {m.value for m in after.values()}
    for key, member in before.items():
        subject = f"{name}.{member.name}"
        if key not in after:
            text = f"flag {subject} is removed"
            wires = ENCODINGS if member.value in taken else NO_WIRES
            result.found.append(
                _found(kinds.FLAG_REMOVED, subject, text, member, None, wires)
            )
            continue
        other = after[key]
        subject = f"{name}.{other.name}"
        if other.name != member.name:
            text = f"flag {subject} was called {member.name}"
            result.found.append(
                _found(kinds.FLAG_RENAMED, subject, text, member, other)
            )
        if other.value != member.value:
            text = f"flag {subject} is bit {other.value}, was {member.value}"
            result.found.append(
                _found(kinds.FLAG_POSITION, subject, text, member, other, ENCODINGS)
            )
    held = {m.value for m in old.members}
    for key, member in after.items():
        if key not in before:
            subject = f"{name}.{key}"
            text = f"flag {subject} is added at bit {member.value}"
            wires = ENCODINGS if member.value in held else NO_WIRES
            result.found.append(
                _found(kinds.FLAG_ADDED, subject, text, None, member, wires)
            )
    return result


def compare_bitsets(old: Bitset, new: Bitset, before: Model, after: Model) -> Compared:
    """Return the changes of a bitset: its fields, their widths and places."""
    result = Compared()
    first, second = fields_of(old, before), fields_of(new, after)
    if first != second:
        # Values hold no names, but a field that moves is found at its old place.
        moved = {name for name, *_ in first} & {name for name, *_ in second} - {None}
        same = [f[1:] for f in first] == [f[1:] for f in second]
        wires = ENCODINGS
        if same and _places(first, moved) == _places(second, moved):
            wires = NO_WIRES
        text = f"{new.scoped} has the fields {_shown(second)}, had {_shown(first)}"
        result.found.append(
            Found(
                kind=kinds.BITFIELDS,
                subject=new.scoped,
                message=text,
                old=old.span,
                new=new.span,
                top=wires,
                nested=wires,
            )
        )
    fields = {field.name: field for field in old.members if field.name}
    for field in new.members:
        if field.name in fields:
            was, name = fields[field.name], f"{new.scoped}.{field.name}"
            result.found += (
                Found(
                    kind=kind, subject=name, message=text, old=was.span, new=field.span
                )
                for kind, text in defaults(was, field, f"field {name}")
            )
    return result


def fields_of(bitset: Bitset, model: Model) -> list[tuple[str | None, int, bool]]:
    """Return the fields with their bits and whether they are signed, those of bases first."""
    found: list[tuple[str | None, int, bool]] = []
    if bitset.base is not None:
        base = model.find(bitset.base)
        assert isinstance(base, Bitset), "the front end saw to it"
        found = fields_of(base, model)
    for member in bitset.members:
        type_ = None if member.type is None else model.unalias(member.type)
        signed = isinstance(type_, PrimitiveType) and type_.kind in _SIGNED
        found.append((member.name, member.bits, signed))
    return found


def _places(
    fields: list[tuple[str | None, int, bool]], names: Container[str | None]
) -> list[str | None]:
    """Return the fields with these names, in the places of all."""
    return [name if name in names else None for name, *_ in fields]


_SIGNED = (Primitive.INT8, Primitive.SHORT, Primitive.LONG, Primitive.LONG_LONG)


def _shown(fields: list[tuple[str | None, int, bool]]) -> str:
    return ", ".join(f"{name or 'a gap'}:{bits}" for name, bits, _ in fields)


def renamed_members(old: Enum | Bitmask, new: Enum | Bitmask) -> dict[str, str]:
    """Return the new names of members whose number is unchanged, by old name."""
    gone = {m.name for m in old.members} - {m.name for m in new.members}
    come = {m.value: m.name for m in _come(old, new)}
    return {
        m.name: come[m.value] for m in old.members if m.name in gone and m.value in come
    }


def _come(old: Enum | Bitmask, new: Enum | Bitmask) -> Iterator[Enumerator]:
    known = {m.name for m in old.members}
    return (m for m in new.members if m.name not in known)


def _bound(old: Enum | Bitmask, new: Enum | Bitmask, wires: frozenset[Wire]) -> Found:
    return Found(
        kind=kinds.BIT_BOUND,
        subject=new.scoped,
        message=f"{new.scoped} has a bit bound of {new.bound}, had {old.bound}",
        old=old.span,
        new=new.span,
        top=wires,
        nested=wires,
    )


def _found(
    kind: Kind,
    subject: str,
    message: str,
    old: Enumerator | None,
    new: Enumerator | None,
    wires: frozenset[Wire] = NO_WIRES,
) -> Found:
    return Found(
        kind=kind,
        subject=subject,
        message=message,
        old=None if old is None else old.span,
        new=None if new is None else new.span,
        top=wires,
        nested=wires,
    )


def _octets(bound: int) -> int:
    """Return the size of a value in XCDR."""
    return next(size for size in (1, 2, 4, 8) if bound <= 8 * size)
