"""Generated modules pass `mypy --strict` with any stubs for the ORB."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import black
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ANY = "from typing import Any\n\ndef __getattr__(name: str) -> Any: ...\n"
_IMPORT = re.compile(r"^import (\w+)$", re.MULTILINE)


def modules(out: Path) -> list[Path]:
    return [path.with_name(f"{path.parent.name}.py") for path in profiles(out)]


def profiles(out: Path) -> list[Path]:
    return sorted(out.glob("openrtm/*/RTC.xml"))


@pytest.mark.nightly
@pytest.mark.peer
def test_modules_are_in_blacks_form(reference: Path) -> None:
    for module in modules(reference):
        text = module.read_text(encoding="utf-8")
        assert black.format_str(text, mode=black.Mode()) == text, module.name


@pytest.mark.nightly
def test_modules_are_typed(reference: Path, tmp_path: Path) -> None:
    """Without stubs, with empty ones, and with OpenRTM's real base classes."""
    stubs = tmp_path / "stubs"
    stubs.mkdir()
    files = modules(reference)
    cache = tmp_path / "cache"
    check(files, [stubs, reference], cache)
    for file in files:
        for name in set(_IMPORT.findall(file.read_text(encoding="utf-8"))) - {"sys"}:
            (stubs / f"{name}.pyi").write_text(ANY, encoding="utf-8")
    check(files, [stubs, reference], cache)
    shutil.copy(HERE / "typings/OpenRTM_aist.pyi", stubs)
    check(files, [stubs, reference], cache)


def check(files: list[Path], path: list[Path], cache: Path) -> None:
    """Check files with a cache of the test: mypy ignores options in a cached module's file."""
    strict = ["mypy", "--strict", "--config-file", "", *map(str, files)]
    completed = subprocess.run(
        [sys.executable, "-m", *strict],
        env={
            **os.environ,
            "MYPYPATH": os.pathsep.join(map(str, (*path, ROOT / "src"))),
            "MYPY_CACHE_DIR": str(cache),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert completed.returncode == 0, completed.stdout + completed.stderr
