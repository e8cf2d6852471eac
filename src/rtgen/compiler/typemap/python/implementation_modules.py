"""Assigns the declarations of definition files to implementation modules.

There is one module for each file, with two exceptions: a file included inside a scope, and files
that depend on each other (an include in mid-file, or interfaces that refer to each other). Such
files share a module, since modules that import each other cannot be imported in any order.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import PurePosixPath

from rtgen.compiler.model import (
    ArrayType,
    Attribute,
    Bitset,
    Const,
    Declaration,
    ExceptionDecl,
    Interface,
    MapType,
    Model,
    NamedType,
    Operation,
    PrimitiveType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.graphs import groups
from rtgen.compiler.typemap.python.names import module_name

_SERIES = (SequenceType, ArrayType)


def implementation_modules(model: Model) -> dict[str, str]:
    """Return the module name of each file, by displayed path."""
    owners = _owners(model)
    modules: dict[str, str] = {}
    for file in model.files:
        if owners[file.name] != file.name:
            continue
        stem = name = module_name(PurePosixPath(file.name).stem)
        number = 1
        while name in modules.values():
            number += 1
            name = f"{stem}_{number}"
        modules[file.name] = name
    return {file.name: modules[owners[file.name]] for file in model.files}


def _owners(model: Model) -> dict[str, str]:
    """Map each file to the file whose module it belongs to."""
    includers = {file.name: file.belongs_to for file in model.files}
    owners = {}
    for file in model.files:
        owner = file.name
        while (above := includers.get(owner)) is not None:
            owner = above
        owners[file.name] = owner
    if len({owners[declaration.file] for declaration in model.declarations}) < 2:
        return owners
    needs = _needs(model, owners)
    places = {name: place for place, name in enumerate(owners)}
    first = {
        name: min(group, key=places.__getitem__)
        for group in groups(needs)
        for name in group
    }
    return {name: first.get(owner, owner) for name, owner in owners.items()}


def _needs(model: Model, owners: dict[str, str]) -> dict[str, set[str]]:
    """Return the other files that each file's declarations refer to."""
    files = {d.name: owners[d.file] for d in model.declarations}
    needs: dict[str, set[str]] = {}
    for declaration in model.declarations:
        own = files[declaration.name]
        others = {files[name] for name in referred(declaration) if name in files}
        needs.setdefault(own, set()).update(others - {own})
    return needs


def referred(declaration: Declaration) -> Iterator[ScopedName]:
    """Yield the names used in a declaration: types, bases, exceptions."""
    match declaration:
        case Struct(members=members, base=base):
            yield from (base,) if base else ()
            yield from _in_types(m.type for m in members)
        case Bitset(base=base):
            yield from (base,) if base else ()
        case ExceptionDecl(members=members):
            yield from _in_types(m.type for m in members)
        case Union(switch=switch, cases=cases):
            yield from _in_types((switch, *(c.type for c in cases)))
        case Const(type=type_) | Typedef(type=type_) | ValueBox(type=type_):
            yield from _in_types((type_,))
        case Interface(bases=bases, attributes=attributes, operations=operations):
            yield from bases
            yield from _in_calls(attributes, operations)
        case Valuetype():
            yield from (*declaration.bases, *declaration.supports)
            yield from _in_types(m.type for m in declaration.state)
            calls = (*declaration.operations, *declaration.factories)
            yield from _in_calls(declaration.attributes, calls)


def _in_calls(
    attributes: Iterable[Attribute], operations: Iterable[Operation]
) -> Iterator[ScopedName]:
    for attribute in attributes:
        yield from (*attribute.get_raises, *attribute.set_raises)
        yield from _in_types((attribute.type,))
    for operation in operations:
        yield from operation.raises
        yield from _in_types(
            (operation.returns, *(p.type for p in operation.parameters))
        )


def _in_types(types: Iterable[Type]) -> Iterator[ScopedName]:
    for type_ in types:
        if type_.__class__ is PrimitiveType:
            continue
        while isinstance(type_, _SERIES):
            type_ = type_.element
        if isinstance(type_, NamedType):
            yield type_.name
        elif isinstance(type_, MapType):
            yield from _in_types((type_.key, type_.value))
