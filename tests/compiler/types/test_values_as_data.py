"""Uses of values as data, each as described in docs/idl.md (Values as data)."""

from __future__ import annotations

import copy
import dataclasses
import gc
import pickle
from decimal import Decimal
from pathlib import Path
from typing import Any

import emitted
import msgspec
import pytest
from msgspec import structs

from refrobots.components.aist_joystick import AistJoystickConfiguration
from refrobots.tecs.board._types import tagWheelState
from rtgen.runtime import ACTIVE_STATE, ComponentProfile
from rtgen.runtime.canopen.wire.emergency import Emergency, ErrorRegister
from rtgen.runtime.canopen.wire.pdo_transmission import PdoParameters
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    BoxDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
)
from rtgen.runtime.openrtm.systems import Connection
from rtgen.runtime.system.records import Statistics

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
        *("self.config", "TECS"),
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


@pytest.mark.parametrize(
    ("made", "name", "other"),
    [
        (AistJoystickConfiguration("a.txt", 0.5), "max_v", 0.7),
        (tagWheelState(5, [1, 2], [0.5, 0.25], True), "count", [3, 4]),
    ],
)
def test_parameters_and_structs_of_tecs(made: Any, name: str, other: object) -> None:
    class_ = type(made)
    members = structs.asdict(made)
    assert list(members) == [f.name for f in structs.fields(class_)]
    assert members == {n: getattr(made, n) for n in class_.__match_args__}
    for same in (
        class_(**members),
        class_(*members.values()),
        copy.copy(made),
        copy.deepcopy(made),
        pickle.loads(pickle.dumps(made)),
        msgspec.convert(msgspec.to_builtins(made), class_),
    ):
        assert same == made
        assert type(same) is class_
        assert repr(same) == repr(made)
    changed = structs.replace(made, **{name: other})
    assert getattr(changed, name) == other
    assert changed != made
    assert class_() == class_()
    assert not gc.is_tracked(made), "its members cannot refer to it"
    with pytest.raises(TypeError):
        structs.replace(made, colour=1)
    with pytest.raises(TypeError):
        hash(made)


def test_defaults_of_structs_of_tecs_are_not_shared() -> None:
    first, second = tagWheelState(), tagWheelState()
    first.count[0] = 7
    assert second.count == [0, 0]


@pytest.mark.parametrize(
    ("made", "name", "other"),
    [
        (Statistics(ACTIVE_STATE, 1, 2, 3, "lost"), "ticks", 4),
        (ComponentProfile("Motor", rate=50.0), "type_name", "Drive"),
        (Emergency(0x8130, ErrorRegister(0x11), b"\1\2\3\4\5"), "code", 0),
        (PdoParameters(cob_id=0x181, transmission_type=1), "cob_id", 0x182),
        (Connection("c", "a.out", "b.in", {"k": "v"}), "name", "d"),
        (SequenceDescriptor(PrimitiveDescriptor("long"), 3), "bound", 4),
    ],
)
def test_records_of_the_runtime(made: Any, name: str, other: object) -> None:
    changed = structs.replace(made, **{name: other})
    assert getattr(changed, name) == other
    assert changed != made
    assert structs.replace(changed, **{name: getattr(made, name)}) == made
    assert pickle.loads(pickle.dumps(made)) == made
    with pytest.raises(AttributeError):
        setattr(made, name, other)


def test_descriptors_are_equal_by_what_they_describe() -> None:
    long = PrimitiveDescriptor("long")
    plain = SequenceDescriptor(long, 3)
    arrays = SequenceDescriptor(long, 3, numeric="numpy")
    assert plain == arrays
    assert hash(plain) == hash(arrays)
    assert plain != SequenceDescriptor(long)
    assert plain != ArrayDescriptor(long, (3,))
    first, second = (BoxDescriptor("IDL:Box:1.0", "Box", long) for _ in range(2))
    first.codecs["made"] = first
    assert first == second
    assert repr(first) == repr(second)
    assert copy.deepcopy(first) is first


def test_an_exception_cannot_be_a_struct() -> None:
    """The reason why exceptions are dataclasses (decision 0016)."""
    with pytest.raises(TypeError, match="Struct base classes cannot define"):
        type(msgspec.Struct)("Both", (Exception, msgspec.Struct), {})
