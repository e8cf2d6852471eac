"""Renames a name and all that uses it in the project, behaviours too."""

from __future__ import annotations

from pathlib import Path

from lsprotocol.types import (
    OptionalVersionedTextDocumentIdentifier,
    Position,
    PrepareRenamePlaceholder,
    RenameFile,
    RenameFileOptions,
    TextDocumentEdit,
    TextEdit,
    WorkspaceEdit,
)

from rtgen.compiler.diagnostics import InputError
from rtgen.facts.encodings import decode
from rtgen.facts.files import absolute_path
from rtgen.tools.indexing.text import Text
from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.workspace import View
from rtgen.tools.renaming import plan
from rtgen.tools.renaming.definitions import LANGUAGES, RenameError, language_of


def prepared(view: View, position: Position) -> PrepareRenamePlaceholder | None:
    """Return the name at a position with its range; None if it cannot be renamed."""
    target = view.occurrence(position)
    if target is None:
        return None
    occurrence, place = target
    definition = view.index.definition(occurrence.key)
    if definition is None or language_of(occurrence.key) not in LANGUAGES:
        return None
    return PrepareRenamePlaceholder(place, definition.name)


def renamed(
    view: View, position: Position, name: str, *, moves: bool = True
) -> WorkspaceEdit:
    """Return the edits that rename the name at a position.

    `moves`: the editor can move files. Raises RenameError.
    """
    occurrence = view.occurrence(position)
    if occurrence is None:
        raise RenameError("there is no name here")
    workspace = view.workspace
    snapshot = workspace.documents.snapshot()
    try:
        planned = plan.by_key(
            lambda: workspace.project_of(view.document.path),
            occurrence[0].key,
            name,
            snapshot.contents,
            snapshot.texts,
        )
    except RenameError:
        raise
    except InputError as error:
        first = error.diagnostics[0]
        place = "" if first.span is None else f"{first.span.file}:{first.span.line}: "
        raise RenameError(f"{place}{first.message}", first.span) from error
    if planned.moves and not moves:
        source = planned.moves[0][0].name
        message = f"{source} has to be moved, which this editor does not do"
        command = f"rtgen generate --rename {planned.old}={planned.new}"
        raise RenameError(f"{message}: {command}")
    texts = {
        absolute_path(file): _edits(view, absolute_path(file), planned, file)
        for file in sorted(planned.edits)
        if absolute_path(file) in planned.contents
    }
    if not moves:
        return WorkspaceEdit(changes={uri_of(p): each for p, each in texts.items()})
    return WorkspaceEdit(
        document_changes=[
            *(
                TextDocumentEdit(_identifier(view, p), each)
                for p, each in texts.items()
            ),
            *(
                RenameFile(
                    uri_of(str(source)),
                    uri_of(str(target)),
                    options=RenameFileOptions(overwrite=target.exists()),
                )
                for source, target in planned.moves
            ),
        ]
    )


def _identifier(view: View, path: str) -> OptionalVersionedTextDocumentIdentifier:
    document = view.workspace.documents.at(path)
    version = None if document is None else document.version
    return OptionalVersionedTextDocumentIdentifier(uri_of(path), version)


def _edits(view: View, path: str, planned: plan.Renaming, file: str) -> list[TextEdit]:
    """Return the edits of a file, sorted and unique."""
    document = view.workspace.documents.at(path)
    if document is not None:
        text = document.text
    else:
        standard = Path(path).suffix in (".py", ".toml", ".yaml", ".yml")
        text = Text(decode(planned.contents[path][0], standard=standard).text)
    places = {text.offsets(edit.span): edit.new for edit in planned.edits[file]}
    encoding = view.workspace.documents.encoding
    return [
        TextEdit(text.range(start, end, encoding), places[start, end])
        for start, end in sorted(places)
    ]
