"""Hover: description of the name under the pointer."""

from __future__ import annotations

import re

from lsprotocol.types import Hover, MarkupContent, MarkupKind, Position

from rtgen.compiler.diagnostics.explain import rules, story
from rtgen.tools.lsp.documents import Language
from rtgen.tools.lsp.features.describe import described
from rtgen.tools.lsp.features.schema import key_at
from rtgen.tools.lsp.workspace import View

_CODE = re.compile(r"[A-Z]{2,6}\d{3,4}")


def hover(view: View, position: Position) -> Hover | None:
    """Return the description of the name at a position."""
    occurrence = view.occurrence(position)
    if occurrence is not None and view.analysis is not None:
        text = described(view.analysis, occurrence[0].key)
        if text is not None:
            return Hover(MarkupContent(MarkupKind.Markdown, text), occurrence[1])
    if view.language is Language.PROJECT:
        return _rule(view, position)
    if view.language is Language.BUS:
        key = key_at(view.text, view.offset(position))
        if key is not None and key.description:
            text = f"**{key.name}**: {key.description}"
            return Hover(
                MarkupContent(MarkupKind.Markdown, text), view.range(key.start, key.end)
            )
    return None


def _rule(view: View, position: Position) -> Hover | None:
    """Return the explanation of a diagnostic code, such as one in `[lint] ignore`."""
    offset = view.offset(position)
    line = view.text.source.rfind("\n", 0, offset) + 1
    for match in _CODE.finditer(view.text.source, line):
        if match.start() > offset:
            return None
        if match.end() >= offset:
            rule = rules().get(match[0])
            if rule is None:
                return None
            text = MarkupContent(MarkupKind.Markdown, story(rule))
            return Hover(text, view.range(*match.span()))
    return None
