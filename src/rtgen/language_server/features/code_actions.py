"""Code actions: the changes that a finding's hint proposes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lsprotocol.types import (
    CodeAction,
    CodeActionKind,
    Diagnostic,
    Range,
    TextEdit,
    WorkspaceEdit,
)

from rtgen.language_server.features.diagnostics import SOURCE
from rtgen.language_server.workspace import View

_NEAR = re.compile(r"\nhint: did you mean (?:the keyword )?'?([\w:.]+)'?\?$")
_WRITE = re.compile(r"\nhint: write ([\w:]+)$")
_INCLUDE = re.compile(
    r"\nhint: it is declared in [^:]+: write (#include \"[^\"\n]+\")$"
)
_NAME = re.compile(r"[\w:.]+")
_INCLUDED = re.compile(r"^[ \t]*#[ \t]*include\b[^\n]*\n", re.MULTILINE)


def code_actions(view: View, diagnostics: Sequence[Diagnostic]) -> list[CodeAction]:
    """The changes for findings of rtgen at a place."""
    return [
        CodeAction(
            title=title,
            kind=CodeActionKind.QuickFix,
            diagnostics=[diagnostic],
            edit=WorkspaceEdit(changes={view.document.uri: [edit]}),
            is_preferred=True,
        )
        for diagnostic in diagnostics
        if diagnostic.source == SOURCE
        for title, edit in _changes(view, diagnostic)
    ]


def _changes(view: View, diagnostic: Diagnostic) -> Iterator[tuple[str, TextEdit]]:
    message = diagnostic.message
    written = _written(view, diagnostic.range)
    if (match := _INCLUDE.search(message)) is not None:
        offset = _behind_includes(view.text.source)
        place = view.range(offset, offset)
        yield f"Add {match[1]}", TextEdit(place, f"{match[1]}\n")
        return
    match = _NEAR.search(message) or _WRITE.search(message)
    if match is not None and _NAME.fullmatch(written) and written != match[1]:
        yield f"Change {written} to {match[1]}", TextEdit(diagnostic.range, match[1])


def _written(view: View, place: Range) -> str:
    return view.text.source[view.offset(place.start) : view.offset(place.end)]


def _behind_includes(source: str) -> int:
    """Where a further include goes: behind the last one, else at the start."""
    last = 0
    for match in _INCLUDED.finditer(source):
        last = match.end()
    return last
