"""The output folder: the only code that writes what rtgen generates.

A plan tells what a run would change; `write` carries it out. A file is written beside its place
and moved onto it, so whenever a run ends, each file is either the old one or the new one. The
manifest is written before the files it names, so no file is ever made that no manifest knows.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from rtgen import __version__
from rtgen.backends import Artifact, Owner
from rtgen.diagnostics import Diagnostic, InputError, Rule, ToolError
from rtgen.project import Project, shown
from rtgen.project_rules import (
    ENCODING,
    LEAVES_OUTPUT,
    LINK_IN_OUTPUT,
    NAME_TOO_LONG,
    SAME_PATH,
)

MANIFEST = ".rtgen.json"
_FORMAT = "rtgen-manifest/1"
_TEMPORARY = (".rtgen-", ".tmp")
_BYTECODE = "__pycache__"
_LONGEST_NAME = 255
_FORBIDDEN = frozenset('\\:*?"<>|').union(map(chr, range(32)), "\x7f")


@dataclass(frozen=True, slots=True)
class Change:
    """A file that differs: its bytes now (None: not there) and then (None: no longer made).

    `obstacle` says that something other than a regular file is in its place.
    """

    path: Path
    old: bytes | None
    new: bytes | None
    obstacle: bool = False


@dataclass(frozen=True, slots=True)
class Plan:
    """What a run would do to the disk. `changes` are rtgen's own files in the order of writing,
    `skeletons` a user's, `strays` files that rtgen neither makes nor made, `leftovers` and
    `barren` what a killed run left and folders that nothing is in, innermost first."""

    changes: tuple[Change, ...]
    skeletons: tuple[Change, ...]
    strays: tuple[Path, ...]
    leftovers: tuple[Path, ...]
    barren: tuple[Path, ...]
    unchanged: int

    @property
    def empty(self) -> bool:
        """Whether there is nothing to do."""
        return not (self.changes or self.skeletons or self.leftovers or self.barren)


def plan(
    project: Project, artifacts: Sequence[Artifact], inputs: Mapping[str, str]
) -> Plan:
    """What to do so that the tree holds the artifacts, made from inputs (key to sha256).

    Raises InputError if a file would leave its folder, ToolError if the disk fails.
    """
    findings = [*_check_paths(artifacts)]
    if findings:
        raise InputError(findings)
    own = [a for a in artifacts if a.owner is Owner.RTGEN]
    users = [a for a in artifacts if a.owner is Owner.USER]
    absent = [a for a in users if not os.path.lexists(project.skeletons / a.path)]
    findings = [
        *_check_links(project, project.output, [*(a.path for a in own), MANIFEST]),
        *_check_links(project, project.skeletons, [a.path for a in absent]),
    ]
    if findings:
        raise InputError(findings)
    wanted = {a.path: a.text.encode() for a in own}
    with _disk_failures():
        there, found, temporary = _tree(project.output)
        former = [p for p in _former(project.output) if p in there and p not in wanted]
        manifest = _manifest(own, wanted, inputs)
        changes = [
            Change(project.output / p, _read(project.output / p), None) for p in former
        ]
        for path, data in [(MANIFEST, manifest), *sorted(wanted.items())]:
            changes += _difference(project.output / path, data)
        written = sum(c.new is not None for c in changes)
        kept = {
            f for p in {*there.difference(former), *wanted} for f in _folders_above(p)
        }
        folders = {(project.skeletons / a.path).parent for a in users}
        return Plan(
            changes=tuple(changes),
            skeletons=tuple(
                Change(project.skeletons / a.path, None, a.text.encode())
                for a in absent
            ),
            strays=tuple(
                project.output / p for p in sorted(there - {*wanted, *former, MANIFEST})
            ),
            leftovers=(
                *temporary,
                *(f for d in sorted(folders) for f in _temporary_in(d)),
            ),
            barren=tuple(
                project.output / f for f in sorted(found - kept, reverse=True)
            ),
            unchanged=len(wanted) + 1 - written,
        )


def write(
    project: Project, artifacts: Sequence[Artifact], inputs: Mapping[str, str]
) -> Plan:
    """Makes the tree hold the artifacts and returns what was done.

    Raises as `plan` does, in which case nothing was written, and ToolError if the disk
    fails on the way.
    """
    with _disk_failures():
        if not project.output.is_dir():
            plan(
                project, artifacts, inputs
            )  # what it finds wrong comes before the folder
            project.output.mkdir(parents=True, exist_ok=True)
        with _lock(project.output):
            planned = plan(project, artifacts, inputs)
            _apply(project, planned)
    return planned


def _apply(project: Project, planned: Plan) -> None:
    for leftover in planned.leftovers:
        leftover.unlink(missing_ok=True)
    for change in planned.changes:
        if change.new is None:
            change.path.unlink()
    for folder in planned.barren:
        _remove_barren(folder)
    touched = set()
    for change in (*planned.changes, *planned.skeletons):
        if change.new is not None:
            change.path.parent.mkdir(parents=True, exist_ok=True)
            _write_whole(change.path, change.new)
            touched.add(change.path.parent)
    for folder in sorted(touched):
        _sync_folder(folder)


def _manifest(
    own: Iterable[Artifact], wanted: Mapping[str, bytes], inputs: Mapping[str, str]
) -> bytes:
    content = {
        "format": _FORMAT,
        "generator": f"rtgen {__version__}",
        "inputs": dict(sorted(inputs.items())),
        "files": {
            a.path: {
                "sha256": sha256(wanted[a.path]).hexdigest(),
                "inputs": list(a.origin),
            }
            for a in sorted(own, key=lambda a: a.path)
        },
    }
    return (json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode()


def _former(output: Path) -> list[str]:
    """The files that the manifest on the disk names; none if it is missing or damaged."""
    file = output / MANIFEST
    if not file.is_file():
        return []
    try:
        content = json.loads(file.read_bytes())
        files = list(content["files"])
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return []
    return sorted(f for f in files if isinstance(f, str) and _name_problem(f) is None)


def _check_paths(artifacts: Iterable[Artifact]) -> Iterator[Diagnostic]:
    """Findings for paths that leave the folder or that two artifacts share."""
    files: dict[tuple[Owner, str], Artifact] = {}
    folders: dict[tuple[Owner, str], Artifact] = {}
    for artifact in artifacts:
        origin = " and ".join(artifact.origin) or "a back end"
        if (problem := _name_problem(artifact.path)) is not None:
            yield problem.at(None, f"{origin}: {problem.title}: {artifact.path!r}")
            continue
        try:
            artifact.text.encode()
        except UnicodeEncodeError:
            yield ENCODING.at(None, f"{origin}: {artifact.path} holds a lone surrogate")
        path = artifact.path.casefold()
        key = (artifact.owner, path)
        other = files.get(key) or folders.get(key)
        for parent in _folders_above(path):
            other = other or files.get((artifact.owner, parent))
            folders.setdefault((artifact.owner, parent), artifact)
        if other is not None:
            others = " and ".join(other.origin) or "a back end"
            yield SAME_PATH.at(
                None,
                f"{artifact.path!r}, made from {origin}, clashes with {other.path!r}, "
                f"made from {others}",
            )
        files.setdefault(key, artifact)


def _name_problem(path: str) -> Rule | None:
    parts = path.split("/")
    for part in parts:
        if (
            part in ("", ".", "..")
            or part.startswith(".rtgen")
            or not _FORBIDDEN.isdisjoint(part)
        ):
            return LEAVES_OUTPUT
        if len(part.encode("utf-8", "surrogatepass")) > _LONGEST_NAME:
            return NAME_TOO_LONG
    return None


def _check_links(
    project: Project, folder: Path, paths: list[str]
) -> Iterator[Diagnostic]:
    """Findings for links on the way from the folder to each path, and for the folder itself."""
    if not paths:
        return
    if not Path(os.path.realpath(folder)).is_relative_to(
        os.path.realpath(project.base)
    ):
        yield LINK_IN_OUTPUT.at(
            None, f"{shown(folder)} leads out of {shown(project.base)}"
        )
        return
    steps = {
        "/".join(parts[:i])
        for p in paths
        for parts in [p.split("/")]
        for i in _upto(parts)
    }
    for step in sorted(steps):
        if (folder / step).is_symlink():
            yield LINK_IN_OUTPUT.at(
                None,
                f"{shown(folder / step)} is a symbolic link",
                hint="remove the link; rtgen makes what it needs",
            )


def _upto(parts: Sequence[str]) -> range:
    return range(1, len(parts) + 1)


def _tree(output: Path) -> tuple[set[str], set[str], list[Path]]:
    """What lies below the output folder, bytecode left out: files and links, folders, and what a
    killed run left half written."""
    there: set[str] = set()
    found: set[str] = set()
    temporary = []
    for parent, folders, files in os.walk(output):
        here = Path(parent)
        below = here.relative_to(output).as_posix()
        if below != ".":
            found.add(below)
        links = [f for f in folders if (here / f).is_symlink()]
        folders[:] = sorted(f for f in folders if f != _BYTECODE and f not in links)
        for name in (*files, *links):
            if _is_temporary(name):
                temporary.append(here / name)
            elif name != _BYTECODE:
                there.add((here / name).relative_to(output).as_posix())
    return there, found, sorted(temporary)


def _folders_above(path: str) -> Iterator[str]:
    return (path[:i] for i, c in enumerate(path) if c == "/")


def _is_temporary(name: str) -> bool:
    return name.startswith(_TEMPORARY[0]) and name.endswith(_TEMPORARY[1])


def _temporary_in(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(f for f in folder.iterdir() if _is_temporary(f.name))


def _difference(path: Path, data: bytes) -> list[Change]:
    try:
        mode = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return [Change(path, None, data)]
    if not stat.S_ISREG(mode):
        return [Change(path, None, data, obstacle=True)]
    old = path.read_bytes()
    return [] if old == data else [Change(path, old, data)]


def _read(path: Path) -> bytes | None:
    return path.read_bytes() if stat.S_ISREG(path.lstat().st_mode) else None


def _write_whole(path: Path, data: bytes) -> None:
    """Writes a file so that its place never holds a part of it."""
    temporary = path.with_name(f"{_TEMPORARY[0]}{os.getpid()}{_TEMPORARY[1]}")
    try:
        with temporary.open("xb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _remove_barren(folder: Path) -> None:
    """Removes a folder in which bytecode at most is left."""
    bytecode = folder / _BYTECODE
    if bytecode.is_dir() and not bytecode.is_symlink():
        shutil.rmtree(bytecode)
    folder.rmdir()


def _sync_folder(folder: Path) -> None:
    if sys.platform != "win32":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


@contextlib.contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """One run at a time writes below the folder; the lock ends with its process."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    descriptor = os.open(folder, os.O_RDONLY)
    try:
        # Some network file systems have no locks: then runs are on their own.
        with contextlib.suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def _disk_failures() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        file = error.filename2 or error.filename  # of a move, where it was to go
        name = shown(Path(file)) if isinstance(file, str) else "the output folder"
        raise ToolError(f"{name}: {error.strerror or error}") from error
