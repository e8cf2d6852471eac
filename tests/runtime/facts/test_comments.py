"""Sentences of comments, and where rtgen states them."""

from __future__ import annotations

import pytest

from rtgen.compiler.backends.kit.member_texts import member_text
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Annotation, Documented
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
    unit = Annotation("unit", (("value", "K"),))
    entry = Documented(span=Span("a.idl", 1, 1, 1, 1), doc=text, annotations=(unit,))
    assert member_text(entry) == expected
