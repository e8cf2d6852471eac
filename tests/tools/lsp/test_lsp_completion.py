"""Completion of IDL: what may stand at a position is offered, and nothing else."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from editor import Editor

from rtgen.compiler.frontends.idl.names.annotation_definitions import DEFINITIONS
from rtgen.compiler.typemap.idl_keywords import CORBA_3, RESERVED
from rtgen.tools.lsp.features.completion import completion
from rtgen.tools.lsp.features.idl_context import expected

KITCHEN = """\
module Kitchen {
  const unsigned long MOST = 4;
  enum Mode { OFF, BAKE };
  @final struct Heat { double degrees; long times[MOST]; };
  typedef Heat Warmth;
  typedef sequence<Heat, MOST> Heats;
  bitmask Lamps { @position(1) LEFT, RIGHT };
  exception Burnt { Mode mode; };
  union Fuel switch (Mode) { case OFF: long none; case BAKE: Heat heat; };
  interface Cook {
    const short LOUD = 3;
    readonly attribute Mode mode;
    void stir(in Heat heat, inout Mode mode) raises(Burnt);
    unsigned short count(out Heats all);
    oneway void ring();
  };
  interface Chef : Cook { Mode plan(); };
};
module Kitchen {
  struct Late : Heat { Warmth more; map<long, Heat> all; };
};
component Oven supports Kitchen::Cook {
  provides Kitchen::Cook cook;
  uses multiple Kitchen::Chef chefs;
  publishes Kitchen::Heat heat;
  consumes Kitchen::Warmth wish;
  @unit("K") @min(0) attribute double start;
  @default(Kitchen::BAKE) attribute Kitchen::Mode mode;
};
"""
"""Each name and each word of it may stand where it does."""

_TOKEN = re.compile(r'"[^"]*"|@?\w+')


def offers(editor: Editor, text: str) -> list[str]:
    """Return what is offered at the `^` of a text."""
    before, after = text.split("^")
    editor.open("kitchen_idl", KITCHEN)
    view = editor.edit("kitchen_idl", "^" + KITCHEN + "^", before + after)
    found = completion(view, view.range(len(before), len(before)).start)
    order = sorted(found.items, key=lambda item: item.sort_text or "")
    return [item.label for item in order]


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    monkeypatch.chdir(tmp_path)
    return Editor(tmp_path, kitchen_idl=KITCHEN)


def test_each_word_is_offered_where_it_stands(editor: Editor) -> None:
    view = editor.open("kitchen_idl")
    names = {d.name for _, d in view.index.all()}
    places = {
        (place.file.path, place.start)
        for _, d in view.index.all()
        for place in view.index.places(d.key)
        if place.defines
    }
    missing = []
    checked = 0
    for match in _TOKEN.finditer(KITCHEN):
        word = match[0].removeprefix("@")
        start = match.end() - len(word)
        known = word in names or word in RESERVED | CORBA_3 or match[0][0] == "@"
        if not known or any(start == place for _, place in places):
            continue
        checked += 1
        found = completion(view, view.range(start, start).start)
        if word not in {item.label for item in found.items}:
            missing.append((KITCHEN[:start].splitlines()[-1], word))
    assert missing == []
    assert checked >= 80


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("component C { publishes Kitchen::^", {"Heat", "Fuel", "Warmth", "Late"}),
        ("component C { emits Kitchen::^", {"Heat", "Fuel", "Warmth", "Late"}),
        ("component C { provides Kitchen::^", {"Cook", "Chef"}),
        ("component C { uses ^", {"Kitchen", "multiple"}),
        ("component C { provides ^", {"Kitchen"}),
        ("component C supports Kitchen::^", {"Cook", "Chef"}),
        ("component C : ^", {"Oven"}),
        ("interface I : Kitchen::^", {"Cook", "Chef"}),
        ("interface I { void f() raises(Kitchen::^", {"Burnt"}),
        ("interface I { void f(^", {"in", "out", "inout"}),
        ("interface I { void f() ^", {"raises"}),
        ("struct S { Kitchen::Heat ^", set()),
        ("struct ^", set()),
        ("struct S { long a[^", {"Kitchen"}),
        ("struct S { long a[Kitchen::^", {"MOST", "OFF", "BAKE", "Cook"}),
        ("const Kitchen::^", {"Mode", "Lamps", "Warmth", "Heats"}),
        ("const long A = Kitchen::^", {"MOST", "OFF", "BAKE", "Cook"}),
        ("const long A = Kitchen::Cook::^", {"LOUD"}),
        ("union U switch (Kitchen::^", {"Mode", "Warmth", "Heats"}),
        ("module M { ^ };", {"struct", "component", "interface", "module"}),
        ("component C { ^", {"provides", "publishes", "attribute", "uses"}),
        ("struct S { unsigned ^", {"short", "long"}),
        ("struct S { sequence<unsigned ^", {"short", "long"}),
        ("@extensibility(^", {"FINAL", "APPENDABLE", "MUTABLE"}),
        ("struct S { @numeric(^", {"ARRAY", "NUMPY"}),
        ("// component C { publishes ^", {"struct", "component"}),
        ('struct S { string<4> a; /* ; { */ @unit("};{") ^', {"long", "Kitchen"}),
    ],
)
def test_only_what_fits_is_offered(editor: Editor, text: str, wanted: set[str]) -> None:
    found = {*offers(editor, text)}
    assert wanted <= found
    names = {"Heat", "Mode", "Cook", "Burnt", "MOST", "OFF", "Oven", "Fuel", "Warmth"}
    names |= {"Chef", "Late", "Lamps", "Heats", "LOUD"}
    assert found & names == wanted & names
    if "long" not in wanted and "struct" not in wanted:
        assert not found & {"long", "double", "struct", "void"}


@pytest.mark.parametrize(
    ("text", "place", "first"),
    [
        ("component C { @^ attribute double a; };", "configuration", "unit"),
        (
            "component C { @^\\n  // how hot\\n publishes Kitchen::Heat h;",
            "port",
            "unit",
        ),
        ("struct S { @^ double a; };", "member", "unit"),
        ("struct S { @key @^ @min(3) double a; };", "member", "unit"),
        ("enum E { @^ A };", "enumerator", "value"),
        ("interface I { void f(@^ in long a); };", "parameter", "unit"),
        ("interface I { @^ void f(in long a); };", "operation", "verbatim"),
        ("interface I { @^ readonly attribute long a; };", "attribute", "unit"),
        ("@^ struct S { long a; };", "struct", "autoid"),
        ("@^ module M { };", "module", "autoid"),
        ("union U switch (long) { @^ case 1: long a; };", "case", "unit"),
        ("bitmask B { @^ LOW };", "bit_value", "position"),
    ],
)
def test_annotations_are_those_of_what_follows(
    editor: Editor, text: str, place: str, first: str
) -> None:
    found = offers(editor, text.replace("\\n", "\n"))
    assert {*found} == {name for name, d in DEFINITIONS.items() if place in d.places}
    assert found[0] == first


@pytest.mark.sampled(0)
def test_any_text_has_an_answer() -> None:
    for end in range(len(KITCHEN)):
        for text in (KITCHEN[:end], KITCHEN[end:], KITCHEN[::-1][:end]):
            expected(text, len(text))
            expected(text, len(text) // 2)
