"""`rtgen fmt` of TOML files: content and comments are kept, a second run changes nothing."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from random import Random

import pytest
from seeds import cases

from rtgen.cli import run
from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.tools.fmt import DEFAULT, Options, toml
from rtgen.tools.fmt.files import format_bytes

ROOT = Path(__file__).parents[3]
OURS = [*ROOT.glob("specs/**/*.toml"), *ROOT.glob("tests/golden/**/*.toml")]
VALUES = (
    *("1", "0x2_0", "-1.5e3", "inf", "true", '"a # b"', "'# no'", '""', "1979-05-27"),
    *(
        '"""\n  a # b\n"""',
        "'''#'''",
        "[1, 2]",
        "[]",
        "{ a = 1, b = [ '#' ] }",
        "07:32:00",
    ),
    *("[\n  1, # one\n  2,\n]", '"\\"#"', "2026-01-02 03:04:05"),
)
TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|' + r"'''.*?'{3,5}|"
    r""""(?:\\.|[^"\\])*"|'[^']*'|(#[^\n]*)|[^#"']+""",
    re.DOTALL,
)


def comments(text: str) -> list[str]:
    return sorted(
        re.sub(r"^#\s*", "", found[1]).strip()
        for found in TOKEN.finditer(text)
        if found[1] and found[1].strip("# ")
    )


def formatted(text: str, options: Options = DEFAULT) -> str:
    return toml.changed_text(text, "bus.toml", options, None)


def check(text: str, options: Options = DEFAULT) -> None:
    new = formatted(text, options)
    assert repr(tomllib.loads(new)) == repr(tomllib.loads(text))
    assert comments(new) == comments(text)
    assert formatted(new, options) == new


def random_text(random: Random) -> str:
    """Return a document with odd white space and comments wherever TOML allows them."""
    numbers = iter(range(10_000))

    def space() -> str:
        return random.choice(("", " ", "  ", "\t"))

    def end() -> str:
        comment = f"#{space()}c{next(numbers)}" if random.random() < 0.4 else ""
        return space() + comment + "\n" * random.choice((1, 1, 1, 2, 4))

    lines = []
    for table in range(random.randrange(4)):
        if table:
            kind = random.choice(("[{}]", "[[{}]]"))
            lines.append(space() + kind.format(f"{space()}t{table}{space()}") + end())
        for _ in range(random.randrange(5)):
            if random.random() < 0.3:
                lines.append(space() + end())
            key = random.choice(
                (f"k{next(numbers)}", f'"{next(numbers)} x"', f"d.e{next(numbers)}")
            )
            lines.append(
                f"{space()}{key}{space()}={space()}{random.choice(VALUES)}{end()}"
            )
    return "".join(lines)


@pytest.mark.random
def test_random_layouts() -> None:
    for number in cases(50):
        random = Random(number)
        options = Options(random.choice((20, 100)), random.choice((2, 4)))
        check(random_text(random), options)


@pytest.mark.sampled(14)
@pytest.mark.parametrize("path", OURS, ids=lambda path: path.parent.name + path.stem)
def test_files_of_the_repository(path: Path) -> None:
    text = path.read_text("utf-8")
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        with pytest.raises(InputError, match="FMT0001"):
            formatted(text)
    else:
        check(text)


def test_the_form() -> None:
    text = '[bus]  # a\nbit_rate=500\n\n\n\n[node.a]\nid   = 1 # first\nname="x"   # second\n'
    assert formatted(text) == (
        '[bus]  # a\nbit_rate = 500\n\n[node.a]\nid = 1      # first\nname = "x"  # second\n'
    )


def test_a_range_changes_hunks_within_it() -> None:
    text = "a=1\nb = 2\nc=3\n"
    assert toml.changed_text(text, "bus.toml", DEFAULT, (1, 1)) == "a = 1\nb = 2\nc=3\n"
    assert toml.changed_text(text, "bus.toml", DEFAULT, (2, 3)) == "a=1\nb = 2\nc = 3\n"
    assert toml.changed_text(text, "bus.toml", DEFAULT, (2, 2)) == text


@pytest.mark.nightly
def test_a_range_of_many_lines() -> None:
    """Line by line, a comparison would take minutes."""
    text = "a = [\n" + "1,\n" * 50_000 + "]\nb=1\nc=1\n"
    new = toml.changed_text(text, "bus.toml", DEFAULT, (2, 2))
    assert new == formatted(text)
    assert toml.changed_text(text + "d=1\n", "bus.toml", DEFAULT, (1, 1)) != text


def test_what_tombi_refuses_is_one_line() -> None:
    with pytest.raises(ToolError, match=r"tombi cannot format bus\.toml") as raised:
        formatted(f"a = {'[' * 200}{']' * 200}\n")
    assert "\n" not in raised.value.message


def test_settings_of_other_files_do_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tombi.toml").write_text("[format.rules]\nindent-width = 8\n")
    monkeypatch.chdir(tmp_path)
    assert formatted("a = [ # x\n1]\n") == "a = [  # x\n    1\n]\n"


def test_a_schema_that_a_file_names_is_not_read(tmp_path: Path) -> None:
    schema = tmp_path / "s.json"
    schema.write_text('{"type": "object", "x-tombi-table-keys-order": "ascending"}')
    check(f"#:schema {schema.as_uri()}\nb = 1\na = 2\n")


def test_line_ends_and_mark_are_kept() -> None:
    data = b"\xef\xbb\xbfa=1\r\nb = 2\r\n"
    assert format_bytes(data, "x.toml") == b"\xef\xbb\xbfa = 1\r\nb = 2\r\n"


def test_without_tombi(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A named file needs tombi; one below a folder is skipped, the others are formatted."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(toml, "_program", lambda: None)
    Path("bus.toml").write_text("[bus]\nbit_rate=500\n")
    Path("a.idl").write_text("struct  S{long a;};\n")
    assert run(["fmt", "bus.toml"]) == 3
    assert (
        "pip install ./runtime '.[fmt]' in a clone of rtgen" in capfd.readouterr().err
    )
    assert run(["fmt", "."]) == 0
    printed = capfd.readouterr().err
    assert "FMT0003" in printed
    assert "bus.toml is left as it is" in printed
    assert Path("a.idl").read_text() == "struct S { long a; };\n"
    assert Path("bus.toml").read_text() == "[bus]\nbit_rate=500\n"
