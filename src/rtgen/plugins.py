"""Plug-ins of installed packages, as entry points; docs/extending.md describes each group."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtgen.diagnostics import ToolError
from rtgen.files import MAX_BYTES, read_start

if TYPE_CHECKING:  # lazily: takes as long as all imports for IDL
    from importlib import metadata

_METADATA_SUFFIXES = (".dist-info", ".egg-info")
"""Suffixes of the folders that contain a package's metadata."""


class Group(StrEnum):
    """The groups of entry points that rtgen reads, besides `rtgen.components`."""

    BACKENDS = "rtgen.backends"
    FRONTENDS = "rtgen.frontends"
    LINT = "rtgen.lint"
    LOWERINGS = "rtgen.lowerings"
    RULES = "rtgen.rules"
    TRANSPORTS = "rtgen.transports"


def announced(*groups: Group) -> tuple[metadata.EntryPoint, ...]:
    """Return the entry points of the groups, by group and name; nothing is imported."""
    if not _may_be_announced(_search_path()):
        return ()
    from importlib import metadata

    found = [entry for group in groups for entry in metadata.entry_points(group=group)]
    return tuple(
        sorted(found, key=lambda entry: (entry.group, entry.name, entry.value))
    )


def loaded(group: Group) -> Iterator[tuple[str, Any]]:
    """Yield each plug-in of a group with its name. Raises ToolError if an import fails."""
    for entry in announced(group):
        yield entry.name, load(entry)


def load(entry: metadata.EntryPoint) -> Any:
    """Load the object of an entry point. Raises ToolError."""
    try:
        return entry.load()
    except (ImportError, AttributeError) as error:
        raise ToolError(
            f"the plug-in {entry.name!r} of {entry.group} ({entry.value}) cannot be"
            f" loaded: {error}",
            hint="repair or uninstall the package that brings it",
        ) from error


def _search_path() -> tuple[tuple[str, int], ...]:
    """Return the folders and archives that Python imports from, with their modification times."""
    found: list[tuple[str, int]] = []
    for place in sys.path:
        with suppress(OSError):
            found.append((place, Path(place).stat().st_mtime_ns))
    return tuple(found)


@lru_cache(maxsize=8)
def _may_be_announced(search_path: tuple[tuple[str, int], ...]) -> bool:
    """Return whether a package may have entry points in one of the groups.

    Only searches for the groups' names, which takes a tenth of the time that importlib.metadata
    takes to read all entry points.
    """
    heads = tuple(f"[{group}]".encode() for group in Group)
    for place, _ in search_path:
        folder = Path(place)
        if not folder.is_dir():  # an archive
            return True
        for name in os.listdir(folder):  # noqa: PTH208 (time)
            if name == "EGG-INFO" or name.endswith(".egg"):
                return True
            if name.endswith(_METADATA_SUFFIXES):
                with suppress(OSError):
                    text = read_start(folder / name / "entry_points.txt", MAX_BYTES)
                    if any(head in text for head in heads):
                        return True
    return False
