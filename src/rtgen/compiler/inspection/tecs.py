"""JSON and text of a TECS unit, for `rtgen.compiler.inspection.models`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

from rtgen.compiler.model.c_types import Expression
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
    TecsPort,
    TecsStruct,
    TecsTypedef,
    TecsUnit,
    TecsVariable,
)
from rtgen.compiler.model.types import ScopedName

Json: TypeAlias = dict[str, Any]

_KINDS: dict[type[TecsDeclaration], str] = {
    TecsStruct: "struct",
    TecsTypedef: "typedef",
    TecsEnum: "enum",
    TecsConst: "const",
    Signature: "signature",
    Celltype: "celltype",
    Composite: "composite",
    Cell: "cell",
    Region: "region",
}


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
        "kind": _KINDS[type(d)],
        "name": d.scoped,
        "file": d.file,
        "line": d.span.line,
    }
    return head | _body(d) | {"doc": d.doc, "annotations": []}


def _body(d: TecsDeclaration) -> Json:
    match d:
        case TecsStruct():
            members = [*map(_member, d.members)]
            return {"repository_id": None, "base": None, "members": members}
        case TecsEnum():
            names = [name for name, _ in d.members]
            values = [value for _, value in d.members]
            return {"repository_id": None, "members": names, "values": values}
        case TecsTypedef():
            return {"repository_id": None, "type": str(d.type)}
        case TecsConst():
            return {"type": str(d.type), "value": _value(d.value)}
        case Signature():
            return {
                "deviate": d.deviate,
                "callback": d.callback,
                "context": d.context,
                "functions": [*map(_function, d.functions)],
            }
        case Celltype():
            return {
                "singleton": d.singleton,
                "active": d.active,
                "idx_is_id": d.idx_is_id,
                "ports": [*map(_port, d.ports)],
                "attributes": [*map(_variable, d.attributes)],
                "variables": [*map(_variable, d.variables)],
            }
        case Composite():
            return {
                "singleton": d.singleton,
                "active": d.active,
                "ports": [*map(_port, d.ports)],
                "attributes": [*map(_variable, d.attributes)],
                "variables": [],
                "cells": [{"name": c.name[-1]} | _cell(c) for c in d.cells],
                "exports": [
                    {"name": name, "cell": cell, "port": port}
                    for name, cell, port in d.exports
                ],
            }
        case Cell():
            return _cell(d)
        case Region():
            return {"linkunit": d.linkunit, "node": d.node}
    raise AssertionError(f"no JSON for {type(d).__name__}")


def _member(m: TecsMember) -> Json:
    head: Json = {"name": m.name, "type": str(m.type)} | _sizes(m.sizes)
    return head | {
        "optional": False,
        "key": False,
        "id": None,
        "doc": m.doc,
        "annotations": [],
    }


def _sizes(sizes: Sizes) -> Json:
    """Return size specifiers; `string` is true without a length, else the length as text."""
    return {
        "size_is": _text(sizes.size_is),
        "max_size": sizes.max_size,
        "count_is": _text(sizes.count_is),
        "string": True if sizes.unsized_string else _text(sizes.string),
        "nullable": sizes.nullable,
    }


def _function(f: TecsFunction) -> Json:
    return {
        "id": f.id,
        "name": f.name,
        "returns": str(f.returns),
        "oneway": f.oneway,
        "parameters": [
            {"name": p.name, "type": str(p.type), "direction": p.direction.value}
            | _sizes(p.sizes)
            | {"allocator": None if p.allocator is None else "::".join(p.allocator)}
            for p in f.parameters
        ],
        "doc": f.doc,
    }


def _port(p: TecsPort) -> Json:
    return {
        "kind": p.kind,
        "name": p.name,
        "signature": "::".join(p.signature),
        "array": p.array,
        "size": p.size,
        "optional": p.optional,
        "omit": p.omit,
        "dynamic": p.dynamic,
        "ref_desc": p.ref_desc,
        "inline": p.inline,
        "required": p.required,
        "hidden": p.hidden,
    }


def _variable(v: TecsVariable) -> Json:
    return {
        "name": v.name,
        "type": str(v.type),
        "initial": _text(v.initial),
        "size_is": _text(v.size_is),
        "omit": v.omit,
        "choice": list(v.choice),
    }


def _cell(c: Cell) -> Json:
    return {
        "celltype": "::".join(c.celltype),
        "region": "::".join(c.region) or None,
        "joins": [*map(_join, c.joins)],
        "attributes": {name: str(value) for name, value in c.attributes},
    }


def _join(j: Join) -> Json:
    return {
        "port": j.port,
        "index": j.index,
        "target": "::".join(j.target),
        "target_port": j.target_port,
        "target_index": j.target_index,
        "signature": "::".join(j.signature) or None,
        "through": [
            {
                "plugin": t.plugin,
                "argument": t.argument.text,
                "origin": t.origin,
                "region": "::".join(t.region) or None,
            }
            for t in j.through
        ],
    }


def _text(expression: Expression | None) -> str | None:
    return None if expression is None else str(expression)


def _value(value: object) -> object:
    return (
        str(value) if isinstance(value, float) and not math.isfinite(value) else value
    )


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


def lines(d: TecsDeclaration) -> Iterator[str]:
    """Yield a declaration as text: a line for it, and one for each of its parts."""
    head = f"{_KINDS[type(d)]} {d.scoped}"
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
