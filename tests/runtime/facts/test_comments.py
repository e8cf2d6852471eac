"""Sentences of comments, and where rtgen states them."""

from __future__ import annotations

import pytest

from rtgen.compiler.typemap.member_units import with_unit
from rtgen.facts.comments import first_sentence, split_sentence

SENTENCES = [
    ("", ""),
    ("One line", "One line"),
    ("One line.\nOther", "One line."),
    ("Over two\nlines. Other.", "Over two lines."),
    ("  Over two\n    lines, e.g. here.\n\n    Other.", "Over two lines, e.g. here."),
    ("Ends by a paragraph\n \nOther.", "Ends by a paragraph"),
    ("Is it 1.5 m? Yes.", "Is it 1.5 m?"),
    ("At most approx. 5 of no. 3. Other.", "At most approx. 5 of no. 3."),
    ("速度です。位置です。", "速度です。"),
]


@pytest.mark.parametrize(("text", "sentence"), SENTENCES)
def test_the_first_sentence(text: str, sentence: str) -> None:
    assert first_sentence(text) == sentence
    assert "".join(split_sentence(text)) == text.strip()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("The warmth of\none joule.", "The warmth of\none joule [K]."),
        ("The warmth of\none joule", "The warmth of\none joule [K]"),
        ("The warmth.\nMore.", "The warmth [K].\nMore."),
        ("The warmth\n\nMore.", "The warmth [K]\n\nMore."),
        ("", "[K]"),
    ],
)
def test_a_unit_ends_the_first_sentence(text: str, expected: str) -> None:
    assert with_unit(text, "K") == expected
