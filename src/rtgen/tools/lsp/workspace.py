"""State of the server: open documents, their projects, and each project's last analysis."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import msgspec
from lsprotocol.types import Location, Position, Range

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span, ToolError
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.project import FILE_NAME, Project, load, shown, with_arguments
from rtgen.compiler.project.kinds import is_definition
from rtgen.facts.files import absolute_path, overlaid
from rtgen.tools.indexing.index import (
    Definition,
    FileIndex,
    Index,
    Occurrence,
    Place,
)
from rtgen.tools.indexing.text import Shift, Shifts, Text
from rtgen.tools.lsp.analysis import Analysis, analyse, emitted, problems_of
from rtgen.tools.lsp.documents import Document, Documents, Language, Snapshot, uri_of


@dataclass(frozen=True, slots=True)
class ProjectKey:
    """A project by its folder; `file` is a document that its rtgen.toml does not contain."""

    root: str
    file: str = ""


@dataclass(slots=True)
class _State:
    """The last analysis of a project, its texts, and the errors in its settings."""

    analysis: Analysis | None = None
    problems: tuple[Diagnostic, ...] = ()
    project: Project | None = None
    snapshot: Snapshot | None = None
    memo: Memo = field(default_factory=Memo)


Findings: TypeAlias = dict[str, list[Diagnostic]]
"""The diagnostics of a project by absolute path."""


class Workspace:
    """Documents, projects and analyses. Analyses may run in another thread than requests."""

    def __init__(self) -> None:
        self.documents = Documents()
        self._states: dict[ProjectKey, _State] = {}
        self._keys: dict[str, ProjectKey] = {}
        self._lock = threading.Lock()

    # Projects

    def key_of(self, path: str) -> ProjectKey:
        """Return the project of a file, which may have to be loaded."""
        with self._lock:
            cached = self._keys.get(path)
        if cached is not None:
            return cached
        folder = Path(path).parent
        with overlaid(self.documents.snapshot().contents):
            try:
                project = load(folder)
            except (InputError, ToolError):
                project = None
        if project is None:
            key = self._around(folder) or ProjectKey(str(folder), path)
        else:
            files = (*project.sources, *project.systems, project.file)
            inside = any(
                file is not None and absolute_path(file) == path for file in files
            )
            key = ProjectKey(str(project.root), "" if inside else path)
        with self._lock:
            self._keys[path] = key
        return key

    def project_of(self, path: str) -> Project:
        """Return the project of a file as it is now. Raises InputError, ToolError."""
        return _loaded(self.key_of(path))

    def _around(self, folder: Path) -> ProjectKey | None:
        """Return the project around a folder whose settings were valid before."""
        with self._lock:
            for parent in (folder, *folder.parents):
                key = ProjectKey(str(parent))
                if key in self._states:
                    return key
        return None

    def _is_foreign(self, path: str) -> bool:
        """Return whether a file with a common suffix, such as .toml, is another tool's."""
        document = self.documents.at(path)
        with overlaid({} if document is None else {path: document.data}):
            return Path(path).name != FILE_NAME and not is_definition(Path(path))

    def forget_projects(self) -> None:
        """Determine the project of each file again: files or settings have changed."""
        with self._lock:
            self._keys.clear()

    def open_projects(self) -> set[ProjectKey]:
        """Return the projects of the open documents."""
        return {self.key_of(document.path) for document in self.documents.all}

    # Analyses

    def analyse(
        self, key: ProjectKey, is_superseded: Callable[[], bool] = lambda: False
    ) -> Findings:
        """Analyse the current texts of a project; return its diagnostics by absolute path.

        Those of back ends are the previous ones, moved to their current places, until `emit` renews
        them. Raises SupersededError if `is_superseded` returns true.
        """
        if key.file and self._is_foreign(key.file):
            with self._lock:
                self._states.pop(key, None)
            return self._by_file(key, ())
        snapshot = self.documents.snapshot()
        with self._lock:
            state = self._states.setdefault(key, _State())
        state.snapshot = snapshot
        with overlaid(snapshot.contents):
            try:
                state.project = _loaded(key)
                state.problems = ()
            except (InputError, ToolError) as error:
                state.problems = problems_of(error)
        if state.project is None:
            return self._by_file(key, state.problems)
        before = state.analysis
        try:
            analysis = analyse(
                state.project,
                snapshot,
                state.memo,
                whole=not key.file,
                before=before,
                is_superseded=is_superseded,
            )
        except ToolError as error:
            return self._by_file(key, (*state.problems, *problems_of(error)))
        if analysis.complete is not None and before is not None:
            moved = (self._moved(emission, before) for emission in before.emitting)
            analysis = replace(
                analysis, emitting=tuple(d for d in moved if d is not None)
            )
        state.analysis = analysis
        return self._by_file(
            key, (*state.problems, *analysis.findings, *analysis.emitting)
        )

    def emit(
        self, key: ProjectKey, is_superseded: Callable[[], bool] = lambda: False
    ) -> Findings | None:
        """Run the back ends on the last analysis; return all diagnostics, None if unchanged.

        Raises SupersededError if `is_superseded` returns true.
        """
        with self._lock:
            state = self._states.get(key)
        if state is None or state.analysis is None or state.snapshot is None:
            return None
        last = state.analysis
        try:
            analysis = emitted(last, state.snapshot, is_superseded=is_superseded)
        except ToolError as error:
            analysis = replace(last, complete=None, emitting=problems_of(error))
        state.analysis = analysis
        if analysis.emitting == last.emitting:
            return None
        return self._by_file(
            key, (*state.problems, *analysis.findings, *analysis.emitting)
        )

    def _moved(self, finding: Diagnostic, analysis: Analysis) -> Diagnostic | None:
        """Return a diagnostic at its current place; None if the place was edited."""
        span = finding.span
        if span is None:
            return finding
        document = self.documents.at(absolute_path(span.file))
        text = analysis.texts.get(span.file)
        if document is None or text is None:
            return finding
        place = document.shift_from(text).forward(*text.offsets(span))
        if place is None:
            return None
        return msgspec.structs.replace(
            finding, span=document.text.span(span.file, *place)
        )

    def _by_file(self, key: ProjectKey, diagnostics: Iterable[Diagnostic]) -> Findings:
        by_file: Findings = {}
        for document in self.documents.all:
            if self.key_of(document.path) == key:
                by_file[document.path] = []
        nowhere = str(Path(key.root) / "rtgen.toml") if not key.file else key.file
        for finding in diagnostics:
            path = nowhere if finding.span is None else absolute_path(finding.span.file)
            by_file.setdefault(path, []).append(finding)
        return by_file

    def analysis(self, path: str) -> Analysis | None:
        """Return the last analysis of a file's project."""
        key = self.key_of(path)
        with self._lock:
            state = self._states.get(key)
        return None if state is None else state.analysis

    def analyses(self) -> list[Analysis]:
        """Return the last analyses of all projects."""
        with self._lock:
            states = list(self._states.values())
        return [state.analysis for state in states if state.analysis is not None]

    def text_of(self, path: str) -> Text | None:
        """Return the current text of a file: the editor's, else that of the last analysis."""
        document = self.documents.at(path)
        if document is not None:
            return document.text
        for analysis in self.analyses():
            for file, text in analysis.texts.items():
                if absolute_path(file) == path:
                    return text
        return None

    def view(self, uri: str) -> View | None:
        """Return a document with its analysis; None if it is not open, or another tool's."""
        document = self.documents.of(uri)
        if document is None:
            return None
        if self.key_of(document.path).file and self._is_foreign(document.path):
            return None
        return View(self, document, self.analysis(document.path))

    # Places

    def range_of(self, place: Place) -> Range | None:
        """Return the current place of a name; None if it is being edited."""
        file = place.file
        document = self.documents.at(file.path)
        if document is None:
            return file.text.range(place.start, place.end, self.documents.encoding)
        moved = document.shift_from(file.text).forward(place.start, place.end)
        if moved is None:
            return None
        return document.text.range(*moved, self.documents.encoding)

    def location_of(self, place: Place) -> Location | None:
        """Return the place of a name with its file."""
        range_ = self.range_of(place)
        return None if range_ is None else Location(uri_of(place.file.path), range_)

    def range_of_span(self, span: Span, text: Text) -> Range:
        """Return the range of a span in a text."""
        return text.range(*text.offsets(span), self.documents.encoding)


class View:
    """A document with the index of its last analysis, whose places are moved by later edits."""

    def __init__(
        self, workspace: Workspace, document: Document, analysis: Analysis | None
    ) -> None:
        self.workspace = workspace
        self.document = document
        self.analysis = analysis
        self.index = Index(()) if analysis is None else analysis.index
        self.file: FileIndex | None = self.index.files.get(document.path)

    @property
    def text(self) -> Text:
        """The current text."""
        return self.document.text

    @property
    def language(self) -> Language:
        """The document's language."""
        return self.document.language

    @cached_property
    def shift(self) -> Shift | Shifts:
        """The edits since the analysis."""
        if self.file is None:
            return Shifts(())
        return self.document.shift_from(self.file.text)

    def offset(self, position: Position) -> int:
        """Return the offset of a position in the current text."""
        return self.text.offset(position, self.workspace.documents.encoding)

    def range(self, start: int, end: int) -> Range:
        """Return the range of [start, end) of the current text."""
        return self.text.range(start, end, self.workspace.documents.encoding)

    def occurrence(self, position: Position) -> tuple[Occurrence, Range] | None:
        """Return the name at a position, and its current range."""
        if self.file is None:
            return None
        shift = self.shift
        hit = self.file.at(shift.back(self.offset(position)))
        if hit is None:
            return None
        moved = shift.forward(hit.start, hit.end)
        if moved is None or not moved[0] <= self.offset(position) <= moved[1]:
            return None
        return hit, self.range(*moved)

    def occurrences(self) -> Iterator[tuple[int, int, Occurrence]]:
        """Yield the current places of the names that edits have not changed."""
        shift = self.shift
        for each in () if self.file is None else self.file.occurrences:
            moved = shift.forward(each.start, each.end)
            if moved is not None:
                yield *moved, each

    def definitions(self) -> Iterator[tuple[int, int, int, int, Definition]]:
        """Yield the current places of definitions: of the name and the whole."""
        shift = self.shift
        for each in () if self.file is None else self.file.definitions:
            moved = shift.forward(each.start, each.end)
            if moved is not None:
                first, last = shift.around(each.first, each.last)
                yield *moved, min(first, moved[0]), max(last, moved[1]), each


def _loaded(key: ProjectKey) -> Project:
    """Load the project of a key. Raises InputError, ToolError."""
    project = load(Path(key.root))
    if not key.file:
        return project
    return with_arguments(project, paths=[shown(Path(key.file))])
