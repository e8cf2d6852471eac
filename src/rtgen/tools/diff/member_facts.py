"""Compares the annotations of members, branches, ports and parameters."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.model import (
    ConstantValue,
    Documented,
    Enum,
    EnumeratorName,
    InitialValue,
    Limits,
    limits,
)
from rtgen.tools.diff.changes import Kind
from rtgen.tools.diff.kinds import types as kinds

_RANGES = ("min", "max", "range")
_COMPARED_ELSEWHERE = frozenset(
    (
        *("id", "autoid", "hashid", "optional", "key", "must_understand", "external"),
        *("final", "appendable", "mutable", "extensibility", "nested", "position"),
        *("value", "bit_bound", "data_representation", "try_construct", "unit"),
        *("default", "name", "port", "instance", "type_name", "rtc", *_RANGES),
        *("default_nested", "constraint", "widget", "verbatim", "oneway"),
        "numeric",
    )
)


def member_facts(
    old: Documented, new: Documented, name: str
) -> Iterator[tuple[Kind, str]]:
    """Yield the changes of a member's annotations, with a message each."""
    for kind, key in (
        (kinds.MUST_UNDERSTAND, "must_understand"),
        (kinds.EXTERNAL, "external"),
    ):
        was, now = (getattr(each, key, False) for each in (old, new))
        if was != now:
            yield kind, f"{name} is {'now' if now else 'no longer'} @{key}"
    yield from _argument(kinds.TRY_CONSTRUCT, "try_construct", old, new, name)
    yield from value_facts(old, new, name)


def value_facts(
    old: Documented, new: Documented, name: str
) -> Iterator[tuple[Kind, str]]:
    """Yield the changes of what annotations say of the values of a member or a declaration."""
    yield from _argument(kinds.MEMBER_UNIT, "unit", old, new, name)
    yield from _defaults(old, new, name)
    yield from _range(old, new, name)
    yield from _other_annotations(old, new, name)


def _argument(
    kind: Kind, key: str, old: Documented, new: Documented, name: str
) -> Iterator[tuple[Kind, str]]:
    before, after = argument(old, key), argument(new, key)
    if before != after:
        yield kind, f"{name} has {_said(key, after)}, had {_said(key, before)}"


def _defaults(
    old: Documented, new: Documented, name: str
) -> Iterator[tuple[Kind, str]]:
    """Yield the change of the value with which a member, a typedef or an enum starts."""
    if isinstance(old, Enum) and isinstance(new, Enum):
        was, now = old.initial, new.initial
        if was.name != now.name and was.value != now.value:
            text = f"{name} starts with {now.name}, did with {was.name}"
            yield kinds.MEMBER_DEFAULT, text
        return
    before, after = (
        getattr(each, "initial", argument(each, "default")) for each in (old, new)
    )
    if before != after:
        text = f"{name} has {_said('default', after)}, had {_said('default', before)}"
        yield kinds.MEMBER_DEFAULT, text


def _other_annotations(
    old: Documented, new: Documented, name: str
) -> Iterator[tuple[Kind, str]]:
    """Yield the changes of annotations that rtgen does not interpret."""
    before = {a for a in old.annotations if a.name not in _COMPARED_ELSEWHERE}
    after = {a for a in new.annotations if a.name not in _COMPARED_ELSEWHERE}
    forms = argument(old, "numeric"), argument(new, "numeric")
    if forms[0] != forms[1]:
        now, was = (_said("form of numbers", form) for form in forms[::-1])
        yield kinds.NUMERIC, f"{name} has {now}, had {was}"
    changed = sorted({a.name for a in before ^ after})
    if changed:
        words = ", ".join(f"@{each}" for each in changed)
        yield kinds.ANNOTATION, f"{name} has other annotations: {words}"


def _range(old: Documented, new: Documented, name: str) -> Iterator[tuple[Kind, str]]:
    before, after = limits(old.annotations), limits(new.annotations)
    if before != after:
        narrowed = is_narrower(before, after)
        kind = kinds.MEMBER_RANGE_NARROWED if narrowed else kinds.MEMBER_RANGE_WIDENED
        yield kind, f"{name} ranges over {shown(after)}, did over {shown(before)}"


def is_narrower(old: Limits, new: Limits) -> bool:
    """Return whether a value of the old range can be outside of the new one."""
    least = new[0] is not None and (old[0] is None or _less(old[0], new[0]))
    most = new[1] is not None and (old[1] is None or _less(new[1], old[1]))
    return least or most


def _less(a: ConstantValue, b: ConstantValue) -> bool:
    if isinstance(a, EnumeratorName) or isinstance(b, EnumeratorName):
        return a != b
    if isinstance(a, str) or isinstance(b, str):
        return str(a) < str(b)
    return a < b


def shown(range_: Limits) -> str:
    """Return a range as shown in messages."""
    least, most = ("" if end is None else value_text(end) for end in range_)
    return f"{least}..{most}"


def argument(item: Documented, key: str) -> ConstantValue | None:
    """Return the argument of an annotation, or None."""
    annotation = item.annotation(key)
    return None if annotation is None else annotation.get()


def value_text(value: InitialValue | None) -> str:
    """Return a constant, or the items of a list, as shown in messages."""
    match value:
        case None:
            return "none"
        case tuple():
            return f"({', '.join(map(value_text, value))})"
        case EnumeratorName(name):
            return name[-1]
        case bool():
            return "TRUE" if value else "FALSE"
        case str():
            return f'"{value}"'
    return str(value)


def _said(key: str, value: InitialValue | None) -> str:
    return f"no {key}" if value is None else f"the {key} {value_text(value)}"
