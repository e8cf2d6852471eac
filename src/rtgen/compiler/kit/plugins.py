"""Plug-ins of installed packages, as entry points; docs/extending.md describes each group."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import StrEnum
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.facts.files import MAX_BYTES, read_start
from rtgen.facts.looks import NAMES, look

if TYPE_CHECKING:  # lazily: takes as long as all imports for IDL
    from importlib import metadata

T = TypeVar("T")

MAX_VALUES = 100_000
"""Maximum number of files or findings of a plug-in."""

_REPAIR = "repair or uninstall the package that brings it"
_SECTION = re.compile(rb"^\s*\[\s*([^\]\s]+)\s*\]", re.M)
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


def announced(*groups: str) -> tuple[metadata.EntryPoint, ...]:
    """Return the entry points of the groups, by group and name; nothing is imported.

    Raises ToolError for malformed ones.
    """
    sections = _sections(_search_path())
    if sections is not None and sections.isdisjoint(g.encode() for g in groups):
        return ()
    from importlib import metadata

    try:
        entry_points = [
            e for group in groups for e in metadata.entry_points(group=group)
        ]
    except (TypeError, ValueError) as error:
        raise ToolError(
            f"the entry points of a package cannot be read: {_words(error)}", _REPAIR
        ) from error
    return tuple(
        sorted(entry_points, key=lambda entry: (entry.group, entry.name, entry.value))
    )


def loaded(group: Group) -> Iterator[tuple[str, Any]]:
    """Yield each plug-in of a group with its name. Raises ToolError if an import fails."""
    for entry in announced(group):
        yield entry.name, load(entry)


def load(entry: metadata.EntryPoint) -> Any:
    """Load the object of an entry point. Raises ToolError, whatever its import raises."""
    try:
        return entry.load()
    except (Exception, SystemExit) as error:
        raise ToolError(
            f"the plug-in {entry.name!r} of {entry.group} ({entry.value}) cannot be"
            f" loaded: {_words(error)}",
            hint=_REPAIR,
        ) from error


@contextmanager
def running(group: Group, name: str, *passed: type[Exception]) -> Iterator[None]:
    """Within the block a plug-in is called: what it raises becomes a ToolError that names it.

    Exceptions for people, and those of the types `passed`, stay as they are.
    """
    for_people: tuple[type[Exception], ...] = (ToolError, InputError, *passed)
    try:
        yield
    except for_people:
        raise
    except (Exception, SystemExit) as error:
        raise ToolError(
            f"the plug-in {name!r} of {group} failed: {_words(error)}",
            hint=f"RTGEN_DEBUG=1 shows the place; {_REPAIR}",
        ) from error


def is_passed_by(entry: metadata.EntryPoint, error: Exception) -> bool:
    """Return whether an exception has come through code of the package of a plug-in."""
    package = entry.value.partition(":")[0].partition(".")[0]
    trace = error.__traceback__
    while trace is not None:
        module = str(trace.tb_frame.f_globals.get("__name__"))
        if module.partition(".")[0] == package:
            return True
        trace = trace.tb_next
    return False


def suffixes(name: str, frontend: Any) -> tuple[str, ...]:
    """Return the suffixes of the files that a plug-in's front end reads. Raises ToolError."""
    with running(Group.FRONTENDS, name):
        if isinstance(frontend.suffixes, str):
            raise TypeError("its suffixes are a text, not a tuple")
        suffixes_of = require_each(str, frontend.suffixes)
        for each in suffixes_of:
            if not each.startswith(".") or each != each.lower():
                raise ValueError(f"{each!r} is not a suffix in lower case")
        return suffixes_of


def require(kind: type[T], value: Any) -> T:
    """Return what a plug-in has given, if it is of that kind. Raises TypeError."""
    if not isinstance(value, kind):
        raise TypeError(f"it gives a {type(value).__name__}, not a {kind.__name__}")
    return value


def require_each(kind: type[T], values: Any) -> tuple[T, ...]:
    """Return the values that a plug-in has given. Raises TypeError, ValueError for too many."""
    required = tuple(require(kind, each) for each in islice(values, MAX_VALUES + 1))
    if len(required) > MAX_VALUES:
        raise ValueError(f"it gives more than {MAX_VALUES:,} {kind.__name__}s")
    return required


def _words(error: BaseException) -> str:
    """Return an exception in one line; a missing module or name says enough."""
    text = " ".join(str(error).split())
    if isinstance(error, ImportError | AttributeError) and text:
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _search_path() -> tuple[tuple[str, int], ...]:
    """Return the folders and archives that Python imports from, with their modification times."""
    places: list[tuple[str, int]] = []
    for place in sys.path:
        with suppress(OSError):
            places.append((place, Path(place).stat().st_mtime_ns))
    return tuple(places)


def names_in(folder: Path) -> list[str]:
    """Return the sorted names in a folder that Python imports from; none if it cannot be read."""
    try:
        return sorted(os.listdir(folder))  # noqa: PTH208 (time)
    except PermissionError:
        return []  # Python passes over it as well


@lru_cache(maxsize=2)
def _sections(search_path: tuple[tuple[str, int], ...]) -> frozenset[bytes] | None:
    """Return the groups of all entry points on the search path; None if they are not all known.

    Only searches for the heads of sections, which takes a tenth of the time that
    importlib.metadata takes to read all entry points.
    """
    sections: set[bytes] = set()
    for place, _ in search_path:
        folder = Path(place)
        if not folder.is_dir():  # an archive
            return None
        look(NAMES, folder)
        for name in names_in(folder):
            if name == "EGG-INFO" or name.endswith(".egg"):
                return None
            if name.endswith(_METADATA_SUFFIXES):
                with suppress(OSError):
                    text = read_start(folder / name / "entry_points.txt", MAX_BYTES)
                    sections.update(_SECTION.findall(text))
    return frozenset(sections)
