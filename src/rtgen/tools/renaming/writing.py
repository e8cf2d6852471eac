"""Writes a rename: all of its files, or none."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project import shown
from rtgen.facts.files import read_file, replace_file
from rtgen.tools.renaming import journal
from rtgen.tools.renaming.plan import Renaming


def write(renaming: Renaming) -> None:
    """Change and move the files of a rename. Raises ToolError; all files are then as before.

    A process that is killed leaves a journal, by which the next command completes the rename.
    """
    names = (renaming.old, renaming.new)
    try:
        _check(renaming)
        with journal.begin(renaming.root, names, renaming.contents, renaming.moves):
            _write(renaming)
    except OSError as error:
        where = shown(Path(error.filename)) if error.filename else "a file"
        message = f"cannot rename in {where}: {error.strerror or error}"
        raise ToolError(message, hint="nothing was changed") from error


def _write(renaming: Renaming) -> None:
    """Change and move the files. Raises OSError; all files are then as before."""
    undo: list[Callable[[], object]] = []
    try:
        for name, (old, new) in renaming.contents.items():
            path = Path(name)
            replace_file(path, new, old)
            undo.append(partial(replace_file, path, old, new))
        for source, target in renaming.moves:
            undo += _move(source, target)
    except BaseException:
        for step in reversed(undo):
            with suppress(OSError):
                step()
        raise


def _check(renaming: Renaming) -> None:
    """Raise OSError for a file that cannot be changed, before the first one is."""
    for name in renaming.contents:
        path = Path(name).resolve()
        for place in (path, path.parent):
            if not os.access(place, os.W_OK):
                raise PermissionError(13, os.strerror(13), str(place))
    for source, target in renaming.moves:
        for place in (source.parent, target.parent):
            if not os.access(place, os.W_OK):
                raise PermissionError(13, os.strerror(13), str(place))


def _move(source: Path, target: Path) -> list[Callable[[], object]]:
    """Move a file, and return how that is undone."""
    skeleton = read_file(target) if target.exists() else None
    source.replace(target)
    back = partial(target.rename, source)
    return [back] if skeleton is None else [partial(target.write_bytes, skeleton), back]
