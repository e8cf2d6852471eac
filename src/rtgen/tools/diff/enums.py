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
from rtgen.tools.diff.member_facts import value_facts
from rtgen.tools.diff.structs import XCDR, Compared, Found
from rtgen.tools.diff.type_expressions import ENCODINGS, NO_WIRES

_ENUMERATORS = (
    (kinds.ENUMERATOR_REMOVED, "enumerator {name} ({was}) is removed"),
    (kinds.ENUMERATOR_RENAMED, "enumerator {name} was called {old}"),
    (kinds.ENUMERATOR_NUMBER, "enumerator {name} is {now}, was {was}"),
    (kinds.ENUMERATOR_ADDED, "enumerator {name} ({now}) is added"),
)
_FLAGS = (
    (kinds.FLAG_REMOVED, "flag {name} is removed"),
    (kinds.FLAG_RENAMED, "flag {name} was called {old}"),
    (kinds.FLAG_POSITION, "flag {name} is bit {now}, was {was}"),
    (kinds.FLAG_ADDED, "flag {name} is added at bit {now}"),
)


def compare_enums(old: Enum, new: Enum) -> Compared:
    """Return the changes of an enum; in classic CDR it always has 4 octets."""
    result = Compared()
    if old.bound != new.bound:
        wires = XCDR if _octets(old.bound) != _octets(new.bound) else NO_WIRES
        result.found.append(_bound(old, new, wires))
    result.found += _members(old, new)
    return result


def compare_bitmasks(old: Bitmask, new: Bitmask) -> Compared:
    """Return the changes of a bitmask, whose readers keep unknown flags."""
    result = Compared()
    if old.bound != new.bound:
        result.found.append(_bound(old, new, ENCODINGS))
    result.found += _members(old, new)
    return result


def _members(old: Enum | Bitmask, new: Enum | Bitmask) -> Iterator[Found]:
    is_mask = isinstance(new, Bitmask)
    removed, renamed, moved, added = _FLAGS if is_mask else _ENUMERATORS
    names = renamed_members(old, new)
    after = {m.name: m for m in new.members}
    before = {names.get(m.name, m.name): m for m in old.members}
    taken, held = ({m.value for m in each.members} for each in (new, old))
    for key, one in before.items():
        other = after.get(key)
        if other is None:
            lost = not is_mask or one.value in taken
            yield _member_change(
                removed, new, one, None, ENCODINGS if lost else NO_WIRES
            )
            continue
        if other.name != one.name:
            yield _member_change(renamed, new, one, other, NO_WIRES)
        if other.value != one.value:
            yield _member_change(moved, new, one, other, ENCODINGS)
    for key, other in after.items():
        if key not in before:
            known = not is_mask or other.value in held
            yield _member_change(
                added, new, None, other, ENCODINGS if known else NO_WIRES
            )


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
                for kind, text in value_facts(was, field, f"field {name}")
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


def _member_change(
    sort: tuple[Kind, str],
    new_type: Enum | Bitmask,
    old: Enumerator | None,
    new: Enumerator | None,
    wires: frozenset[Wire],
) -> Found:
    kind, text = sort
    member = new or old
    assert member is not None
    name = f"{new_type.scoped}.{member.name}"
    was, now = (each and each.value for each in (old, new))
    return Found(
        kind=kind,
        subject=name,
        message=text.format(name=name, old=old and old.name, was=was, now=now),
        old=None if old is None else old.span,
        new=None if new is None else new.span,
        top=wires,
        nested=wires,
    )


def _octets(bound: int) -> int:
    """Return the size of a value in XCDR."""
    return next(size for size in (1, 2, 4, 8) if bound <= 8 * size)
