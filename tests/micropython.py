"""Runs programs as on a board: by MicroPython, in its port to WebAssembly from npm."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from node import node

_TESTS = Path(__file__).parent
_PACKAGE = _TESTS.parent / "ui" / "package.json"


def micropython(program: str, folder: Path, given: str = "") -> str:
    """Return what a program prints that imports modules of a folder.

    It may read `given.txt`. Without MicroPython the calling test is skipped.
    """
    if not (_PACKAGE.parent / "node_modules" / "@micropython").exists():
        pytest.skip("MicroPython is missing (`make page` installs it)")
    script = _TESTS / "micropython.mjs"
    text = json.dumps({"program": program, "given": given})
    return node(script, text, str(_PACKAGE), str(folder))
