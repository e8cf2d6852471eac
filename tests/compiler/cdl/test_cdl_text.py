"""Bytes of a CDL file to text: comments, strings in angles, places."""

from cdl_stages import source

from rtgen.compiler.frontends.cdl.text.source import ANGLE_MARK


def test_comments_are_blanked_and_kept() -> None:
    read = source("a /* b */ c // d\ne")
    assert read.code == "a         c     \ne"
    assert [comment.text for comment in read.comments] == ["/* b */", "// d"]


def test_only_strings_in_angles_are_marked() -> None:
    read = source('import( <a.h> );\nx < y;\n"<z>"')
    assert read.code == f'import( {ANGLE_MARK}a.h> );\nx < y;\n"<z>"'


def test_places_count_from_one() -> None:
    span = source("ab\ncd\n").span(3, 5)
    assert (span.line, span.column, span.end_line, span.end_column) == (2, 1, 2, 3)


def test_what_is_no_text_is_reported() -> None:
    assert [p.message for p in source("a\0b").problems] == [
        "this is not a text file: it holds a NUL byte"
    ]
    assert source("/* a").unfinished
