"""Values in the text of `rtgen inspect` are literals of their types, on one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

IDL = """\
module m {
    enum Color { RED, GREEN };
    const long NUMBER = 3;
    const Color SHADE = GREEN;
    const string TEXT = "a\\tb\\"c\\n";
    const wstring WIDE = L"\\u3042";
    const char LETTER = '\\'';
    const wchar SIGN = L'\\u3042';
    const boolean FLAG = TRUE;
    const double REAL = 1.5;
    const fixed EXACT = 1.25d;
    struct Sample {
        @default("x\\ny") string text;
        @default('z') char letter;
        @default(GREEN) Color hue;
        @default(TRUE) boolean flag;
    };
    component Part {
        @default("two words") attribute string name;
        @default(TRUE) attribute boolean on;
        @default(2.5) attribute double speed;
    };
};
"""
CDL = """\
const int32_t NUMBER = 3;
const bool_t FLAG = true;
const double64_t REAL = 1.5;
const char_t *const TEXT = "a\\tb";
"""
EDS = Path(__file__).parents[3] / "specs/canopen/f_palette.eds"
VALUES = {
    "a.idl": {
        "const m::NUMBER: long = 3",
        "const m::SHADE: m::Color = m::GREEN",
        'const m::TEXT: string = "a\\x09b\\x22c\\x0a"',
        'const m::WIDE: wstring = L"あ"',
        "const m::LETTER: char = '\\x27'",
        "const m::SIGN: wchar = L'あ'",
        "const m::FLAG: boolean = TRUE",
        "const m::REAL: double = 1.5",
        "const m::EXACT: fixed<3,2> = 1.25",
        'text: string = "x\\x0ay"',
        "letter: char = 'z'",
        "hue: m::Color = m::GREEN",
        "flag: boolean = TRUE",
        'parameter name: string = "two words"',
        "parameter on: boolean = TRUE",
        "parameter speed: double = 2.5",
    },
    "a.cdl": {
        "const NUMBER: const int32_t = 3",
        "const FLAG: const bool_t = true",
        "const REAL: const double64_t = 1.5",
        'const TEXT: const char_t* const = "a\\tb"',
    },
    "a.eds": {
        "0: UNSIGNED32 ro Device type = 983441",
        '0: VISIBLE_STRING const Manufacturer device name = "f\\x09\\x22palette"',
    },
}


@pytest.mark.parametrize("name", VALUES)
def test_values(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    eds = EDS.read_text(encoding="utf-8").replace("=f-palette", '=f\t"palette')
    file = tmp_path / name
    text = {"a.idl": IDL, "a.cdl": CDL, "a.eds": eds}[name]
    file.write_text(text, encoding="utf-8")
    assert run(["inspect", str(file)]) == 0
    lines = {line.strip() for line in capsys.readouterr().out.split("\n")}
    assert lines >= VALUES[name]
