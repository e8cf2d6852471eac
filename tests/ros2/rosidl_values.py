"""What rtgen says of the messages of a model, to compare it with rosidl."""

from __future__ import annotations

from rtgen.compiler.layouts.ros_types import service_hash, type_hash
from rtgen.compiler.model import Model, Struct
from rtgen.facts.ros import is_interface


def hashes(model: Model) -> dict[str, str]:
    """Return rtgen's hashes of a model's messages and services, by name."""
    structs = {
        d.name: d
        for d in model.declarations
        if isinstance(d, Struct) and is_interface(d.name)
    }
    found = {"/".join(name): type_hash(model, each) for name, each in structs.items()}
    for name, request in structs.items():
        stem = name[-1].removesuffix("_Request")
        if stem != name[-1]:
            response = structs[(*name[:-1], f"{stem}_Response")]
            whole = "/".join((*name[:-1], stem))
            found[whole] = service_hash(model, request, response)
    return found
