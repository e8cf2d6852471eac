"""Positions in UTF-8, UTF-16 and UTF-32, and positions that move with edits."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol.types import Position, PositionEncodingKind, Range

from rtgen.compiler.diagnostics import Span
from rtgen.tools.indexing.text import Shift, Text

TEXTS = st.text(alphabet="ab \n\r\t\u00e9\u5bb6\U0001f916\u2028\x0c", max_size=60)
UTF_8 = PositionEncodingKind.Utf8
UTF_16 = PositionEncodingKind.Utf16
UTF_32 = PositionEncodingKind.Utf32
ENCODINGS = st.sampled_from([UTF_8, UTF_16, UTF_32])


@pytest.mark.parametrize(
    ("encoding", "character"), [(UTF_8, 10), (UTF_16, 5), (UTF_32, 4)]
)
def test_units(encoding: PositionEncodingKind, character: int) -> None:
    text = Text("x\n\u00e9\u5bb6\U0001f916a!\n")
    assert text.position(text.source.index("!"), encoding) == Position(1, character)
    assert text.offset(Position(1, character), encoding) == text.source.index("!")


def test_a_position_inside_a_character_is_before_it() -> None:
    text = Text("a\U0001f916b")
    assert text.offset(Position(0, 2), UTF_16) == 1


def test_a_position_beyond_a_line_is_its_end() -> None:
    text = Text("ab\r\ncd")
    assert text.offset(Position(0, 99), UTF_16) == 2
    assert text.offset(Position(9, 0), UTF_16) == 6


@pytest.mark.parametrize("end", ["\u2028", "\x0c", "\x0b", "\x85"])
def test_other_separators_end_no_line(end: str) -> None:
    assert Text(f"a{end}b").lines == 1


@given(TEXTS, ENCODINGS)
def test_positions_are_the_inverse_of_offsets(
    source: str, encoding: PositionEncodingKind
) -> None:
    text = Text(source)
    for offset in range(len(source) + 1):
        if source[max(offset - 1, 0) : offset + 1] == "\r\n":
            continue  # between the two there is no position
        assert text.offset(text.position(offset, encoding), encoding) == offset


@given(TEXTS)
def test_spans_are_the_inverse_of_offsets(source: str) -> None:
    text = Text(source)
    for start in range(len(source) + 1):
        span = text.span("f", start, len(source))
        assert text.offsets(span) == (start, len(source))


def test_a_span_beyond_the_text_is_its_end() -> None:
    assert Text("ab\n").offsets(Span("f", 9, 9, 12, 1)) == (3, 3)


@given(TEXTS, TEXTS, TEXTS, TEXTS)
def test_replacing_a_range(before: str, old: str, new: str, after: str) -> None:
    text = Text(before + old + after)
    start, end = len(before), len(before) + len(old)
    if "\r\n" in (text.source[start - 1 : start + 1], text.source[end - 1 : end + 1]):
        return
    range_ = Range(text.position(start, UTF_16), text.position(end, UTF_16))
    replaced, shift = text.replaced(range_, new, UTF_16)
    assert replaced.source == before + new + after
    assert shift == Shift(start, end, start + len(new))


@given(TEXTS, TEXTS, TEXTS, TEXTS)
def test_what_an_edit_has_not_touched_moves_with_it(
    before: str, old: str, new: str, after: str
) -> None:
    source, edited = before + old + after, before + new + after
    shift = Shift.between(source, edited)
    assert source[: shift.start] == edited[: shift.start]
    assert source[shift.old :] == edited[shift.new :]
    for start in range(len(source)):
        moved = shift.forward(start, start + 1)
        if moved is not None:
            assert edited[moved[0] : moved[1]] == source[start]
            assert shift.back(moved[0]) == start or moved[0] == shift.start


def test_texts_that_differ_far_behind() -> None:
    source = "x" * 10_000 + "a" + "y" * 10_000
    assert Shift.between(source, source.replace("a", "bc")) == Shift(
        10000, 10001, 10002
    )
