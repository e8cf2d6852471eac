"""Compares rtgen.toml of two versions; effects on definitions are compared elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.project import FILE_NAME
from rtgen.tools.diff.changes import Change, Kind, change
from rtgen.tools.diff.kinds import systems as kinds
from rtgen.tools.diff.versions import Version

_DEFAULTS: dict[tuple[str, str], Any] = {
    ("output", "package"): "robots",
    ("output", "dir"): "generated",
    ("output", "skeletons"): "src",
    ("output", "target"): "embedded",
    ("output", "representation"): "cdr",
    ("output", "extensibility"): "final",
    ("python", "numeric"): "array",
    ("tecs", "corba"): False,
    ("small", "sequence"): 1024,
    ("small", "string"): 128,
    ("small", "buffer"): 2,
}
_KINDS: dict[tuple[str, str], Kind] = {
    ("output", "package"): kinds.PACKAGE,
    ("output", "dir"): kinds.OUTPUT,
    ("output", "skeletons"): kinds.SKELETONS,
    ("output", "target"): kinds.TARGET,
    ("output", "representation"): kinds.REPRESENTATION,
    ("output", "extensibility"): kinds.EXTENSIBILITY,
    ("python", "numeric"): kinds.NUMERIC,
    ("tecs", "corba"): kinds.TECS_CORBA,
    ("sources", "paths"): kinds.SOURCES,
}
_SECTIONS: dict[str, Kind] = {
    "sources": kinds.READING,
    "idl": kinds.READING,
    "components": kinds.FACTORY,
    "lint": kinds.TOOLS,
    "diff": kinds.TOOLS,
    "plugin": kinds.TOOLS,
}


def compare_settings(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of settings; adapters are compared as part of the model."""
    if not (old.settings and new.settings):
        return
    before, after = _flat(old), _flat(new)
    for key in sorted({*before, *after, *_DEFAULTS}):
        was, now = (side.get(key, _DEFAULTS.get(key)) for side in (before, after))
        if was == now:
            continue
        kind = _KINDS.get(key) or _SECTIONS.get(key[0]) or kinds.TOOLS
        if key[0] == "small":
            less = isinstance(now, int) and isinstance(was, int) and now < was
            kind = kinds.SMALL_ROOM if less else kinds.SMALL_ROOM_MORE
        name = ".".join(key)
        text = f"{name} is {now}, was {was}"
        yield change(kind, name, text, _place(old, key), _place(new, key))


def _flat(version: Version) -> dict[tuple[str, str], Any]:
    return {
        (section, key): value
        for section, table in version.settings.items()
        if isinstance(table, dict) and section != "adapter"
        for key, value in table.items()
    }


def _place(version: Version, key: tuple[str, str]) -> Span:
    """Return the place of a key, or the start of the file."""
    found = version.places.get(key)
    if found is not None:
        return found
    file = next((span.file for span in version.places.values()), FILE_NAME)
    return Span(file, 1, 1, 1, 2)
