"""Modules of the command line are short, and their functions simple: the work is in the wings."""

from __future__ import annotations

import subprocess
import sys

import pytest
from rtgen_sources import sources

LONGEST = 200
"""Lines of a module."""
COMPLEXITY = 15
"""Largest cyclomatic number of a function (McCabe)."""

COMMANDS = {name: path for name, path in sources().items() if name.startswith("cli/")}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_module_is_short(name: str) -> None:
    assert len(COMMANDS[name].read_text("utf-8").splitlines()) <= LONGEST


def test_functions_are_simple() -> None:
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--no-cache"]
    command += ["--select", "C901", "--config"]
    command += [f"lint.mccabe.max-complexity={COMPLEXITY}"]
    done = subprocess.run(
        [*command, *map(str, COMMANDS.values())], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout
