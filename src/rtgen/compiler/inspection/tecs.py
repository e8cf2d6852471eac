"""JSON and text of a TECS unit, for `rtgen.compiler.inspection.models`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.compiler.inspection.facts import FIELDS, Json, facts, kind_of
from rtgen.compiler.model.tecs import (
    Cell,
    Celltype,
    Composite,
    Join,
    Region,
    Signature,
    Sizes,
    TecsConst,
    TecsDeclaration,
    TecsEnum,
    TecsFunction,
    TecsMember,
    TecsParameter,
    TecsPort,
    TecsStruct,
    TecsTypedef,
    TecsUnit,
    TecsVariable,
    Through,
)
from rtgen.compiler.model.types import ScopedName

_SIZES = "size_is max_size count_is string nullable"

FIELDS.update(
    {
        TecsStruct: "repository_id base members",
        TecsEnum: "repository_id members values",
        TecsTypedef: "repository_id type",
        TecsConst: "type value",
        Signature: "deviate callback context functions",
        Celltype: "singleton active idx_is_id ports attributes variables",
        Composite: "singleton active ports attributes variables cells exports",
        Cell: "celltype:: region:: joins attributes",
        Region: "linkunit node",
        Sizes: _SIZES,
        TecsMember: f"name type {_SIZES} optional key id doc annotations",
        TecsFunction: "id name returns oneway parameters doc",
        TecsParameter: f"name type direction {_SIZES} allocator::",
        TecsPort: "kind name signature:: array size optional omit dynamic ref_desc inline"
        " required hidden",
        TecsVariable: "name type initial size_is omit choice",
        Join: "port index target:: target_port target_index signature:: through",
        Through: "plugin argument=argument.text origin region::",
    }
)


def shown(units: Iterable[TecsUnit]) -> list[TecsDeclaration]:
    """Return the declarations of CDL files, each once, without those of C headers."""
    found: dict[tuple[type, ScopedName, object], TecsDeclaration] = {}
    for unit in units:
        for d in unit.declarations:
            if not getattr(d, "from_c", False):
                found.setdefault((type(d), d.name, d.span), d)
    return list(found.values())


def declaration(d: TecsDeclaration) -> Json:
    """Return a declaration as the JSON of `rtgen-inspect/1`."""
    head = {
        "kind": kind_of(d),
        "name": d.scoped,
        "file": d.file,
        "line": d.span.line,
    }
    return head | facts(d, **_others(d)) | {"doc": d.doc, "annotations": []}


def _others(d: TecsDeclaration) -> Json:
    """Return the facts that are not fields of the declaration."""
    match d:
        case TecsStruct():
            none: Json = {
                "optional": False,
                "key": False,
                "id": None,
                "annotations": [],
            }
            members = [facts(m, **_sizes(m.sizes), **none) for m in d.members]
            return {"repository_id": None, "base": None, "members": members}
        case TecsEnum():
            names, values = ([m[at] for m in d.members] for at in (0, 1))
            return {"repository_id": None, "members": names, "values": values}
        case TecsTypedef():
            return {"repository_id": None}
        case Signature():
            return {"functions": [*map(_function, d.functions)]}
        case Composite():
            cells = [{"name": c.name[-1]} | facts(c, **_others(c)) for c in d.cells]
            keys = ("name", "cell", "port")
            exports = [dict(zip(keys, export, strict=True)) for export in d.exports]
            return {"variables": [], "cells": cells, "exports": exports}
        case Cell():
            return {"attributes": {name: str(value) for name, value in d.attributes}}
    return {}


def _sizes(sizes: Sizes) -> Json:
    """Return size specifiers; `string` is true without a length, else the length as text."""
    return facts(sizes, **({"string": True} if sizes.unsized_string else {}))


def _function(f: TecsFunction) -> Json:
    parameters = [facts(p, **_sizes(p.sizes)) for p in f.parameters]
    return facts(f, parameters=parameters)


def _shown(value: bool | float | str | None) -> str:
    """Return ` = value` with a literal of CDL; nothing for one that only C can evaluate."""
    match value:
        case None:
            return ""
        case bool():
            return f" = {str(value).lower()}"
        case str():
            return f' = "{value}"'  # with its escapes
    return f" = {value}"


def prototype(f: TecsFunction) -> str:
    """Return a function as in CDL."""
    parameters = ", ".join(f"[{p.direction}] {p.type} {p.name}" for p in f.parameters)
    return f"{f.returns} {f.name}({parameters or 'void'})"


def lines(d: TecsDeclaration) -> Iterator[str]:
    """Yield a declaration as text: a line for it, and one for each of its parts."""
    head = f"{kind_of(d)} {d.scoped}"
    match d:
        case TecsConst():
            yield f"{head}: {d.type}{_shown(d.value)}"
        case TecsTypedef():
            yield f"{head} = {d.type}"
        case Cell():
            yield f"{head}: {'::'.join(d.celltype)}"
        case _:
            yield head
    yield from (f"  {line}" for line in _parts(d))


def _parts(d: TecsDeclaration) -> Iterator[str]:
    match d:
        case TecsStruct():
            yield from (f"{m.name}: {m.type}" for m in d.members)
        case TecsEnum():
            yield from (f"{name} = {value}" for name, value in d.members)
        case Signature():
            for f in d.functions:
                parameters = (
                    f"{p.direction.value} {p.name}: {p.type}" for p in f.parameters
                )
                oneway = "oneway " * f.oneway
                yield f"{f.id} {oneway}{f.name}({', '.join(parameters)}): {f.returns}"
        case Celltype():
            yield from map(_port_line, d.ports)
            yield from (_variable_line("attribute", v) for v in d.attributes)
            yield from (_variable_line("variable", v) for v in d.variables)
        case Composite():
            yield from map(_port_line, d.ports)
            yield from (_variable_line("attribute", v) for v in d.attributes)
            for cell in d.cells:
                yield f"cell {cell.name[-1]}: {'::'.join(cell.celltype)}"
                yield from (f"  {line}" for line in _cell_lines(cell))
            yield from (f"{name} => {cell}.{port}" for name, cell, port in d.exports)
        case Cell():
            yield from _cell_lines(d)
        case Region():
            yield from (word for word in ("linkunit", "node") if getattr(d, word))


def _port_line(p: TecsPort) -> str:
    size = "" if not p.array else "[]" if p.size is None else f"[{p.size}]"
    words = ("optional", "omit", "dynamic", "ref_desc", "inline", "required", "hidden")
    notes = [word for word in words if getattr(p, word)]
    note = f" ({', '.join(notes)})" if notes else ""
    return f"{p.kind} {p.name}{size}: {'::'.join(p.signature)}{note}"


def _variable_line(kind: str, v: TecsVariable) -> str:
    return f"{kind} {v.name}: {v.type}" + (
        "" if v.initial is None else f" = {v.initial}"
    )


def _cell_lines(cell: Cell) -> Iterator[str]:
    for j in cell.joins:
        index = "" if j.index is None else f"[{j.index}]"
        place = "" if j.target_index is None else f"[{j.target_index}]"
        through = "".join(f" through {t.plugin}" for t in j.through)
        yield f"{j.port}{index} -> {'::'.join(j.target)}.{j.target_port}{place}{through}"
    yield from (f"{name} = {value}" for name, value in cell.attributes)
