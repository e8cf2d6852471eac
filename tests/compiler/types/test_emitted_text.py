"""The emitted text: golden files, black's form for names of any length, types, diagnostics."""

from __future__ import annotations

import random
import re
from pathlib import Path

import black
import pytest
from type_checkers import check_by_mypy

from rtgen.compiler.backends import Emission, Options
from rtgen.compiler.backends.kit.python_text import fit
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.frontends.idl import load

HERE = Path(__file__).parent
GOLDEN = Path(__file__).parents[2] / "golden" / "types"
CONSTRUCTS = HERE / "constructs.idl"
DYNAMIC = Path(__file__).with_name("dynamic.idl")
OPTIONS = Options("robots", "skeletons", "0.1.0")
MODE = black.Mode(line_length=88, target_versions={black.TargetVersion.PY311})


def emission(path: Path) -> Emission:
    result = load([path], root=path.parent)
    assert not [d for d in result.diagnostics if d.severity == "error"]
    return BACKEND.emit(result.model, OPTIONS)


def emission_of(folder: Path, text: str) -> Emission:
    path = folder / "case.idl"
    path.write_text(text, encoding="utf-8")
    return emission(path)


@pytest.mark.parametrize("case", sorted(p.name for p in GOLDEN.iterdir() if p.is_dir()))
def test_golden(case: str, update_golden: bool) -> None:
    folder = GOLDEN / case
    made = {a.path: a.text for a in emission(folder / "case.idl").artifacts}
    expected = folder / "expected"
    if update_golden:
        for path, text in made.items():
            (expected / path).parent.mkdir(parents=True, exist_ok=True)
            (expected / path).write_text(text, encoding="utf-8")
    kept = {
        p.relative_to(expected).as_posix(): p.read_text(encoding="utf-8")
        for p in expected.rglob("*")
        if p.is_file()
    }
    assert made == kept


@pytest.mark.peer
def test_black_leaves_every_construct_unchanged() -> None:
    for artifact in emission(CONSTRUCTS).artifacts:
        if artifact.text:
            assert black.format_str(artifact.text, mode=MODE) == artifact.text


NAMED = """
module {a} {{
  /// Doc of it.
  enum {b} {{ {c}, {d} }};
  const long {e} = 5; const string {f} = "abc"; const {b} {g} = {c};
  typedef sequence<long> {h}; typedef double {i}[3][4]; typedef string {j};
  struct {k} {{ double {l}; octet {m}; }};
  struct {n} {{
    {k} {o}; sequence<{k}> {p}; {h} {q}; string<5> {r}; {b} {s}; {i} {t}; sequence<{b}> {u};
    boolean {v}[2]; sequence<string> {w}; sequence<double, 4> {x};
  }};
  union {y} switch ({b}) {{ case {c}: {n} {z}; default: long {A}; }};
  struct {B}; typedef sequence<{B}> {C};
  struct {B} {{ long {D}; {C} {E}; {y} {F}; }};
  exception {G} {{ string {H}; }};
  interface {I} {{
    attribute double {J}; readonly attribute {n} {K};
    {n} {L}(in {n} {M}, out {k} {N}) raises ({G});
    void {O}(); long {P}(in long {Q}, in string {R});
  }};
  interface {S} : {I} {{
    void {T}(); {I} {dd}(in {S} {ee}); oneway void {ff}(in {I} {gg});
    {S} {hh}(inout {I} {ii}, in string {jj}, out {h} {kk}) raises ({G}); attribute {I} {ll};
  }};
  struct {U} {{ {I} {V}; {y} {W}; fixed<5,2> {X}; }};
}};
interface {Y} {{}};
struct {Z} {{ double {aa}; double {bb}; double {cc}; }};
"""


@pytest.mark.sampled(3)
@pytest.mark.peer
@pytest.mark.parametrize("longest", [5, 20, 50, 65, 80, 90, 100, 110, 120])
def test_black_leaves_names_of_any_length_unchanged(
    tmp_path: Path, longest: int
) -> None:
    numbers = random.Random(longest)
    names: dict[str, str] = {}
    for key in re.findall(r"\{(\w+)\}", NAMED):
        while key not in names:
            length = numbers.randrange(3, longest)
            name = "n" + "".join(numbers.choices("abcXYZ_09", k=length)) + "e"
            if name.lower() not in [n.lower() for n in names.values()]:
                names[key] = name
    for artifact in emission_of(tmp_path, NAMED.format(**names)).artifacts:
        if artifact.text:
            assert black.format_str(artifact.text, mode=MODE) == artifact.text


@pytest.mark.parametrize(
    "text", ["it's", 'say "x"', "both \" and '", "a\\b", "\0\n\u2028", ""]
)
def test_literals_are_in_blacks_form(text: str) -> None:
    line = f"x = {string_literal(text)}\n"
    assert black.format_str(line, mode=MODE) == line
    scope: dict[str, str] = {}
    exec(line, scope)
    assert scope["x"] == text


@pytest.mark.parametrize(
    "text",
    [
        "One line.",
        'Ends "so"',
        '"Begins" so',
        "A\n\n  B\n   C",
        "\\d",
        "x" * 90,
        'a"""b',
    ],
)
def test_docstrings_are_in_blacks_form(text: str) -> None:
    module = f"class A:\n{docstring(text, 4)}\n    x: int = 0\n"
    assert black.format_str(module, mode=MODE) == module


def test_no_docstring_for_no_text() -> None:
    assert docstring(" \n ", 4) == ""


def test_a_statement_that_cannot_be_split_is_marked() -> None:
    name = "n" * 80
    assert fit(f"{name} = {name}", 4) == f"    {name} = {name}  # fmt: skip"


def test_same_output_twice() -> None:
    assert emission(CONSTRUCTS) == emission(CONSTRUCTS)


def test_headers_name_the_sources() -> None:
    for artifact in emission(CONSTRUCTS).artifacts:
        if artifact.text:
            first, second, _ = artifact.text.split("\n", 2)
            assert first == "# Generated by rtgen 0.1.0 from constructs.idl."
            assert second == "# Owned by rtgen: edits are overwritten by the next run."


def test_types_without_codec_are_reported_at_the_member(tmp_path: Path) -> None:
    text = (
        "native H; struct A { long x; H y; };\nstruct B { A inner; };\n"
        "union C switch (long) { case 1: H z; };\n"
        "struct D { @optional long y; any z; };\n"
        "custom valuetype V { public long x; }; struct E { V v1; };\n"
        "local interface L {}; exception F { L where; };\n"
        "struct G {}; struct I { sequence<G> g1; }; valuetype J { public H y; };\n"
        "typedef H Handles; interface K { H work(in Handles h1, in V v1); };"
    )
    made = emission_of(tmp_path, text)
    assert not made.artifacts
    places = [(d.code, d.span.line, d.span.column) for d in made.diagnostics if d.span]
    assert [code for code, _, _ in places] == ["PY0001"] * 7
    assert [line for _, line, _ in places] == [1, 3, 4, 5, 6, 7, 7]


def test_nothing_is_emitted_for_nothing(tmp_path: Path) -> None:
    assert emission_of(tmp_path, "// nothing\n") == Emission()


@pytest.mark.slow
def test_emitted_modules_pass_mypy(tmp_path: Path) -> None:
    for artifact in (*emission(CONSTRUCTS).artifacts, *emission(DYNAMIC).artifacts):
        path = tmp_path / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    check_by_mypy([tmp_path / "robots"], [tmp_path])


def test_a_file_included_in_a_scope_is_an_input_of_its_owner(tmp_path: Path) -> None:
    (tmp_path / "part.inc").write_text("struct Part { long a; };\n")
    found = emission_of(tmp_path, 'module M {\n#include "part.inc"\n};\n')
    module = next(a for a in found.artifacts if a.path.endswith("_idl/case.py"))
    assert set(module.origin) == {"case.idl", "part.inc"}
    assert "part.inc" in module.text.split('"""')[0]
