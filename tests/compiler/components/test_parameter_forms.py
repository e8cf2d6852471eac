"""Every possible type of an attribute, with every annotation: a finding, or a profile."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from component_models import OPTIONS

from rtgen.cli import run
from rtgen.compiler.backends.components.checks import check_component
from rtgen.compiler.backends.profiles.rtc_profile import profile_text
from rtgen.compiler.frontends import idl
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.model import Component

TYPES = (
    *("octet", "int8", "uint8", "short", "long", "unsigned long long", "float"),
    *("double", "long double", "fixed<5,2>", "boolean", "char", "wchar", "string"),
    *("string<3>", "wstring", "Mode", "Three", "Letters"),
    *("sequence<char>", "sequence<boolean>", "sequence<long>", "sequence<Mode>"),
)
ANNOTATIONS = (
    "",
    *(f"@{name}({value})" for name in ("min", "max", "default") for value in "1X"),
    *("@min('a')", "@max(TRUE)", '@default("x")', "@default('a')", "@min(0.5)"),
    *(f'@constraint("{text}")' for text in ("x<1", "1", "(a,b)", "0<=x<=1,x>2")),
    '@constraint("{a:x<1}")',
    '@constraint("(0,1)") @widget("radio")',
    '@min(0) @max(1) @widget("slider.0.1")',
    '@widget("checkbox")',
)
PRELUDE = """\
enum Mode { X, Y };
typedef long Three[3];
typedef sequence<char> Letters;
"""


def test_parameters(tmp_path: Path) -> None:
    counts: Counter[str] = Counter()
    for number, annotation in enumerate(ANNOTATIONS):
        path = tmp_path / f"a{number}.idl"
        path.write_text(
            PRELUDE
            + "".join(
                f"component Part{i} {{ {annotation} attribute {type_} value; }};\n"
                for i, type_ in enumerate(TYPES)
            )
        )
        read = idl.load([path], root=tmp_path)
        refused = {d.span.line for d in read.diagnostics if d.span is not None}
        assert len(read.model.declarations) == 3 + len(TYPES)
        for made in read.model.declarations:
            if not isinstance(made, Component) or made.span.line in refused:
                continue
            found = check_component(read.model, made)
            if not found:
                text = profile_text(read.model, made, OPTIONS)
                located_xml.parse(text, "RTC.xml")
                counts["written"] += 1
            for each in found:
                assert each.span is not None
                assert each.code.startswith("RTC03")
                counts[each.code] += 1
    assert counts["written"] > 50
    assert {"RTC0302", "RTC0303", "RTC0305", "RTC0306"} <= counts.keys()


@pytest.mark.parametrize(
    ("annotation", "type_"),
    [
        ("", "char"),
        ("@min(FALSE)", "char"),
        ("", "boolean"),
        ("@min(FALSE)", "boolean"),
    ],
)
def test_conversion_to_a_profile(
    annotation: str,
    type_: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text(f"component Part {{ {annotation} attribute {type_} v; }};")
    sound = type_ == "boolean" and not annotation
    assert run(["convert", "a.idl", "--to", "rtc-xml"]) == (0 if sound else 2)
    out, err = capsys.readouterr()
    assert bool(out) is sound
    assert sound or "a.idl:1:" in err
