"""Uses the runtime's classes for the types of rtgen's own IDL files, in all projects.

The runtime's classes are used for a file whose declarations are those they were generated from,
with the same settings. So a project gets its own classes if its numbers have another
representation, or if it replaces a file that the file includes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from hashlib import sha256
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from rtgen.compiler.kit.resources import IDL_FILES, idl_key, implemented_idl
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import (
    Component,
    Declaration,
    Home,
    Model,
    NamedType,
    Native,
)
from rtgen.compiler.model.graphs import reached

PACKAGE: Final = "rtgen.runtime.library"
"""The package of the runtime with the types."""

_NO_CLASS = (Component, Home, Native)
_PLACES = ("span", "file")


def lower(model: Model, settings: Settings) -> Lowered:
    """Return the model in which files name the runtime's package with their types."""
    usual = Settings()
    if (settings.representation, settings.extensibility) != (
        usual.representation,
        usual.extensibility,
    ):
        return Lowered(model)
    held = _implemented(model)
    if not held:
        return Lowered(model)
    modules = _known_to_user(model)
    declared: dict[str, set[str]] = {}
    for declaration in model.declarations:
        declared.setdefault(declaration.file, set()).add(declaration.name[0])
    files = (
        (
            replace(
                file,
                package=PACKAGE,
                exported=not modules.isdisjoint(declared.get(file.name, ())),
            )
            if file.name in held
            else file
        )
        for file in model.files
    )
    return Lowered(replace(model, files=tuple(files)))


def digest(declarations: Iterable[Declaration]) -> str:
    """Return a digest of declarations, independent of their file."""
    content = [
        [type(each).__name__, _placeless(msgspec.to_builtins(each))]
        for each in declarations
    ]
    return sha256(json.dumps(content).encode()).hexdigest()


def _placeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _placeless(v) for k, v in value.items() if k not in _PLACES}
    return [*map(_placeless, value)] if isinstance(value, list | tuple) else value


def classes_of(model: Model, file: str) -> list[Declaration]:
    """Return the declarations of a file that have classes or values in Python."""
    return [
        each
        for each in model.declarations
        if each.file == file and not isinstance(each, _NO_CLASS)
    ]


def _implemented(model: Model) -> set[str]:
    """Return the displayed paths of the files whose types the runtime has."""
    digests = implemented_idl()
    held: set[str] = set()
    for file in model.files:  # included before includer
        expected = digests.get(file.key)
        if (
            expected is None
            or file.belongs_to is not None
            or not held.issuperset(file.includes)
        ):
            continue
        if digest(classes_of(model, file.name)) == expected:
            held.add(file.name)
    return held


def _known_to_user(model: Model) -> set[str]:
    """Return the outermost IDL modules that the user's files use.

    They have declarations there, include a file that has some, or a component has such a port.
    """
    shipped = set(map(idl_key, IDL_FILES))
    files = {file.name: file for file in model.files}
    own = {n for n, f in files.items() if not f.module and f.key not in shipped}
    seen = reached(own, lambda name: files[name].includes if name in files else ())
    names: set[str] = set()
    for declaration in model.declarations:
        if declaration.file in seen and len(declaration.name) > 1:
            names.add(declaration.name[0])
        if isinstance(declaration, Component) and declaration.file in own:
            types = (model.unalias(port.type) for port in declaration.ports)
            names.update(each.name[0] for each in types if isinstance(each, NamedType))
    return names
