"""Identifiers derived from any text, such as the outside name of a port."""

from __future__ import annotations

import ast
import keyword
import unicodedata

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rtgen.compiler.typemap.python.names import (
    identifier,
    module_name,
    snake_case,
)


@given(st.text())
@example("")
@example("²")
@example("x²")
@example("\uff33elf")
@example("ﬁ")
@example("℘·")
@example("1a")
@example("\u0301")
@example("class")
@example("\uff43lass")
@example('a"); import os; ("')
def test_any_text_gives_an_identifier(text: str) -> None:
    for name in (identifier(text), module_name(text)):
        assert name.isidentifier()
        assert not keyword.iskeyword(name)
        assert unicodedata.normalize("NFKC", name) == name
        [made] = ast.parse(f"{name}: int").body
        assert isinstance(made, ast.AnnAssign)
        assert isinstance(made.target, ast.Name)
        assert made.target.id == name


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("left wheel", "left_wheel"),
        ("m²", "m2"),
        ("\uff33peed", "Speed"),
        ("²", "o_2"),
        ("モータ", "モータ"),
    ],
)
def test_what_can_be_kept_is_kept(text: str, name: str) -> None:
    assert identifier(text) == name


WORDS = {
    "CANopen": "canopen",
    "CANopenState": "canopen_state",
    "MyCANopenNode": "my_canopen_node",
    "CiA402Drive": "cia402_drive",
    "PDOs": "pdos",
    "nodeIDs": "node_ids",
    "IDsOfNodes": "ids_of_nodes",
    "HTTPServer": "http_server",
    "LaserScan": "laser_scan",
    "OmniTo2WD": "omni_to2_wd",
    "minAngle": "min_angle",
    "already_snake": "already_snake",
}


@pytest.mark.parametrize("name", WORDS)
def test_words_of_names(name: str) -> None:
    assert snake_case(name) == WORDS[name]
