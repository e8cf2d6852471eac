"""Formats planned changes as a unified diff."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import unified_diff

from rtgen.compiler.project import shown
from rtgen.compiler.project.output import Change
from rtgen.facts.encodings import decode

_DEV_NULL = "/dev/null"


def diff(changes: Iterable[Change]) -> str:
    """Return the diff from the files on disk to the generated ones."""
    return "".join(map(_one, changes))


def _one(change: Change) -> str:
    name = shown(change.path)
    if change.obstacle:
        return f"Not a regular file: {name}\n"
    before = f"a/{name}" if change.old is not None else _DEV_NULL
    after = f"b/{name}" if change.new is not None else _DEV_NULL
    lines = [*unified_diff(_lines(change.old), _lines(change.new), before, after)]
    if not lines:
        lines = [f"--- {before}\n", f"+++ {after}\n"]
    return "".join(
        line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"
        for line in lines
    )


def _lines(data: bytes | None) -> list[str]:
    text = decode(data or b"").text
    lines = text.split("\n")
    return [f"{line}\n" for line in lines[:-1]] + ([lines[-1]] if lines[-1] else [])
