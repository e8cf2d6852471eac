"""Kinds of files in a project, by suffix and by their first octets."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from rtgen.compiler.kit import plugins
from rtgen.compiler.kit.project_file import FILE_NAME
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import DEVICE_SUFFIXES
from rtgen.facts.encodings import MARKS
from rtgen.facts.files import is_file, read_start
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.facts.ros import INTERFACE_SUFFIXES, interface_beside

SUFFIXES = (*IDL_SUFFIXES, ".cdl", *DEVICE_SUFFIXES, *INTERFACE_SUFFIXES)
"""Suffixes of definitions, in lower case."""

_BUSES = {
    ".toml": re.compile(rb"^[ \t]*(\[[ \t]*bus[ \t]*\]|bus[ \t]*[.=])", re.MULTILINE)
}
_MAX_BUS_BYTES = 1024 * 1024
_PROFILES = {
    ".xml": re.compile(rb"<(\w+:)?RtcProfile[\s>]"),
    **dict.fromkeys((".yaml", ".yml"), re.compile(rb"^rtcProfile\s*:", re.MULTILINE)),
}
_MAX_PROLOG_BYTES = 64 * 1024
_SYSTEMS = {
    ".xml": re.compile(rb"<(\w+:)?RtsProfile[\s>]"),
    **dict.fromkeys((".yaml", ".yml"), re.compile(rb"^rtsProfile\s*:", re.MULTILINE)),
}


def is_definition(path: Path) -> bool:
    """Return whether the file is read by a front end, or is a system."""
    return (
        path.name.lower().endswith((*SUFFIXES, *plugin_suffixes()))
        or is_bus_file(path)
        or is_component_profile(path)
        or is_system(path)
    )


@cache
def plugin_suffixes() -> tuple[str, ...]:
    """Return the suffixes of plug-ins' front ends. Raises ToolError for an invalid plug-in."""
    return tuple(
        suffix
        for name, frontend in plugins.loaded(plugins.Group.FRONTENDS)
        for suffix in plugins.suffixes(name, frontend)
    )


def is_other_kind(path: Path, own: Sequence[str]) -> bool:
    """Return whether the suffix of a file is of another kind of definition than `own` suffixes.

    A suffix that no front end has, such as `.txt`, is of no other kind.
    """
    suffix = path.suffix.lower()
    known = (*SUFFIXES, *CDL_SUFFIXES, *_BUSES, *_PROFILES, *plugin_suffixes())
    return suffix not in own and suffix in known


def searched() -> str:
    """Return a hint: the files that a folder is searched for."""
    suffixes = ", ".join(f"*{s}" for s in (*SUFFIXES, *plugin_suffixes()))
    return (
        f"searched for {suffixes}, bus files (*.toml with [bus]), and profiles of "
        "components and systems (*.xml, *.yaml)"
    )


def is_generated(path: Path) -> bool:
    """Return whether it is IDL beside the interface file that ROS 2 has generated it from."""
    source = interface_beside(path)
    return source is not None and is_file(source)


def is_component_profile(path: Path) -> bool:
    """Return whether the file describes a component only (RtcProfile, in XML or YAML)."""
    return _begins_as(path, _PROFILES)


def is_system(path: Path) -> bool:
    """Return whether the file describes a system only (RtsProfile, in XML or YAML)."""
    return _begins_as(path, _SYSTEMS)


def _begins_as(
    path: Path, forms: Mapping[str, re.Pattern[bytes]], limit: int = _MAX_PROLOG_BYTES
) -> bool:
    form = forms.get(path.suffix.lower())
    if form is None:
        return False
    try:
        return form.search(_head(path, limit)) is not None
    except OSError:
        return False


def _head(path: Path, limit: int) -> bytes:
    """Return the start of a file as lines of ASCII, whatever its encoding. Raises OSError."""
    head = read_start(path, limit)
    for mark in MARKS:
        head = head.removeprefix(mark)
    return head.replace(b"\0", b"").replace(b"\r", b"\n")


def is_bus_file(path: Path) -> bool:
    """Return whether the file is TOML with a table `[bus]`."""
    return path.name != FILE_NAME and _begins_as(path, _BUSES, _MAX_BUS_BYTES)
