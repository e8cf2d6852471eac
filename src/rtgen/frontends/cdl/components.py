"""The component half of a unit: celltypes, composites, cells and regions, and their model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtgen.diagnostics import Related
from rtgen.frontends.cdl import entities as known
from rtgen.frontends.cdl import plugin_arguments, plugins, specifiers, tree
from rtgen.frontends.cdl.cells import Cells
from rtgen.frontends.cdl.celltypes import Celltypes
from rtgen.frontends.cdl.composites import Composites
from rtgen.frontends.cdl.entities import Place
from rtgen.frontends.cdl.joins import Joins
from rtgen.frontends.cdl.open_ends import OpenEnds
from rtgen.frontends.cdl.regions import Regions
from rtgen.frontends.cdl.rules import cells as rules
from rtgen.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.frontends.cdl.scopes import Entity, Kind, Scope
from rtgen.frontends.cdl.values import AnalysisValues
from rtgen.model.tecs import (
    Cell,
    Celltype,
    Composite,
    Expression,
    Join,
    PluginArgument,
    Reference,
    Region,
    TecsPort,
    TecsVariable,
    TextPiece,
    Through,
)
from rtgen.model.types import ScopedName

if TYPE_CHECKING:
    from rtgen.frontends.cdl.analysis import Analysis

_GENERATED = (Kind.SIGNATURE, Kind.CELLTYPE, Kind.COMPOSITE, Kind.CELL)


class Components:
    """Takes the statements of components in the order of the text, then `finish`es.

    The model of a cell is made when all is known, in `finish`.
    """

    def __init__(self, analysis: Analysis) -> None:
        values, report = AnalysisValues(analysis), analysis.report
        self._analysis = analysis
        self._report = report
        self._regions = Regions(analysis.root, report)
        self._cells = Cells(values, self._regions, report)
        self._joins = Joins(values, self._regions, self._cells, report)
        self._celltypes = Celltypes(values, self._regions.applied, report)
        self._open_ends = OpenEnds(values, self._regions, report)
        self._composites = Composites(
            self._celltypes, self._cells, self._joins, self._open_ends, report
        )
        self._types: list[known.Celltype] = []
        self._docs: dict[Entity, str] = {}

    # In the order of the text

    def celltype(self, item: tree.Item, node: tree.Celltype, place: Place) -> None:
        """Take a celltype."""
        unit, scope = place.unit, place.scope
        entity = self._analysis.declare(Kind.CELLTYPE, node.name, item, unit, scope)
        if entity is None:
            return
        type_ = known.Celltype(entity, place)
        self._specify(type_, item, place)
        entity.component = type_
        self._celltypes.fill(type_, node)
        self._types.append(type_)
        entity.declaration = Celltype(
            name=entity.name,
            file=entity.place.file,
            span=entity.place,
            doc=self._doc(place, item),
            ports=tuple(map(_port, type_.ports)),
            attributes=tuple(self._variables(type_, "attr")),
            variables=tuple(self._variables(type_, "var")),
            singleton=type_.singleton,
            active=type_.active,
            idx_is_id=type_.idx_is_id,
        )
        self._analysis.declared(entity)

    def composite(self, item: tree.Item, node: tree.Composite, place: Place) -> None:
        """Take a composite with its inner cells."""
        unit, scope = place.unit, place.scope
        entity = self._analysis.declare(Kind.COMPOSITE, node.name, item, unit, scope)
        if entity is None:
            return
        composite = known.Composite(entity, place)
        self._specify(composite, item, place)
        self._composites.fill(composite, node)
        entity.component = composite
        entity.declaration = Composite(
            name=entity.name,
            file=entity.place.file,
            span=entity.place,
            doc=self._doc(place, item),
            ports=tuple(map(_port, composite.ports)),
            attributes=tuple(self._variables(composite, "attr")),
            cells=tuple(self._cell(cell) for cell in composite.inner.values()),
            exports=tuple(
                (exported.name, exported.cell.name, exported.member)
                for exported in composite.exports
                if isinstance(composite.members.get(exported.name), known.Port)
            ),
            singleton=composite.singleton,
            active=composite.active,
        )
        self._analysis.declared(entity)

    def cell(self, item: tree.Item, node: tree.Cell, place: Place) -> None:
        """Take a cell, or its prototype."""
        before = len(self._cells.all)
        self._cells.declare(item, node, place)
        for cell in self._cells.all[before:]:
            self._docs[cell.entity] = self._doc(place, item)
            self._analysis.declared(cell.entity)

    def region(self, item: tree.Item, node: tree.Region, place: Place) -> Scope:
        """Open a region: the scope for what is in it."""
        before = place.scope.own(node.name.text)
        scope = self._regions.open(item, node, place)
        if scope is not before and scope.place is not None:
            permits = self._regions.of(scope)
            entity = Entity(Kind.REGION, scope.name, place.unit, item, scope.place)
            entity.declaration = Region(
                name=scope.name,
                file=scope.place.file,
                span=scope.place,
                doc=self._doc(place, item),
                linkunit=permits.linkunit,
                node=permits.node,
            )
            self._analysis.declared(entity)
        return scope

    def generate(self, node: tree.Generate, place: Place) -> None:
        """Take a plug-in that is applied to something declared before."""
        maker = self._regions.applied.of_types
        self.applied(node.plugin, place)
        target = place.lookup(node.target)
        if target is None and (place.lost(node.target) or self._analysis.incomplete):
            return
        if target is None and maker is not None:
            message = f"{node.target} is not declared here; {maker} may do it"
            self._report(rules.MADE_BY_PLUGIN.at(place.span(node.target), message))
            return
        type_ = target.component if isinstance(target, Entity) else None
        if isinstance(type_, known.Celltype) and plugins.may_join(node.plugin.text):
            type_.joined_by = node.plugin.text
        if target is None or target.kind not in _GENERATED:
            what = "is not known" if target is None else f"is a {target.kind}"
            self._report(
                rules.GENERATE_TARGET.at(
                    place.span(node.target),
                    f"{node.target} {what}: a plug-in is applied to a signature, "
                    "celltype, composite or cell",
                    hint=place.near(node.target.parts[-1], *_GENERATED),
                )
            )

    def applied(self, plugin: tree.Name, place: Place) -> None:
        """Note a plug-in of a signature, celltype or cell: it may declare things."""
        self._regions.apply(plugin, place, on_way=False)

    def _doc(self, place: Place, item: tree.Item) -> str:
        return self._analysis.doc(place.unit, item.start, item.end)

    def _specify(self, type_: known.Celltype, item: tree.Item, place: Place) -> None:
        what = f"the {type_.entity.kind} {type_.name}"
        given = specifiers.accepted(
            item.specifiers, specifiers.CELLTYPE, what, place, self._report
        )
        for specifier in given:
            match specifier.word:
                case "singleton":
                    type_.singleton = True
                case "active":
                    type_.active = True
                case "idx_is_id" if isinstance(type_, known.Composite):
                    self._report(
                        celltype_rules.NO_EFFECT_ON_COMPOSITE.at(
                            place.span(specifier),
                            f"idx_is_id has no effect on the composite {type_.name}",
                            hint="remove it",
                        )
                    )
                case "idx_is_id":
                    type_.idx_is_id = True
        generate = specifiers.once(given, "generate", place, self._report)
        if generate is not None:
            plugin = generate.arguments[0]
            assert isinstance(plugin, tree.Name)
            self.applied(plugin, place)
            if plugins.may_join(plugin.text):
                type_.joined_by = plugin.text

    # After the last file

    def finish(self) -> None:
        """Resolve what needs the whole unit: joins, required ports, ids; make the cells' model."""
        cells = self._cells
        cells.finish()
        for cell in cells.all:
            cells.turn(cell)
        for cell in cells.declared:
            cells.turn(cell)  # what stands in a prototype
        for type_ in self._types:
            self._joins.require(type_)
        for cell in cells.all:
            self._joins.resolve(cell)
        for cell in cells.all:
            self._joins.fixed(cell)
        for cell in cells.all:
            self._open_ends.check(cell)
        self._check_unused()
        self._check_ids()
        for cell in cells.all:
            cell.entity.declaration = self._cell(cell)

    def _check_unused(self) -> None:
        for cell in self._cells.declared:
            span = cell.span or cell.entity.place
            if not cell.defined and cell.used:
                message = f"the cell {cell.name} is used, and has a prototype only"
                hint = f"write cell {cell.celltype_name} {cell.name} {{ ... }};"
                self._report(rules.UNDEFINED_CELL.at(span, message, hint=hint))
            elif not cell.defined:
                message = f"the cell {cell.name} is neither used nor defined"
                self._report(rules.UNUSED_PROTOTYPE.at(span, message))
            elif not cell.used and cell.celltype is not None and cell.celltype.inactive:
                message = (
                    f"nobody calls the cell {cell.name}, and it does not run by itself"
                )
                self._report(rules.UNUSED_CELL.at(span, message))
            self._check_callers(cell)

    def _check_callers(self, cell: known.Cell) -> None:
        for port, name in cell.celltype.fixed() if cell.celltype is not None else ():
            if cell.callers.get(name, 0) > 1:
                self._report(
                    rules.MANY_CALLERS.at(
                        cell.span or cell.entity.place,
                        f"{cell.name}.{name} has a fixed join, and is joined elsewhere, too",
                        related=[Related(port.span, "the fixed join")],
                    )
                )

    def _check_ids(self) -> None:
        """The ids of a celltype in a link unit are 1 to the number of its cells."""
        counts: dict[Scope, Counter[known.Celltype]] = {}
        groups: dict[tuple[known.Celltype, Scope], list[known.Cell]] = {}
        for cell in self._cells.all:
            if cell.celltype is None:
                continue
            unit = self._regions.link_unit(cell.region)
            counts.setdefault(unit, Counter()).update(cell.celltype.real())
            groups.setdefault((cell.celltype, unit), []).append(cell)
        for (type_, unit), cells in groups.items():
            count = counts[unit][type_]
            taken: dict[int, known.Cell] = {}
            for cell in cells:
                if cell.id is None:
                    continue
                assert cell.id_span is not None
                number = cell.id if cell.id > 0 else count + 1 + cell.id
                first = taken.setdefault(number, cell)
                if not 1 <= number <= count:
                    plural = "is 1 cell" if count == 1 else f"are {count} cells"
                    message = f"there {plural} of {type_.name}, so no id {cell.id}"
                    self._report(rules.ID_TAKEN.at(cell.id_span, message))
                elif first is not cell:
                    assert first.id_span is not None
                    self._report(
                        rules.ID_TAKEN.at(
                            cell.id_span,
                            f"the id {cell.id} of {cell.name} is that of {first.name}",
                            related=[Related(first.id_span, "taken here")],
                        )
                    )

    # The model

    def _variables(self, type_: known.Celltype, kind: str) -> Iterator[TecsVariable]:
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

    def _cell(self, cell: known.Cell) -> Cell:
        type_ = cell.celltype
        name = _scoped(cell.celltype_name) if type_ is None else type_.entity.name
        return Cell(
            name=cell.entity.name,
            file=(cell.span or cell.entity.place).file,
            span=cell.span or cell.entity.place,
            doc=self._docs.get(cell.entity, ""),
            celltype=name,
            region=cell.region.name,
            joins=tuple(self._lowered_joins(cell)),
            attributes=tuple(self._attributes(cell)),
        )

    def _attributes(self, cell: known.Cell) -> Iterator[tuple[str, Expression]]:
        type_ = cell.celltype
        for name, exported in cell.exported.items():
            member = type_.members.get(name) if type_ is not None else None
            if isinstance(member, known.Variable):
                yield name, Reference(f"composite.{exported.name}")
        for join in cell.order:
            if join.initial is not None and join.name not in cell.exported:
                yield join.name, join.initial

    def _lowered_joins(self, cell: known.Cell) -> Iterator[Join]:
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
                    join.port.signature.name
                    if join.port and join.port.signature
                    else ()
                ),
                through=tuple(self._through(cell, join, p) for p in join.chain),
                span=join.span,
            )

    def _through(
        self, cell: known.Cell, join: known.Join, plugin: known.Plugin
    ) -> Through:
        name = plugins.class_name(plugin.name.text)
        argument = _argument(plugin)
        ours = plugins.is_ours(name)
        words = _words(cell, join, plugin)
        return Through(
            plugin=plugins.OWN_NAME if ours else name,
            argument=argument,
            span=plugin.place.span(plugin.name),
            origin=plugin.origin,
            region=plugin.region.name if plugin.region is not None else (),
            options=(
                plugin_arguments.options(argument, words, self._report) if ours else ()
            ),
        )


def _port(port: known.Port) -> TecsPort:
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
    """The argument with the places of its pieces; a piece ends with its line of the source."""
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


def _words(cell: known.Cell, join: known.Join, plugin: known.Plugin) -> dict[str, str]:
    """What stands between dollars in the argument of a plug-in."""
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
