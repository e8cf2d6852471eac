"""Structs and enums without a tag have the name of what is declared with them, in CDL and C."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
import seeds

from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.model.tecs import (
    TecsDeclaration,
    TecsEnum,
    TecsStruct,
    TecsTypedef,
    TecsUnit,
)

CASES = [
    ("typedef struct { int x; } tPos;", {"tPos": "x: int"}),
    ("typedef struct { int x; } tPos, tAlias;", {"tPos": "x: int"}),
    ("typedef struct { int x; } *pPos, tPos;", {"tPos": "x: int"}),
    ("typedef struct { int x; } tRow[3], tPos;", {"tPos": "x: int"}),
    ("typedef struct { int x; } *pPos;", {"pPos_type": "x: int"}),
    ("typedef struct { int x; } tRow[3], *pRow;", {"tRow_type": "x: int"}),
    ("typedef struct { int x; } (*pRow)[3];", {"pRow_type": "x: int"}),
    ("typedef struct tPos { int x; } tPos;", {"tPos": "x: int"}),
    ("typedef struct tTag { int x; } tPos;", {"tTag": "x: int"}),
    (
        "struct tOuter { struct { int x; } inner, other; };",
        {"tOuter": "inner: struct tOuter_inner, other: struct tOuter_inner"},
    ),
    (
        "typedef struct { struct { int x; } cells[2]; } tOuter;",
        {"tOuter": "cells: struct tOuter_cells[2]", "tOuter_cells": "x: int"},
    ),
    (
        "typedef struct { struct { struct { int x; } b; } *a; } tOuter;",
        {"tOuter_a": "b: struct tOuter_a_b", "tOuter_a_b": "x: int"},
    ),
    ("typedef enum { RED, GREEN } tColour;", {"tColour": "RED=0 GREEN=1"}),
    ("typedef enum { RED } *pColour;", {"pColour_type": "RED=0"}),
    (
        "typedef struct { enum { RED } colour; } tLamp;",
        {"tLamp": "colour: enum tLamp_colour", "tLamp_colour": "RED=0"},
    ),
    # Tags have a name space of their own.
    (
        "struct tPos { int a; }; typedef struct { int b; } tPos;",
        {"tPos": "a: int", "tPos_": "b: int"},
    ),
    (
        "typedef struct { struct { int x; } a; } t; struct t_a { int y; };"
        "struct user { struct t_a one; };",
        {"t_a": "x: int", "t_a_": "y: int", "user": "one: struct t_a_"},
    ),
]


def read(folder: Path, text: str, *, header: bool) -> TecsUnit:
    """Return the unit of declarations in a CDL file, or in a header that one imports."""
    main = folder / "main.cdl"
    if header:
        (folder / "types.h").write_text(text)
        main.write_text('import_C( "types.h" );')
    else:
        main.write_text(text)
    result = load([main], root=folder)
    assert [d.message for d in result.diagnostics] == []
    (unit,) = result.model.tecs
    return unit


def shown(declaration: TecsDeclaration) -> str:
    if isinstance(declaration, TecsEnum):
        return " ".join(f"{name}={value}" for name, value in declaration.members)
    assert isinstance(declaration, TecsStruct)
    return ", ".join(f"{m.name}: {m.type}" for m in declaration.members)


def types(unit: TecsUnit) -> dict[str, str]:
    """Return the structs and enums by name."""
    found = [d for d in unit.declarations if isinstance(d, TecsStruct | TecsEnum)]
    assert len({d.name for d in found}) == len(found)
    return {d.scoped: shown(d) for d in found}


@pytest.mark.parametrize("header", [False, True])
@pytest.mark.parametrize(("text", "expected"), CASES)
def test_names(
    text: str, expected: dict[str, str], header: bool, tmp_path: Path
) -> None:
    found = types(read(tmp_path, text, header=header))
    assert {name: found.get(name) for name in expected} == expected


@pytest.mark.parametrize("header", [False, True])
def test_a_type_in_a_name_space_or_header_is_found(
    header: bool, tmp_path: Path
) -> None:
    text = "typedef struct { int x; } tPos; typedef struct { tPos at; } tBase;"
    unit = read(tmp_path, text, header=header)
    typedef = unit.find(("tBase",), TecsTypedef)
    struct = unit.find(("tBase",), TecsStruct)
    assert isinstance(typedef, TecsTypedef)
    assert isinstance(struct, TecsStruct)
    assert str(typedef.type) == "struct tBase"
    assert str(struct.members[0].type) == "tPos"


def test_in_a_name_space(tmp_path: Path) -> None:
    text = "typedef struct { int a; } tPos; namespace nA { typedef struct { int x; } tIn; };"
    found = types(read(tmp_path, text, header=False))
    assert found == {"tPos": "a: int", "nA::tIn": "x: int"}


def test_the_comment_of_the_typedef_describes_the_struct(tmp_path: Path) -> None:
    text = "/** A position. */ typedef struct { int x; } tPos;"
    struct, typedef = read(tmp_path, text, header=False).declarations
    assert struct.doc == typedef.doc == "A position."


@pytest.mark.parametrize("header", [False, True])
def test_unrelated_types_change_no_name(header: bool, tmp_path: Path) -> None:
    """Names depend on the declaration alone, not on the number of those before it."""
    random = Random(seeds.seed())
    texts = [text for text, expected in CASES if "tPos_" not in expected]
    for number in range(seeds.budget(20)):
        chosen = random.sample(texts, 2)
        prefix = (
            "typedef struct { int q; struct { int r; } s; } tUnrelated, *pUnrelated;"
        )
        alone, beside = (
            read(_made(tmp_path / f"{number}{i}"), text, header=header)
            for i, text in enumerate((chosen[0], f"{prefix} {chosen[0]}"))
        )
        before = types(alone)
        assert before.items() <= types(beside).items()


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder
