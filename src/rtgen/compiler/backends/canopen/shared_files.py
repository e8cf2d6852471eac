"""Files generated once for a project with CANopen devices: shared IDL, and the manager."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends import Artifact, Options
from rtgen.compiler.backends.canopen.manager_module import manager_module
from rtgen.compiler.backends.kit.python_module import python_module
from rtgen.compiler.backends.kit.python_text import header
from rtgen.compiler.kit.resources import idl_file
from rtgen.compiler.model import Model
from rtgen.compiler.typemap.python.idl_names import PythonNames

_SHARED = ("BasicDataType.idl", "Canopen.idl")
"""The IDL files of rtgen that those of devices include."""


def shared_files(
    model: Model, names: PythonNames, options: Options, networks: str
) -> Iterator[Artifact]:
    """The files. `networks` is the package of the networks, empty if there is none."""
    folder = f"{options.folder}/canopen"
    if options.target == "openrtm":
        yield from _shared_idl(model, options, folder)
    if networks:
        origin = [bus.key for bus in model.buses]
        yield python_module(
            f"{folder}/__init__.py",
            options,
            origin,
            "The CANopen networks and their manager.",
            plain=True,
        )
        yield manager_module(model, names, options, origin, networks)


def _shared_idl(model: Model, options: Options, folder: str) -> Iterator[Artifact]:
    """Copies for omniidl, which reads the IDL of devices without rtgen."""
    files = {file.name: file for file in model.files}
    for name in _SHARED:
        file = files.get(name)
        if file is None:
            continue  # the project replaces it
        lines = header(options.version, [file.key])
        head = "".join(f"// {line}\n" for line in lines)
        text = idl_file(name).read_text(encoding="utf-8")
        yield Artifact(f"{folder}/{name}", f"{head}\n{text}", (file.key,))
