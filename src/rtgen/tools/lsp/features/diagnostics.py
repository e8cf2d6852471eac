"""Converts rtgen's diagnostics to the protocol's."""

from __future__ import annotations

from collections.abc import Iterable

from lsprotocol import types

from rtgen.compiler import diagnostics
from rtgen.tools.indexing.index import path_of
from rtgen.tools.indexing.text import Text
from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.workspace import Workspace

_SEVERITIES = {
    diagnostics.Severity.ERROR: types.DiagnosticSeverity.Error,
    diagnostics.Severity.WARNING: types.DiagnosticSeverity.Warning,
    diagnostics.Severity.NOTE: types.DiagnosticSeverity.Information,
}
SOURCE = "rtgen"


def published(
    workspace: Workspace, path: str, findings: Iterable[diagnostics.Diagnostic]
) -> list[types.Diagnostic]:
    """Return the diagnostics of a file, with places in its current text."""
    text = workspace.text_of(path) or Text("")
    return [_published(workspace, text, finding) for finding in findings]


def _published(
    workspace: Workspace, text: Text, finding: diagnostics.Diagnostic
) -> types.Diagnostic:
    start = types.Position(0, 0)
    place = types.Range(start, start)
    if finding.span is not None:
        place = workspace.range_of_span(finding.span, text)
    hint = f"\nhint: {finding.hint}" if finding.hint else ""
    return types.Diagnostic(
        range=place,
        message=finding.message + hint,
        severity=_SEVERITIES[finding.severity],
        code=finding.code or None,
        source=SOURCE,
        related_information=[*_related(workspace, finding)] or None,
    )


def _related(
    workspace: Workspace, finding: diagnostics.Diagnostic
) -> Iterable[types.DiagnosticRelatedInformation]:
    for related in finding.related:
        path = path_of(related.span.file)
        text = workspace.text_of(path)
        if text is not None:
            place = workspace.range_of_span(related.span, text)
            location = types.Location(uri_of(path), place)
            yield types.DiagnosticRelatedInformation(location, related.label)
