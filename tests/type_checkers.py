"""Checks generated code with mypy and pyright.

All runs of mypy in a process of pytest share a cache, which is kept: imported modules are analysed
once.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

_WORKER = os.environ.get("PYTEST_XDIST_WORKER", "alone")
_VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"
_CACHE = Path(__file__).parents[1] / "build" / "mypy-of-tests" / _VERSION / _WORKER


def check_by_mypy(paths: Iterable[Path], search: Iterable[Path]) -> None:
    """Check files and packages by mypy, strictly; `search` are the folders of packages.

    Raises AssertionError with mypy's output if it finds something.
    """
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary"]
    command += ["--config-file=", "--explicit-package-bases"]
    command += ["--cache-dir", str(_CACHE), *map(str, paths)]
    environment = {**os.environ, "MYPYPATH": os.pathsep.join(map(str, search))}
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False
    )
    printed = done.stdout + done.stderr
    assert (done.returncode, printed) == (0, ""), printed


def check_by_pyright(paths: Iterable[Path], folder: Path) -> None:
    """Check packages by pyright; they import each other from `folder`.

    Raises AssertionError with pyright's output if it finds something; skips if it cannot run.
    """
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
    command += map(str, paths)
    environment = {**os.environ, "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    found = re.search(r"^(\d+) errors?, (\d+) warnings?", done.stdout, re.MULTILINE)
    if found is None:
        pytest.skip(f"pyright cannot run here, it needs Node.js: {done.stderr[-300:]}")
    assert found.groups() == ("0", "0"), done.stdout
