"""The command line around the pipeline: exit codes, streams, drift, failures of all kinds."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from small_pipeline import Pipeline

from rtgen.cli import COMMANDS, run
from rtgen.cli.can import COMMANDS as CAN_COMMANDS
from rtgen.cli.ctl import COMMANDS as CTL_COMMANDS
from rtgen.cli.log import COMMANDS as LOG_COMMANDS
from rtgen.cli.new import COMMANDS as NEW_COMMANDS
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.cli.rpc import COMMANDS as RPC_COMMANDS
from rtgen.compiler import compilation
from rtgen.compiler.project.output import MANIFEST
from rtgen.facts.version import __version__

GENERATE = ["generate", "a.idl", "b.idl"]
CHECK = ["check", "a.idl", "b.idl"]


def snapshot() -> dict[str, tuple[int, int, bytes]]:
    return {
        str(f): (f.stat().st_ino, f.stat().st_mtime_ns, f.read_bytes())
        for f in sorted(Path().rglob("*"))
        if f.is_file()
    }


def test_version_and_help(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capfd.readouterr().out == f"rtgen {__version__}\n"
    assert run(["--help"]) == 0
    shown = capfd.readouterr().out
    assert all(name in shown for name in COMMANDS)
    groups = {
        "rpc": RPC_COMMANDS,
        "can": CAN_COMMANDS,
        "ctl": CTL_COMMANDS,
        "log": LOG_COMMANDS,
        "new": NEW_COMMANDS,
    }
    words = [[name] for name in COMMANDS if name not in groups]
    for group, commands in groups.items():
        assert run([group, "--help"]) == 0
        shown = capfd.readouterr().out
        assert all(name in shown for name in commands)
        words += [[group, name] for name in commands]
    for command in words:
        assert run([*command, "--help"]) == 0
        assert "--diagnostics" in capfd.readouterr().out


def test_what_a_host_has_frozen_stays_out_of_garbage_collections(
    pipeline: Pipeline,
) -> None:
    gc.freeze()
    assert run(GENERATE) == 0
    assert gc.get_freeze_count() > 0
    assert gc.isenabled()


@pytest.mark.parametrize(
    "arguments",
    [
        ["generat"],
        ["rpc", "serv"],
        ["generate", "--no-such"],
        ["check", "-D", "1x"],
        ["run"],
        ["inspect", "-D", "="],
    ],
)
def test_wrong_usage(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    assert "Error: " in capfd.readouterr().err


def test_generate_then_check(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(CHECK) == 1
    assert capfd.readouterr().out.count("--- /dev/null") == 2  # not for the manifest
    assert run(GENERATE) == 0
    assert capfd.readouterr() == ("", "generated: 3 written, 0 removed, 0 same\n")
    before = snapshot()
    assert run(GENERATE) == 0
    assert capfd.readouterr() == ("", "generated: 0 written, 0 removed, 3 same\n")
    assert run(CHECK) == 0
    assert capfd.readouterr() == ("", "")
    assert snapshot() == before


def test_quiet(pipeline: Pipeline, capfd: pytest.CaptureFixture[str]) -> None:
    assert run([*GENERATE, "--quiet"]) == 0
    assert run([*CHECK, "-q"]) == 0
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("cached", [True, False])
def test_one_character_anywhere_is_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str], cached: bool
) -> None:
    check = CHECK if cached else [*CHECK, "--no-cache"]
    assert run(GENERATE) == 0
    for file in sorted(f for f in Path("generated").rglob("*") if f.is_file()):
        good = file.read_bytes()
        for position in {0, len(good) // 2, len(good) - 1}:
            file.write_bytes(good[:position] + b"!" + good[position + 1 :])
            capfd.readouterr()
            assert run(check) == 1
            out, err = capfd.readouterr()
            assert "error[PRJ0017]" in err
            head = f"--- a/{file.as_posix()}\n+++ b/{file.as_posix()}\n@@"
            assert out.startswith(head) if file.name != MANIFEST else not out
        file.write_bytes(good)
    assert run(check) == 0


def test_line_ends_are_no_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    """A tree that git has converted (core.autocrlf) is up to date."""
    assert run(GENERATE) == 0
    files = [path for path in Path("generated").rglob("*") if path.is_file()]
    for file in files:
        file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    capfd.readouterr()
    assert run(CHECK) == 0
    shown = capfd.readouterr()
    assert shown.out == ""
    assert shown.err.count("line ends") == 1
    assert "generated/** -text" in shown.err
    file = Path("generated/robots/a.idl.txt")
    file.write_bytes(file.read_bytes() + b"more\r\n")
    assert run(CHECK) == 1
    changed = [
        line
        for line in capfd.readouterr().out.splitlines()
        if line.startswith(("+", "-")) and not line.startswith(("+++", "---"))
    ]
    assert changed == ["-more"]


def test_a_missing_file_is_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(GENERATE) == 0
    Path("generated/robots/a.idl.txt").unlink()
    assert run(CHECK) == 1
    assert "--- /dev/null\n+++ b/generated/robots/a.idl.txt\n" in capfd.readouterr().out


def test_a_stray_file_is_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(GENERATE) == 0
    Path("generated/robots/__pycache__").mkdir()
    Path("generated/robots/__pycache__/x.pyc").write_bytes(b"")
    assert run(CHECK) == 0
    Path("generated/robots/extra.py").write_text("")
    assert run(CHECK) == 1
    printed = capfd.readouterr()
    assert "Only in the tree: generated/robots/extra.py\n" in printed.out
    assert "1 file not made by rtgen" in printed.err
    assert "run rtgen generate" not in printed.err


def test_a_file_no_longer_made_is_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(GENERATE) == 0
    assert run(["check", "a.idl"]) == 1
    out = capfd.readouterr().out
    assert "--- a/generated/robots/b.idl.txt\n+++ /dev/null\n" in out
    assert run(["generate", "a.idl"]) == 0
    assert not Path("generated/robots/b.idl.txt").exists()
    assert run(["check", "a.idl"]) == 0


def test_something_else_in_the_place_of_a_file_is_drift(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(GENERATE) == 0
    file = Path("generated/robots/a.idl.txt")
    file.unlink()
    os.mkfifo(file)
    assert run(CHECK) == 1
    assert f"Not a regular file: {file}\n" in capfd.readouterr().out
    assert run(GENERATE) == 0
    assert file.is_file()


def test_errors_leave_everything_as_it_was(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(GENERATE) == 0
    Path("a.idl").write_text("an error\n")
    before = snapshot()
    capfd.readouterr()
    for command in (GENERATE, CHECK):
        assert run(command) == 2
        out, err = capfd.readouterr()
        assert out == ""
        assert (
            err
            == "a.idl:1:1: error[IDL0999]: an error\n    1 | an error\n      | ^\n1 error\n"
        )
    assert snapshot() == before


def test_warnings_do_not_keep_from_writing_and_are_reported_from_the_cache_too(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    pipeline.warn = True
    assert run([*GENERATE, "--quiet"]) == 0
    first = capfd.readouterr().err
    assert first.startswith("a.idl:1:1: warning[IDL0998]: a warning\n    1 | one\n")
    assert run([*GENERATE, "--quiet"]) == 0
    assert capfd.readouterr().err == first
    assert pipeline.reads == 1


def test_diagnostics_for_machines_are_all_there_is(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*GENERATE, "--diagnostics", "json"]) == 0
    assert json.loads(capfd.readouterr().err) == []
    Path("a.idl").write_text("error\n")
    assert run([*GENERATE, "--diagnostics", "json"]) == 2
    [finding] = json.loads(capfd.readouterr().err)
    assert (finding["code"], finding["file"], finding["line"]) == (
        "IDL0999",
        "a.idl",
        1,
    )


def test_diff_shows_and_writes_nothing(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*GENERATE, "--diff"]) == 0
    assert "+++ b/generated/robots/a.idl.txt\n" in capfd.readouterr().out
    assert not Path("generated").exists()


def test_another_folder(pipeline: Pipeline) -> None:
    assert run([*GENERATE, "-o", "there"]) == 0
    assert Path("there/generated/robots/a.idl.txt").is_file()
    assert not Path("generated").exists()
    assert run([*CHECK, "-o", "there"]) == 0


def test_an_unknown_target(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*GENERATE, "--target", "dds"]) == 2
    assert "'dds' is not one of 'embedded', 'openrtm'," in capfd.readouterr().err
    assert not Path("generated").exists()


def test_a_folder_that_cannot_be_written(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("there").write_text("a file")
    assert run([*GENERATE, "-o", "there"]) == 3
    out, err = capfd.readouterr()
    assert out == ""
    assert "error[ENV0001]: there" in err


def test_an_unexpected_exception_is_one_line(
    pipeline: Pipeline,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    def broken(project: object, **_: bool) -> None:
        raise ValueError("first line\nsecond line")

    monkeypatch.setattr(compilation, "read", broken)
    assert run(GENERATE) == 3
    assert capfd.readouterr().err == (
        "rtgen: internal error: ValueError: first line second line; please report it\n"
    )
    monkeypatch.setenv("RTGEN_DEBUG", "1")
    with pytest.raises(ValueError, match="first line"):
        run(GENERATE)


def test_an_interrupt_is_silent(
    pipeline: Pipeline,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    def interrupted(project: object, **_: bool) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(compilation, "read", interrupted)
    assert run(GENERATE) == 130
    out, err = capfd.readouterr()
    assert out + err.strip() == ""


def test_a_reader_that_leaves_does_not_change_the_exit_code() -> None:
    code = "from rtgen.tools.kit.console import write_out; write_out('x' * 99999); write_out('y')"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", code], stdout=write, stderr=subprocess.PIPE
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("choice", ["always", "never"])
def test_colour(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str], choice: str
) -> None:
    Path("a.idl").write_text("error\n")
    assert run([*GENERATE, "--color", choice]) == 2
    assert ("\x1b[" in capfd.readouterr().err) is (choice == "always")


def test_what_is_not_needed_is_not_imported() -> None:
    code = (
        "import sys, rtgen.cli.generate, rtgen.cli.check, rtgen.cli.inspect\n"
        "import rtgen.compiler.project.output\n"
        "heavy = {'lark', 'jinja2', 'rich', 'lxml', 'black', 'matplotlib', 'tomllib', 'difflib'}\n"
        "parts = {'rtgen.compiler.model', 'rtgen.runtime', 'rtgen.compiler.frontends'}\n"
        "parts |= {'rtgen.compiler.diagnostics.report'}\n"
        "print(sorted((heavy | parts) & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("command", ["generate", "check", "inspect", "lint", "docs"])
@pytest.mark.parametrize("settings", [None, '[sources]\npaths = ["idl"]\n'])
def test_a_folder_without_definitions(
    command: str,
    settings: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """The message names the folder, the hint what was searched for."""
    monkeypatch.chdir(tmp_path)
    for folder in ("idl", "empty/.hidden", "generated"):
        Path(folder).mkdir(parents=True)
    Path("idl/a.idl").write_text("struct A { long x; };\n")
    Path("empty/notes.txt").write_text("struct A { long x; };\n")
    Path("empty/.hidden/a.idl").write_text("struct A { long x; };\n")
    if settings is not None:
        Path("rtgen.toml").write_text(settings)
    assert run([command, "empty"]) == 2
    printed = capfd.readouterr().err
    assert "PRJ0007]: no definition file is in the folder empty" in printed
    assert "hint: searched for *.idl, *.pidl, *.cdl, *.eds" in printed
    assert run([command, "idl", "empty"]) == 2
    assert "the folder empty" in capfd.readouterr().err
    monkeypatch.chdir("empty")
    assert run([command, "."]) == 2
    assert "the folder ." in capfd.readouterr().err


CASE_CLASHES = {
    "IDL0203": "struct Foo { long a; long A; };",
    "IDL0204": "struct Path { long n; }; struct Plan { Path path; };",
    "IDL0205": "interface Motor { void motor(); };",
    "IDL0206": "struct Foo { long Struct; };",
}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("code", CASE_CLASHES)
@pytest.mark.parametrize("command", ["generate", "check", "inspect", "lint", "docs"])
def test_names_that_differ_in_case_only(
    command: str,
    code: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.idl").write_text(f"{CASE_CLASHES[code]}\n")
    assert run([command, "case.idl"]) == 2
    printed = capfd.readouterr().err
    assert code in printed
    assert '[idl] case = "dds" in rtgen.toml, or --ignore-case-clashes' in printed
    assert run(["explain", code]) == 0
    explained = capfd.readouterr().out
    assert "--ignore-case-clashes" in explained
    assert 'case = "dds"' in explained
    assert run([command, "--ignore-case-clashes", "case.idl"]) != 2
    for settings in ('[idl]\ncase = "dds"', "[sources]\nignore_case_clashes = true"):
        Path("rtgen.toml").write_text(f"{settings}\n")
        assert run([command, "case.idl"]) != 2
    Path("rtgen.toml").write_text('[idl]\ncase = "strict"\n')
    assert run([command, "case.idl"]) == 2


@pytest.mark.parametrize("code", ["IDL0202", "IDL0204", "IDL0205"])
def test_names_that_are_equal_clash_in_any_case(
    code: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """The hint does not name a setting that does not help."""
    texts = {
        "IDL0202": "struct Foo { long a; long a; };",
        "IDL0204": "struct Path { long n; }; struct Plan { Path Path; };",
        "IDL0205": "interface Motor { void f(); attribute long Motor; };",
    }
    monkeypatch.chdir(tmp_path)
    Path("case.idl").write_text(texts[code])
    assert run(["inspect", "case.idl"]) == 2
    printed = capfd.readouterr().err
    assert code in printed
    assert "case-clashes" not in printed
    assert run(["inspect", "--ignore-case-clashes", "case.idl"]) == 2


@pytest.mark.parametrize(
    ("range_", "text"),
    [
        (WholeRange(0, 232), "0 to 232"),
        (WholeRange(min=1), "at least 1"),
        (WholeRange(max=1_000_000), "at most 1000000"),
        (FiniteRange(min=0, min_open=True), "above 0"),
        (FiniteRange(0.001, 3600), "0.001 to 3600"),
    ],
)
def test_ranges_are_described_in_words(range_: click.ParamType, text: str) -> None:
    option = click.Option(["--n"], type=range_)
    _, shown = option.get_help_record(click.Context(click.Command("c"))) or ("", "")
    assert shown == f"[{text}]"
    with pytest.raises(click.BadParameter, match=f"range {text}"):
        range_.convert("-1" if "most" not in text else "2000000", None, None)
