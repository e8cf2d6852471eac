"""`@unit`, `@min`, `@max` and `@range`: each place that may have them shows them to its readers."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.frontends.idl.names.annotation_definitions import DEFINITIONS

PLACES = {
    "member": "struct Sample {{ {0} double x; }};",
    "case": "union Sample switch (boolean) {{ case TRUE: {0} double x; }};",
    "bitfield": "bitset Sample {{ {0} bitfield<7> x; }};",
    "typedef": "{0} typedef double Sample;",
    "constant": "{0} const double SAMPLE = 2.5;",
    "attribute": "interface Sample {{ {0} attribute double x; }};",
    "parameter": "interface Sample {{ void f(in {0} double x); }};",
}
"""A declaration for each place of `@unit`, except those of components, which have fields for it."""

FORMS = ("@min({0}) @max({1})", "@range(min={0}, max={1})", "@range(min={0}) @max({1})")


def project(folder: Path, text: str) -> Path:
    (folder / "sample.idl").write_text(text)
    (folder / "rtgen.toml").write_text('[sources]\npaths = ["sample.idl"]\n')
    return folder


def test_each_place_is_tested() -> None:
    for name in ("unit", "min", "max", "range"):
        assert {*DEFINITIONS[name].places} == {*PLACES, "port", "configuration"}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("place", PLACES)
def test_generated_files_and_pages_show_unit_and_limits(
    place: str, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bounds = ("1", "3") if place == "bitfield" else ("1.5", "3.5")
    facts = f'@unit("rad") {form.format(*bounds)}'
    monkeypatch.chdir(project(tmp_path, PLACES[place].format(facts)))
    assert run(["generate"]) == 0
    assert run(["docs", "-o", "site"]) == 0
    module = Path("generated/robots/_idl/sample.py").read_text()
    page = "".join(p.read_text() for p in Path("site/docs/types").glob("*.md"))
    for text in (module, page):
        assert "rad" in text
        assert f"at least {bounds[0]}, at most {bounds[1]}." in text.lower()


def test_a_valuetype_shows_the_units_of_its_operations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = """valuetype Wheel {
        @unit("m") attribute double radius;
        void turn(in @unit("Hz") @max(9.0) double rate);
    };"""
    monkeypatch.chdir(project(tmp_path, text))
    assert run(["generate"]) == 0
    module = Path("generated/robots/_idl/sample.py").read_text()
    assert "`attribute double radius` [m]." in module
    assert "rate: [Hz]. At most 9.0." in module


@pytest.mark.parametrize(
    ("parameter", "limits"),
    [
        ("attribute Ratio gain;", "minimum=0.0, maximum=1.0"),
        ("@max(0.7) attribute Ratio gain;", "minimum=0.0, maximum=0.7"),
        ("@range(min=0.2) attribute Share gain;", "minimum=0.2, maximum=0.9"),
    ],
)
def test_a_parameter_has_the_limits_of_its_typedefs(
    parameter: str, limits: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = f"""@min(0.0) @max(1.0) @default(0.5) typedef double Ratio;
    @range(max=0.9) typedef Ratio Share;
    component Mixer {{ {parameter} }};"""
    monkeypatch.chdir(project(tmp_path, text))
    assert run(["generate"]) == 0
    module = Path("generated/robots/components/mixer/__init__.py").read_text()
    assert f"gain: float = parameter(0.5, {limits})" in module


@pytest.mark.parametrize(
    "facts",
    ["@min(1) @range(min=2)", "@range(min=1, max=3) @max(2)", "@min(1) @min(2)"],
)
def test_a_limit_is_given_once(
    facts: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    project(tmp_path, f"struct Sample {{ {facts} long x; }};")
    assert run(["check", str(tmp_path / "sample.idl")]) == 2
    assert capsys.readouterr().err.count("IDL0809") == 1
