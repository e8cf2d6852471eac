"""Makes the model of celltypes and cells after all passes; adds nothing."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.frontends.cdl.names import entities as known
from rtgen.compiler.frontends.cdl.passes import plugin_arguments, plugins
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.model.c_types import Expression, Reference
from rtgen.compiler.model.tecs import (
    Cell,
    Join,
    PluginArgument,
    TecsPort,
    TecsVariable,
    TextPiece,
    Through,
)
from rtgen.compiler.model.types import ScopedName


def variables(type_: known.Celltype, kind: str) -> Iterator[TecsVariable]:
    """Yield the attributes (`attr`) or variables (`var`) of a celltype that have a type."""
    for variable in type_.variables:
        if variable.kind != kind or variable.type is None:
            continue
        yield TecsVariable(
            name=variable.name,
            type=variable.type,
            initial=variable.initial,
            size_is=variable.size,
            omit=variable.omit,
            choice=variable.choice,
            span=variable.span,
        )


def cell_of(cell: known.Cell, doc: str, report: known.Report) -> Cell:
    """Return the model of a cell; reports errors in the options of plug-ins on its joins."""
    type_ = cell.celltype
    name = _scoped(cell.celltype_name) if type_ is None else type_.entity.name
    return Cell(
        name=cell.entity.name,
        file=(cell.span or cell.entity.place).file,
        span=cell.span or cell.entity.place,
        doc=doc,
        celltype=name,
        region=cell.region.name,
        joins=tuple(_joins(cell, report)),
        attributes=tuple(_attributes(cell)),
    )


def _attributes(cell: known.Cell) -> Iterator[tuple[str, Expression]]:
    type_ = cell.celltype
    for name, exported in cell.exported.items():
        member = type_.members.get(name) if type_ is not None else None
        if isinstance(member, known.Variable):
            yield name, Reference(f"composite.{exported.name}")
    for join in cell.order:
        if join.initial is not None and join.name not in cell.exported:
            yield join.name, join.initial


def _joins(cell: known.Cell, report: known.Report) -> Iterator[Join]:
    seen: dict[str, int] = {}
    for join in cell.order:
        index = join.index
        if index == -1:
            index = seen[join.name] = seen.get(join.name, -1) + 1
        target = join.cell.entity.name if join.cell is not None else join.made
        if not target:
            continue
        yield Join(
            port=join.name,
            index=index,
            target=target,
            target_port=join.port_name,
            target_index=join.port_index,
            signature=(
                join.port.signature.name if join.port and join.port.signature else ()
            ),
            through=tuple(_through(cell, join, p, report) for p in join.chain),
            span=join.span,
        )


def _through(
    cell: known.Cell, join: known.Join, plugin: known.Plugin, report: known.Report
) -> Through:
    name = plugins.class_name(plugin.name.text)
    argument = _argument(plugin)
    ours = plugins.is_ours(name)
    words = _substitutions(cell, join, plugin)
    return Through(
        plugin=plugins.OWN_NAME if ours else name,
        argument=argument,
        span=plugin.place.span(plugin.name),
        origin=plugin.origin,
        region=plugin.region.name if plugin.region is not None else (),
        options=(plugin_arguments.options(argument, words, report) if ours else ()),
    )


def port_of(port: known.Port) -> TecsPort:
    """Return the model of a port."""
    return TecsPort(
        name=port.name,
        kind=port.kind,
        signature=(
            port.signature_name if port.signature is None else port.signature.name
        ),
        array=port.array,
        size=port.size,
        optional=port.optional,
        omit="omit" in port.flags,
        dynamic="dynamic" in port.flags,
        ref_desc="ref_desc" in port.flags,
        inline="inline" in port.flags,
        required=port.required is not None,
        hidden=port.hidden is not None,
        span=port.span,
    )


def _scoped(name: tree.ScopedName) -> ScopedName:
    return tuple(part.text for part in name.parts)


def _argument(plugin: known.Plugin) -> PluginArgument:
    """Return the argument with the places of its pieces; a piece ends with its source line."""
    pieces = []
    offset = 0
    for part in plugin.argument.parts:
        start = part.start
        for line in part.text.split("\n"):
            span = plugin.place.unit.span(start, start + len(line))
            pieces.append(TextPiece(offset, span))
            offset += len(line) + 1
            start += len(line) + 1
        offset -= 1
    return PluginArgument(plugin.argument.text, tuple(pieces))


def _substitutions(
    cell: known.Cell, join: known.Join, plugin: known.Plugin
) -> dict[str, str]:
    """Return the `$...$` substitutions in the argument of a plug-in."""
    caller = cell.entity.name
    callee = join.cell.entity.name if join.cell is not None else join.made
    start = cell.region
    end = join.cell.region if join.cell is not None else start
    preferred = start if plugin.origin in ("out_through", "to_through") else end
    return {
        "source": caller[-1],
        "destination": callee[-1],
        "next": callee[-1],
        "SOURCE": "_".join(caller),
        "DESTINATION": "_".join(callee),
        "NEXT": "_".join(callee),
        "start_region": "::".join(start.name),
        "end_region": "::".join(end.name),
        "preferred_region": "::".join(preferred.name),
        "count": str(plugin.count),
    }
