"""Printers of findings."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Diagnostic, Related, Severity, Span
from rtgen.compiler.diagnostics.report import report, summary


def finding(
    line: int = 1,
    column: int = 1,
    end_column: int = 2,
    *,
    end_line: int | None = None,
    message: str = "wrong",
    hint: str | None = None,
    related: tuple[Related, ...] = (),
) -> Diagnostic:
    span = Span("a.idl", line, column, end_line or line, end_column)
    return Diagnostic("IDL0001", Severity.ERROR, message, span, related, hint)


def lines(diagnostic: Diagnostic, source: str) -> list[str]:
    return report([diagnostic], {"a.idl": source}).splitlines()


def test_text_with_line_caret_related_place_and_hint() -> None:
    related = (Related(Span("b.idl", 1, 8, 1, 9), "first declared here"),)
    diagnostic = finding(2, 8, 9, message="S again", hint="rename it", related=related)
    text = report([diagnostic], {"a.idl": "\nstruct S {};\n", "b.idl": "struct S;"})
    assert text == (
        "a.idl:2:8: error[IDL0001]: S again\n"
        "    2 | struct S {};\n"
        "      |        ^\n"
        "b.idl:1:8: note: first declared here\n"
        "    1 | struct S;\n"
        "      |        ^\n"
        "  hint: rename it\n"
    )


def test_colour() -> None:
    text = report([finding()], {"a.idl": "x"}, colour=True)
    assert "\x1b[1;31merror[IDL0001]\x1b[0m" in text
    assert "\x1b[1;31m^\x1b[0m" in text


def test_tabs_and_wide_characters_keep_the_caret_under_its_text() -> None:
    assert lines(finding(1, 2, 4), "\tab")[1:] == ["    1 |     ab", "      |     ^^"]
    assert lines(finding(1, 3, 5), "ロボab")[1:] == ["    1 | ロボab", "      |     ^^"]
    assert lines(finding(1, 1, 3), "ロボab")[1:] == ["    1 | ロボab", "      | ^^^^"]
    assert lines(finding(1, 3, 4), "e\u0301x")[1:] == ["    1 | e\u0301x", "      |  ^"]


def test_a_span_over_lines_is_underlined_to_the_end_of_its_first() -> None:
    assert lines(finding(1, 3, 2, end_line=2), "abcd\nef")[2] == "      |   ^^"


def test_a_place_behind_the_end_of_the_line() -> None:
    assert lines(finding(1, 3, 4), "ab\r\ncd")[1:] == ["    1 | ab", "      |   ^"]


def test_a_line_that_is_not_there_is_left_out() -> None:
    assert lines(finding(9), "x") == ["a.idl:9:1: error[IDL0001]: wrong"]


def test_a_very_long_line_is_cut_around_the_caret() -> None:
    source = "a" * 5_000_000 + "!" + "b" * 5_000_000
    head, text, carets = lines(finding(1, 5_000_001, 5_000_002), source)
    assert head.startswith("a.idl:1:5000001: ")
    assert len(text) < 120
    assert text[carets.index("^")] == "!"
    assert text.startswith("    1 | …a")
    assert text.endswith("b…")


def test_characters_that_steer_a_terminal_are_not_printed() -> None:
    text = report([finding(message="bad \x1b[2J")], {"a.idl": "\x1b[2J\0"})
    assert "\x1b" not in text
    assert "\0" not in text


def test_order_and_repetitions() -> None:
    found = [finding(2, message="b"), finding(1, message="a"), finding(2, message="b")]
    text = report(found, {"a.idl": ""})
    assert [
        line.partition(" ")[0] for line in text.splitlines() if "error" in line
    ] == [
        "a.idl:1:1:",
        "a.idl:2:1:",
    ]
    assert summary(found) == "2 errors"
    assert summary([]) == ""


def test_a_text_that_is_not_given_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.idl").write_bytes(b"one\r\ntwo\xff\n")
    assert (
        report([finding(2)], {}).splitlines()[1]
        == "    2 | two\N{LATIN SMALL LETTER Y WITH DIAERESIS}"
    )


def test_json() -> None:
    related = (Related(Span("b.idl", 1, 8, 1, 9), "here"),)
    nowhere = Diagnostic("PRJ0007", Severity.WARNING, "nothing")
    assert json.loads(
        report([finding(hint="h", related=related), nowhere], {}, "json")
    ) == [
        {
            "code": "PRJ0007",
            "severity": "warning",
            "message": "nothing",
            "file": None,
            "line": None,
            "column": None,
            "end_line": None,
            "end_column": None,
            "related": [],
            "hint": None,
        },
        {
            "code": "IDL0001",
            "severity": "error",
            "message": "wrong",
            "file": "a.idl",
            "line": 1,
            "column": 1,
            "end_line": 1,
            "end_column": 2,
            "related": [{"file": "b.idl", "line": 1, "column": 8, "label": "here"}],
            "hint": "h",
        },
    ]
    assert json.loads(report([], {}, "json")) == []


def test_github() -> None:
    text = report([finding(message="100%\nbad", hint="so")], {}, "github")
    assert text == (
        "::error file=a.idl,line=1,col=1,endLine=1,endColumn=2,title=IDL0001::100%25%0Abad%0Aso\n"
    )


def test_sarif() -> None:
    related = (Related(Span("b c.idl", 1, 8, 1, 9), "here"),)
    [run] = json.loads(report([finding(related=related)], {}, "sarif"))["runs"]
    assert run["tool"]["driver"]["name"] == "rtgen"
    [rule] = run["tool"]["driver"]["rules"]
    assert rule["id"] == "IDL0001"
    [result] = run["results"]
    assert (result["ruleId"], result["ruleIndex"], result["level"]) == (
        "IDL0001",
        0,
        "error",
    )
    place = result["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "a.idl"
    assert place["region"] == {
        "startLine": 1,
        "startColumn": 1,
        "endLine": 1,
        "endColumn": 2,
    }
    assert (
        result["relatedLocations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        == "b%20c.idl"
    )


def test_a_file_name_stays_in_its_line() -> None:
    """A line that begins with `::` is a command for GitHub's workflows."""
    span = Span("a\n::warning::idl", 1, 1, 1, 2)
    text = report([Diagnostic("IDL0001", Severity.ERROR, "wrong", span)], {})
    assert text.split("\n")[0] == "a\ufffd::warning::idl:1:1: error[IDL0001]: wrong"
