"""Types with much content: their text grows with the definition, not with all reachable types."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.layouts.cdr_types import MAX_LOOPS

LEVELS = 24


def tower(levels: int = LEVELS) -> str:
    """Return structs, each with two sequences and a value of the one before."""
    lines = ["struct S0 { string a; sequence<string> b; octet c; };"]
    lines += [
        f"struct S{n} {{ octet z; sequence<S{n - 1}> a; sequence<S{n - 1}, 4> b; S{n - 1} c; }};"
        for n in range(1, levels)
    ]
    return "\n".join(lines)


def filled(package: Any, level: int) -> Any:
    if level == 0:
        return package.S0("a" * 3, ["", "bc"], 7)
    inner = filled(package, level - 1)
    last = package.__dict__[f"S{level - 1}"]()
    return package.__dict__[f"S{level}"](level, [last, inner], [last], last)


def test_structs_in_structs_in_structs(tmp_path: Path) -> None:
    """The text stays small, compiles, and agrees with the codec along descriptors."""
    package = emitted.emit_text(tmp_path, tower())
    size = sum(path.stat().st_size for path in tmp_path.rglob("*.py"))
    assert size < LEVELS * 80_000
    value = filled(package, LEVELS - 1)
    for little_endian in (True, False):
        octets = value.to_cdr(little_endian)
        assert octets == value.to_xcdr1(little_endian)
        assert type(value).from_cdr(octets, little_endian) == value
    assert value._snapshot_() == value


@pytest.mark.parametrize("depth", [MAX_LOOPS + 1, MAX_LOOPS + 2])
def test_sequences_in_sequences(tmp_path: Path, depth: int) -> None:
    """The innermost sequence, of numbers, is not a loop."""
    type_ = "sequence<" * depth + "long" + ">" * depth
    text = f"struct S {{ {type_} x; }};"
    if depth > MAX_LOOPS + 1:
        path = tmp_path / "deep.idl"
        path.write_text(text, encoding="utf-8")
        model = load([path], root=tmp_path).model
        found = BACKEND.emit(model, Options("deep", "skeletons", "0.0.0")).diagnostics
        assert [d.code for d in found] == ["PY0001"]
        return
    package: Any = emitted.emit_text(tmp_path, text)
    nested: Any = [1, 2]
    for _ in range(depth - 1):
        nested = [[], nested] if isinstance(nested[0], list) else [nested]
    value = package.S(nested)
    assert package.S.from_cdr(value.to_cdr()) == value
