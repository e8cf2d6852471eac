"""References to a name in the project, and highlights in a document."""

from __future__ import annotations

from lsprotocol.types import (
    DocumentHighlight,
    DocumentHighlightKind,
    Location,
    Position,
)

from rtgen.tools.lsp.workspace import View


def references(view: View, position: Position, *, declaration: bool) -> list[Location]:
    """Return the places of the name at a position, including its `declaration` if requested."""
    occurrence = view.occurrence(position)
    if occurrence is None:
        return []
    places = view.index.places(occurrence[0].key)
    located = (
        view.workspace.location_of(place)
        for place in places
        if declaration or not place.defines
    )
    return [location for location in located if location is not None]


def highlights(view: View, position: Position) -> list[DocumentHighlight]:
    """Return the places of the name at a position in its document."""
    occurrence = view.occurrence(position)
    if occurrence is None:
        return []
    return [
        DocumentHighlight(
            view.range(start, end),
            (
                DocumentHighlightKind.Write
                if each.defines
                else DocumentHighlightKind.Read
            ),
        )
        for start, end, each in view.occurrences()
        if each.key == occurrence[0].key
    ]
