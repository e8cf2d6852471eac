"""Uses of values as data, each as described in docs/idl.md (Values as data)."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from decimal import Decimal
from pathlib import Path
from typing import Any

import emitted
import msgspec
import pytest
from msgspec import structs

PAGE = Path(__file__).parents[3] / "docs" / "idl.md"


@pytest.fixture(scope="module")
def p(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(
        tmp_path_factory.mktemp("data"),
        """
        enum Color { RED, GREEN };
        struct Point { double x; double y; };
        struct Path { Color hue; sequence<Point> points; sequence<octet> raw; fixed<4,2> price; };
        union Choice switch (short) { case 1: Point at; case 2: string text; };
        bitset Bits { bitfield<3> a; bitfield<1> b; };
        exception NoMap { string reason; Point near; };
        valuetype Node { public string name; public Node next; };
        """,
    )


def path(p: Any) -> Any:
    return p.Path(p.GREEN, [p.Point(1.0, 2.0)], b"ab", Decimal("1.25"))


def test_the_page_names_each_way() -> None:
    text = PAGE.read_text(encoding="utf-8")
    section = text.partition("## Values as data\n")[2].partition("\n## ")[0]
    for way in (
        *("structs.replace", "structs.asdict", "structs.fields", "msgspec.to_builtins"),
        *("msgspec.convert", "__match_args__", "dataclasses.replace"),
        *("dataclasses.asdict", "dataclasses.fields", "dataclasses.is_dataclass"),
    ):
        assert f"{way}" in section, way


def test_structs(p: Any) -> None:
    value = path(p)
    changed = structs.replace(value, hue=p.RED)
    assert (changed.hue, value.hue) == (p.RED, p.GREEN)
    assert changed.points is value.points
    assert structs.asdict(value) == {
        "hue": p.GREEN,
        "points": [p.Point(1.0, 2.0)],
        "raw": b"ab",
        "price": Decimal("1.25"),
    }
    data = msgspec.to_builtins(value, builtin_types=(bytes, Decimal))
    assert data == {
        "hue": 1,
        "points": [{"x": 1.0, "y": 2.0}],
        "raw": b"ab",
        "price": Decimal("1.25"),
    }
    assert msgspec.convert(data, p.Path) == value
    assert [f.name for f in structs.fields(p.Path)] == [*p.Path.__match_args__]
    assert p.Path.__match_args__ == ("hue", "points", "raw", "price")
    assert isinstance(value, msgspec.Struct)
    with pytest.raises(TypeError):
        structs.replace(value, colour=p.RED)


def test_unions_and_bitsets(p: Any) -> None:
    choice = p.Choice.of_text("a")
    assert structs.asdict(choice) == {"discriminator": 2, "value": "a"}
    assert structs.replace(choice, value="b") == p.Choice.of_text("b")
    assert structs.asdict(p.Bits(5, True)) == {"a": 5, "b": True}
    assert structs.replace(p.Bits(5, True), a=1) == p.Bits(1, True)


def test_exceptions(p: Any) -> None:
    error = p.NoMap("lost", p.Point(1.0, 2.0))
    changed = dataclasses.replace(error, reason="late")
    assert changed == p.NoMap("late", p.Point(1.0, 2.0))
    assert error.reason == "lost"
    assert dataclasses.asdict(error) == {"reason": "lost", "near": p.Point(1.0, 2.0)}
    assert [f.name for f in dataclasses.fields(p.NoMap)] == ["reason", "near"]
    assert dataclasses.is_dataclass(error)
    match error:
        case p.NoMap(reason, near):
            assert (reason, near.x) == ("lost", 1.0)
        case _:
            pytest.fail("no match")
    for made in (
        copy.copy(error),
        copy.deepcopy(error),
        pickle.loads(pickle.dumps(error)),
        p.NoMap(**dataclasses.asdict(error)),
    ):
        assert made == error
        assert type(made) is p.NoMap


def test_valuetypes(p: Any) -> None:
    node = p.Node("a", p.Node("b", None))
    changed = dataclasses.replace(node, name="c")
    assert (changed.name, changed.next) == ("c", node.next)
    assert [f.name for f in dataclasses.fields(p.Node)] == ["name", "next"]
    assert node != dataclasses.replace(node)


def test_an_exception_cannot_be_a_struct() -> None:
    """The reason why exceptions are dataclasses (decision 0016)."""
    with pytest.raises(TypeError, match="Struct base classes cannot define"):
        type(msgspec.Struct)("Both", (Exception, msgspec.Struct), {})
