"""Definitions that have changed since files were generated from them, by the manifest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends import key_of
from rtgen.compiler.kit.project_file import FILE_NAME
from rtgen.compiler.kit.resources import ros_interfaces
from rtgen.compiler.project.loading import Project
from rtgen.compiler.project.output import MANIFEST
from rtgen.compiler.project_rules import CHANGED_INPUTS
from rtgen.facts.encodings import digest
from rtgen.facts.files import MAX_BYTES, read_file, read_start
from rtgen.facts.messages import from_json
from rtgen.facts.ros import interface_beside

LIBRARY = "rtgen/"
"""How the keys of files that come with rtgen begin."""
_MAX_NAMES = 3


class _Manifest(msgspec.Struct):
    inputs: Mapping[str, str] = {}


def findings(project: Project) -> Iterator[Diagnostic]:
    """Yield a warning if definitions differ from those that the output folder was made from.

    Nothing is said without a manifest. Settings of rtgen.toml are not compared.
    """
    try:
        octets = read_start(project.output / MANIFEST, MAX_BYTES)
        before = from_json(octets, _Manifest).inputs
    except (OSError, ValueError):
        return
    changed = sorted(_changed(project, before))
    if changed:
        names = ", ".join(changed[:_MAX_NAMES])
        more = len(changed) - _MAX_NAMES
        names += f" and {more} more" if more > 0 else ""
        message = f"definitions have changed since the last rtgen generate: {names}"
        yield CHANGED_INPUTS.at(None, message)


def _lies_elsewhere(project: Project, key: str) -> bool:
    """Return whether a file that is not in the project may never have been there."""
    folder = (project.root / key).parent
    interface = interface_beside(Path(key))
    ships = interface is not None and interface.as_posix() in ros_interfaces()
    return ships or folder == project.root or not folder.is_dir()


def _changed(project: Project, before: Mapping[str, str]) -> Iterator[str]:
    """Yield the keys of definitions that are changed, new or missing."""
    for key, sha256 in before.items():
        if key.startswith(LIBRARY) or key == FILE_NAME:
            continue
        try:
            if digest(read_file(project.root / key)) != sha256:
                yield key
        except OSError:
            if not _lies_elsewhere(project, key):
                yield key
    for path in project.sources if before else ():
        shown = path.as_posix().removeprefix(f"{project.root.as_posix()}/")
        if shown not in before and (key := key_of(path, project.root)) not in before:
            yield key
