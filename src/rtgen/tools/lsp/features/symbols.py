"""Symbols: the outline of a document, and a search for names in all projects."""

from __future__ import annotations

from lsprotocol.types import (
    DocumentSymbol,
    Location,
    Position,
    Range,
    SymbolKind,
    WorkspaceSymbol,
)

from rtgen.tools.indexing.index import Kind, Place
from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.workspace import View, Workspace

SYMBOLS = {
    Kind.FILE: SymbolKind.File,
    Kind.MODULE: SymbolKind.Module,
    Kind.STRUCT: SymbolKind.Struct,
    Kind.UNION: SymbolKind.Struct,
    Kind.EXCEPTION: SymbolKind.Struct,
    Kind.ENUM: SymbolKind.Enum,
    Kind.ENUMERATOR: SymbolKind.EnumMember,
    Kind.BITS: SymbolKind.Enum,
    Kind.TYPEDEF: SymbolKind.TypeParameter,
    Kind.CONSTANT: SymbolKind.Constant,
    Kind.INTERFACE: SymbolKind.Interface,
    Kind.OPERATION: SymbolKind.Method,
    Kind.PARAMETER: SymbolKind.Variable,
    Kind.ATTRIBUTE: SymbolKind.Property,
    Kind.MEMBER: SymbolKind.Field,
    Kind.COMPONENT: SymbolKind.Class,
    Kind.PORT: SymbolKind.Event,
    Kind.SIGNATURE: SymbolKind.Interface,
    Kind.FUNCTION: SymbolKind.Method,
    Kind.CELLTYPE: SymbolKind.Class,
    Kind.CELL: SymbolKind.Object,
    Kind.DEVICE: SymbolKind.Class,
    Kind.OBJECT: SymbolKind.Object,
    Kind.NODE: SymbolKind.Object,
    Kind.INSTANCE: SymbolKind.Object,
}
_LEFT_OUT = (Kind.PARAMETER,)
MAX_SYMBOLS = 1000
"""Maximum number of symbols in the response of a search."""


def document_symbols(view: View) -> list[DocumentSymbol]:
    """Return the outline of a document: definitions nested as in the text."""
    outermost: list[DocumentSymbol] = []
    holders: dict[str, DocumentSymbol] = {}
    entries = [e for e in view.definitions() if e[4].kind not in _LEFT_OUT]
    for start, end, first, last, d in sorted(entries, key=lambda e: (e[2], -e[3])):
        symbol = DocumentSymbol(
            name=d.name,
            kind=SYMBOLS[d.kind],
            range=view.range(first, last),
            selection_range=view.range(start, end),
            detail=d.detail or None,
        )
        holder = holders.get(d.container)
        if holder is None:
            outermost.append(symbol)
        else:
            holder.children = holder.children or []
            assert isinstance(holder.children, list)
            holder.children.append(symbol)
            _widen(holder, symbol)
        holders[d.key] = (
            symbol  # a module can be reopened: what follows is in the last opening
        )
    return outermost


def _widen(holder: DocumentSymbol, inner: DocumentSymbol) -> None:
    """Extend the range of a symbol to contain that of a nested one."""
    if _after(inner.range.end, holder.range.end):
        holder.range = Range(holder.range.start, inner.range.end)


def _after(one: Position, two: Position) -> bool:
    return (one.line, one.character) > (two.line, two.character)


def workspace_symbols(workspace: Workspace, query: str) -> list[WorkspaceSymbol]:
    """Return the names that contain the letters of a query in order, best matches first."""
    lower_query = query.lower()
    symbols: dict[tuple[str, str, int], tuple[tuple[int, str], WorkspaceSymbol]] = {}
    for analysis in workspace.analyses():
        for file, d in analysis.index.all():
            rank = _rank(lower_query, d.name.lower())
            if rank is None or d.kind in _LEFT_OUT:
                continue
            place = Place(file, d.start, d.end, True)
            location = workspace.location_of(place)
            if location is None:
                continue
            symbol = WorkspaceSymbol(
                location=Location(uri_of(file.path), location.range),
                name=d.name,
                kind=SYMBOLS[d.kind],
                container_name=_named(d.container) or None,
            )
            symbols[file.path, d.key, d.start] = (rank, d.name), symbol
            if len(symbols) > 16 * MAX_SYMBOLS:
                break
    ordered = sorted(symbols.items(), key=lambda item: (item[1][0], item[0]))
    return [symbol for _, (_, symbol) in ordered[:MAX_SYMBOLS]]


def _rank(query: str, name: str) -> int | None:
    """Rank a match: 0 equal, 1 starts with the query, 2 contains it, 3 contains its letters."""
    if name == query:
        return 0
    if name.startswith(query):
        return 1
    if query in name:
        return 2
    letters = iter(name)
    return 3 if all(letter in letters for letter in query) else None


def _named(key: str) -> str:
    return key.rpartition("#")[2].rpartition(" ")[2]
