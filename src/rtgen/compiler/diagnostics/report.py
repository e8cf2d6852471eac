"""Printers of diagnostics: text with source lines, JSON, SARIF 2.1.0, annotations of GitHub.

A printer takes diagnostics and the texts that they refer to, and returns the text to print.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TypeAlias
from urllib.parse import quote

from rtgen.compiler.diagnostics import Diagnostic, Fix, Rule, Severity, Span, in_order
from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.kit.translation import listed, translated, translated_word
from rtgen.facts.columns import columns
from rtgen.facts.encodings import decode
from rtgen.facts.files import MAX_BYTES, is_file, read_start
from rtgen.facts.version import __version__

FORMS = ("text", "json", "sarif", "github")

_TAB = 4
_WINDOW = 100
_COLOURS = {Severity.ERROR: "1;31", Severity.WARNING: "1;33", Severity.NOTE: "1;36"}
_BEFORE = 40
_MAX_DESCRIPTION = 1024
"""Maximum length of a rule's description for GitHub."""
_PROJECT = "rtgen.toml"
_SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def report(
    diagnostics: Sequence[Diagnostic],
    sources: Mapping[str, str],
    form: str = "text",
    *,
    colour: bool = False,
) -> str:
    """Return the diagnostics in one of FORMS, sorted and without duplicates; ends with a line feed.

    `sources` maps displayed paths to texts; other files are read from the disk.
    """
    ordered = in_order(diagnostics)
    match form:
        case "json":
            return json.dumps([as_json(d) for d in ordered], indent=2) + "\n"
        case "sarif":
            return json.dumps(_sarif(ordered), indent=2) + "\n"
        case "github":
            return "".join(_github(d) for d in ordered)
    texts = _Texts(sources)
    return "".join(_text(d, texts, colour) for d in ordered)


def summary(diagnostics: Sequence[Diagnostic]) -> str:
    """Return `2 errors, 1 warning, 3 notes` in the language; empty without diagnostics."""
    ordered = in_order(diagnostics)
    counts = []
    for severity in Severity:
        number = sum(d.severity is severity for d in ordered)
        if number:
            text = f"{number} {severity.value}{'s' if number > 1 else ''}"
            counts.append(translated(text))
    return listed(counts)


def as_json(d: Diagnostic) -> dict[str, object]:
    """Return a diagnostic as a JSON object."""
    return {
        "code": d.code,
        "severity": d.severity.value,
        "message": d.message,
        **_place(d.span),
        "related": [
            {
                "file": r.span.file,
                "line": r.span.line,
                "column": r.span.column,
                "label": r.label,
            }
            for r in d.related
        ],
        "hint": d.hint,
        **({} if d.fix is None else {"fix": _fix(d.fix)}),
    }


def _fix(fix: Fix) -> dict[str, object]:
    edits = [{**_place(edit.span), "text": edit.new} for edit in fix.edits]
    return {"title": fix.title, "edits": edits}


def _place(span: Span | None) -> dict[str, object]:
    if span is None:
        return dict.fromkeys(("file", "line", "column", "end_line", "end_column"))
    return {
        "file": span.file,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }


_Paint: TypeAlias = Callable[[str, str], str]


class _Texts:
    """The lines of the files that diagnostics refer to."""

    def __init__(self, sources: Mapping[str, str]) -> None:
        self._sources = sources
        self._lines: dict[str, list[str]] = {}

    def line(self, file: str, number: int) -> str | None:
        """Return a line by number, without its line end; None if there is none."""
        if file not in self._lines:
            self._lines[file] = self._text(file).split("\n")
        lines = self._lines[file]
        return (
            lines[number - 1].removesuffix("\r") if 0 < number <= len(lines) else None
        )

    def _text(self, file: str) -> str:
        if file in self._sources:
            return self._sources[file]
        path = Path(file)
        try:
            return decode(read_start(path, MAX_BYTES)).normal
        except OSError:
            return ""


def _text(d: Diagnostic, texts: _Texts, colour: bool) -> str:
    paint = _painter(colour)
    severity = translated_word(d.severity.value)
    head = f"{paint(f'{severity}[{d.code}]', _COLOURS[d.severity])}: "
    lines = [_prefix(d.span) + head + paint(_shown(d.message), "1")]
    if d.span is not None:
        lines += _excerpt(d.span, texts, paint, _COLOURS[d.severity])
    for related in d.related:
        note = paint(translated_word("note"), _COLOURS[Severity.NOTE])
        lines.append(f"{_prefix(related.span)}{note}: {_shown(related.label)}")
        lines += _excerpt(related.span, texts, paint, _COLOURS[Severity.NOTE])
    if d.hint:
        lines.append(f"  {paint(translated_word('hint'), '1;32')}: {_shown(d.hint)}")
    return "\n".join(lines) + "\n"


def _prefix(span: Span | None) -> str:
    return "" if span is None else f"{printable(span.file)}:{span.line}:{span.column}: "


def _painter(colour: bool) -> _Paint:
    """Return a function that applies an ANSI style, or the identity function."""
    return (
        (lambda text, style: f"\x1b[{style}m{text}\x1b[0m")
        if colour
        else (lambda text, _: text)
    )


def _excerpt(span: Span, texts: _Texts, paint: _Paint, style: str) -> list[str]:
    """Return the source line of a span and a line of carets; empty if the line does not exist."""
    line = texts.line(span.file, span.line)
    if line is None:
        return []
    start = min(span.column - 1, len(line))
    end = span.end_column - 1 if span.end_line == span.line else len(line)
    first = max(0, start - _BEFORE) if len(line) > _WINDOW else 0
    last = first + _WINDOW
    head, before = _drawn(line[first:start], 1 if first else 0)
    marked, wide = _drawn(line[start : min(end, last)], before)
    tail, _ = _drawn(line[max(start, min(end, last)) : last], wide)
    left = "…" if first else ""
    right = "…" if len(line) > last else ""
    gutter = f"{span.line:>5} | "
    carets = "^" * max(1, wide - before)
    return [
        (gutter + left + head + marked + tail + right).rstrip(),
        " " * (len(gutter) - 2) + "| " + " " * before + paint(carets, style),
    ]


def _drawn(text: str, column: int) -> tuple[str, int]:
    """Return the text as a terminal can show it, and the column after it; it begins in `column`."""
    if text.isascii() and text.isprintable():
        return text, column + len(text)
    drawn = []
    for character in text:
        if character == "\t":
            character = " " * (_TAB - column % _TAB)
            width = len(character)
        else:
            width = columns(character)
            if width and not character.isprintable():
                character = "\N{REPLACEMENT CHARACTER}"
                width = columns(character)
        drawn.append(character)
        column += width
    return "".join(drawn), column


def _shown(text: str) -> str:
    return printable(translated(text), "\n")


def _github(d: Diagnostic) -> str:
    """Return a workflow command of GitHub; columns are of one line only, as it requires."""
    level = "notice" if d.severity is Severity.NOTE else d.severity.value
    properties = {"title": d.code}
    if d.span is not None:
        is_line = d.span.line == d.span.end_line
        properties = {
            "file": _in_repository(d.span.file),
            "line": str(d.span.line),
            **({"col": str(d.span.column)} if is_line else {}),
            "endLine": str(d.span.end_line),
            **({"endColumn": str(d.span.end_column)} if is_line else {}),
            **properties,
        }
    text = ",".join(f"{k}={_escaped(v, ',:')}" for k, v in properties.items())
    message = d.message if d.hint is None else f"{d.message}\n{d.hint}"
    return f"::{level} {text}::{_escaped(message)}\n"


def _in_repository(file: str) -> str:
    """Return the path from the root of the repository in a workflow of GitHub, else as shown.

    GitHub takes relative paths as such, whatever the working folder is.
    """
    root = os.environ.get("GITHUB_WORKSPACE")
    if root:
        path = Path(os.path.realpath(file))
        with suppress(ValueError):
            return path.relative_to(os.path.realpath(root)).as_posix()
    return file


def _escaped(text: str, further: str = "") -> str:
    for character in "%\r\n" + further:
        text = text.replace(character, f"%{ord(character):02X}")
    return text


def _sarif(diagnostics: Sequence[Diagnostic]) -> dict[str, object]:
    codes = sorted({d.code for d in diagnostics})
    rules = _rules() if diagnostics else {}
    return {
        "$schema": _SARIF_SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "rtgen",
                        "version": __version__,
                        "rules": [_sarif_rule(code, rules.get(code)) for code in codes],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "results": [_sarif_result(d, codes.index(d.code)) for d in diagnostics],
            }
        ],
    }


def _rules() -> Mapping[str, Rule]:
    from rtgen.compiler.diagnostics.explain import rules

    return rules()


def _sarif_rule(code: str, rule: Rule | None) -> dict[str, object]:
    """Return a rule; code scanning of GitHub requires each of the texts."""
    title = code if rule is None else rule.title
    text = "" if rule is None else rule.explanation.strip()
    summary = text.partition("\n\n")[0].replace("\n", " ")
    severity = Severity.WARNING if rule is None else rule.severity
    return {
        "id": code,
        "shortDescription": {"text": title},
        "fullDescription": {"text": (summary or title)[:_MAX_DESCRIPTION]},
        "defaultConfiguration": {"level": severity.value},
        "help": {"text": text or title, "markdown": text or title},
    }


def _sarif_result(d: Diagnostic, rule_index: int) -> dict[str, object]:
    text = d.message if d.hint is None else f"{d.message}\n{d.hint}"
    result: dict[str, object] = {
        "ruleId": d.code,
        "ruleIndex": rule_index,
        "level": d.severity.value,
        "message": {"text": text},
    }
    span = d.span or _of_project()
    if span is not None:
        result["locations"] = [{"physicalLocation": _sarif_place(span)}]
    if d.related:
        result["relatedLocations"] = [
            {"physicalLocation": _sarif_place(r.span), "message": {"text": r.label}}
            for r in d.related
        ]
    if d.fix is not None:
        result["fixes"] = [_sarif_fix(d.fix)]
    return result


def _of_project() -> Span | None:
    """Return the place of a diagnostic without one: hosts show none that has no location."""
    return Span(_PROJECT, 1, 1, 1, 1) if is_file(Path(_PROJECT)) else None


def _sarif_fix(fix: Fix) -> dict[str, object]:
    """Return a fix as in SARIF 2.1.0, 3.55; all edits of a fix are in one file."""
    places = [_sarif_place(edit.span) for edit in fix.edits]
    change = {
        "artifactLocation": places[0]["artifactLocation"],
        "replacements": [
            {"deletedRegion": place["region"], "insertedContent": {"text": edit.new}}
            for place, edit in zip(places, fix.edits, strict=True)
        ],
    }
    return {"description": {"text": fix.title}, "artifactChanges": [change]}


def _sarif_place(span: Span) -> dict[str, object]:
    file = _in_repository(span.file)
    path = Path(file)
    return {
        "artifactLocation": {
            "uri": path.as_uri() if path.is_absolute() else quote(file)
        },
        "region": {
            "startLine": span.line,
            "startColumn": span.column,
            "endLine": span.end_line,
            "endColumn": span.end_column,
        },
    }
