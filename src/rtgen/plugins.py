"""Plug-ins of installed packages, by entry points; docs/extending.md describes each group."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import suppress
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtgen.diagnostics import ToolError

if TYPE_CHECKING:  # it takes as long to import as all that rtgen has for IDL
    from importlib import metadata

_INFORMATION = (".dist-info", ".egg-info")
"""The ends of the names of folders that describe a package."""


class Group(StrEnum):
    """The groups of entry points that rtgen reads, besides `rtgen.components`."""

    BACKENDS = "rtgen.backends"
    FRONTENDS = "rtgen.frontends"
    LINT = "rtgen.lint"
    LOWERINGS = "rtgen.lowerings"
    RULES = "rtgen.rules"
    TRANSPORTS = "rtgen.transports"


def announced(*groups: Group) -> tuple[metadata.EntryPoint, ...]:
    """The entry points of the groups, by group and name; nothing is imported."""
    if not _may_be_announced(_search_path()):
        return ()
    from importlib import metadata

    found = [entry for group in groups for entry in metadata.entry_points(group=group)]
    return tuple(
        sorted(found, key=lambda entry: (entry.group, entry.name, entry.value))
    )


def loaded(group: Group) -> Iterator[tuple[str, Any]]:
    """Each plug-in of a group with its name. Raises ToolError for one that cannot be imported."""
    for entry in announced(group):
        yield entry.name, load(entry)


def load(entry: metadata.EntryPoint) -> Any:
    """What an entry point names. Raises ToolError."""
    try:
        return entry.load()
    except (ImportError, AttributeError) as error:
        raise ToolError(
            f"the plug-in {entry.name!r} of {entry.group} ({entry.value}) cannot be"
            f" loaded: {error}",
            hint="repair or uninstall the package that brings it",
        ) from error


def _search_path() -> tuple[tuple[str, int], ...]:
    """The folders and archives that Python imports from, with the times of their last change."""
    found: list[tuple[str, int]] = []
    for place in sys.path:
        with suppress(OSError):
            found.append((place, Path(place).stat().st_mtime_ns))
    return tuple(found)


@lru_cache(maxsize=8)
def _may_be_announced(search_path: tuple[tuple[str, int], ...]) -> bool:
    """Whether a package may have entry points in one of the groups.

    Looks for their names alone, which takes a tenth of the time that importlib.metadata takes to
    read all entry points.
    """
    heads = tuple(f"[{group}]".encode() for group in Group)
    for place, _ in search_path:
        folder = Path(place)
        if not folder.is_dir():  # an archive, whose packages importlib.metadata knows
            return True
        for entry in folder.iterdir():
            if entry.name == "EGG-INFO" or entry.suffix == ".egg":
                return True
            if entry.suffix in _INFORMATION:
                with suppress(OSError):
                    text = (entry / "entry_points.txt").read_bytes()
                    if any(head in text for head in heads):
                        return True
    return False
