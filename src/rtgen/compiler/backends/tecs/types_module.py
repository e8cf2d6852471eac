"""The module `_types.py`: the structs and constants of a CDL file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rtgen.compiler.backends.kit.python_text import fit_text
from rtgen.compiler.backends.kit.quoting.python import (
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.tdr import Node, Record, SignatureLayout
from rtgen.compiler.model.c_types import CStructType, resolve
from rtgen.compiler.model.tecs import TecsConst, TecsTypedef, TecsUnit
from rtgen.compiler.typemap.tecs.python import (
    annotation,
    is_mutable,
    member_name,
    module_level_name,
    struct_class,
    zero,
)


@dataclass(frozen=True, slots=True)
class _Class:
    """The class of a struct, its members as statements."""

    name: str
    docstring: str
    members: list[str]


def types_text(unit: TecsUnit, layouts: Iterable[SignatureLayout], header: str) -> str:
    """Return the module: structs of the signatures, their typedefs, all constants."""
    records: dict[str, Record] = {}
    for layout in layouts:
        for record in layout.records:
            records.setdefault(struct_class(record.struct.name), record)
    aliases = list(_aliases(unit, records))
    taken = {*records, *(name for name, _ in aliases)}
    classes = [_class(name, record) for name, record in records.items()]
    text = render(
        "tecs/types.py.j2",
        key=unit.key,
        classes=classes,
        has_fields=any("field(" in line for each in classes for line in each.members),
        aliases=aliases,
        constants=list(_constants(unit, taken)),
    )
    return fit_text(f"{header}{text.rstrip()}\n")


def _class(name: str, record: Record) -> _Class:
    struct = record.struct
    members = [
        f"{member_name(item.name)}: {annotation(item.node)} = {_default(item.node)}"
        for item in record.items
    ]
    text = docstring(struct.doc, 4, f"`struct {struct.scoped}`.")
    return _Class(name, text, members)


def _default(node: Node) -> str:
    value = zero(node)
    if not is_mutable(node):
        return value
    if isinstance(node, Record):
        # A lambda defers the lookup: an earlier member may have the name of the class.
        return f"field(default_factory=lambda: {value})"
    if value == "[]":
        return "field(default_factory=list)"
    return f"field(default_factory=lambda: {value})"


def _aliases(unit: TecsUnit, classes: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield the typedefs of structs."""
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
