"""Snapshots of types with headers in XCDR: optional members, mutable and recursive types."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import emitted
import pytest

from rtgen.runtime.marshalling.compiler import compiled_in_python

DEFINITIONS = """\
module S {
    struct Part { sequence<long> items; @optional double weight; };
    struct Plain { long id; Part inner; };
    @appendable struct Grown { @optional Part first; @optional sequence<string> names; };
    struct Knot;
    @mutable struct Knot {
        long number;
        @optional @external Knot next;
        Grown held;
        @optional sequence<Part> parts;
        map<long, Part> named;
        @optional Plain other;
        Part rows[2][2];
        @optional string text;
    };
    @mutable union Loose switch (long) {
        case 1: Knot a; case 2: @external Part b; case 3: octet c;
    };
    struct Base { @optional Part first; };
    struct Derived : Base { sequence<Loose> choices; };
};
"""


@pytest.fixture(scope="module")
def s(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("snapshots")
    (folder / "s.idl").write_text(DEFINITIONS, encoding="utf-8")
    return emitted.emit(folder, [folder / "s.idl"]).s


def part(s: Any, *items: int, weight: float | None = None) -> Any:
    return s.Part([*items], weight)


def values(s: Any) -> Iterator[Any]:
    """Yield values of each type, with all members and with none."""
    yield part(s, 1, 2, weight=0.5)
    yield s.Plain(1, part(s, 3))
    yield s.Grown()
    yield s.Grown(part(s), [])
    yield s.Knot()
    full = s.Knot(
        number=1,
        held=s.Grown(part(s, 4), ["a"]),
        parts=[part(s, 5), part(s, weight=1.0)],
        named={7: part(s, 6)},
        other=s.Plain(2, part(s, 7)),
        text="t",
    )
    yield full
    yield s.Knot(next=s.Knot(next=full, parts=[]))
    yield s.Loose.of_a(full)
    yield s.Loose.of_b(part(s, 8))
    yield s.Loose.of_c(9)
    yield s.Derived()
    yield s.Derived(part(s, 1), [s.Loose.of_b(part(s, 2)), s.Loose.of_c(3)])


def mutable(value: Any) -> Iterator[Any]:
    """Yield all mutable parts of a value."""
    if isinstance(value, array):
        yield value
    elif isinstance(value, list | dict):
        yield value
        for item in value.values() if isinstance(value, dict) else value:
            yield from mutable(item)
    elif hasattr(type(value), "_descriptor_"):
        yield value
        names = getattr(type(value), "__struct_fields__", None)
        for name in ("discriminator", "value") if names is None else names:
            yield from mutable(getattr(value, name))


def test_snapshots_are_equal_and_share_nothing(s: Any) -> None:
    for value in values(s):
        copy = value._snapshot_()
        assert type(copy) is type(value)
        assert copy == value == deepcopy(value)
        assert copy.to_xcdr2() == value.to_xcdr2()
        of_value, of_copy = list(mutable(value)), list(mutable(copy))
        assert len(of_value) == len(of_copy) >= 1
        assert not {*map(id, of_value)} & {*map(id, of_copy)}, value


def test_snapshots_are_compiled(s: Any) -> None:
    """`deep_copy` remains for graphs of valuetypes and for `any`."""
    for value in values(s):
        function = compiled_in_python("_snapshot_", type(value)._descriptor_)
        assert "deep_copy" not in function.__globals__
