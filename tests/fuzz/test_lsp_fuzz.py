"""The language server after random edits: it has the findings of `rtgen lint` and `check`.

The server reuses what it has read of files; lint and check read everything again.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import seeds
from msgspec.structs import replace

from rtgen.compiler import compilation, linting
from rtgen.compiler.diagnostics import Diagnostic, InputError, has_errors, in_order
from rtgen.compiler.project import behaviours, load
from rtgen.compiler.systems import reading

sys.path.append(str(Path(__file__).parents[1] / "tools" / "lsp"))

from editor import SETTINGS, Editor
from lsprotocol.types import Position, Range, TextDocumentContentChangePartial
from projects import PROJECT

from rtgen.tools.lsp.documents import Document
from rtgen.tools.lsp.features.code_actions import code_actions
from rtgen.tools.lsp.features.completion import completion
from rtgen.tools.lsp.features.definition import definition
from rtgen.tools.lsp.features.folding import folding
from rtgen.tools.lsp.features.formatting import formatting
from rtgen.tools.lsp.features.hover import hover
from rtgen.tools.lsp.features.inlay_hints import inlay_hints
from rtgen.tools.lsp.features.references import highlights, references
from rtgen.tools.lsp.features.rename import RenameError, prepared, renamed
from rtgen.tools.lsp.features.semantic_tokens import semantic_tokens
from rtgen.tools.lsp.features.symbols import document_symbols, workspace_symbols
from rtgen.tools.lsp.workspace import View

SESSIONS = 9
EDITS = 20
"""Number of edits in each session: 180 in all, 5,400 with the budget of `make fuzz`."""

PIECES = (
    *("{", "}", "(", ")", "[", "]", "<", ">", ";", ",", "::", ".", "=", '"', "'", "\n"),
    *("struct", "module", "sequence<long>", "Shapes::Point", "cell", "signature", "#"),
    *('#include "types.idl"\n', "/*", "*/", "//", "1", "-7", "0x2000", "[1017]\n", "\r"),
    *('import("board.cdl");\n', 'import_C("types.h");\n', "#pragma once\n", "word_t"),
    *('#include "drawing.idl"\n', '#include "BasicDataType.idl"\n', '@numeric("array") '),
    *("@unit", "\u00e9", "\U0001f916", "\x0c", "\u2028", "\t", "[node.right]\n", "$NODEID"),
)  # fmt: skip
ALL = Range(Position(0, 0), Position(10_000, 0))

FEATURES: tuple[Callable[[View, Position], Any], ...] = (
    hover,
    definition,
    completion,
    highlights,
    prepared,
    lambda view, place: references(view, place, declaration=True),
    lambda view, place: renamed(view, place, "Renamed"),
    lambda view, _: semantic_tokens(view),
    lambda view, place: semantic_tokens(view, Range(place, ALL.end)),
    lambda view, _: document_symbols(view),
    lambda view, _: workspace_symbols(view.workspace, "po"),
    lambda view, _: folding(view),
    lambda view, _: inlay_hints(view, ALL),
    lambda view, _: code_actions(view, ALL, []),
    lambda view, _: formatting(view),
)


def edited(draw: random.Random, text: str) -> tuple[int, int, str]:
    """Return a range of a text, and its replacement."""
    start = draw.randrange(len(text) + 1)
    kind = draw.randrange(4)
    if kind == 0:
        return start, start, draw.choice(PIECES)
    end = min(len(text), start + draw.choice((1, 2, 8, 40)))
    if kind == 1:
        return start, end, ""
    if kind == 2:
        return start, end, draw.choice(PIECES)
    other = draw.randrange(len(text) + 1)
    return start, start, text[other : other + draw.choice((4, 30, 120))]


def checked(folder: Path) -> list[Diagnostic] | InputError:
    """Return the findings of `rtgen lint` and `check` on disk, or the error of the settings."""
    try:
        project = load(folder)
    except InputError as error:
        return error
    read = compilation.read(project)
    run = compilation.compile_project(project)
    lowered = read
    if not has_errors(read.diagnostics):
        lowered = compilation.read(project, lowered=True)
    place = {"root": project.root, "output": project.output}
    added = reading.added(lowered, project.systems, **place)
    of_systems = added.diagnostics[len(lowered.diagnostics) :]
    read = replace(read, sources=added.sources)
    found = [*linting.unknown_codes(project)] or linting.findings(
        project, read, beside=of_systems
    )
    emitted = [*run.diagnostics]
    if not run.failed:
        emitted += behaviours.check(project, run)
    known = {*read.diagnostics, *of_systems, *found}
    return in_order([*found, *(d for d in emitted if d not in known)])


class Files:
    """The files of a project: each is open in the editor, except a C header."""

    def __init__(self, folder: Path, draw: random.Random) -> None:
        files = dict(PROJECT)
        target = draw.choice(("embedded", "openrtm", "small"))
        settings = f'{SETTINGS}\n[output]\ntarget = "{target}"\n'
        files["more_cdl"] = 'import("board.cdl");\nimport_C("types.h");\n'
        self.editor = Editor(folder, settings, **files)
        self.names = [*files, "rtgen_toml"]
        self._draw = draw
        self._header = self.editor.path("types_h")
        self._header.write_text("typedef int word_t;\n")
        for name in self.names:
            self.editor.open(name)

    def change(self) -> str:
        """Change a file, or add or remove one; return the name of an open one."""
        kind = self._draw.randrange(40)
        name = self._draw.choice(self.names)
        if kind == 0:
            word = self._draw.choice(("short", "long", "struct word"))
            self._header.write_text(f"typedef {word} word_t;\n")
            return name
        if kind == 1 and len(self.names) < 12 and name != "rtgen_toml":
            return self._copy(name)
        if kind in (2, 3) and len(self.names) > 3 and name != "rtgen_toml":
            other = self._copy(name) if kind == 3 else None
            self._remove(name)
            return other or self.names[0]
        start, end, new = edited(self._draw, self.document(name).text.source)
        self._replace(name, start, end, new)
        return name

    def save(self) -> None:
        """Write all files as in the editor."""
        for each in self.names:
            text = self.document(each).text.source
            self.editor.path(each).write_bytes(text.encode())

    def document(self, name: str) -> Document:
        """Return a file as in the editor."""
        found = self.editor.workspace.documents.at(str(self.editor.path(name)))
        assert found is not None
        return found

    def _replace(self, name: str, start: int, end: int, new: str) -> None:
        document, documents = self.document(name), self.editor.workspace.documents
        place = document.text.range(start, end, documents.encoding)
        change = TextDocumentContentChangePartial(place, new)
        documents.change(document.uri, document.version + 1, [change])
        if name == "rtgen_toml":
            self.editor.workspace.forget_projects()

    def _copy(self, name: str) -> str:
        stem, _, suffix = name.rpartition("_")
        new = f"{stem}{self._draw.randrange(10)}_{suffix}"
        if new not in self.names:
            text = self.document(name).text.source
            self.editor.path(new).write_bytes(text.encode())
            self.names.append(new)
            self.editor.workspace.forget_projects()
            uri = self.editor.path(new).as_uri()
            self.editor.workspace.documents.open(uri, 1, text)
        return new

    def _remove(self, name: str) -> None:
        self.names.remove(name)
        self.editor.workspace.documents.close(self.document(name).uri)
        self.editor.path(name).unlink()
        self.editor.workspace.forget_projects()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("number", seeds.cases(SESSIONS))
def test_random_edits(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    draw = random.Random(number)
    files = Files(tmp_path, draw)
    editor = files.editor
    for edit in range(1, EDITS + 1):
        document = files.document(files.change())
        view = editor.workspace.view(document.uri)
        offset = draw.randrange(len(document.text.source) + 1)
        features = draw.sample(FEATURES, 5)
        if view is not None:  # else its words differ from those of rtgen's files
            position = view.range(offset, offset).start
            for feature in features:
                with suppress(RenameError):
                    feature(view, position)
        if edit % 5:
            continue
        found = editor.findings(
            "rtgen_toml"
        )  # of the project, which may not have the file any more
        if edit % 10:
            continue
        files.save()
        wanted = checked(tmp_path)
        if isinstance(
            wanted, InputError
        ):  # the files are read with the previous settings
            # One of these files may be deleted; then a system has no position for it.
            placed = [d for d in found["rtgen.toml"] if d.span is not None]
            assert placed == in_order(wanted.diagnostics)
            continue
        assert in_order(d for each in found.values() for d in each) == wanted
