"""A source and its unit: blanked and joined text, and positions in the file."""

from idl_stages import preprocessed, source


def test_comments_are_blanked_and_kept() -> None:
    made = source("long a; // one\n/* two\n lines */ long b;\n")
    assert made.code == "long a;       \n" + " " * 16 + " long b;\n"
    assert [comment.text for comment in made.comments] == [
        "// one",
        "/* two\n lines */",
    ]
    assert made.problems == []


def test_a_comment_within_a_string_is_none() -> None:
    made = source('const string a = "// no comment";\n')
    assert made.code == made.text
    assert made.comments == []


def test_joined_lines_keep_their_places() -> None:
    made = source("const \\\nlong a = 1;\n")
    assert made.code == "const long a = 1;\n"
    span = made.span(made.code.index("a ="), made.code.index("a =") + 1)
    assert (span.line, span.column) == (2, 6)


def test_problems_of_the_text() -> None:
    assert [p.message for p in source("long a; /* open").problems] == [
        "this comment is never closed"
    ]
    assert [p.message for p in source("long\x01 a;").problems] == [
        "the control character U+0001 is not allowed here"
    ]
    assert source("a\0b").code == ""


def test_bytes_that_are_no_utf_8_are_latin_1() -> None:
    unit, messages = preprocessed("const string a = 'ü';")
    assert not messages
    assert "ü" in unit.text


def test_an_expansion_has_the_place_of_its_call() -> None:
    text = "#define SIZE 3 + 4\nconst long a = SIZE;\n"
    unit, messages = preprocessed(text)
    assert not messages
    start = unit.text.index("3 + 4")
    span = unit.span(start, start + 1)
    assert (span.line, span.column, span.end_column) == (2, 16, 20)


def test_what_a_condition_leaves_out_is_not_in_the_unit() -> None:
    unit, messages = preprocessed("#if 0\nlong a;\n#else\nlong b;\n#endif\n")
    assert not messages
    assert unit.text.split() == ["long", "b;"]


def test_pragmas_are_events_at_their_offsets() -> None:
    unit, _ = preprocessed('struct A {};\n#pragma prefix "org"\nstruct B {};\n')
    [event] = unit.events
    assert unit.text[: event.offset].split() == ["struct", "A", "{};"]
    assert unit.text[event.offset :].split() == ["struct", "B", "{};"]
