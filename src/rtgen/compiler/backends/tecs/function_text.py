"""Functions of CDL in Python: names and annotations."""

from __future__ import annotations

import builtins
from collections.abc import Sequence

from rtgen.compiler.backends.tecs.views import used_structs
from rtgen.compiler.layouts.tdr import FunctionLayout, SignatureLayout
from rtgen.compiler.typemap.python.idl_names import distinct
from rtgen.compiler.typemap.tecs.python import (
    CODEC_ATTRIBUTES,
    annotation,
    argument_annotation,
    item_annotation,
    struct_class,
)

LOCALS = frozenset({"_", "self", *dir(builtins)})
"""Names that a parameter cannot have."""

_ANNOTATIONS = frozenset(
    {"Sequence", "bool", "bytes", "float", "int", "list", "str", "tuple"}
)
"""The names used in annotations, which a method of the same name would hide in its class."""


def function_names(layout: SignatureLayout) -> dict[str, str]:
    """Return the Python names of the functions in codec, proxy and target."""
    return distinct(
        (f.function.name for f in layout.functions),
        {
            *("abstractmethod", "channel", "codec", "handlers", "target"),
            *CODEC_ATTRIBUTES,
            *dir(object),
            *_ANNOTATIONS,
            *struct_classes(layout),
        },
    )


def struct_classes(layout: SignatureLayout) -> list[str]:
    """Return the classes of structs that annotations name."""
    found = {
        struct_class(record.struct.name)
        for function in layout.functions
        for item in (*function.items, function.returned)
        for record in used_structs(item.node)
    }
    return sorted(found)


def target_types(layout: FunctionLayout) -> list[str]:
    """Return the annotations of a function's arguments."""
    return [
        (
            "bool"
            if i.asked
            else item_annotation(i) if i.outward else argument_annotation(i)
        )
        for i in layout.arguments
    ]


def parameters_text(layout: FunctionLayout, names: dict[str, str]) -> str:
    """Return the parameters of a method, with `self`."""
    pairs = zip(layout.arguments, target_types(layout), strict=True)
    return ", ".join(["self", *(f"{names[i.name]}: {t}" for i, t in pairs)])


def result_text(layout: FunctionLayout) -> str:
    """Return the annotation of a function's return value."""
    results = [] if layout.is_void else [annotation(layout.returned.node)]
    results += [item_annotation(item) for item in layout.outs]
    return tuple_type(results)


def tuple_type(types: Sequence[str]) -> str:
    """Return the annotation of several results, of one, or of none."""
    if len(types) > 1:
        return f"tuple[{', '.join(types)}]"
    return types[0] if types else "None"
