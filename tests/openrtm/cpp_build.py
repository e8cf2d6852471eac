"""Programs in C++ with omniORB, compiled if its headers are installed.

They are Debian's `libomniorb4-dev` and `omniidl`, below /usr or the folder that `OMNIORB_PREFIX`
names.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

PREFIX = Path(os.environ.get("OMNIORB_PREFIX", "/usr"))
_COMPILER = shutil.which("g++")
_LIBRARIES = ("omniORB4", "omniDynamic4", "omnithread", "pthread")
_OMNIIDL = PREFIX / "bin" / "omniidl"
_IS_THERE = (PREFIX / "include/omniORB4/CORBA.h").exists() and _OMNIIDL.exists()

needed = [
    pytest.mark.skipif(_COMPILER is None, reason="g++ is missing"),
    pytest.mark.skipif(
        not _IS_THERE,
        reason="omniORB's headers for C++ (libomniorb4-dev, omniidl) are missing; "
        "OMNIORB_PREFIX names their folder",
    ),
]
"""Marks of tests that need a program in C++."""


def programs(folder: Path, idl: Sequence[Path], source: Path) -> Path:
    """Compile the stubs of IDL files and all files of a folder; return the folder of programs.

    A file without a header of its name is a program; it is linked with all others.
    """
    assert _COMPILER is not None
    for file in idl:
        included = [f"-I{each.parent}" for each in idl]
        _run(
            [str(_OMNIIDL), "-bcxx", "-Wbh=.hh", "-Wbs=.cc", *included, str(file)],
            folder,
            PYTHONPATH=str(PREFIX / "lib/omniidl"),
        )
    files = [*sorted(folder.glob("*.cc")), *sorted(source.glob("*.cc"))]
    options = ["-std=c++17", "-O0", "-I."]
    if Path("/usr") != PREFIX:
        # That is searched anyway; named, it would precede the folders of C++ itself.
        options.append(f"-isystem{PREFIX / 'include'}")

    def compiled(file: Path) -> str:
        strict = ["-Wall", "-Wextra", "-Werror"] if file.parent == source else []
        target = f"{file.stem}.o"
        _run([str(_COMPILER), *options, *strict, "-c", str(file), "-o", target], folder)
        return target

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = dict(zip(files, pool.map(compiled, files), strict=True))
    mains = [each for each in files if not each.with_suffix(".hh").exists()]
    shared = [made for file, made in objects.items() if file not in mains]
    [library] = {file.parent for file in PREFIX.glob("lib/**/libomniORB4.so")}
    found = [f"-L{library}", f"-Wl,-rpath,{library}"]
    linked = [f"-l{name}" for name in _LIBRARIES]
    for file in mains:
        made = [objects[file], *shared, "-o", file.stem]
        _run([_COMPILER, *made, *found, *linked], folder)
    return folder


def _run(command: Sequence[str], folder: Path, **environment: str) -> None:
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
