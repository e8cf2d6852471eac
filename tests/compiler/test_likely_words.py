"""What a misspelt word, or a TOML value without quotes, was likely meant as."""

from __future__ import annotations

import pytest

from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.kit.toml_text import TomlError, parse

TYPES = ("int_t", "uint_t", "int8_t", "uint8_t", "uint16_t", "uint32_t", "char_t")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("uint9_t", "uint8_t"),
        ("uint31_t", "uint32_t"),
        ("uin_t", "uint_t"),
        ("UINT8_T", "uint8_t"),
        ("chat_t", "char_t"),
        ("velocity", None),
    ],
)
def test_one_other_letter_is_likelier_than_one_that_is_missing(
    word: str, meant: str | None
) -> None:
    assert nearest(word, TYPES) == meant


@pytest.mark.parametrize(
    ("text", "column", "message", "hint"),
    [
        ("a = gripper\n", 5, "gripper is no value", 'write "gripper"'),
        ("[t]\nname = my-robot # one\n", 8, "my-robot is no value", 'write "my-robot"'),
        ("a = [one, two]\n", 6, "one is no value", 'write "one"'),
        ("a = { b = c }\n", 11, "c is no value", 'write "c"'),
        ("a = True\n", 5, "True is no value", "write true"),
        ("a = no\n", 5, "no is no value", "write false"),
        ("a = zenoh.json5\n", 5, "zenoh.json5 is no value", 'write "zenoh.json5"'),
        ("a =\n", 4, "Invalid value", None),
        ("a = ,\n", 5, "Invalid value", None),
    ],
)
def test_a_text_without_quotes(
    text: str, column: int, message: str, hint: str | None
) -> None:
    with pytest.raises(TomlError) as caught:
        parse(text, "a.toml")
    assert (str(caught.value), caught.value.hint) == (message, hint)
    assert caught.value.span.column == column
