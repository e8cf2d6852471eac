"""`rtgen lint --fix`: an edit for each rule with a fix, and none if it is not safe."""

from pathlib import Path
from typing import Any

import pytest

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.diagnostics import Edit, Span
from rtgen.compiler.frontends.kit.character_rules import OCTET_OF_COMMENT
from rtgen.compiler.inspection.models import inspect
from rtgen.compiler.lint.fixes import CODES, applied
from rtgen.compiler.project.output import Change
from rtgen.tools.compiling.fixing import changed_files

CASES = [
    ("IDL0110", "a.idl", "struct A { long n;; };\n", "struct A { long n; };\n"),
    ("IDL0113", "a.idl", r'const string A = "a\qb\n";', r'const string A = "aqb\n";'),
    ("IDL0114", "a.idl", 'const string A = "a\nb";', r'const string A = "a\nb";'),
    ("IDL0507", "a.idl", "const double A = 5;", "const double A = 5.0;"),
    (
        "IDL0606",
        "a.idl",
        "exception E {};\ninterface I { void f() raises (E, E); };",
        "exception E {};\ninterface I { void f() raises (E); };",
    ),
    (
        "LINT0001",
        "a.idl",
        '#include "other.idl"\nstruct A { long n; };\n',
        "struct A { long n; };\n",
    ),
    (
        "LINT0015",
        "a.idl",
        "struct A { long n; }; // rtgen: ignore[IDL0110]\n",
        "struct A { long n; };\n",
    ),
    (
        "LINT0015",
        "a.idl",
        "// rtgen: ignore[IDL0110] why\nstruct A { long n; };\n",
        "struct A { long n; };\n",
    ),
    (
        "LINT0015",
        "a.idl",
        "struct A { long n;; }; /* rtgen: ignore[IDL0110, IDL0114] */\n",
        "struct A { long n;; }; /* rtgen: ignore[IDL0110] */\n",
    ),
    (
        "LINT0015",
        "a.idl",
        "struct A { long n;; }; // rtgen: ignore[IDL0114, IDL0110]\n",
        "struct A { long n;; }; // rtgen: ignore[IDL0110]\n",
    ),
    (
        "CDL0404",
        "a.cdl",
        "signature sA { void f( ); };",
        "signature sA { void f(void); };",
    ),
    (
        "CDL0410",
        "a.cdl",
        "signature sA { void f([in, in] int32_t a); };",
        "signature sA { void f([in] int32_t a); };",
    ),
    (
        "CDL0424",
        "a.cdl",
        "signature sA { void f([in,size_is(4,8)] const int8_t *a); };",
        "signature sA { void f([in,size_is(4)] const int8_t *a); };",
    ),
]


@pytest.mark.parametrize(("code", "name", "before", "after"), CASES)
def test_a_fix_removes_the_finding_alone(
    code: str,
    name: str,
    before: str,
    after: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("other.idl").write_text("struct Other { long n; };\n")
    file = Path(name)
    file.write_text(before)
    model = inspect(api.read([name]).model, [])["declarations"]
    run(["lint", name])
    assert code in capsys.readouterr().err
    assert run(["lint", "--diff", name]) == 1
    assert file.read_text() == before
    run(["lint", "--fix", name])
    assert file.read_text() == after
    assert code not in capsys.readouterr().err
    fixed = inspect(api.read([name]).model, [])["declarations"]
    assert _own(fixed) == _own(model)


def _own(declarations: object) -> object:
    """Return the declarations without positions, and without those of a file left out."""
    assert isinstance(declarations, list)
    return [
        {k: v for k, v in d.items() if k != "line"}
        for d in declarations
        if d["file"] != "other.idl"
    ]


EDS = """[DeviceInfo]
VendorName: Acme
ProdctName=Motor
# a comment
[MandatoryObjects]
SupportedObjects=1
1=0x1000
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0
PDOMapping=0
"""


def test_an_eds(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("a.eds")
    file.write_bytes(EDS.replace("\n", "\r\n").encode("latin-1"))
    run(["lint", "--fix", "a.eds"])
    assert file.read_bytes().startswith(
        b"[DeviceInfo]\r\nVendorName= Acme\r\nProductName=Motor\r\n; a comment\r\n["
    )
    shown = capsys.readouterr().err
    assert not any(code in shown for code in ("EDS0105", "EDS0109", "EDS0110"))


HEADER = """typedef struct {\r
  int x;   // X座標の表  \r
  int y;   // Y座標\r
} Pose;\r
"""
BOARD = """import_C("pose.h");\r
signature sPose {\r
  ER get([out] Pose *pose);   // 位置の機能\r
  ER stop(void);              // 停止
};\r
"""
MEMBERS = """struct P {\r
  long x;   // X座標の十\r
  long y;   // 予定のソ   \r
  long z;   /* 表\r
  */
};\r
"""


@pytest.mark.parametrize("declared", [True, False])
def test_octets_of_backslashes_at_the_end_of_comments(
    declared: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fix of files in Shift_JIS adds an octet each, and changes nothing else."""
    monkeypatch.chdir(tmp_path)
    if declared:
        Path("rtgen.toml").write_text('[sources]\nencoding = "sjis"\n')
    texts = {"pose.h": HEADER, "board.cdl": BOARD, "p.idl": MEMBERS}
    for name, text in texts.items():
        Path(name).write_bytes(text.encode("cp932"))
    run(["lint", "--fix", "--ignore", "LINT0005", "board.cdl", "p.idl"])
    for name, text in texts.items():
        fixed = text
        for end in ("座標の表  ", "の機能", "座標の十", "のソ   "):
            fixed = fixed.replace(end, f"{end.rstrip()}.{' ' * end.count(' ')}")
        assert Path(name).read_bytes().decode("cp932") == fixed, name
    assert OCTET_OF_COMMENT.code not in [
        d.code for d in api.read([*texts][1:]).diagnostics
    ]


def test_every_fix_is_tried() -> None:
    tried = {code for code, *_ in CASES} | {"EDS0105", "EDS0109", "EDS0110"}
    tried.add(OCTET_OF_COMMENT.code)
    assert tried == CODES


@pytest.mark.parametrize(
    "text",
    [
        "#define M ;;\nstruct A { long n M };\n",
        "#define FIVE 5\nconst double A = FIVE;\n",
        "const double A = 010;\n",
    ],
)
def test_what_is_not_safe_stays(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text(text)
    run(["lint", "--fix", "a.idl"])
    assert Path("a.idl").read_text() == text


def test_included_files_and_files_with_errors_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text('#include "b.idl"\nstruct A { B b; };\n')
    Path("b.idl").write_text("struct B { long n;; };\n")
    run(["lint", "--fix", "a.idl"])
    assert Path("b.idl").read_text() == "struct B { long n;; };\n"
    Path("c.idl").write_text("struct C { Unknown n;; };\n")
    assert run(["lint", "--fix", "c.idl"]) == 2
    assert Path("c.idl").read_text() == "struct C { Unknown n;; };\n"


def test_edits_that_overlap_or_find_another_text() -> None:
    def edit(start: int, end: int, old: str, new: str) -> Edit:
        return Edit(Span("a", 1, start, 1, end), old, new)

    text = "abcdef\n"
    assert applied(text, [edit(1, 3, "ab", "x"), edit(5, 6, "e", "")]) == "xcdf\n"
    assert applied(text, [edit(1, 3, "ab", "x"), edit(2, 4, "bc", "y")]) == "xcdef\n"
    assert applied(text, [edit(1, 3, "zz", "x")]) == text
    assert applied(text, []) == text


def test_a_file_that_is_saved_after_it_was_read_is_left_as_it_is(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The places of the findings are those of the text that was read."""
    monkeypatch.chdir(tmp_path)
    file = Path("a.idl")
    file.write_bytes(b"struct A { long n;; };\n")
    saved = b"// a line more\nstruct A { long n;; };\n"

    def changed(*arguments: Any) -> list[Change]:
        file.write_bytes(saved)
        return changed_files(*arguments)

    monkeypatch.setattr("rtgen.cli.lint.changed_files", changed)
    assert run(["lint", "--fix", "a.idl"]) == 3
    assert "cannot fix a.idl: it has been changed meanwhile" in capsys.readouterr().err
    assert file.read_bytes() == saved
