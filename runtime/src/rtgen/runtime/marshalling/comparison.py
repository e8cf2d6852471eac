"""Compares types by repository id and structure, and describes differences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.facts.columns import columns, padded
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    MemberDescriptor,
    Named,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
    registered,
)


def known(descriptor: Descriptor) -> Descriptor:
    """Return the equal generated type, or the descriptor itself.

    Types are equal if repository id and structure are.
    """
    registered_one = registered(getattr(descriptor, "repository_id", ""))
    return (
        registered_one
        if registered_one is not None and _same(descriptor, registered_one)
        else descriptor
    )


def _same(a: Descriptor, b: Descriptor) -> bool:
    """Return whether a type code describes a generated type, ignoring names that it omits."""
    if isinstance(a, LinkDescriptor) or isinstance(b, LinkDescriptor):
        return getattr(a, "repository_id", None) == getattr(b, "repository_id", "")
    if type(a) is not type(b):
        return False
    match a, b:
        case AliasDescriptor(target=one), AliasDescriptor(target=other):
            return _same(one, other)
        case BoxDescriptor(target=one), BoxDescriptor(target=other):
            return _same(one, other)
        case SequenceDescriptor(one, most), SequenceDescriptor(other, limit):
            return most == limit and _same(one, other)
        case ArrayDescriptor(one, here), ArrayDescriptor(other, there):
            return here == there and _same(one, other)
        case EnumDescriptor(), EnumDescriptor():
            return len(a.members) == len(b.members)
        case UnionDescriptor(), UnionDescriptor():
            return _same(a.switch, b.switch) and _same_parts(a.branches, b.branches)
        case (
            StructDescriptor() | ExceptionDescriptor() | ValueDescriptor(),
            StructDescriptor() | ExceptionDescriptor() | ValueDescriptor(),
        ):
            return _same_parts(a.members, b.members)
        case Named(), Named():
            return a.repository_id == b.repository_id
    return a == b


def _same_parts(
    left: Sequence[MemberDescriptor | BranchDescriptor],
    right: Sequence[MemberDescriptor | BranchDescriptor],
) -> bool:
    return len(left) == len(right) and all(
        a.name in ("", b.name)
        and getattr(a, "labels", ()) == getattr(b, "labels", ())
        and _same(a.type, b.type)
        for a, b in zip(left, right, strict=True)
    )


def difference(a: Descriptor, b: Descriptor) -> str | None:
    """Return None if repository id and structure agree, else both types, side by side.

    Differing lines are marked with `!`. An opaque type, whose content is unknown, agrees with none.
    """
    for one in (a, b):
        if isinstance(one, StructDescriptor | InterfaceDescriptor) and one.opaque:
            return f"  the definition of {one.name} was not found; generate with its IDL file"
    if a == b:
        return None
    return text_difference(definition(a), definition(b))


def definition(descriptor: Descriptor) -> str:
    """Return name, repository id and structure of a type as lines of text.

    Equal types have equal texts.
    """
    return "\n".join(_lines(descriptor))


def text_difference(a: str, b: str) -> str | None:
    """Return None for equal definitions, else both, in the form of `difference`."""
    left, right = a.split("\n"), b.split("\n")
    if left == right:
        return None
    height = max(len(left), len(right))
    left += [""] * (height - len(left))
    right += [""] * (height - len(right))
    width = max(map(columns, left))
    return "\n".join(
        f"{' ' if x == y else '!'} {padded(x, width)} | {y}".rstrip()
        for x, y in zip(left, right, strict=True)
    )


def _lines(descriptor: Descriptor) -> Iterator[str]:
    """Yield the definition as text, with nested structs expanded."""
    descriptor = plain(descriptor)
    if isinstance(descriptor, Named):
        yield f"{descriptor.name}  {descriptor.repository_id}"
    yield from _inside(descriptor, "  ")


def _inside(descriptor: Descriptor, margin: str) -> Iterator[str]:
    match descriptor:
        case AliasDescriptor(target=target):
            yield from _inside(target, margin)
        case StructDescriptor(members=members) | ExceptionDescriptor(members=members):
            for member in members:
                optional = "@optional " if member.optional else ""
                yield f"{margin}{optional}{member.type} {member.name}"
                yield from _inside(member.type, margin + "  ")
        case BitsetDescriptor(fields=fields):
            for bits in fields:
                yield f"{margin}bitfield<{bits.bits}> {bits.name} at {bits.position}"
        case EnumDescriptor(members=enumerators) | FlagsDescriptor(members=enumerators):
            yield margin + ", ".join(
                f"{name} = {number}" for name, number in enumerators
            )
        case UnionDescriptor(switch=switch, branches=branches):
            yield f"{margin}switch ({switch})"
            yield from _inside(switch, margin + "  ")
            for branch in branches:
                labels = [f"case {label!r}" for label in branch.labels]
                labels += ["default"] * branch.default
                yield f"{margin}{', '.join(labels)}: {branch.type} {branch.name}"
                yield from _inside(branch.type, margin + "  ")
        case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
            yield from _inside(element, margin)
        case MapDescriptor(key=key, value=value):
            yield from _inside(key, margin)
            yield from _inside(value, margin)
        case InterfaceDescriptor(operations=operations):
            for operation in operations:
                yield f"{margin}{operation}"
