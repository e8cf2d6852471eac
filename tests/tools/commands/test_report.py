"""Printers of findings."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Diagnostic, Related, Severity, Span, explain
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


# What GitHub documents and its runner does: the parameters of a workflow command, by name.
PARAMETERS = {"file", "line", "endLine", "col", "endColumn", "title"}


def commands(text: str) -> list[tuple[str, dict[str, str], str]]:
    """Parse workflow commands as GitHub's runner does: level, parameters, message."""
    parsed = []
    for line in text.splitlines():
        match = re.fullmatch(r"::(error|warning|notice) (.*?)::(.*)", line)
        assert match is not None, line
        pairs = [each.split("=", 1) for each in match[2].split(",")]
        plain = {k: re.sub("%(..)", _character, v) for k, v in pairs}
        parsed.append((match[1], plain, re.sub("%(..)", _character, match[3])))
    return parsed


def _character(match: re.Match[str]) -> str:
    return chr(int(match[1], 16))


@pytest.mark.parametrize("severity", Severity)
def test_annotations_have_the_form_that_the_host_documents(severity: Severity) -> None:
    spans = [
        Span("a,b:c%.idl", 2, 3, 2, 8),
        Span("a.idl", 2, 9, 4, 1),  # columns stand for one line only
        None,
    ]
    given = [Diagnostic("IDL0001", severity, "100%: a,b\r\n::c", s) for s in spans]
    for span, (level, parameters, message) in zip(
        sorted(spans, key=str), commands(report(given, {}, "github")), strict=True
    ):
        assert level == {"note": "notice"}.get(severity.value, severity.value)
        assert message == "100%: a,b\r\n::c"
        assert parameters.pop("title") == "IDL0001"
        assert parameters.keys() <= PARAMETERS
        if span is None:
            assert parameters == {}
            continue
        assert parameters.pop("file") == span.file
        lines = {"line": str(span.line), "endLine": str(span.end_line)}
        columns = {"col": str(span.column), "endColumn": str(span.end_column)}
        assert parameters == (lines | columns if span.line == span.end_line else lines)


def test_paths_are_those_of_the_repository_on_the_host(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The host takes relative paths from the root of the repository, not the working folder."""
    (tmp_path / "robot/idl").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "robot")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    outside = Path(__file__).as_posix()
    files = {
        "idl/a.idl": "robot/idl/a.idl",
        "../b.idl": "b.idl",
        str(tmp_path / "robot/c.idl"): "robot/c.idl",
        outside: outside,
    }
    for file, shown in files.items():
        given = [Diagnostic("IDL0001", Severity.ERROR, "bad", Span(file, 1, 1, 1, 2))]
        [(_, parameters, _)] = commands(report(given, {}, "github"))
        assert parameters["file"] == shown
        [run] = json.loads(report(given, {}, "sarif"))["runs"]
        [place] = run["results"][0]["locations"]
        uri = place["physicalLocation"]["artifactLocation"]["uri"]
        assert uri == (f"file://{outside}" if file == outside else shown)
        assert f"{file}:1:1: error" in report(
            given, {}
        )  # for people, from where they are


def test_sarif_has_all_that_code_scanning_requires(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As GitHub lists it, for every rule, and for findings without a place."""
    monkeypatch.chdir(tmp_path)
    Path("rtgen.toml").write_text("")
    codes = [*explain.rules(), "OTHER1"]
    given = [Diagnostic(code, Severity.ERROR, "wrong") for code in codes]
    log = json.loads(report(given, {}, "sarif"))
    assert log["$schema"]
    assert log["version"] == "2.1.0"
    [run] = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert len(rules) == len(run["results"]) == len(codes)
    for rule in rules:
        assert 0 < len(rule["shortDescription"]["text"]) <= 1024
        assert 0 < len(rule["fullDescription"]["text"]) <= 1024
        assert rule["help"]["text"]
        assert rule["defaultConfiguration"]["level"] in ("note", "warning", "error")
    for result in run["results"]:
        assert result["message"]["text"]
        [place] = result["locations"]
        assert place["physicalLocation"] == {
            "artifactLocation": {"uri": "rtgen.toml"},
            "region": {"startLine": 1, "startColumn": 1, "endLine": 1, "endColumn": 1},
        }


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
