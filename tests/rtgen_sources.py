"""The source files of rtgen, which two distributions install into one namespace."""

from __future__ import annotations

from pathlib import Path

import rtgen


def sources() -> dict[str, Path]:
    """Return all Python files by their path below `rtgen` (`runtime/idl.py`), in order."""
    found = {
        path.relative_to(root).as_posix(): path
        for root in map(Path, rtgen.__path__)
        for path in root.rglob("*.py")
    }
    return dict(sorted(found.items()))
