"""A text that an output cannot hold is a finding at its place, whichever back end meets it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.backends import Backend, Emission, Options, stage
from rtgen.compiler.backends.kit.quoting import (
    UnquotableError,
    properties,
    scripts,
    xml,
)
from rtgen.compiler.frontends.kit.places import place_of
from rtgen.compiler.model import Component, Model


class Quoter:
    """A back end that quotes the vendor of each component for a batch file."""

    name = "quoter"

    def emit(self, model: Model, options: Options) -> Emission:
        for declaration in model.declarations:
            if isinstance(declaration, Component):
                scripts.quote_batch(declaration.vendor)
        return Emission()


def test_a_back_end_without_a_rule_for_a_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text('@rtc(vendor="a\\\\b %PATH%")\ncomponent C { };\n')

    def only() -> Iterator[Backend]:
        yield Quoter()

    monkeypatch.setattr(stage, "backends", only)
    assert run(["generate", "-o", "out", "a.idl", "--no-cache"]) == 2
    printed = capfd.readouterr().err
    assert "a.idl:1:14: error[PRJ0107]: back end quoter: a batch file cannot" in printed
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("source", "text", "column"),
    [
        ("x = a%b", "a%b", 5),
        ("x = a\\\\b", "a\\b", 5),
        ("<x y='a&amp;&lt;'/>", "a&<", 7),
        ("x = \\u0007Long\\u0007Word", "\aLong\aWord", 5),
        ("nothing", "else", None),
    ],
)
def test_the_place_of_a_text(source: str, text: str, column: int | None) -> None:
    found = place_of({"other": "", "file": f"\n{source}\n"}, text)
    assert (found and (found.file, found.line, found.column)) == (
        column and ("file", 2, column)
    )


def test_the_error_has_the_whole_text() -> None:
    text = "long " * 100 + "\0"
    for quote in (scripts.shell_word, properties.conf_value, xml.quote_xml):
        with pytest.raises(UnquotableError) as raised:
            quote(text)
        assert raised.value.text == text
        assert len(str(raised.value)) < 200
