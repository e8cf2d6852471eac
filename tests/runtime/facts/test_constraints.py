"""Constraint texts, their trees, and the allowed values."""

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.facts.constraints import (
    AllOf,
    AnyOf,
    Between,
    Comparison,
    Constraint,
    ConstraintError,
    ItemConstraints,
    KeyConstraints,
    Operator,
    Unit,
    Value,
    allows,
    is_enumeration,
    is_range,
    parse,
    text_of,
)

GREATER = Comparison(Operator.GREATER, "0")


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("", None),
        (" \t", None),
        ("100", Comparison(Operator.EQUAL, "100")),
        ("x>=5", Comparison(Operator.GREATER_OR_EQUAL, "5")),
        ("5<=x", Comparison(Operator.GREATER_OR_EQUAL, "5")),
        ("5 < x", Comparison(Operator.GREATER, "5")),
        ("x<-1.5e3", Comparison(Operator.LESS, "-1.5e3")),
        ("0<=x<=10", Between("0", "10")),
        ("10>=x>=0", Between("0", "10")),
        ("0<x<10", AllOf((GREATER, Comparison(Operator.LESS, "10")))),
        ("10>=x>0", AllOf((GREATER, Comparison(Operator.LESS_OR_EQUAL, "10")))),
        ("(a)", Comparison(Operator.EQUAL, "a")),
        (
            "(a, b)",
            AnyOf((Comparison(Operator.EQUAL, "a"), Comparison(Operator.EQUAL, "b"))),
        ),
        ("x>0,7", ItemConstraints((GREATER, Comparison(Operator.EQUAL, "7")))),
        (
            "{k:x>0,j:7}",
            KeyConstraints((("k", GREATER), ("j", Comparison(Operator.EQUAL, "7")))),
        ),
    ],
)
def test_text_to_tree(text: str, tree: Constraint | None) -> None:
    assert parse(text) == tree


@pytest.mark.parametrize(
    "text",
    [
        "x>",
        "x>y",
        "1<x>2",
        "5<=x<=1",
        "(a,,b)",
        "(a,b",
        "a)b(",
        "{k:x>0",
        "{x>0}",
        "{}",
        "x<1,",
        "((a,b))",
        "1<x<2<3",
        "x<nan",
        "x<1_0",
        "y<3",
        "x<inf",
    ],
)
def test_unreadable(text: str) -> None:
    with pytest.raises(ConstraintError):
        parse(text)


numbers = st.integers(-99, 99).map(str)
comparisons = st.builds(
    Comparison,
    st.sampled_from([o for o in Operator if o is not Operator.EQUAL]),
    numbers,
)
words = st.text("abcdez", min_size=1, max_size=4)
equals = st.builds(Comparison, st.just(Operator.EQUAL), words)


def _ordered(low: int, size: int, ends: tuple[bool, bool]) -> Unit:
    lower, upper = str(low), str(low + size)
    if ends == (True, True):
        return Between(lower, upper)
    return AllOf(
        (
            Comparison(
                Operator.GREATER_OR_EQUAL if ends[0] else Operator.GREATER, lower
            ),
            Comparison(Operator.LESS_OR_EQUAL if ends[1] else Operator.LESS, upper),
        )
    )


intervals = st.builds(
    _ordered,
    st.integers(-9, 9),
    st.integers(0, 9),
    st.tuples(st.booleans(), st.booleans()),
)
choices = st.lists(equals, min_size=2, max_size=4).map(
    lambda items: AnyOf(tuple(items))
)
units = comparisons | equals | intervals | choices
constraints = (
    units
    | st.lists(units, min_size=2, max_size=4).map(
        lambda items: ItemConstraints(tuple(items))
    )
    | st.lists(st.tuples(words, units), min_size=1, max_size=3).map(
        lambda items: KeyConstraints(tuple(items))
    )
)


@given(constraints)
def test_text_form_round_trip(tree: Constraint) -> None:
    assert parse(text_of(tree)) == tree


@pytest.mark.parametrize(
    ("text", "values", "allowed"),
    [
        ("0.0<x<=2.0", [2], True),
        ("0.0<x<=2.0", [0.0], False),
        ("x>=1,x<1", [1, 0], True),
        ("x>=1,x<1", [1, 1], False),
        ("x>=1", [1, 2, 0], False),
        ("(clip,drop)", ["drop"], True),
        ("(clip,drop)", ["Drop"], False),
        ("(clip and hold)", ["clip and hold"], True),
        ("(1,2)", [2.0], True),
        ("(1,2)", ["2.0"], False),
        ("9007199254740993", [9007199254740992], False),
        ("x<9007199254740993", [9007199254740992], True),
        ("(1.5,2)", [Decimal("1.50")], True),
        ("x<=1.1", [Decimal("1.1")], True),
        ("(true)", [True], True),
        ("(0)", [True], False),
        ("x<1", ["0"], False),
        ("{k:x>5}", ["anything"], True),
        ("x<=3", [], True),
        ("x<3", [3], False),
        ("x>3", [3], False),
        ("1<=x<=3", [4], False),
    ],
)
def test_what_is_allowed(text: str, values: list[Value], allowed: bool) -> None:
    constraint = parse(text)
    assert constraint is not None
    assert allows(constraint, values) is allowed


@pytest.mark.parametrize(
    ("text", "ranged", "listed"),
    [
        ("0<=x<=1", True, False),
        ("0<x<1,0<=x<=1", True, False),
        ("x<1", False, False),
        ("(a,b)", False, True),
        ("a,(b,c)", False, True),
        ("{k:7}", False, False),
    ],
)
def test_what_widgets_ask(text: str, ranged: bool, listed: bool) -> None:
    assert is_range(parse(text)) is ranged
    assert is_enumeration(parse(text)) is listed
