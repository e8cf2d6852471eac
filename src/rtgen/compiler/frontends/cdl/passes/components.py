"""Pass over component statements: adds celltypes, composites, cells and regions to the table."""

from __future__ import annotations

from rtgen.compiler.frontends.cdl.names import entities as known
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes import plugins, specifiers
from rtgen.compiler.frontends.cdl.passes.cell_checks import check_ids, check_use
from rtgen.compiler.frontends.cdl.passes.cells import Cells
from rtgen.compiler.frontends.cdl.passes.celltypes import Celltypes
from rtgen.compiler.frontends.cdl.passes.composites import Composites
from rtgen.compiler.frontends.cdl.passes.implicit_joins import ImplicitJoins
from rtgen.compiler.frontends.cdl.passes.lowering import cell_of, port_of, variables
from rtgen.compiler.frontends.cdl.passes.open_ends import OpenEnds
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.model.tecs import Celltype, Composite, Region

_GENERATED = (Kind.SIGNATURE, Kind.CELLTYPE, Kind.COMPOSITE, Kind.CELL)


class Components:
    """Analyses the statements of components in source order; `finish` completes them.

    The models of cells are made in `finish`, once the whole unit is known.
    """

    def __init__(self, table: Table, values: known.Values) -> None:
        report = table.report
        self._table = table
        self._report = report
        self._regions = Regions(table.root, report, table.has_plugin)
        self._cells = Cells(values, self._regions, report)
        self._joins = ImplicitJoins(values, self._regions, self._cells, report)
        self._celltypes = Celltypes(values, self._regions.applied, report)
        self._open_ends = OpenEnds(values, self._regions, report)
        self._composites = Composites(
            self._celltypes, self._cells, self._joins, self._open_ends, report
        )
        self._types: list[known.Celltype] = []
        self._docs: dict[Entity, str] = {}

    # In the order of the text

    def celltype(
        self, item: statements.Item, node: statements.Celltype, place: Place
    ) -> None:
        """Declare a celltype."""
        entity = self._table.declare(Kind.CELLTYPE, node.name, item, place)
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
            doc=place.doc(item),
            ports=tuple(map(port_of, type_.ports)),
            attributes=tuple(variables(type_, "attr")),
            variables=tuple(variables(type_, "var")),
            singleton=type_.singleton,
            active=type_.active,
            idx_is_id=type_.idx_is_id,
        )
        self._table.declared(entity)

    def composite(
        self, item: statements.Item, node: statements.Composite, place: Place
    ) -> None:
        """Declare a composite with its inner cells."""
        entity = self._table.declare(Kind.COMPOSITE, node.name, item, place)
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
            doc=place.doc(item),
            ports=tuple(map(port_of, composite.ports)),
            attributes=tuple(variables(composite, "attr")),
            cells=tuple(
                cell_of(cell, "", self._report) for cell in composite.inner.values()
            ),
            exports=tuple(
                (exported.name, exported.cell.name, exported.member)
                for exported in composite.exports
                if isinstance(composite.members.get(exported.name), known.Port)
            ),
            singleton=composite.singleton,
            active=composite.active,
        )
        self._table.declared(entity)

    def cell(self, item: statements.Item, node: statements.Cell, place: Place) -> None:
        """Declare a cell, or its prototype."""
        before = len(self._cells.all)
        self._cells.declare(item, node, place)
        for cell in self._cells.all[before:]:
            self._docs[cell.entity] = place.doc(item)
            self._table.declared(cell.entity)

    def region(
        self, item: statements.Item, node: statements.Region, place: Place
    ) -> Scope:
        """Open the scope of a region."""
        before = place.scope.own(node.name.text)
        scope = self._regions.open(item, node, place)
        if scope is not before and scope.place is not None:
            permits = self._regions.of(scope)
            entity = Entity(Kind.REGION, scope.name, place.unit, item, scope.place)
            entity.declaration = Region(
                name=scope.name,
                file=scope.place.file,
                span=scope.place,
                doc=place.doc(item),
                linkunit=permits.linkunit,
                node=permits.node,
            )
            self._table.declared(entity)
        return scope

    def generate(self, node: statements.Generate, place: Place) -> None:
        """Record a plug-in that `generate` applies to an earlier declaration."""
        maker = self._regions.applied.of_types
        self.applied(node.plugin, place)
        target = place.lookup(node.target)
        if target is None and (
            place.may_be_declared(node.target) or self._table.incomplete
        ):
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
        """Record a plug-in of a signature, celltype or cell, which may add declarations."""
        self._regions.apply(plugin, place, on_way=False)

    def _specify(
        self, type_: known.Celltype, item: statements.Item, place: Place
    ) -> None:
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
        """Resolve joins, required ports and ids, which need the whole unit; make cells' models."""
        cells = self._cells
        cells.finish()
        for cell in cells.all:
            cells.turn(cell)
        for cell in cells.declared:
            cells.turn(cell)  # joins in a prototype
        for type_ in self._types:
            self._joins.require(type_)
        for cell in cells.all:
            self._joins.resolve(cell)
        for cell in cells.all:
            self._joins.fixed(cell)
        cells.check()
        for cell in cells.all:
            self._open_ends.check(cell)
        check_use(cells.declared, self._report)
        check_ids(cells.all, self._regions, self._report)
        for cell in cells.all:
            doc = self._docs.get(cell.entity, "")
            cell.entity.declaration = cell_of(cell, doc, self._report)
