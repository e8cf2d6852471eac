"""Formats planned changes as a unified diff."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher, unified_diff
from itertools import takewhile

import msgspec

from rtgen.compiler.project import shown
from rtgen.compiler.project.output import MANIFEST, Change
from rtgen.facts.encodings import decode

_DEV_NULL = "/dev/null"
_HEAD = ("---", "+++")
"""The lines before the first difference."""
_MAX_WIDTH = 160
_MAX_COMPARED = 2000
"""Maximum number of lines between the first and the last difference that are compared."""


class Hunk(msgspec.Struct, frozen=True):
    """Lines that differ: their range in the old text and in the new one, ends exclusive."""

    old: tuple[int, int]
    new: tuple[int, int]


def hunks(old: Sequence[str], new: Sequence[str]) -> list[Hunk]:
    """Return the differences of two texts; one of all lines if they are long and far apart."""
    start = _equal(zip(old, new, strict=False))
    end = _equal(zip(reversed(old[start:]), reversed(new[start:]), strict=False))
    before, after = (lines[start : len(lines) - end] for lines in (old, new))
    if max(len(before), len(after)) > _MAX_COMPARED:
        return [Hunk((start, len(old) - end), (start, len(new) - end))]
    matcher = SequenceMatcher(None, before, after, autojunk=False)
    return [
        Hunk((start + a, start + b), (start + c, start + d))
        for kind, a, b, c, d in matcher.get_opcodes()
        if kind != "equal"
    ]


def _equal(pairs: Iterable[tuple[str, str]]) -> int:
    """Return the number of equal pairs before the first that differs."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def diff(changes: Iterable[Change], *, most: int | None = None) -> str:
    """Return the diff from the files on disk to the generated ones, without the manifest.

    `most` is the number of lines that are shown of each file that is there before and afterwards;
    None: all.
    """
    return "".join(_one(c, most) for c in changes if c.path.name != MANIFEST)


def _one(change: Change, most: int | None) -> str:
    name = shown(change.path)
    if change.obstacle:
        return f"Not a regular file: {name}\n"
    before = f"a/{name}" if change.old is not None else _DEV_NULL
    after = f"b/{name}" if change.new is not None else _DEV_NULL
    lines = [*unified_diff(_lines(change.old), _lines(change.new), before, after)]
    if not lines:
        lines = [f"--- {before}\n", f"+++ {after}\n"]
    if most is not None:
        is_changed = change.old is not None and change.new is not None
        lines = _short(lines, most if is_changed else len(_HEAD))
    return "".join(
        line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"
        for line in lines
    )


def _short(lines: list[str], most: int) -> list[str]:
    """Return the first lines of a diff, long ones cut, and how many more there are."""
    cut = [
        line if len(line) <= _MAX_WIDTH else f"{line[:_MAX_WIDTH]}...\n"
        for line in lines[:most]
    ]
    if most == len(_HEAD) or len(lines) <= most:
        return cut
    return [*cut, f"... {len(lines) - most} more lines, see rtgen generate --diff\n"]


def _lines(data: bytes | None) -> list[str]:
    text = decode(data or b"").text
    lines = text.split("\n")
    return [f"{line}\n" for line in lines[:-1]] + ([lines[-1]] if lines[-1] else [])
