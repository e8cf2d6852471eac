"""Renames a name and all its uses in the project."""

from __future__ import annotations

import re
from collections.abc import Mapping

from lsprotocol.types import (
    Position,
    PrepareRenamePlaceholder,
    TextEdit,
    WorkspaceEdit,
)

from rtgen.compiler.frontends.cdl.syntax import keywords as cdl_keywords
from rtgen.compiler.kit.resources import IDL_FILES, idl_file
from rtgen.compiler.typemap.idl_keywords import FOLDED
from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.indexing.index import Definition, Kind, Place
from rtgen.tools.lsp.workspace import View

_NAME = re.compile(r"[^\W\d]\w*", re.ASCII)
_LANGUAGES = ("idl", "cdl", "rts", "bus")
_INSTANCE = re.compile(r"[\w.-]+")


class RenameError(Exception):
    """The name cannot be renamed, or not to the new one; the message says why."""


def prepared(view: View, position: Position) -> PrepareRenamePlaceholder | None:
    """Return the name at a position with its range; None if it cannot be renamed."""
    target = view.occurrence(position)
    if target is None or view.index.definition(target[0].key) is None:
        return None
    occurrence, place = target
    if occurrence.key.split(" ", 1)[0] not in _LANGUAGES:
        return None
    definition = view.index.definition(occurrence.key)
    assert definition is not None
    return PrepareRenamePlaceholder(place, definition.name)


def renamed(view: View, position: Position, name: str) -> WorkspaceEdit:
    """Return the edits that rename the name at a position. Raises RenameError."""
    occurrence = view.occurrence(position)
    if occurrence is None:
        raise RenameError("there is no name here")
    key = occurrence[0].key
    definition = view.index.definition(key)
    language = key.split(" ", 1)[0]
    if definition is None or language not in _LANGUAGES:
        raise RenameError(f"{_called(definition, key)} is not defined by a name")
    _check_name(definition, language, name)
    siblings = view.index.inside(definition.container)
    clash = next((d for d in siblings if _same(d, name, language)), None)
    if clash is not None and clash.key != key:
        raise RenameError(f"there is a {clash.kind} {clash.name} beside it")
    edits: dict[str, list[TextEdit]] = {}
    for place in view.index.places(key):
        path, edit = _edit(view, place, definition, name)
        edits.setdefault(uri_of(path), []).append(edit)
    return WorkspaceEdit(changes=_sorted(edits))


def _check_name(definition: Definition, language: str, name: str) -> None:
    form = _INSTANCE if definition.kind is Kind.INSTANCE else _NAME
    if not form.fullmatch(name):
        raise RenameError(f"{name!r} is not a name")
    if language == "idl" and name.lower() in FOLDED:
        raise RenameError(f"{name} is a keyword of IDL")
    if language == "cdl" and name in cdl_keywords.RESERVED:
        raise RenameError(f"{name} is a keyword of CDL")


def _same(definition: Definition, name: str, language: str) -> bool:
    if language == "idl":  # names of IDL that differ in case only clash
        return definition.name.lower() == name.lower()
    return definition.name == name


def _edit(
    view: View, place: Place, definition: Definition, name: str
) -> tuple[str, TextEdit]:
    path = place.file.path
    if any(path == str(idl_file(shipped)) for shipped in IDL_FILES) and not (
        view.document.path == path
    ):
        raise RenameError(f"{definition.name} is used in a file of rtgen itself")
    written = place.file.text.source[place.start : place.end]
    if written.lstrip("_") != definition.name.lstrip("_"):
        raise RenameError(
            f"{definition.name} comes from a macro, or is written so: {written}"
        )
    range_ = view.workspace.range_of(place)
    if range_ is None:
        raise RenameError("the name is being edited: try again")
    return path, TextEdit(range_, name)


def _sorted(edits: Mapping[str, list[TextEdit]]) -> dict[str, list[TextEdit]]:
    """Return the edits by file, sorted and unique."""
    return {
        uri: sorted(
            {(e.range.start.line, e.range.start.character): e for e in each}.values(),
            key=lambda e: (e.range.start.line, e.range.start.character),
        )
        for uri, each in sorted(edits.items())
    }


def _called(definition: Definition | None, key: str) -> str:
    return definition.name if definition is not None else key.split(" ", 1)[-1]
