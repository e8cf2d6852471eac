"""The README's tour, carried out as it stands there: its files made, its commands run."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).resolve().parents[3] / "README.md"
BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.DOTALL)
FILE_NAME = re.compile(r"`([\w/]+\.\w+)`")
WALL_TIME = re.compile(r"^(wall \[s\]|ratio)( +)[\d.]+$", re.MULTILINE)


def tour() -> tuple[dict[str, str], list[tuple[str, str]]]:
    """The files of the tour by name, and its commands with what they print."""
    text = (
        README.read_text(encoding="utf-8")
        .partition("## Five minutes")[2]
        .partition("\n## ")[0]
    )
    files: dict[str, str] = {}
    commands = []
    end = 0
    for block in BLOCK.finditer(text):
        before, end = text[end : block.start()], block.end()
        language, body = block.groups()
        if body.startswith("$ "):
            command, _, output = body[2:].partition("\n")
            commands.append((command, output))
        elif language:
            files[FILE_NAME.findall(before)[-1]] = body
    return files, commands


def run(folder: Path, command: str) -> str:
    """What the command prints, progress and messages first."""
    words = [sys.executable, "-m", *shlex.split(command)]
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, check=False
    )
    return WALL_TIME.sub(r"\1\2?", done.stderr + done.stdout)


@pytest.mark.slow
def test_the_tour_prints_what_the_readme_says(tmp_path: Path) -> None:
    files, commands = tour()
    assert set(files) == {
        "rtgen.toml",
        "idl/types.idl",
        "idl/joint.idl",
        "src/mynodes/swing.py",
        "swing.xml",
    }
    skeleton = files.pop("src/mynodes/swing.py")
    for name, body in files.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(body, encoding="utf-8")
    *good, (check, complaint) = commands
    for command, output in good:
        assert run(tmp_path, command) == WALL_TIME.sub(r"\1\2?", output)
        (tmp_path / "src/mynodes/swing.py").write_text(skeleton, encoding="utf-8")
    types = tmp_path / "idl/types.idl"
    wrong = types.read_text(encoding="utf-8").replace("double angle", "duble angle")
    types.write_text(wrong.replace("velocity;", "velocity"), encoding="utf-8")
    assert run(tmp_path, check) == complaint
