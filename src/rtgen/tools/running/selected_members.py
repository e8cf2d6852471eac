"""Checks the members that a command line selects against the type of the port, before a run."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

from rtgen.runtime.marshalling.descriptors import (
    ANY,
    ArrayDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    MapDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)

TIME = "tm"
"""The member that curves and labels leave out, unless it is the only one."""


class MemberError(Exception):
    """The type has no such member, or the member has no numbers; `hint` helps."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.hint = hint
        super().__init__(message)


def require_numbers(descriptor: Descriptor, path: Sequence[str | int]) -> None:
    """Check that a path leads to numbers in each sample of a type. Raises MemberError.

    What depends on a sample, such as the branch of a union, is not checked.
    """
    inner: Descriptor | None = descriptor
    label = str(plain(descriptor))
    for step in path:
        if inner is None:
            return
        inner = (
            _element(inner, step, label)
            if isinstance(step, int)
            else _member(inner, step, label)
        )
        label = f"{label}[{step}]" if isinstance(step, int) else f"{label}.{step}"
    if inner is not None and not _has_numbers(inner):
        raise MemberError(f"{label} has no numbers")


def _members(target: Descriptor) -> dict[str, Descriptor | None] | None:
    """Return the members of a type; None for a type that has none, or unknown ones."""
    match target:
        case StructDescriptor() | ExceptionDescriptor():
            return {each.name: each.type for each in target.members}
        case ValueDescriptor():
            return {each.name: each.type for each in target.all_members()}
        case UnionDescriptor():
            return {"discriminator": target.switch, "value": None}
    return None


def _unwrapped(descriptor: Descriptor, step: str | int) -> Descriptor | None:
    """Return what a step selects from: the only member beside the time stamp if not the type."""
    target = plain(descriptor)
    while (members := _members(target)) is not None and step not in members:
        others = [each for name, each in members.items() if name != TIME]
        if len(others) != 1:
            break
        if others[0] is None:
            return None
        target = plain(others[0])
    return target


def _member(descriptor: Descriptor, step: str, label: str) -> Descriptor | None:
    target = _unwrapped(descriptor, step)
    members = None if target is None else _members(target)
    if members is not None and step in members:
        return members[step]
    if target is None or _is_open(target):
        return None
    names = _members(plain(descriptor)) or members or {}
    close = get_close_matches(step, names, n=1)
    hint = f"did you mean {close[0]!r}?" if close else None
    if names and not close:
        hint = f"members: {', '.join(names)}"
    raise MemberError(f"{label} has no member {step!r}", hint)


def _element(descriptor: Descriptor, step: int, label: str) -> Descriptor | None:
    target = _unwrapped(descriptor, step)
    length: int | None = None
    inner: Descriptor | None = None
    match target:
        case SequenceDescriptor(element=inner, bound=length):
            pass
        case ArrayDescriptor(element=inner, dimensions=(length, *rest)):
            if rest:
                inner = ArrayDescriptor(inner, tuple(rest))
        case _ if target is None or _is_open(target):
            return None
        case _:
            names = _members(plain(descriptor))
            hint = f"members: {', '.join(names)}" if names else None
            raise MemberError(f"{label} has no elements", hint)
    if length is not None and step >= length:
        raise MemberError(f"{label} has {length} elements at most: 0 to {length - 1}")
    return inner


def _is_open(target: Descriptor) -> bool:
    """Return whether only a sample tells what is in it."""
    return target == ANY or isinstance(
        target, MapDescriptor | BitsetDescriptor | BoxDescriptor
    )


def _has_numbers(descriptor: Descriptor, around: tuple[Descriptor, ...] = ()) -> bool:
    """Return whether samples of a type may have numbers, other than a time stamp."""
    target = plain(descriptor)
    if any(target is each for each in around):
        return False
    around = (*around, target)
    if isinstance(target, SequenceDescriptor | ArrayDescriptor):
        return _has_numbers(target.element, around)
    members = _members(target)
    if members is None:
        return not isinstance(target, StringDescriptor | EnumDescriptor)
    if len(members) > 1:
        members.pop(TIME, None)
    return any(each is None or _has_numbers(each, around) for each in members.values())
