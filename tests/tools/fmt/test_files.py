"""`rtgen fmt` of files: encodings, line ends, links; standard input; settings."""

import io
import stat
import sys
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.tools.fmt.files import format_bytes

SPECS = Path(__file__).parents[3] / "specs"
LOOSE = b"struct  S{long a;};\n"
NEAT = b"struct S { long a; };\n"


@pytest.mark.parametrize(
    ("name", "data", "form"),
    [
        ("a.idl", b"\xef\xbb\xbf" + LOOSE, b"\xef\xbb\xbf" + NEAT),
        ("a.idl", b"//  a\r\nlong  b;\r\n", b"//  a\r\nlong b;\r\n"),
        ("a.idl", "long  a; // 長さ".encode(), "long a; // 長さ\n".encode()),
        ("a.idl", b"long  a; // \x83\x5c\nlong b;", b"long a; // \x83\x5c\nlong b;\n"),
        (
            "a.idl",
            "long  a; // ソ\n".encode("cp932"),
            "long a; // ソ\n".encode("cp932"),
        ),
        (
            "a.cdl",
            "/* 表 */ const  int A = 1; // ソ\n".encode("cp932"),
            "/* 表 */ const int A = 1; // ソ\n".encode("cp932"),
        ),
        (
            "a.cdl",
            "/* 名前 */ const  int A = 1;".encode("euc_jp"),
            "/* 名前 */ const int A = 1;\n".encode("euc_jp"),
        ),
        ("a.idl", b"// \xff\x85\xa0 \nlong  a;", b"// \xff\x85\xa0\nlong a;\n"),
        ("a.idl", b"", b""),
        (
            "a.idl",
            "// 約 \u2252 ｺﾝ\rlong  a; // 表\r".encode("cp932").replace(
                b"\x81\xe0", b"\x87\x90"
            ),
            "// 約 \u2252 ｺﾝ\nlong a; // 表\n".encode("cp932").replace(
                b"\x81\xe0", b"\x87\x90"
            ),
        ),
        (
            "a.idl",
            "// 速度\nlong  a; // ".encode() + "予定".encode("cp932"),
            "// 速度\nlong a; // ".encode() + "予定\n".encode("cp932"),
        ),
        (
            "a.idl",
            b"\xff\xfe" + "long  a; // 表\r\n".encode("utf-16-le"),
            b"\xff\xfe" + "long a; // 表\r\n".encode("utf-16-le"),
        ),
    ],
)
def test_the_bytes_of_a_file_are_kept(name: str, data: bytes, form: bytes) -> None:
    assert format_bytes(data, name) == form
    assert format_bytes(form, name) == form


def test_characters_that_cannot_be_written_back_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A character with two forms in the file has no octets to be written as."""
    monkeypatch.chdir(tmp_path)
    data = b"// \x87\x90 \x81\xe0 " + "ほぼ等しい\nlong  a;\n".encode("cp932")
    Path("a.idl").write_bytes(data)
    assert run(["fmt", "a.idl"]) == 2
    assert "convert the file to UTF-8 first" in capsys.readouterr().err
    assert Path("a.idl").read_bytes() == data


def test_the_encoding_can_be_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    data = "// ｵｰﾅｰ\nlong  a;\n".encode("cp932")
    Path("a.idl").write_bytes(data)
    assert run(["fmt", "-q", "--kcode", "sjis", "a.idl"]) == 0
    assert Path("a.idl").read_bytes() == data.replace(b"  ", b" ")


def test_links_and_permissions_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("real").mkdir()
    real = Path("real/a.idl")
    real.write_bytes(LOOSE)
    real.chmod(0o640)
    link = Path("link.idl")
    link.symlink_to(real)
    assert run(["fmt", "-q", "link.idl"]) == 0
    assert link.is_symlink()
    assert real.read_bytes() == NEAT
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert [*Path("real").iterdir()] == [real]


def test_a_file_in_form_is_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("a.idl")
    file.write_bytes(NEAT)
    before = file.stat()
    assert run(["fmt", "-q", "."]) == 0
    assert (file.stat().st_ino, file.stat().st_mtime_ns) == (
        before.st_ino,
        before.st_mtime_ns,
    )


@pytest.mark.parametrize(
    ("arguments", "data", "code", "printed"),
    [
        (["-"], LOOSE, 0, NEAT),
        (["-", "--check"], LOOSE, 1, b"stdin.idl\n"),
        (["-", "--check"], NEAT, 0, b""),
        (
            ["-", "--range", "2:2"],
            b"long  a;\nlong  b;\n",
            0,
            b"long  a;\nlong b;\n",
        ),
        (
            ["-", "--stdin-filename", "x.cdl"],
            b"[active]cell  a b;",
            0,
            b"[active]\ncell a b;\n",
        ),
        (["-"], b'const string A = "', 2, b""),
        (["-", "--stdin-filename", "x.txt"], LOOSE, 2, b""),
        (["-", "a.idl"], LOOSE, 2, b""),
        (["-", "--range", "2:1"], LOOSE, 2, b""),
        (["-", "--range", "x"], LOOSE, 2, b""),
    ],
)
def test_standard_input(
    arguments: list[str],
    data: bytes,
    code: int,
    printed: bytes,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfdbinary: pytest.CaptureFixture[bytes],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    assert run(["fmt", *arguments]) == code
    assert capfdbinary.readouterr().out == printed


def test_generated_files_of_a_project_below_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They stay, while the definitions beside them are formatted."""
    monkeypatch.chdir(tmp_path)
    project = Path("arm")
    project.mkdir()
    definition = project / "arm.eds"
    definition.write_bytes((SPECS / "canopen" / "epos_drive.eds").read_bytes())
    (project / "rtgen.toml").write_text('[sources]\npaths = ["arm.eds", "a.idl"]\n')
    (project / "a.idl").write_bytes(LOOSE)
    monkeypatch.chdir(project)
    assert run(["generate", "-q"]) == 0
    monkeypatch.chdir(tmp_path)
    [idl] = (project / "generated").rglob("*.idl")
    before = idl.read_bytes()
    assert run(["fmt", "-q", "."]) == 0
    assert (project / "a.idl").read_bytes() == NEAT
    assert idl.read_bytes() == before
    assert run(["fmt", "-q", str(idl)]) == 0
    assert idl.read_bytes() != before


def test_without_paths_and_without_a_project(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["fmt"]) == 2
    assert "name a PATH" in capsys.readouterr().err
    assert run(["fmt", "missing.idl"]) == 2
    assert "error[FMT0002]: missing.idl cannot be read" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_bytes(LOOSE)

    def refused(self: Path, target: Path) -> Path:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", refused)
    assert run(["fmt", "a.idl"]) == 3
    assert "cannot write a.idl: Permission denied" in capsys.readouterr().err
    assert [*Path().iterdir()] == [Path("a.idl")]
    assert Path("a.idl").read_bytes() == LOOSE


def test_hard_links_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_bytes(LOOSE)
    Path("b.idl").hardlink_to("a.idl")
    assert run(["fmt", "-q", "a.idl"]) == 0
    assert Path("b.idl").read_bytes() == NEAT
    assert Path("a.idl").samefile("b.idl")


def test_a_file_that_is_saved_meanwhile_is_left_as_it_is(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_bytes(LOOSE)
    Path("b.idl").write_bytes(LOOSE)
    saved = b"struct  S{long saved;};\n"

    def save(data: bytes, name: str, *rest: Any, **options: Any) -> bytes:
        Path(name).write_bytes(saved)
        return format_bytes(data, name, *rest, **options)

    monkeypatch.setattr("rtgen.cli.fmt.format_bytes", save)
    assert run(["fmt", "a.idl", "b.idl"]) == 3
    assert (
        "cannot write a.idl: it has been changed meanwhile" in capsys.readouterr().err
    )
    assert Path("a.idl").read_bytes() == saved
    assert Path("b.idl").read_bytes() == LOOSE
    assert sorted(Path().iterdir()) == [Path("a.idl"), Path("b.idl")]


def test_a_file_is_replaced_before_the_next_one_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_bytes(LOOSE)
    Path("b.idl").write_bytes(LOOSE)
    states = []

    def note(data: bytes, name: str, *rest: Any, **options: Any) -> bytes:
        states.append((name, Path("a.idl").read_bytes()))
        return format_bytes(data, name, *rest, **options)

    monkeypatch.setattr("rtgen.cli.fmt.format_bytes", note)
    assert run(["fmt", "-q", "."]) == 0
    assert states == [("a.idl", LOOSE), ("b.idl", NEAT)]


def test_files_without_errors_are_formatted_beside_those_with_errors(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    broken = b'const  string A = "'
    Path("a.idl").write_bytes(broken)
    Path("b.idl").write_bytes(LOOSE)
    assert run(["fmt", "."]) == 2
    assert "a.idl:1:19: error[FMT0001]" in capsys.readouterr().err
    assert Path("a.idl").read_bytes() == broken
    assert Path("b.idl").read_bytes() == NEAT
    assert run(["fmt", "--check", "."]) == 2
