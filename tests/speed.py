"""Builds the codecs in C for tests, in `build/speed`, where a compiler is.

    python tests/speed.py

`RTGEN_CODEC=c PYTHONPATH=build/speed pytest` then runs tests with them, as `make nightly` does.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import environments
import pytest

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "speed"
FOLDER = ROOT / "build" / "speed"
FILE = FOLDER / f"rtgen_speed{sysconfig.get_config_var('EXT_SUFFIX')}"


def build(file: Path = FILE, **environment: str) -> None:
    """Build the module unless it is newer than its sources.

    `environment` are variables of the build. Raises CalledProcessError without a compiler, and if
    the tools of a build cannot be had.
    """
    sources = [SOURCE / "pyproject.toml", *(SOURCE / "src").iterdir()]
    newest = max(path.stat().st_mtime for path in sources)
    if file.exists() and file.stat().st_mtime > newest:
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = shutil.copytree(
            SOURCE, Path(folder, "source"), ignore=shutil.ignore_patterns("build")
        )
        wheel = environments.build_wheel(copy, Path(folder, "wheels"), **environment)
        with zipfile.ZipFile(wheel) as members:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.unlink(missing_ok=True)
            members.extract(file.name, file.parent)
    file.touch()


def module() -> ModuleType:
    """Return the module that was built; skips the test if there is none."""
    found = sys.modules.get("rtgen_speed")
    if found is not None:
        return found
    if not FILE.exists():
        pytest.skip("rtgen-speed is not built: python tests/speed.py, with a compiler")
    spec = importlib.util.spec_from_file_location("rtgen_speed", FILE)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def choose_for_ports(monkeypatch: pytest.MonkeyPatch, module: Any) -> None:
    """Calls of ports are in that module from the next connection on, or in Python without one."""
    from rtgen.runtime import InPort, OutPort
    from rtgen.runtime.marshalling import tables
    from rtgen.runtime.ports import data_ports, in_c

    for class_, name in ((OutPort, "write"), (InPort, "read"), (InPort, "is_new")):
        call = vars(class_)[name]
        monkeypatch.setattr(class_, name, getattr(call, "__wrapped__", call))
    monkeypatch.setattr(tables, "speed", lambda: module)
    monkeypatch.setattr(data_ports, "module", cache(in_c.module.__wrapped__))


if __name__ == "__main__":
    try:
        build()
    except subprocess.CalledProcessError as failure:
        sys.exit(f"rtgen-speed was not built: {failure}")
