"""Plug-ins of installed packages, by entry points; docs/extending.md describes each group."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from importlib import metadata
from typing import Any

from rtgen.diagnostics import ToolError


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
