"""Writes an output folder again and again, with a fault in each run, in a child process.

    python write_faults.py kill|full|readonly

Prints the number of runs with a fault. In any case, each file is the old one or the new one, and
the next run without a fault writes the same tree as a run without previous faults.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from rtgen.compiler.backends import Artifact
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project import Project, output
from rtgen.compiler.project.compilation import Compilation

OLD, NEW = b"old\n" * 500, b"new\n" * 900
BEFORE = [f"{folder}/{name}.txt" for folder in "ab" for name in "12"]
AFTER = [f"{folder}/{name}.txt" for folder in "bc" for name in "123"]
UNPRIVILEGED = 65534
_CHANGES = {
    *("open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate"),
    *("os.link", "os.symlink", "os.chmod"),
}
"""Audit events of changes of a folder, and of opening files."""


def _written(project: Project, paths: list[str], text: bytes) -> None:
    made = [Artifact(path, text.decode(), ("a.idl",)) for path in paths]
    output.write(project, Compilation(made, {"a.idl": str(len(text))}))


def _project(folder: Path) -> Project:
    return Project(
        root=folder, base=folder, output=folder / "generated", skeletons=folder / "src"
    )


def _tree(project: Project) -> dict[str, bytes]:
    return {
        file.relative_to(project.output).as_posix(): file.read_bytes()
        for file in sorted(project.output.rglob("*"))
        if file.is_file()
    }


def _child(act: Callable[[], None]) -> int:
    """Return the signal or exit code of a child that acts; 3 for a reported error."""
    sys.stdout.flush()
    if child := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    try:
        act()
    except ToolError:
        os._exit(3)
    except BaseException:
        sys.excepthook(*sys.exc_info())
        os._exit(1)
    os._exit(0)


def _killed_at(number: int, folder: str) -> None:
    """Kill this process at its n-th change, or opening, in the folder."""
    seen = 0

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        nonlocal seen
        if event in _CHANGES and str(arguments[0]).startswith(folder):
            seen += 1
            if seen == number:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(hook)


def _full_at(octets: int) -> None:
    """Limit the octets of all files, like a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (octets, octets))


def _checked(folder: Path, act: Callable[[Project], None]) -> int:
    """Act in a child on a tree; return the outcome."""
    project = _project(folder / "tree")
    shutil.rmtree(project.root, ignore_errors=True)
    project.root.mkdir()
    _written(project, BEFORE, OLD)
    code = _child(lambda: act(project))
    left = _tree(project)
    manifest = json.loads(left.get(".rtgen.json", b"{}")).get("files", {})
    for path, data in left.items():
        if path.endswith(".txt"):
            assert data in (OLD, NEW), f"{path} has {len(data)} octets"
            assert path in manifest, f"{path} is not in the manifest"
    _written(project, AFTER, NEW)
    assert sorted(_tree(project)) == sorted([".rtgen.json", *AFTER])
    assert all(data == NEW for path, data in _tree(project).items() if path in AFTER)
    return code


def kill(folder: Path) -> int:
    """Kill at each change."""
    number = 0
    while True:
        number += 1

        def act(project: Project, number: int = number) -> None:
            _killed_at(number, str(project.root))
            _written(project, AFTER, NEW)

        if (code := _checked(folder, act)) == 0:
            return number - 1
        assert code == -signal.SIGKILL, code


def full(folder: Path) -> int:
    """Simulate a full disk at a number of octets."""
    sizes = (0, 1, 100, len(OLD), len(NEW) - 1)

    def act(project: Project, octets: int) -> None:
        _full_at(octets)
        _written(project, AFTER, NEW)

    for octets in sizes:
        code = _checked(folder, lambda project, octets=octets: act(project, octets))
        assert code == 3, (octets, code)
    return len(sizes)


def readonly(folder: Path) -> int:
    """Write without permission into each folder of the tree."""
    places = ("generated", "generated/b", "")
    folder.chmod(0o755)

    def act(project: Project, place: str) -> None:
        for path in (project.root, *project.root.rglob("*")):
            path.chmod(0o755 if path.is_dir() else 0o644)
            if not os.getuid():
                os.chown(path, UNPRIVILEGED, -1)
        (project.root / place).chmod(0o555)
        if not os.getuid():
            os.setuid(UNPRIVILEGED)
        try:
            _written(project, AFTER, NEW)
        finally:
            (project.root / place).chmod(0o755)

    for place in places:
        code = _checked(folder, lambda project, place=place: act(project, place))
        assert code == (0 if place == "" else 3), (place, code)
    return len(places) - 1


if __name__ == "__main__":
    # A folder that an unprivileged user can reach, too.
    with TemporaryDirectory() as scratch:
        faults = {"kill": kill, "full": full, "readonly": readonly}
        print(faults[sys.argv[1]](Path(scratch)))
