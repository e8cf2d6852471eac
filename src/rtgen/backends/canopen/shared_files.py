"""Files generated once for a project with CANopen devices: shared IDL, and the manager."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.backends import Artifact, Options
from rtgen.backends.canopen.manager_module import manager_text
from rtgen.backends.canopen.service_module import service_text
from rtgen.backends.python_text import header, header_comment
from rtgen.model import Model
from rtgen.resources import idl_file
from rtgen.typemap.idl_python_names import PythonNames

_SHARED = ("BasicDataType.idl", "Canopen.idl")


def shared_files(
    model: Model, names: PythonNames, options: Options, networks: str
) -> Iterator[Artifact]:
    """The files. `networks` is the package of the networks, empty if there is none."""
    folder = f"{options.folder}/canopen"
    files = {file.name: file for file in model.files}
    for name in _SHARED:
        file = files.get(name)
        if file is None:
            continue  # the project replaces it
        lines = header(options.version, [file.key])
        head = "".join(f"// {line}\n" for line in lines)
        text = idl_file(name).read_text(encoding="utf-8")
        yield Artifact(f"{folder}/{name}", f"{head}\n{text}", (file.key,))
    key = files[_SHARED[1]].key
    comment = header_comment(options.version, [key])
    text = service_text(model, names, options, comment)
    yield Artifact(f"{folder}/service.py", text, (key,))
    if networks:
        origin = tuple(bus.key for bus in model.buses)
        comment = header_comment(options.version, origin)
        text = manager_text(model, names, options, comment, networks)
        yield Artifact(f"{folder}/manager.py", text, origin)
