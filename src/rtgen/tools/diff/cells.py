"""Compares celltypes, composites, cells with their joins, and regions of CDL files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from operator import attrgetter

from rtgen.compiler.lowering.tecs.options import TECSGEN_OPTIONS, read_options
from rtgen.compiler.lowering.tecs.plan import PLUGIN
from rtgen.compiler.matching import Matching, matching
from rtgen.compiler.model.tecs import (
    Cell,
    Celltype,
    Composite,
    Join,
    Region,
    TecsPort,
    TecsVariable,
    Through,
)
from rtgen.compiler.model.types import ScopedName
from rtgen.tools.diff.changes import Change, Wire, change
from rtgen.tools.diff.items import Fact, Group, differing, fact_changes, item_changes
from rtgen.tools.diff.kinds import signatures as kinds
from rtgen.tools.diff.signatures import TecsSides, declared
from rtgen.tools.diff.versions import Version

_CELLTYPES = Group("celltype", kinds.CELLTYPE_ADDED, kinds.CELLTYPE_REMOVED)
_CELLS = Group("cell", kinds.CELL_ADDED, kinds.CELL_REMOVED, kinds.CELL_RENAMED)
_PORTS = Group(
    lambda p: f"{p.kind} port",
    lambda p: (
        kinds.CELLTYPE_PORT_ADDED
        if p.kind == "call" and not p.optional
        else kinds.CELLTYPE_ENTRY_ADDED
    ),
    kinds.CELLTYPE_PORT_REMOVED,
)
_REGION_FACTS = (
    Fact(kinds.REGION, "{name} has other specifiers", lambda r: (r.linkunit, r.node)),
)
_JOINS = Group("join", kinds.JOIN_ADDED, kinds.JOIN_REMOVED)
_REGIONS = Group("region", kinds.REGION_ADDED, kinds.REGION)


def compare_cells(old: Version, new: Version, sides: TecsSides) -> Iterator[Change]:
    """Yield the changes of celltypes, composites, cells and regions."""
    types: Matching[ScopedName, Celltype | Composite] = matching(
        {**declared(old, Celltype), **declared(old, Composite)},
        {**declared(new, Celltype), **declared(new, Composite)},
    )
    yield from item_changes(_CELLTYPES, types, attrgetter("scoped"))
    for one, other in types.pairs:
        yield from _celltype(one, other, sides)
    cells = matching(declared(old, Cell), declared(new, Cell), _cell_shape)
    yield from item_changes(_CELLS, cells, attrgetter("scoped"))
    names = {a.name: b.name for a, b in (*cells.pairs, *cells.renamed)}
    for first, second in (*cells.pairs, *cells.renamed):
        yield from _cell(first, second, names)
    yield from _regions(old, new)


def _cell_shape(cell: Cell) -> object:
    joins = ((j.port, j.index, j.target, j.target_port) for j in cell.joins)
    return (cell.celltype, cell.region, tuple(joins)) if cell.joins else None


def _celltype(
    old: Celltype | Composite, new: Celltype | Composite, sides: TecsSides
) -> Iterator[Change]:
    name, spans = new.scoped, (old.span, new.span)
    facts = [
        (type(c), c.singleton, c.active, getattr(c, "idx_is_id", False))
        for c in (old, new)
    ]
    if facts[0] != facts[1]:
        text = f"celltype {name} has other specifiers"
        yield change(kinds.CELLTYPE_KIND, name, text, *spans)
    ports = matching(_visible(old), _visible(new))
    yield from item_changes(_PORTS, ports, lambda p: f"{name}.{p.name}", spans)
    for one, other in ports.pairs:
        yield from _port(one, other, f"{name}.{other.name}", sides)
    before = {v.name: v for v in (*old.attributes, *_variables(old))}
    after = {v.name: v for v in (*new.attributes, *_variables(new))}
    for key in dict.fromkeys((*before, *after)):
        first, second = before.get(key), after.get(key)
        if _variable(first) != _variable(second):
            text = f"{name}.{key} is {_shown(second)}, was {_shown(first)}"
            spans = (first or old).span, (second or new).span
            yield change(kinds.CELLTYPE_VARIABLE, f"{name}.{key}", text, *spans)


def _visible(celltype: Celltype | Composite) -> dict[str, TecsPort]:
    return {p.name: p for p in celltype.ports if not p.hidden}


def _variables(celltype: Celltype | Composite) -> tuple[TecsVariable, ...]:
    return celltype.variables if isinstance(celltype, Celltype) else ()


def _variable(variable: TecsVariable | None) -> object:
    if variable is None:
        return None
    texts = (str(e) for e in (variable.type, variable.initial, variable.size_is))
    return (*texts, variable.omit, variable.choice)


def _shown(variable: TecsVariable | None) -> str:
    if variable is None:
        return "not there"
    initial = "" if variable.initial is None else f" = {variable.initial}"
    return f"{variable.type}{initial}"


def _port(
    old: TecsPort, new: TecsPort, name: str, sides: TecsSides
) -> Iterator[Change]:
    spans = (old.span, new.span)
    if (old.kind, old.signature) != (new.kind, new.signature):
        now, was = (f"{p.kind} {'::'.join(p.signature)}" for p in (new, old))
        text = f"port {name} is {now}, was {was}"
        same = old.kind == new.kind and sides.same(old.signature, new.signature)
        wires = () if same else None
        yield change(kinds.CELLTYPE_PORT_SIGNATURE, name, text, *spans, wires=wires)
    if (old.array, old.size) != (new.array, new.size):
        text = f"port {name} has another array"
        yield change(kinds.CELLTYPE_PORT_ARRAY, name, text, *spans)
    facts = [(p.optional, p.omit, p.dynamic, p.ref_desc, p.inline) for p in (old, new)]
    if facts[0] != facts[1]:
        text = f"port {name} has other specifiers"
        yield change(kinds.CELLTYPE_PORT_SPECIFIER, name, text, *spans)


Names = Mapping[ScopedName, ScopedName]


def _cell(old: Cell, new: Cell, names: Names) -> Iterator[Change]:
    name, spans = new.scoped, (old.span, new.span)
    if old.celltype != new.celltype:
        now, was = "::".join(new.celltype), "::".join(old.celltype)
        text = f"cell {name} is a {now}, was a {was}"
        yield change(kinds.CELL_CELLTYPE, name, text, *spans)
    before, after = (
        {key: str(value) for key, value in c.attributes} for c in (old, new)
    )
    for key, was, now in differing(before, after):
        text = f"{name}.{key} is {now}, was {was}"
        yield change(kinds.CELL_ATTRIBUTE, f"{name}.{key}", text, *spans)
    joins = matching(
        {(j.port, j.index): j for j in old.joins},
        {(j.port, j.index): j for j in new.joins},
    )
    yield from item_changes(_JOINS, joins, lambda join: _end(name, join), spans)
    for one, other in joins.pairs:
        yield from _join(one, other, _end(name, other), names)


def _end(cell: str, join: Join) -> str:
    index = "" if join.index is None else f"[{join.index}]"
    return f"{cell}.{join.port}{index}"


def _join(old: Join, new: Join, name: str, names: Names) -> Iterator[Change]:
    spans = (old.span, new.span)
    target = names.get(old.target, old.target)
    if (target, old.target_port, old.target_index) != (
        *(new.target, new.target_port, new.target_index),
    ):
        text = f"join {name} leads to {'::'.join(new.target)}.{new.target_port}"
        yield change(kinds.JOIN_TARGET, name, text, *spans)
    before, after = ([t.plugin for t in j.through] for j in (old, new))
    if before != after:
        now, was = (", ".join(p) or "no plug-in" for p in (after, before))
        text = f"join {name} goes through {now}, did through {was}"
        yield change(kinds.JOIN_PLUGIN, name, text, *spans)
        return
    for one, other in zip(old.through, new.through, strict=True):
        if one.argument.text != other.argument.text:
            text = (
                f"join {name}: {other.plugin} has the argument "
                f'"{other.argument.text}", had "{one.argument.text}"'
            )
            wires = _wires_of_options(one, other)
            spans = one.span, other.span
            yield change(kinds.JOIN_OPTIONS, name, text, *spans, wires=wires)


def _wires_of_options(old: Through, new: Through) -> tuple[Wire, ...]:
    """Return what a change of options breaks: octets and transport, or the calls over CORBA.

    Options of tecsgen's half, default values, time-outs and names do not concern the peer.
    """
    if new.plugin != PLUGIN:
        before, after = ({o.name: o.value for o in t.options} for t in (old, new))
        changed = (k for k in {**before, **after} if before.get(k) != after.get(k))
        return (Wire.TDR,) * any(key not in TECSGEN_OPTIONS for key in changed)
    one, other = (replace(read_options(t)[0], timeout=0.0, name="") for t in (old, new))
    octets = [
        (replace(o, long_bits=None, intptr_bits=None, array=""), o.widths)
        for o in (one, other)
    ]
    in_calls = (Wire.GIOP,) * (one.array != other.array)
    return (Wire.TDR,) * (octets[0] != octets[1]) + in_calls


def _regions(old: Version, new: Version) -> Iterator[Change]:
    regions = matching(declared(old, Region), declared(new, Region))
    for one, other in regions.pairs:
        spans = one.span, other.span
        yield from fact_changes(
            _REGION_FACTS, one, other, other.scoped, spans, "region"
        )
    yield from item_changes(_REGIONS, regions, attrgetter("scoped"))
