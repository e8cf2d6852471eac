"""Formats TOML with tombi, a separate program (extra `fmt`).

Values, their order and comments are kept; only spaces and line ends change.
"""

from __future__ import annotations

import difflib
import os
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.kit import toml_text
from rtgen.facts.extras import installation
from rtgen.tools.fmt import Options
from rtgen.tools.fmt.rules import NO_TOKENS

SUFFIX = ".toml"

_SETTINGS = """\
[format.rules]
indent-width = {indent}
line-width = {line_length}
line-ending = "lf"
string-quote-style = "preserve"
date-time-delimiter = "preserve"
trailing-comment-alignment = true

[schema]
enabled = false
"""
_SECONDS = 10
_MAX_COMPARED = 4_000_000
"""Maximum product of the numbers of lines that are compared, line by line."""


def is_available() -> bool:
    """Return whether tombi is installed."""
    return _program() is not None


def changed_text(
    text: str, name: str, options: Options, lines: tuple[int, int] | None
) -> str:
    """Return the formatted text; `lines` limits changed hunks to a range, from 1."""
    before = _values(text, name)
    new = _formatted(text, name, options)
    if lines is not None:
        new = _within(text, new, lines)
    # A single hunk may not be valid TOML, or not mean the same: then nothing is changed.
    return new if new == text or _is_same(before, new, name) else text


def _values(text: str, name: str) -> dict[str, Any]:
    try:
        return toml_text.parse(text, name)
    except toml_text.TomlError as error:
        raise InputError(
            [NO_TOKENS.at(error.span, str(error), hint=error.hint)]
        ) from None


def _is_same(before: dict[str, Any], new: str, name: str) -> bool:
    """Return whether a text has the same values, in the same order."""
    try:
        return repr(toml_text.parse(new, name)) == repr(before)
    except toml_text.TomlError:
        return False


def _formatted(text: str, name: str, options: Options) -> str:
    program = _program()
    if program is None:
        raise ToolError(
            f"{name} is formatted by tombi, which is not installed",
            hint=installation("fmt"),
        )
    settings = _SETTINGS.format(indent=options.indent, line_length=options.line_length)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tombi.toml").write_text(settings, encoding="utf-8")
        try:
            done = subprocess.run(
                [program, "format", "--offline", "--quiet", "-"],
                input=text.encode(),
                cwd=folder,
                env={**os.environ, "NO_COLOR": "1"},
                capture_output=True,
                timeout=_SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ToolError(f"tombi cannot format {name}: {error}") from error
    if done.returncode != 0:
        why = " ".join(done.stderr.decode(errors="replace").split())
        raise ToolError(f"tombi cannot format {name}: {why or 'it does not say why'}")
    return done.stdout.decode()


@cache
def _program() -> str | None:
    """Return the path of tombi: in this environment, else on the search path."""
    return shutil.which("tombi", path=sysconfig.get_path("scripts")) or shutil.which(
        "tombi"
    )


def _within(text: str, new: str, lines: tuple[int, int]) -> str:
    """Apply those hunks of a change that start or end within the lines."""
    old_lines, new_lines = text.splitlines(True), new.splitlines(True)
    parts: list[str] = []
    first, last = lines[0] - 1, lines[1]
    for tag, start, end, new_start, new_end in _hunks(old_lines, new_lines):
        inside = tag != "equal" and start < last and max(end, start + 1) > first
        parts += new_lines[new_start:new_end] if inside else old_lines[start:end]
    return "".join(parts)


def _hunks(old: list[str], new: list[str]) -> Sequence[tuple[str, int, int, int, int]]:
    """Return the differences as `difflib` does; as one if there are too many lines to compare."""
    if len(old) * len(new) <= _MAX_COMPARED:
        return difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
    pairs = zip(old, new, strict=False)
    head = next(
        (i for i, (a, b) in enumerate(pairs) if a != b), min(map(len, (old, new)))
    )
    pairs = zip(reversed(old[head:]), reversed(new[head:]), strict=False)
    rest = min(len(old), len(new)) - head
    tail = next((i for i, (a, b) in enumerate(pairs) if a != b), rest)
    old_end, new_end = len(old) - tail, len(new) - tail
    return [
        ("equal", 0, head, 0, head),
        ("replace", head, old_end, head, new_end),
        ("equal", old_end, len(old), new_end, len(new)),
    ]
