"""The part of the output that a golden case stores (README.md)."""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

SUMS = "SHA256SUMS"
"""The name of the list of digests, in the format of sha256sum."""


def condensed(
    written: Mapping[str, bytes],
    *,
    digest: Sequence[str] = (),
    like: Mapping[str, str] | None = None,
    folder: Path,
) -> dict[str, str]:
    """Return the texts to store by their relative paths: in full, as differences, or as digests.

    `digest` are patterns of paths; `like` maps a path to that of the file of `folder` that it is
    compared with.
    """
    stored: dict[str, str] = {}
    sums = []
    for name, data in sorted(written.items()):
        if like and name in like:
            base = (folder / like[name]).read_text(encoding="utf-8")
            stored[f"{name}.diff"] = difference(base, data.decode(), like[name])
        elif any(fnmatchcase(name, pattern) for pattern in digest):
            sums.append(f"{hashlib.sha256(data).hexdigest()}  {name}\n")
        else:
            stored[name] = data.decode()
    if sums:
        stored[SUMS] = "".join(sums)
    return stored


def difference(base: str, text: str, name: str) -> str:
    """Return a unified diff without context; both texts end with a line feed."""
    assert base.endswith("\n")
    assert text.endswith("\n")
    lines = (side.splitlines(keepends=True) for side in (base, text))
    return "".join(difflib.unified_diff(*lines, name, "this file", n=0))


def shortened(text: str, shown: int) -> str:
    """Return the first and the last `shown` lines, and a digest of the lines between."""
    lines = text.splitlines(keepends=True)
    middle = lines[shown:-shown]
    digest = hashlib.sha256("".join(middle).encode()).hexdigest()
    between = f"({len(middle)} lines, sha256 {digest})\n"
    return "".join([*lines[:shown], between, *lines[-shown:]])
