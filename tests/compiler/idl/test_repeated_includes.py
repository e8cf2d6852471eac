"""Includes of files that were included before are passed over, and change no result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random

import pytest
from msgspec.structs import replace
from seeds import cases

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends import idl
from rtgen.compiler.frontends.idl.rules.lexical import INCLUDE_CYCLE
from rtgen.compiler.frontends.idl.text import preprocessor
from rtgen.compiler.model import Model

FILES = 5
PARTS: tuple[Callable[[Random, int], str], ...] = (
    lambda draw, _: f'#include "{draw.randrange(FILES)}.idl"\n'
    * draw.choice((1, 1, 2)),
    lambda draw, _: "".join(f'#include "{n}.idl"\n' for n in range(FILES)),
    lambda draw, _: draw.choice(
        ("\n", "// between\n", "/* two\nlines */\n", " \\\n\n")
    ),
    lambda draw, own: f"struct S{own}_{draw.randrange(9)} {{ long x; }};\n",
    lambda draw, _: f"#line {draw.randrange(1, 99)}\n",
    lambda draw, _: f"#undef G{draw.randrange(FILES)}\n",
    lambda draw, _: f"#define G{draw.randrange(FILES)}\n",
    lambda draw, _: (
        f"#ifdef G{draw.randrange(FILES)}\n"
        f'#include "{draw.randrange(FILES)}.idl"\n#endif\n'
    ),
    lambda draw, own: (
        f'module M{own} {{\n#include "{draw.randrange(FILES)}.idl"\n'
        f"const long C{draw.randrange(9)} = 1;\n}};\n"
    ),
    lambda draw, _: "#include missing\n",
)
WEIGHTS = (6, 4, 4, 4, 1, 1, 1, 2, 2, 0.2)


def _write(folder: Path, draw: Random) -> list[Path]:
    """Write files that include each other, each guarded in one of three ways."""
    paths = [folder / f"{number}.idl" for number in range(FILES)]
    for number, path in enumerate(paths):
        parts = draw.choices(PARTS, WEIGHTS, k=draw.randrange(1, 7))
        body = "".join(part(draw, number) for part in parts)
        guarded = f"#ifndef G{number}\n#define G{number}\n{body}#endif\n"
        path.write_text(
            draw.choice(
                (guarded, guarded, f"// {number}\n{guarded}", f"#pragma once\n{body}")
            )
        )
    return paths


@pytest.mark.sampled(40)
@pytest.mark.parametrize("number", cases(400, always=40))
def test_results_are_those_of_reading_each_include(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = Random(number)
    paths = _write(tmp_path, draw)
    mains = draw.sample(paths, draw.randrange(1, 3))
    passed_over = idl.load(mains, root=tmp_path)
    monkeypatch.setattr(preprocessor._Prepared, "repeats", False)
    monkeypatch.setattr(preprocessor.Preprocessor, "row", lambda *_: None)
    each = idl.load(mains, root=tmp_path)
    assert _placed(passed_over.diagnostics) == _placed(each.diagnostics)
    assert _without_owners(passed_over.model) == _without_owners(each.model)


def _placed(diagnostics: Sequence[Diagnostic]) -> set[Diagnostic]:
    """Return diagnostics; includes without an end are given up in any of their lines."""
    anywhere = Span(file="", line=1, column=1, end_line=1, end_column=1)
    return {
        replace(each, span=anywhere) if each.code == INCLUDE_CYCLE.code else each
        for each in diagnostics
    }


def _without_owners(model: Model) -> Model:
    """Return a model whose files belong to none: what adds nothing does not change an owner."""
    files = tuple(replace(file, belongs_to=None) for file in model.files)
    return replace(model, files=files)
