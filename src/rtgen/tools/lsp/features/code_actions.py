"""Code actions: the safe fixes of `rtgen lint --fix`, and the suggestions in hints."""

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

from rtgen.tools.indexing.index import path_of
from rtgen.tools.lsp.features.diagnostics import SOURCE
from rtgen.tools.lsp.workspace import View

_NEAR = re.compile(
    r"\nhint: did you mean (?:the keyword )?'?([\w:.]+)'?\?(?: If it was renamed: .*)?$"
)
_WRITE = re.compile(r"\nhint: write ([\w:]+)$")
_INCLUDE = re.compile(
    r"\nhint: it is declared in [^:]+: write (#include \"[^\"\n]+\")$"
)
_NAME = re.compile(r"[\w:.]+")
_INCLUDED = re.compile(r"^[ \t]*#[ \t]*include\b[^\n]*\n", re.MULTILINE)


def code_actions(
    view: View, range_: Range, diagnostics: Sequence[Diagnostic]
) -> list[CodeAction]:
    """Return the actions for a range, and for rtgen's diagnostics there."""
    return [*_fixes(view, range_), *_hinted(view, diagnostics)]


def _fixes(view: View, range_: Range) -> Iterator[CodeAction]:
    """Yield the fixes of diagnostics that start or end in a range, and one for all fixes."""
    if view.analysis is None or view.file is None:
        return
    low, high = view.offset(range_.start), view.offset(range_.end)
    everything: list[TextEdit] = []
    for finding in view.analysis.findings:
        if finding.fix is None or finding.span is None:
            continue
        if path_of(finding.span.file) != view.document.path:
            continue
        place = view.shift.forward(*view.file.text.offsets(finding.span))
        moved = [
            (view.shift.forward(*view.file.text.offsets(edit.span)), edit)
            for edit in finding.fix.edits
        ]
        edits = [
            TextEdit(view.range(*stretch), edit.new)
            for stretch, edit in moved
            if stretch is not None
            and view.text.source[stretch[0] : stretch[1]] == edit.old
        ]
        if place is None or len(edits) < len(moved):
            continue
        if not any(edit in everything for edit in edits):
            everything += edits
        if place[0] <= high and place[1] >= low:
            yield CodeAction(
                title=f"{finding.fix.title[:1].upper()}{finding.fix.title[1:]} ({finding.code})",
                kind=CodeActionKind.QuickFix,
                edit=WorkspaceEdit(changes={view.document.uri: edits}),
                is_preferred=True,
            )
    if everything:
        yield CodeAction(
            title="Fix all that rtgen can fix safely",
            kind=CodeActionKind.SourceFixAll,
            edit=WorkspaceEdit(changes={view.document.uri: everything}),
        )


def _hinted(view: View, diagnostics: Sequence[Diagnostic]) -> list[CodeAction]:
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
        offset = _after_includes(view.text.source)
        place = view.range(offset, offset)
        yield f"Add {match[1]}", TextEdit(place, f"{match[1]}\n")
        return
    match = _NEAR.search(message) or _WRITE.search(message)
    if match is not None and _NAME.fullmatch(written) and written != match[1]:
        yield f"Change {written} to {match[1]}", TextEdit(diagnostic.range, match[1])


def _written(view: View, place: Range) -> str:
    return view.text.source[view.offset(place.start) : view.offset(place.end)]


def _after_includes(source: str) -> int:
    """Return the offset for a new include: after the last one, else the start."""
    last = 0
    for match in _INCLUDED.finditer(source):
        last = match.end()
    return last
