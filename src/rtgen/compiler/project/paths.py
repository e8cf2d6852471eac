"""Paths of a project: how they are shown, and the search for its files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from rtgen.compiler.project.kinds import is_definition, is_generated
from rtgen.facts.files import in_order, is_folder, walk


def shown_path(path: Path, folder: Path | None = None) -> Path:
    """Return the path relative to the folder, by default the working folder (absolute on another
    drive).
    """
    try:
        return Path(os.path.relpath(path, folder))
    except ValueError:
        return path


def shown(path: Path) -> str:
    """Return the path as displayed in messages."""
    return shown_path(path).as_posix()


def tecs_path() -> tuple[Path, ...]:
    """Return the folder that TECSPATH names, and its subfolders."""
    name = os.environ.get("TECSPATH")
    if not name or not is_folder(Path(name)):
        return ()
    folder = Path(name).absolute()
    return (folder, *(p for p in in_order(folder) if p.is_dir()))


def normal(path: Path) -> Path:
    """Return the path without `..` and repeated separators; links are not followed."""
    return Path(os.path.normpath(path))


def files(paths: Iterable[Path], skip: Path) -> Iterator[Path]:
    """Yield the definition files given, and those below the given folders, sorted and unique."""
    seen: set[Path] = set()
    for path in paths:
        candidates = below(path, skip) if is_folder(path) else [path]
        for file in candidates:
            key = normal(file.absolute())
            if key not in seen:
                seen.add(key)
                yield file


def below(folder: Path, skip: Path) -> list[Path]:
    """Return the definition files below a folder, sorted, without hidden folders and `skip`."""
    paths = []
    for parent, folders, files in walk(folder):
        here = Path(parent)
        folders[:] = [
            f
            for f in folders
            if not f.startswith(".") and normal((here / f).absolute()) != skip
        ]
        paths += [
            here / f
            for f in files
            if not f.startswith(".")
            and is_definition(here / f)
            and not is_generated(here / f)
        ]
    return sorted(paths, key=lambda p: p.parts)
