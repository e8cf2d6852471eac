"""Each folder below `cases` is a run of rtgen: a new test needs a folder, no code.

`case.toml` has the command line (`arguments`) and its `exit` code, those of `rtgen lint` also the
`rules` that they are about; `input/` is the working folder;
`expected/` has the written files, some condensed by `digest` and `like` of `case.toml` (README.md);
`stdout.txt` and `stderr.txt` are the output.
"""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from condensed import condensed

from rtgen.cli import run
from rtgen.compiler.diagnostics import explain

CASES = Path(__file__).parent / "cases"


def files_of(folder: Path) -> dict[str, bytes]:
    """Return the contents of all files below a folder, by their relative paths."""
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and file.suffix != ".pyc"
    }


def places_of(folder: Path) -> set[Path]:
    """Return all files and folders below a folder but those of Python's bytecode."""
    return {path for path in folder.rglob("*") if "__pycache__" not in path.parts}


def arguments(settings: Mapping[str, Any]) -> list[str]:
    """Return the command line of a case; `rtgen lint` ignores the rules that it is not about.

    So a new rule changes no other case.
    """
    line: list[str] = settings["arguments"]
    if line[0] != "lint":
        return line
    others = explain.rules().keys() - settings["rules"]
    return [*line, *(f"--ignore={code}" for code in sorted(others))]


def renew(case: Path, stored: dict[str, str], streams: dict[str, str]) -> None:
    """Update the folder of a case with the actual result."""
    shutil.rmtree(case / "expected", ignore_errors=True)
    for name, text in stored.items():
        file = case / "expected" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text.encode())
    for name, text in streams.items():
        (case / name).unlink(missing_ok=True)
        if text:
            (case / name).write_text(text, encoding="utf-8", newline="")


@pytest.mark.parametrize(
    "case", sorted(p.parent.name for p in CASES.glob("*/case.toml"))
)
def test_case(
    case: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    update_golden: bool,
) -> None:
    folder = CASES / case
    settings = tomllib.loads((folder / "case.toml").read_text(encoding="utf-8"))
    work = tmp_path / "work"
    work.mkdir()
    if (folder / "input").is_dir():
        shutil.copytree(folder / "input", work, dirs_exist_ok=True)
    before, places = files_of(work), places_of(work)
    monkeypatch.chdir(work)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    code = run(arguments(settings))
    out, err = capfd.readouterr()
    after = files_of(work)
    written = {name: data for name, data in after.items() if before.get(name) != data}
    stored = condensed(
        written,
        digest=settings.get("digest", ()),
        like=settings.get("like"),
        folder=work,
    )
    if update_golden:
        renew(folder, stored, {"stdout.txt": out, "stderr.txt": err})
    assert code == settings["exit"], err
    for name, text in {"stdout.txt": out, "stderr.txt": err}.items():
        file = folder / name
        assert text == (file.read_bytes().decode() if file.exists() else ""), name
    expected = files_of(folder / "expected") if (folder / "expected").is_dir() else {}
    assert sorted(stored) == sorted(expected)
    for name, data in expected.items():
        lines = data.decode().splitlines(keepends=True)
        assert stored[name].splitlines(keepends=True) == lines, f"{name} in {work}"
    assert set(before) <= set(after) | set(settings.get("removed", ()))
    if code == 2:
        assert places_of(work) == places
