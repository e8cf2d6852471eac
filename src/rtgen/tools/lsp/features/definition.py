"""Go to definition, across languages."""

from __future__ import annotations

from lsprotocol.types import Location, Position, Range

from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.workspace import View

_START = Range(Position(0, 0), Position(0, 0))


def definition(view: View, position: Position) -> list[Location]:
    """Return the definitions of the name at a position; that of a file is its start."""
    occurrence = view.occurrence(position)
    if occurrence is None:
        return []
    key = occurrence[0].key
    if key.startswith("file "):
        return [Location(uri_of(key.removeprefix("file ")), _START)]
    places = [place for place in view.index.places(key) if place.defines]
    located = (view.workspace.location_of(place) for place in places)
    return [location for location in located if location is not None]
