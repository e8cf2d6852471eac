"""The language server after random edits: alive, and its findings those of `rtgen lint`."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import seeds

from rtgen import compiler, linting
from rtgen.diagnostics import Diagnostic, InputError, in_order
from rtgen.project import load

sys.path.append(str(Path(__file__).parents[1] / "unit" / "language_server"))

from editor import Editor
from lsprotocol.types import Position, Range
from projects import PROJECT

from rtgen.language_server.features.code_actions import code_actions
from rtgen.language_server.features.completion import completion
from rtgen.language_server.features.definition import definition
from rtgen.language_server.features.folding import folding
from rtgen.language_server.features.formatting import formatting
from rtgen.language_server.features.hover import hover
from rtgen.language_server.features.inlay_hints import inlay_hints
from rtgen.language_server.features.references import highlights, references
from rtgen.language_server.features.rename import RenameError, prepared, renamed
from rtgen.language_server.features.semantic_tokens import semantic_tokens
from rtgen.language_server.features.symbols import document_symbols, workspace_symbols
from rtgen.language_server.workspace import View

SESSIONS = 17
EDITS = 20
"""So many edits in each session: 340, and 10,200 with the budget of `make fuzz`."""

PIECES = (
    *("{", "}", "(", ")", "[", "]", "<", ">", ";", ",", "::", ".", "=", '"', "'", "\n"),
    *("struct", "module", "sequence<long>", "Shapes::Point", "cell", "signature", "#"),
    *('#include "types.idl"\n', "/*", "*/", "//", "1", "-7", "0x2000", "[1017]\n", "\r"),
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
    """A stretch of a text, and what takes its place."""
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


def linted(folder: Path) -> list[Diagnostic] | InputError:
    """The findings of `rtgen lint` on the disk, or what is wrong with the settings."""
    try:
        project = load(folder)
    except InputError as error:
        return error
    found = [*linting.unknown_codes(project)]
    return in_order(found or linting.findings(project, compiler.read(project)))


@pytest.mark.parametrize("number", seeds.cases(SESSIONS))
def test_random_edits(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    draw = random.Random(number)
    files = {name: text for name, text in PROJECT.items() if name != "system_xml"}
    editor = Editor(tmp_path, **files)
    names = [*files, "rtgen_toml"]
    for name in names:
        editor.open(name)
    for edit in range(1, EDITS + 1):
        name = draw.choice(names)
        view = editor.view(name)
        start, end, new = edited(draw, view.text.source)
        editor.replace(name, start, end, new)
        view = editor.view(name)
        offset = draw.randrange(len(view.text.source) + 1)
        position = view.range(offset, offset).start
        for feature in draw.sample(FEATURES, 5):
            with suppress(RenameError):
                feature(view, position)
        if edit % 5:
            continue
        found = editor.findings(
            "rtgen_toml"
        )  # of the project, which a file may have left
        if edit % 10:
            continue
        for each in names:
            text = editor.view(each).text.source
            editor.path(each).write_bytes(text.encode())
        wanted = linted(tmp_path)
        if isinstance(
            wanted, InputError
        ):  # the files are read by the settings of before
            assert found["rtgen.toml"] == in_order(wanted.diagnostics)
            continue
        assert in_order(d for each in found.values() for d in each) == wanted
