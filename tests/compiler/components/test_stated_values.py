"""Texts for parameters of other processes, by the type and the constraint that these state."""

from __future__ import annotations

import pytest

from rtgen.facts.parameter_words import CANONICAL
from rtgen.runtime.rtc.stated_values import problem

TAKEN = [
    ("12", "int", ""),
    ("-12", "short", ""),
    ("3000000000", "long", ""),
    ("1e-3", "double", ""),
    ("1.5", "float", "x>0"),
    ("1", "bool", ""),
    ("any text", "string", ""),
    ("", "std::string", ""),
    ("0.0,1.0,2.0", "std::vector<double>", ""),
    ("1,2", "vector< int >", "{x>0,x>0}"),
    ("incr", "string", "(logincr,incr,const)"),
    ("5", "int", "0<=x<=10"),
    ("what it likes", "MyType", ""),
    ("5", "", "0<=x<=10"),
    ("slow", "", "(slow,fast)"),
    ("5", "int", "not a constraint ((("),
    ("x", "", ""),
]
REFUSED = [
    ("many", "int"),
    ("1.5", "int"),
    ("", "int"),
    ("40000", "short"),
    ("3000000000", "int"),
    ("-1", "unsigned int"),
    ("1,5", "double"),
    ("nan?", "double"),
    ("1,x", "std::vector<double>"),
    ("maybe", "bool"),
]
BEYOND = [
    ("11", "int", "0<=x<=10"),
    ("-0.5", "double", "x>0"),
    ("other", "string", "(logincr,incr,const)"),
    ("11", "", "0<=x<=10"),
    ("medium", "", "(slow,fast)"),
]


@pytest.mark.parametrize(("text", "type_", "constraint"), TAKEN)
def test_taken(text: str, type_: str, constraint: str) -> None:
    assert problem("p", text, type_, constraint) == ""


@pytest.mark.parametrize(("text", "type_"), REFUSED)
@pytest.mark.parametrize("constraint", ["", "not a constraint ((("])
def test_refused_by_the_type(text: str, type_: str, constraint: str) -> None:
    assert problem("p", text, type_, constraint).startswith("parameter 'p' cannot be ")


@pytest.mark.parametrize(("text", "type_", "constraint"), BEYOND)
def test_refused_by_the_constraint(text: str, type_: str, constraint: str) -> None:
    expected = f"parameter 'p' cannot be {text!r}: its constraint is {constraint}"
    assert problem("p", text, type_, constraint) == expected


@pytest.mark.parametrize("word", CANONICAL)
def test_every_word_judges(word: str) -> None:
    assert problem("p", "1", word, "") == ""
    is_text = CANONICAL[word] == "string"
    assert bool(problem("p", "no number", word, "")) is not is_text
