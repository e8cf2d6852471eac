"""Invariants of reading a definition file, whatever its content."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from random import Random

import octets
from fuzzing import ViolationError
from generated import Generated, forgotten_types, generate

from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    Span,
    has_errors,
    in_order,
)
from rtgen.compiler.diagnostics.report import FORMS, report
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.rules import RULES
from rtgen.compiler.frontends.kit import character_rules
from rtgen.compiler.inspection.models import inspect, tree
from rtgen.compiler.lint import lint
from rtgen.compiler.lint import rules as lint_rules
from rtgen.compiler.model import Model

HELPERS = {
    "guarded.idl": (
        b"#ifndef GUARDED\n#define GUARDED\nmodule Inc { struct Item { long a; };"
        b" typedef sequence<Item> Items; enum Tone { DO, RE }; const long SIZE = 3;"
        b" interface Thing { void go(); }; exception Oops {}; };\n#endif\n"
    ),
    "once.idl": b'#pragma once\n#pragma prefix "once.org"\nmodule Once { interface I {}; };\n',
    "members.idl": b"long included_a;\ndouble included_b;\n",
    "broken.idl": b"module Broken { struct S { long a }; \n#if 1\n interface ;",
    "loop.idl": b'#include "loop.idl"\n',
}
"""Files that an input may include beside itself (`input.idl`)."""

CHECK_INTERVALS = {
    "emit": 7,
    "again": 23,
    "loose": 11,
    "lint": 5,
    "import": 77,
    "print": 13,
}
"""One in that many inputs gets the named check."""

_MARKER = re.compile(
    rb"line|#(?:[^\"\w/]|/(?!\*)|/\*(?:[^*]|\*(?!/))*\*/)*\d", re.DOTALL
)
_CODES = {
    rule.code: rule for rule in (*RULES, *lint_rules.RULES, *character_rules.RULES)
}
_ON_DEMAND = [rule.code for rule in lint_rules.ON_DEMAND]


class IdlTarget:
    """Reads inputs as `input.idl` of a folder."""

    def __init__(
        self,
        folder: Path,
        make: Callable[[int], bytes],
        is_valid: Callable[[int], bool] = lambda _number: False,
    ) -> None:
        self._folder = folder
        self._is_valid = is_valid
        self.make = make
        self._path = folder / "input.idl"
        for name, data in HELPERS.items():
            (folder / name).write_bytes(data)

    def check(self, number: int, data: bytes) -> list[str]:
        """Read the input, check all results, and return labels."""
        result = self._read(data)
        # In UTF-16, ASCII has an octet 0 beside each character.
        moved = has_marker(data)
        findings(result.diagnostics, result.sources, moved=moved)
        model, diagnostics = result.model, result.diagnostics
        text = json.dumps(inspect(model, diagnostics), allow_nan=False)
        json.loads(text)
        labels = [d.code for d in diagnostics]
        labels.append("rejected" if has_errors(diagnostics) else "accepted")
        if labels[-1] == "rejected" and self._is_valid(number):
            errors = (d for d in diagnostics if d.severity is Severity.ERROR)
            raise ViolationError(f"a valid program is rejected: {next(errors)}")
        if number % CHECK_INTERVALS["print"] == 0:
            _print(result)
        if number % CHECK_INTERVALS["again"] == 0:
            again = self._read(data)
            if (again.model, again.diagnostics) != (model, diagnostics):
                raise ViolationError("the same input gives something else")
        if number % CHECK_INTERVALS["loose"] == 0:
            loose = self._read(data, ignore_case_clashes=True)
            findings(loose.diagnostics, loose.sources, moved=moved)
        if labels[-1] == "accepted" and number % CHECK_INTERVALS["lint"] == 0:
            found = lint(model, result.sources, select=_ON_DEMAND)
            findings(found, result.sources, moved=moved)
            labels += (d.code for d in found)
        if "accepted" in labels and number % CHECK_INTERVALS["emit"] == 0:
            labels.append(_emit(model, number))
        return list(dict.fromkeys(labels))

    def _read(
        self, data: bytes, *, ignore_case_clashes: bool = False
    ) -> FrontendResult:
        self._path.write_bytes(data)
        return load(
            [self._path],
            root=self._folder,
            include=[self._folder],
            ignore_case_clashes=ignore_case_clashes,
        )


def has_marker(data: bytes) -> bool:
    """Return whether a text has a line marker, which changes the positions of findings."""
    return _MARKER.search(data.replace(b"\0", b"")) is not None


def findings(
    diagnostics: Sequence[Diagnostic], sources: Mapping[str, str], *, moved: bool
) -> None:
    """Check that findings are of known rules, sorted, and within a file.

    `moved`: line markers change their positions.
    """
    if list(diagnostics) != in_order(diagnostics):
        raise ViolationError("the findings are not in order")
    lines = {name: text.split("\n") for name, text in sources.items()}
    for d in diagnostics:
        rule = _CODES.get(d.code)
        if rule is None or rule.severity is not d.severity:
            raise ViolationError(f"{d.code} is not a rule of that severity")
        if not d.message:
            raise ViolationError(f"{d.code} says nothing")
        if d.span is None:
            raise ViolationError(f"{d.code} is nowhere")
        for span in (d.span, *(related.span for related in d.related)):
            _exists(d, span, lines, moved)


def _exists(
    d: Diagnostic, span: Span, lines: dict[str, list[str]], moved: bool
) -> None:
    place = f"{d.code} at {span}"
    if (span.line, span.column) > (span.end_line, span.end_column) or span.column < 1:
        raise ViolationError(f"{place} ends before it starts")
    if span.line < 1:
        raise ViolationError(f"{place} is above the file")
    if moved:
        return
    text = lines.get(span.file)
    if text is None:
        raise ViolationError(f"{place} is in no file that was read")
    # A finding at the end of a line, or of the file, points at the position after it.
    for line, column, room in (
        (span.line, span.column, 1),
        (span.end_line, span.end_column, 2),
    ):
        if line > len(text) or column > len(text[line - 1]) + room:
            raise ViolationError(f"{place} is outside the file")


def _print(result: FrontendResult) -> None:
    for form in FORMS:
        report(result.diagnostics, result.sources, form).encode()
    tree(result.model).encode()
    json.dumps(
        inspect(result.model, result.diagnostics), ensure_ascii=False, indent=2
    ).encode()


def _emit(model: Model, number: int) -> str:
    """Run all back ends; now and then import the output, and decode octets with its types."""
    try:
        texts = generate(model)
    except InputError:
        return "not emitted"
    if number % CHECK_INTERVALS["import"]:
        return "emitted"
    chance = Random(number)
    with forgotten_types():
        modules = Generated(texts).load().values()
        found = [t for module in modules for t in octets.types(module)]
        for type_ in chance.sample(found, min(len(found), 2)):
            for encoding in octets.encodings(type_):
                list(octets.explore(encoding, chance, 10))
    return "imported"
