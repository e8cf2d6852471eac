"""Programs in C++ with omniORB, compiled if its headers are installed.

They are Debian's `libomniorb4-dev` and `omniidl`, below /usr or the folder that `OMNIORB_PREFIX`
names.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

PREFIX = Path(os.environ.get("OMNIORB_PREFIX", "/usr"))
_COMPILER = shutil.which("g++")
_LIBRARIES = ("omniORB4", "omniDynamic4", "omnithread", "pthread")
_OMNIIDL = PREFIX / "bin" / "omniidl"
_KEPT = Path(__file__).parents[2] / "build" / "cpp"
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


def programs(idl: Sequence[Path], source: Path) -> Path:
    """Return the folder of the programs that consist of IDL files and the files of a folder.

    They are compiled once for all processes, and after a change of these files. A file without a
    header of its name is a program; it is linked with all others.
    """
    digest = hashlib.sha256(str(PREFIX).encode())
    for file in (*idl, *sorted(source.iterdir())):
        digest.update(file.read_bytes())
    _KEPT.mkdir(parents=True, exist_ok=True)
    made = _KEPT / digest.hexdigest()[:16]
    with (_KEPT / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            folder = Path(tempfile.mkdtemp(dir=_KEPT))
            _compile(folder, idl, source)
            folder.rename(made)
    return made


def _compile(folder: Path, idl: Sequence[Path], source: Path) -> None:
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


def _run(command: Sequence[str], folder: Path, **environment: str) -> None:
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
