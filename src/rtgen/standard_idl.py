"""The IDL files of OpenRTM's data types, which definitions may include without having them."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

from rtgen.frontends import Dependency
from rtgen.frontends.kit.library import VirtualFile
from rtgen.model import Model
from rtgen.resources import idl_file

STANDARD = ("BasicDataType.idl", "ExtendedDataTypes.idl", "InterfaceDataTypes.idl")
"""The data types of OpenRTM, each file including those before it."""


def standard_idl(definitions: Sequence[Path]) -> dict[str, VirtualFile | Path]:
    """What these names include where no such file is found.

    It is the file of that name among `definitions`, else the one that ships with rtgen.
    """
    own = {path.name: path for path in definitions}
    return {
        name: own.get(name)
        or VirtualFile(f"rtgen/idl/{name}", idl_file(name).read_text("utf-8"))
        for name in STANDARD
    }


def dependencies(model: Model) -> tuple[Dependency, ...]:
    """Those of the files that a model was read from which ship with rtgen."""
    keys = {file.key for file in model.files}
    used = [idl_file(name) for name in STANDARD if f"rtgen/idl/{name}" in keys]
    return tuple(Dependency(p, sha256(p.read_bytes()).hexdigest()) for p in used)
