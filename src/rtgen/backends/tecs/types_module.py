"""The module `_types.py`: the structs and constants of a CDL file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.backends.python_text import (
    comment_text,
    docstring,
    fit_text,
    number_literal,
    string_literal,
)
from rtgen.backends.rendering import render
from rtgen.layouts.tdr import Node, Record
from rtgen.layouts.tdr_messages import layout_of
from rtgen.model.tecs import (
    CStructType,
    Signature,
    TecsConst,
    TecsTypedef,
    TecsUnit,
    resolve,
)
from rtgen.typemap.tecs_python import (
    annotation,
    is_mutable,
    member_name,
    module_level_name,
    struct_class,
    zero,
)


def types_text(unit: TecsUnit, signatures: Iterable[Signature], header: str) -> str:
    """The module: the structs that the signatures need, their typedefs, all constants.

    Raises TransferError.
    """
    records: dict[str, Record] = {}
    for signature in signatures:
        for record in layout_of(unit, signature).records:
            records.setdefault(struct_class(record.struct.name), record)
    aliases = list(_aliases(unit, records))
    taken = {*records, *(name for name, _ in aliases)}
    text = render(
        "tecs/types.py.j2",
        key=comment_text(unit.key),
        classes=[_class(name, record) for name, record in records.items()],
        aliases=aliases,
        constants=list(_constants(unit, taken)),
    )
    return fit_text(f"{header}{text.rstrip()}\n")


def _class(name: str, record: Record) -> dict[str, object]:
    struct = record.struct
    members = [
        f"{member_name(item.name)}: {annotation(item.node)} = {_default(item.node)}"
        for item in record.items
    ]
    text = docstring(struct.doc or f"`struct {struct.scoped}`.", 4)
    return {"name": name, "docstring": text, "members": members}


def _default(node: Node) -> str:
    value = zero(node)
    if not is_mutable(node):
        return value
    if isinstance(node, Record):
        # Looked up late: an earlier member may have the name of the class.
        return f"field(default_factory=lambda: {value})"
    if value == "[]":
        return "field(default_factory=list)"
    return f"field(default_factory=lambda: {value})"


def _aliases(unit: TecsUnit, classes: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The typedefs of structs."""
    taken = set(classes)
    for declaration in unit.declarations:
        if not isinstance(declaration, TecsTypedef):
            continue
        target = resolve(declaration.type)
        name = struct_class(declaration.name)
        if isinstance(target, CStructType) and struct_class(target.tag) in classes:
            if name not in taken:
                yield name, struct_class(target.tag)
            taken.add(name)


def _constants(unit: TecsUnit, taken: set[str]) -> Iterator[str]:
    for declaration in unit.declarations:
        name = module_level_name(declaration.global_name)
        if (
            not isinstance(declaration, TecsConst)
            or declaration.value is None
            or name in taken
        ):
            continue
        taken.add(name)
        yield f"{name}: Final = {_literal(declaration.value)}"


def _literal(value: float | str) -> str:
    return string_literal(value) if isinstance(value, str) else number_literal(value)
