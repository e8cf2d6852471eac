"""Functions of CDL in Python: names, annotations, and the text of their declaration."""

from __future__ import annotations

import builtins
from collections.abc import Sequence

from rtgen.backends.tecs.views import used_structs
from rtgen.layouts.tdr import FunctionLayout, SignatureLayout
from rtgen.model.tecs import Sizes, TecsFunction
from rtgen.typemap.idl_python_names import distinct
from rtgen.typemap.tecs_python import (
    CODEC_ATTRIBUTES,
    annotation,
    argument_annotation,
    item_annotation,
    struct_class,
)

LOCALS = frozenset({"_", "self", *dir(builtins)})
"""Names that no parameter can have."""

_ANNOTATIONS = frozenset(
    {"Sequence", "bool", "bytes", "float", "int", "list", "str", "tuple"}
)
"""The names used in annotations, which a method of that name would hide in its class."""


def function_names(layout: SignatureLayout) -> dict[str, str]:
    """The Python names of the functions in codec, proxy and target."""
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
    """The classes of structs that annotations name."""
    found = {
        struct_class(record.struct.name)
        for function in layout.functions
        for item in (*function.items, function.returned)
        for record in used_structs(item.node)
    }
    return sorted(found)


def target_types(layout: FunctionLayout) -> list[str]:
    """The annotations of a function's arguments."""
    return [
        (
            "bool"
            if i.asked
            else item_annotation(i) if i.outward else argument_annotation(i)
        )
        for i in layout.arguments
    ]


def parameters_text(layout: FunctionLayout, names: dict[str, str]) -> str:
    """The parameters of a method, with `self`."""
    pairs = zip(layout.arguments, target_types(layout), strict=True)
    return ", ".join(["self", *(f"{names[i.name]}: {t}" for i, t in pairs)])


def result_text(layout: FunctionLayout) -> str:
    """The annotation of a function's return value."""
    results = [] if layout.is_void else [annotation(layout.returned.node)]
    results += [item_annotation(item) for item in layout.outs]
    return tuple_type(results)


def tuple_type(types: Sequence[str]) -> str:
    """The annotation of several results, of one, or of none."""
    if len(types) > 1:
        return f"tuple[{', '.join(types)}]"
    return types[0] if types else "None"


def shown(function: TecsFunction, name: str | None = None) -> str:
    """The function as CDL declares it; `name` in place of its own."""
    shown = ", ".join(
        f"[{', '.join([str(p.direction), *sizes_text(p.sizes)])}] {_declared(p.type, p.name)}"
        for p in function.parameters
    )
    oneway = "[oneway] " if function.oneway else ""
    named = function.name if name is None else name
    return f"{oneway}{function.returns} {named}({shown or 'void'})"


def sizes_text(sizes: Sizes) -> list[str]:
    """The specifiers of a parameter other than its direction."""
    found = []
    if sizes.size_is is not None:
        most = "" if sizes.max_size is None else f", {sizes.max_size}"
        found.append(f"size_is({sizes.size_is}{most})")
    if sizes.count_is is not None:
        found.append(f"count_is({sizes.count_is})")
    if sizes.string is not None:
        found.append(f"string({sizes.string})")
    elif sizes.is_string:
        found.append("string")
    if sizes.nullable:
        found.append("nullable")
    return found


def _declared(type_: object, name: str) -> str:
    text = str(type_)
    if text.endswith("]") and "[" in text:
        head, bracket, tail = text.partition("[")
        return f"{head} {name}{bracket}{tail}"
    return f"{text[:-1]} *{name}" if text.endswith("*") else f"{text} {name}"
