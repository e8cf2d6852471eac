"""Bad input of every kind, through the whole tool.

There are findings with position and caret, exit code 2, and an unchanged output folder.
"""

from __future__ import annotations

import json
import random
import re
from pathlib import Path

import pytest

from rtgen.cli import run

GOOD = b"module M { struct S { long x; }; };\n"
JUNK = random.Random(7).randbytes(5000)

BAD: dict[str, bytes] = {
    "syntax": b"module M { struct S { long x } };\n",
    "end of file": b"module M { struct S {",
    "unknown type": b"module M { struct S { Nothing x; }; };\n",
    "same name": b"module M { struct S { long x; }; struct S { long x; }; };\n",
    "include of itself": b'#include "a.idl"\n',
    "include of a cycle": b'#include "b.idl"\n',
    "include that is missing": b'#include "gone.idl"\n',
    "open condition": b"#ifdef X\n",
    "open comment": b"/* never closed",
    "open string": b'const string S = "never closed;\n',
    "binary junk": JUNK,
    "NUL": b"module M { \0 };\n",
    "invalid UTF-8": b"module M { struct S { long \xff; }; };\n",
    "UTF-16": GOOD.decode().encode("utf-16-le"),
    "400 kB line": b"module M { struct S { " + b"Nothing x; " * 36_000 + b"}; };\n",
    "1 MB word": b"module " + b"M" * 1_000_000 + b" {",
    "deep modules": b"".join(b"module M%d {" % i for i in range(1_000)),
    "deep types": b"typedef "
    + b"sequence<" * 20_000
    + b"long"
    + b">" * 20_000
    + b" T;\n",
    "deep expression": b"const long X = "
    + b"(" * 50_000
    + b"1"
    + b")" * 50_000
    + b";\n",
    "long expression": b"const long X = " + b"1+" * 100_000 + b"y;\n",
    "huge array": b"typedef long T[99999999999999999999999999];\n",
    "division by zero": b"const long X = 1 / 0;\n",
    "shift without end": b"const long X = 1 << 99999999999;\n",
    "macro bomb": b"".join(
        b"#define A%d A%d A%d A%d A%d\n" % (i + 1, i, i, i, i) for i in range(40)
    )
    + b"A40\n",
}


@pytest.fixture
def generated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a tree that was generated from good input."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    Path("a.idl").write_bytes(GOOD)
    Path("b.idl").write_bytes(b'#include "a.idl"\n')
    assert run(["generate", "a.idl", "-o", "out", "--quiet"]) == 0
    return tmp_path / "out"


def state(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        str(f): (f.stat().st_ino, f.stat().st_mtime_ns)
        for f in sorted(folder.rglob("*"))
    }


@pytest.mark.sampled(4)
@pytest.mark.parametrize("kind", BAD)
def test_bad_input(
    generated: Path, capfd: pytest.CaptureFixture[str], kind: str
) -> None:
    before = state(generated)
    Path("a.idl").write_bytes(BAD[kind])
    assert run(["generate", "a.idl", "-o", "out"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert re.search(
        r"^[ab]\.idl:\d+:\d+: error\[IDL\d{4}\]: \S", err, re.MULTILINE
    ), err[:500]
    assert re.search(r"^ +\d+ \|.*\n +\| +\^", err, re.MULTILINE), err[:500]
    assert "Traceback" not in err
    assert max(map(len, err.splitlines())) < 400
    assert state(generated) == before


def test_a_missing_file(generated: Path, capfd: pytest.CaptureFixture[str]) -> None:
    before = state(generated)
    assert run(["generate", "gone.idl", "-o", "out"]) == 2
    assert re.search(r"error\[\w{3}\d{4}\]: .*gone\.idl", capfd.readouterr().err)
    assert state(generated) == before


@pytest.mark.parametrize(
    "place", ["generated", "generated/robots", "generated/robots/_idl"]
)
def test_linked_folders_are_not_followed(
    generated: Path, capfd: pytest.CaptureFixture[str], place: str
) -> None:
    folder = generated / place
    elsewhere = generated.parent / "elsewhere"
    folder.rename(elsewhere)
    folder.symlink_to(elsewhere)
    before = state(elsewhere)
    Path("a.idl").write_bytes(GOOD.replace(b"long", b"double"))
    assert run(["generate", "a.idl", "-o", "out"]) == 2
    assert "error[PRJ0103]" in capfd.readouterr().err
    assert state(elsewhere) == before


@pytest.mark.parametrize(
    "text",
    [
        '@name("../../../evil") component C { };',
        'component C { @name("../../../evil") attribute long x; };',
        "module __init__ { struct S { long x; }; };",
        "module _idl { struct S { long x; }; };",
        "module components { struct S { long x; }; };",
    ],
)
def test_names_do_not_leave_the_output_folder(generated: Path, text: str) -> None:
    Path("a.idl").write_text(text)
    outside = {
        f for f in generated.parent.rglob("*") if not f.is_relative_to(generated)
    }
    code = run(["generate", "a.idl", "-o", "out", "--no-cache"])
    assert code in (0, 2)
    after = {f for f in generated.parent.rglob("*") if not f.is_relative_to(generated)}
    assert after == outside
    for file in generated.rglob("*"):
        assert file.resolve().is_relative_to(generated)


def test_an_input_with_a_name_of_its_own(generated: Path) -> None:
    odd = Path("..idl")
    odd.write_bytes(GOOD)
    assert run(["generate", "..idl", "-o", "out", "--quiet"]) in (0, 2)
    assert not [f for f in generated.parent.iterdir() if "evil" in f.name]


def test_inspect_of_a_file_with_errors_prints_these_and_json_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct Good { long x; };\nstruct Bad { Foo y; };\n")
    assert run(["inspect", "a.idl"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert "a.idl:2:14: error[IDL0200]" in err
    assert run(["inspect", "--json", "a.idl"]) == 2
    read = json.loads(capfd.readouterr().out)
    assert [each["name"] for each in read["declarations"]] == ["Good"]
    assert [each["code"] for each in read["diagnostics"]] == ["IDL0200"]
