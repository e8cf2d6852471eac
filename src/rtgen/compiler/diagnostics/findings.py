"""Diagnostics as values: places in texts, notes and fixes."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rtgen.compiler.diagnostics.severities import Severity


class Span(msgspec.Struct, frozen=True, order=True):
    """A range in a user's text: 1-based lines and columns (in characters), end exclusive."""

    file: str
    line: int
    column: int
    end_line: int
    end_column: int


class Related(msgspec.Struct, frozen=True):
    """A further place that explains a diagnostic, such as "first declared here"."""

    span: Span
    label: str


class Edit(msgspec.Struct, frozen=True):
    """An edit that replaces the text `old` at `span`."""

    span: Span
    old: str
    new: str


class Fix(msgspec.Struct, frozen=True):
    """Edits that remove the cause of a diagnostic without changing the meaning."""

    title: str
    edits: tuple[Edit, ...]


class Diagnostic(msgspec.Struct, frozen=True):
    """A diagnostic. `span` is None only if it concerns no file."""

    code: str
    severity: Severity
    message: str
    span: Span | None = None
    related: tuple[Related, ...] = ()
    hint: str | None = None
    fix: Fix | None = None


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return whether any diagnostic is an error."""
    return any(d.severity is Severity.ERROR for d in diagnostics)


def in_order(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics without duplicates, sorted by place, then code."""
    unique = dict.fromkeys(diagnostics)
    nowhere = Span("", 0, 0, 0, 0)
    return sorted(unique, key=lambda d: (d.span or nowhere, d.code, d.message))
