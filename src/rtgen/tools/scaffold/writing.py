"""Writes a starter: all of its files or none, never overwriting."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.project import shown
from rtgen.tools.scaffold.rules import EXISTS
from rtgen.tools.scaffold.starters import File, Link


def require_absent(paths: Sequence[Path]) -> None:
    """Raise InputError for the paths that exist."""
    diagnostics = [
        EXISTS.at(
            None,
            f"{shown(path)} exists already",
            hint="choose another name, or move it",
        )
        for path in paths
        if os.path.lexists(path)
    ]
    if diagnostics:
        raise InputError(diagnostics)


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """Make a folder beside `target`, renamed to it when the block ends without an exception."""
    require_absent([target])
    with _disk_failures():
        folder = Path(tempfile.mkdtemp(prefix=".rtgen-new-", dir=target.parent))
        try:
            folder.chmod(0o777 & ~_umask())
            yield folder
            require_absent([target])
            folder.rename(target)
        finally:
            shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def added(files: Sequence[File | Link]) -> Iterator[None]:
    """Write files and links that are removed again if the block raises an exception.

    Raises InputError if one of them exists, ToolError if the disk fails.
    """
    require_absent([file.path for file in files])
    paths: list[Path] = []
    try:
        with _disk_failures():
            for file in files:
                paths += _make_folders(file.path.parent)
                if isinstance(file, Link):
                    file.path.symlink_to(file.target)
                    paths.append(file.path)
                    continue
                with file.path.open("x", encoding="utf-8", newline="\n") as stream:
                    paths.append(file.path)
                    stream.write(file.text)
        yield
    except BaseException:
        for path in reversed(paths):
            # A folder that has other content by now is kept.
            with contextlib.suppress(OSError):
                is_folder = path.is_dir() and not path.is_symlink()
                path.rmdir() if is_folder else path.unlink()
        raise


def write(files: Sequence[File]) -> None:
    """Write files to a new folder."""
    with added(files):
        pass


def _make_folders(folder: Path) -> list[Path]:
    """Make a folder and its parents; return the new ones, outermost first."""
    missing = [f for f in (folder, *folder.parents) if not f.exists()]
    for each in reversed(missing):
        each.mkdir()
    return missing[::-1]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@contextmanager
def _disk_failures() -> Iterator[None]:
    try:
        yield
    except FileExistsError as error:
        message = f"{shown(Path(error.filename))} exists already"
        raise InputError([EXISTS.at(None, message)]) from error
    except OSError as error:
        name = shown(Path(error.filename)) if error.filename else "the folder"
        raise ToolError(f"{name}: {error.strerror or error}") from error
