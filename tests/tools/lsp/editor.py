"""An editor in the tests' process: a project on disk, documents with unsaved texts."""

from __future__ import annotations

from pathlib import Path

from lsprotocol.types import (
    Location,
    Position,
    Range,
    TextDocumentContentChangePartial,
    TextDocumentEdit,
    TextEdit,
    WorkspaceEdit,
)

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.tools.lsp.documents import path_of, uri_of
from rtgen.tools.lsp.workspace import View, Workspace

SETTINGS = '[sources]\npaths = ["specs"]\ninclude = ["specs"]\n'


class Editor:
    """Opens files of a project in `folder`; a `^` in a text marks a position."""

    def __init__(self, folder: Path, settings: str = SETTINGS, **files: str) -> None:
        self.folder = folder
        self.workspace = Workspace()
        (folder / "specs").mkdir()
        (folder / "rtgen.toml").write_text(settings, encoding="utf-8")
        for name, text in files.items():
            self.path(name).write_text(text, encoding="utf-8", newline="")

    def path(self, name: str) -> Path:
        """Return the path of a file: `types_idl` is specs/types.idl."""
        if name == "rtgen_toml":
            return self.folder / "rtgen.toml"
        stem, _, suffix = name.rpartition("_")
        return self.folder / "specs" / f"{stem}.{suffix}"

    def open(self, name: str, text: str | None = None) -> View:
        """Open a file with its own text or an unsaved one."""
        path = self.path(name)
        source = path.read_bytes().decode("utf-8") if text is None else text
        self.workspace.documents.open(uri_of(str(path)), 1, source)
        return self.analysed(name)

    def findings(self, name: str) -> dict[str, list[Diagnostic]]:
        """Analyse the project of a file; return its findings by the names of files."""
        key = self.workspace.key_of(str(self.path(name)))
        found = self.workspace.analyse(key)
        found = self.workspace.emit(key) or found
        return {Path(path).name: each for path, each in found.items()}

    def analysed(self, name: str) -> View:
        """Return the view of a document after an analysis."""
        self.findings(name)
        return self.view(name)

    def view(self, name: str) -> View:
        """Return the current view of a document."""
        view = self.workspace.view(uri_of(str(self.path(name))))
        assert view is not None
        return view

    def edit(self, name: str, at: str, new: str) -> View:
        """Replace the range between two `^` of a piece of the text, without analysis."""
        view = self.view(name)
        before, old, after = at.split("^")
        start = view.text.source.index(before + old + after) + len(before)
        range_ = view.range(start, start + len(old))
        document = view.document
        self.workspace.documents.change(
            document.uri,
            document.version + 1,
            [TextDocumentContentChangePartial(range_, new)],
        )
        return self.view(name)

    def at(self, view: View, marked: str) -> Position:
        """Return the position of the `^` in a piece of the text."""
        before, after = marked.split("^")
        assert view.text.source.count(before + after) == 1, marked
        offset = view.text.source.index(before + after) + len(before)
        return view.range(offset, offset).start

    def shown(self, location: Location) -> str:
        """Return a location with its text: `types.idl:3 Point`."""
        path = path_of(location.uri)
        assert path is not None
        line = location.range.start.line
        return f"{Path(path).name}:{line + 1} {self.text(path, location.range)}"

    def text(self, path: str, range_: Range) -> str:
        """Return the text in a range of a file."""
        text = self.workspace.text_of(path)
        assert text is not None
        encoding = self.workspace.documents.encoding
        first = text.offset(range_.start, encoding)
        return text.source[first : text.offset(range_.end, encoding)]

    def applied(self, edit: WorkspaceEdit) -> dict[str, str]:
        """Return the texts of the files after an edit, by name."""
        made = {}
        changes = dict(edit.changes or {}) | {
            each.text_document.uri: each.edits
            for each in edit.document_changes or ()
            if isinstance(each, TextDocumentEdit)
        }
        for uri, edits in changes.items():
            path = path_of(uri)
            assert path is not None
            text = self.workspace.text_of(path)
            assert text is not None
            for each in sorted(
                (each for each in edits if isinstance(each, TextEdit)),
                key=lambda e: (e.range.start.line, e.range.start.character),
                reverse=True,
            ):
                text, _ = text.replaced(
                    each.range, each.new_text, self.workspace.documents.encoding
                )
            made[Path(path).name] = text.source
        return made
