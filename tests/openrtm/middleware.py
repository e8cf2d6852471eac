"""OpenRTM-aist-Python for tests: the real one if it is installed, else the stub of this folder."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import programs

HERE = Path(__file__).parent
STUB = HERE / "stub"
DATA_TYPES = HERE.parents[1] / "specs/idl"
STOCK = ("BasicDataType", "ExtendedDataTypes", "InterfaceDataTypes")

REAL = importlib.util.find_spec("OpenRTM_aist") is not None
"""Whether OpenRTM-aist-Python itself is installed."""


def program(name: str) -> str:
    """Return the path of a program that must exist."""
    found = programs.find(name)
    assert found is not None, f"{name} is missing"
    return found


def compile_stubs(folder: Path) -> Path:
    """Create the folder `RTM_IDL` below a folder: IDL files and omniidl's output."""
    target = folder / "RTM_IDL"
    target.mkdir()
    for file in (*(DATA_TYPES / f"{name}.idl" for name in STOCK), *STUB.glob("idl/*")):
        shutil.copy(file, target)
    compile_idl(target, sorted(target.glob("*.idl")), [target])
    return target


def compile_idl(
    target: Path, files: list[Path], include: list[Path] | None = None
) -> None:
    """Compile files to Python modules by omniidl."""
    included = [f"-I{folder}" for folder in include or []]
    command = [program("omniidl"), "-bpython", f"-C{target}", *included]
    subprocess.run([*command, *map(str, files)], check=True)


def search_path(stubs: Path) -> list[Path]:
    """Return the folders that OpenRTM's .pth file puts on the search path."""
    return [STUB, stubs]


def environment(folders: list[Path]) -> dict[str, str]:
    """Return the environment of a process that finds OpenRTM in these folders."""
    there = [os.environ["PYTHONPATH"]] if os.environ.get("PYTHONPATH") else []
    path = os.pathsep.join([*map(str, folders), *there])
    own = {"PYTHONPATH": path, "PYTHON": sys.executable}
    if folders:
        own["RTM_IDL"] = str(folders[-1])
    places = [str(Path(sys.executable).parent), os.environ["PATH"]]
    return {**os.environ, **own, "PATH": os.pathsep.join(places)}


@contextmanager
def launched(
    command: list[str],
    options: dict[str, str],
    environment: dict[str, str],
    folder: Path,
) -> Iterator[subprocess.Popen[bytes]]:
    """Start a manager in a process of its own, which works in `folder`."""
    settings = [text for item in options.items() for text in ("-o", ":".join(item))]
    with (folder / "manager.out").open("wb") as out:
        process = subprocess.Popen(
            [sys.executable, *command, *settings],
            cwd=folder,
            env=environment,
            stdout=out,
            stderr=subprocess.STDOUT,
        )
    try:
        yield process
    finally:
        process.terminate()
        process.wait()
