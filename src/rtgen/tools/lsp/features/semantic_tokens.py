"""Semantic tokens: the kind of each name, which an editor's grammar cannot determine."""

from __future__ import annotations

from lsprotocol.types import (
    Range,
    SemanticTokenModifiers,
    SemanticTokens,
    SemanticTokensLegend,
    SemanticTokenTypes,
)

from rtgen.tools.indexing.index import Kind
from rtgen.tools.indexing.text import UTF_32
from rtgen.tools.lsp.workspace import View

_TYPES = {
    Kind.FILE: SemanticTokenTypes.String,
    Kind.MODULE: SemanticTokenTypes.Namespace,
    Kind.STRUCT: SemanticTokenTypes.Struct,
    Kind.UNION: SemanticTokenTypes.Struct,
    Kind.EXCEPTION: SemanticTokenTypes.Struct,
    Kind.ENUM: SemanticTokenTypes.Enum,
    Kind.ENUMERATOR: SemanticTokenTypes.EnumMember,
    Kind.BITS: SemanticTokenTypes.Enum,
    Kind.TYPEDEF: SemanticTokenTypes.Type,
    Kind.CONSTANT: SemanticTokenTypes.Variable,
    Kind.INTERFACE: SemanticTokenTypes.Interface,
    Kind.OPERATION: SemanticTokenTypes.Method,
    Kind.PARAMETER: SemanticTokenTypes.Parameter,
    Kind.ATTRIBUTE: SemanticTokenTypes.Property,
    Kind.MEMBER: SemanticTokenTypes.Property,
    Kind.COMPONENT: SemanticTokenTypes.Class,
    Kind.PORT: SemanticTokenTypes.Event,
    Kind.SIGNATURE: SemanticTokenTypes.Interface,
    Kind.FUNCTION: SemanticTokenTypes.Method,
    Kind.CELLTYPE: SemanticTokenTypes.Class,
    Kind.CELL: SemanticTokenTypes.Variable,
    Kind.DEVICE: SemanticTokenTypes.Class,
    Kind.OBJECT: SemanticTokenTypes.Property,
    Kind.NODE: SemanticTokenTypes.Variable,
    Kind.INSTANCE: SemanticTokenTypes.Variable,
}
_ORDER = [*dict.fromkeys(_TYPES.values())]
_NUMBERS = {kind: _ORDER.index(token) for kind, token in _TYPES.items()}
_DEFINITION, _READ_ONLY = 1, 2
LEGEND = SemanticTokensLegend(
    token_types=[str(each.value) for each in _ORDER],
    token_modifiers=[
        SemanticTokenModifiers.Definition.value,
        SemanticTokenModifiers.Readonly.value,
    ],
)


def semantic_tokens(view: View, range_: Range | None = None) -> SemanticTokens:
    """Return the resolved names of a document, or of a range."""
    text = view.text
    encoding = view.workspace.documents.encoding
    low = 0 if range_ is None else view.offset(range_.start)
    high = len(text.source) if range_ is None else view.offset(range_.end)
    plain = encoding == UTF_32 or text.source.isascii()
    starts = text.whole_lines
    data: list[int] = []
    line = before_line = before = 0
    passed = -1
    for start, end, each in view.occurrences():
        if start < low or start >= high or start < passed or end == start:
            continue
        definition = view.index.definition(each.key)
        if definition is None:
            continue
        while line + 1 < len(starts) and starts[line + 1] <= start:
            line += 1
        if line + 1 < len(starts) and end > starts[line + 1]:
            continue  # a token cannot span lines
        if plain:
            character, length = start - starts[line], end - start
        else:
            place = text.range(start, end, encoding)
            character = place.start.character
            length = place.end.character - character
        modifiers = _DEFINITION if each.defines else 0
        if definition.kind is Kind.CONSTANT:
            modifiers |= _READ_ONLY
        data += (
            line - before_line,
            character - (before if line == before_line else 0),
            length,
            _NUMBERS[definition.kind],
            modifiers,
        )
        before_line, before, passed = line, character, end
    return SemanticTokens(data=data)
