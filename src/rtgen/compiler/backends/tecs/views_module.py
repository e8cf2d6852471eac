"""The part of the module `_views.py` that converts structs, besides their classes in IDL."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.views import struct_views
from rtgen.compiler.layouts.tdr import Record
from rtgen.compiler.lowering.tecs.idl_model import VIEWS, IdlSide
from rtgen.compiler.model import Struct
from rtgen.compiler.typemap.python.idl_names import PythonNames


def views_module(
    side: IdlSide,
    names: PythonNames,
    records: Sequence[Record],
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    """Return the conversions of all structs of a package."""
    structs = []
    for record in records:
        scoped = side.structs[record.struct.name]
        declaration = side.model.find(scoped)
        assert isinstance(declaration, Struct)
        members = names.members(declaration)
        structs.append(
            struct_views(
                record,
                names.implementation(scoped)[1],
                tuple(members[member.name] for member in declaration.members),
            )
        )
    return python_module(
        f"{options.folder}/{VIEWS}.py",
        options,
        origin,
        "Structs in the two views: CDL's types, which codecs have, and IDL's.",
        imports=imports_from(options.package, ["_types"]),
        body=render("tecs/views.py.j2", structs=structs),
    )
