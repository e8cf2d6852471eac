"""The module `_views.py`: the structs of a package in CDL's types and in IDL's."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.backends import Options
from rtgen.backends.components.imports import Imports
from rtgen.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.backends.kit.rendering import render
from rtgen.backends.tecs.views import struct_views
from rtgen.layouts.tdr import Record
from rtgen.lowering.tecs.idl_model import IdlSide
from rtgen.model import Struct
from rtgen.typemap.idl_python_names import PythonNames


def views_module(
    side: IdlSide,
    names: PythonNames,
    records: Sequence[Record],
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    """The module `_views.py`, for all structs of a package."""
    imports = Imports(side.model, names, {"_types", "value"})
    structs = []
    for record in records:
        scoped = side.structs[record.struct.name]
        declaration = side.model.find(scoped)
        assert isinstance(declaration, Struct)
        members = names.members(declaration)
        structs.append(
            struct_views(
                record,
                imports.type_name(scoped),
                tuple(members[member.name] for member in declaration.members),
            )
        )
    return python_module(
        f"{options.folder}/_views.py",
        options.package,
        options.version,
        origin,
        "Structs in the two views: CDL's types, which codecs have, and IDL's.",
        imports=[*imports_from(options.package, ["_types"]), *imports.imports()],
        body=render("tecs/views.py.j2", structs=structs),
    )
