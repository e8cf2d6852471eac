"""Diagnostics about a user's input, made from rules; `report` prints them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from functools import cache
from pathlib import Path

import msgspec

from rtgen.facts.looks import CONTENT, look

_PAGES = Path(__file__).parent / "pages"
_HINTS = Path(__file__).with_name("hints.toml")


class Severity(StrEnum):
    """Severity of a diagnostic; only an error makes a command exit with 2."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


MAX_TEXT_LENGTH = 1000
"""Maximum length of a message, hint or label in characters; quotations of a file may be longer."""


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


class Rule(msgspec.Struct, frozen=True):
    """A rule: the source of its diagnostics and of the page of `rtgen explain`.

    `text` is the explanation of a plug-in's rule; rtgen's own rules have theirs in a file.
    """

    code: str
    title: str
    severity: Severity
    text: str | None = None

    @property
    def explanation(self) -> str:
        """Markdown: the error, an example, and how to fix it; read from `pages/<code>.md`.

        Empty for a plug-in's rule without one.
        """
        if self.text is not None:
            return self.text
        return _page(self.code)

    def at(
        self,
        span: Span | None,
        message: str,
        *,
        related: Iterable[Related] = (),
        hint: str | None = None,
    ) -> Diagnostic:
        """Return a diagnostic; texts longer than MAX_TEXT_LENGTH are cut in the middle.

        Without a `hint`, the rule's hint in `hints.toml` is used, if there is one.
        """
        if hint is None:
            hint = _hints().get(self.code)
        return Diagnostic(
            self.code,
            self.severity,
            _shortened(message),
            span,
            tuple(Related(each.span, _shortened(each.label)) for each in related),
            None if hint is None else _shortened(hint),
        )


def rules_of(names: Mapping[str, object]) -> tuple[Rule, ...]:
    """Return the rules among the `globals()` of a module, in order."""
    return tuple(value for value in names.values() if isinstance(value, Rule))


@cache
def _page(code: str) -> str:
    page = _PAGES / f"{code}.md"
    look(CONTENT, page)
    return page.read_text(encoding="utf-8") if page.is_file() else ""


@cache
def _hints() -> dict[str, str]:
    import tomllib

    return tomllib.loads(_HINTS.read_text(encoding="utf-8"))


def _shortened(text: str) -> str:
    if len(text) <= MAX_TEXT_LENGTH:
        return text
    half = MAX_TEXT_LENGTH // 2
    return f"{text[:half]} [...] {text[-half:]}"


class InputError(Exception):
    """Input that cannot be processed further, with its diagnostics (at least one error)."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(f"{d.code}: {d.message}" for d in self.diagnostics))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Diagnostic, ...]]]:
        return (InputError, (self.diagnostics,))


class ToolError(Exception):
    """An error of the environment (disk, port, missing extra), not of the input: exit code 3."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.message = message
        self.hint = hint
        super().__init__(message)

    def __reduce__(self) -> tuple[type[ToolError], tuple[str, str | None]]:
        return (ToolError, (self.message, self.hint))


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return whether any diagnostic is an error."""
    return any(d.severity is Severity.ERROR for d in diagnostics)


def in_order(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics without duplicates, sorted by place, then code."""
    unique = dict.fromkeys(diagnostics)
    nowhere = Span("", 0, 0, 0, 0)
    return sorted(unique, key=lambda d: (d.span or nowhere, d.code, d.message))
