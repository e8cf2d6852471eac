"""Specifiers of cells: adds id, allocators, restrictions, plug-in and prototype to the cell."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import msgspec

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    Cell,
    CellAllocator,
    Join,
    Place,
    Report,
    Values,
)
from rtgen.compiler.frontends.cdl.names.scopes import Kind
from rtgen.compiler.frontends.cdl.passes import specifiers
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.passes.specifiers import belongs
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.kit.nodes import Spanned
from rtgen.compiler.frontends.kit.suggestions import nearest


class CellSpecifiers(msgspec.Struct, eq=False):
    """Reads the specifiers of cells; `add` adds a join to a cell."""

    _values: Values
    _regions: Regions
    _add: Callable[[Cell, Join], bool]
    _report: Report
    _restricted: list[tuple[tree.ScopedName, Place]] = []
    _of_joins: list[tuple[Cell, tree.Specifier, Place]] = []

    def take(self, cell: Cell, given: list[tree.Specifier], place: Place) -> None:
        """Record the specifiers of a cell."""
        for specifier in given:
            match specifier.word:
                case "through":
                    self._of_joins.append((cell, specifier, place))
                case "id":
                    self._id(cell, specifier, place)
                case "allocator":
                    for argument in specifier.arguments:
                        assert isinstance(argument, tree.Allocation)
                        self._allocator(cell, argument, place)
                case "restrict":
                    for argument in specifier.arguments:
                        assert isinstance(argument, tree.Restriction)
                        self._restricted += ((name, place) for name in argument.regions)
        generate = specifiers.once(given, "generate", place, self._report)
        if generate is not None:
            name = generate.arguments[0]
            assert isinstance(name, tree.Name)
            self._regions.apply(name, place, on_way=False)
        marks = [s for s in given if s.word == "prototype"]
        if marks and (cell.defined or generate is not None):
            reason = "is defined before" if cell.defined else "has a plug-in"
            self._report(
                rules.PROTOTYPE.at(
                    place.span(marks[0]),
                    f"{cell.name} is not a prototype: it {reason}",
                    related=[Related(cell.span, "defined here")] if cell.span else [],
                )
            )
        elif generate is not None and not cell.defined:
            message = f"a plug-in cannot be applied to {cell.name}, a prototype"
            hint = "put it where the cell has its body"
            self._report(rules.PROTOTYPE.at(place.span(generate), message, hint=hint))

    def _id(self, cell: Cell, specifier: tree.Specifier, place: Place) -> None:
        expression = specifier.arguments[0]
        value = self._values.constant(expression, place)  # type: ignore[arg-type]
        if isinstance(value, int) and not isinstance(value, bool) and value:
            cell.id, cell.id_span = value, place.span(specifier)
            return
        message = "an id cannot be 0" if value == 0 else "an id is a constant integer"
        self._report(rules.BAD_ID.at(place.span(specifier), message))

    def finish(self) -> None:
        """Check the regions that `restrict` names; they may be declared after the cell."""
        for name, place in self._restricted:
            found = place.lookup(name)
            if found is None or found.kind is not Kind.REGION:
                what = "is not known" if found is None else f"is a {found.kind}"
                self._report(
                    rules.RESTRICT.at(
                        place.span(name),
                        f"{name} {what}: restrict names regions",
                        hint=place.near(name.parts[-1], Kind.REGION),
                    )
                )

    def check(self, cells: Sequence[Cell]) -> None:
        """Report `through` in front of cells; the hint is the join that it belongs to."""
        for cell, specifier, place in self._of_joins:
            joins = [*_leading_to(cell, cells), *(j for j in cell.order if j.cell)]
            hint, related = belongs(specifier.word), []
            if joins:
                join = joins[0]
                related = [Related(join.span, "this join of the cell")]
                written = f"{_text(place, specifier)}] {join.name}"
                if join.value is not None:
                    value = _text(join.place, join.value)
                    hint = f"write it in front of the join: [{written} = {value};"
            self._report(
                syntax.MISPLACED_SPECIFIER.at(
                    place.span(specifier),
                    f"through cannot precede the cell {cell.name}",
                    related=related,
                    hint=hint,
                )
            )

    def _allocator(self, cell: Cell, node: tree.Allocation, place: Place) -> None:
        """Handle `port[i].function.parameter = Cell.eAlloc` of a cell: a join of a hidden port."""
        if node.operator != "=" or len(node.path) != 3:
            self._report(
                celltype_rules.ALLOCATOR_FORM.at(
                    place.span(node),
                    "this is not the form of an allocator here",
                    hint="write ePort.function.parameter = Cell.eAlloc",
                )
            )
            return
        port, function, parameter = (name.text for name in node.path)
        name = f"{port}_{function}_{parameter}"
        span = place.unit.span(node.path[0].start, node.path[2].end)
        if cell.celltype is not None and name not in cell.celltype.members:
            entries = [
                ".".join((p.hidden.port.name, p.hidden.function, p.hidden.parameter))
                for p in cell.celltype.ports
                if p.hidden is not None
            ]
            near = nearest(".".join((port, function, parameter)), entries)
            message = f"{port}.{function}.{parameter} is not a parameter that needs an allocator"
            hint = f"did you mean {near}?" if near else None
            self._report(rules.ALLOCATOR_OF_CELL.at(span, message, hint=hint))
            return
        index = self.index(node.subscript, place)
        join = Join(name, index, span, place, node.value)
        self._add(cell, join)
        cell.allocators.append(CellAllocator(port, index, function, parameter, join))

    def index(self, subscript: tree.Subscript | None, place: Place) -> int | None:
        """Return the number in a subscript: -1 for `[]`, None where there is none."""
        if subscript is None:
            return None
        if subscript.index is None:
            return -1
        value = self._values.constant(subscript.index, place)
        if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
            return value
        self._report(
            rules.LEFT_SUBSCRIPT.at(
                place.span(subscript), "a subscript is a constant integer, 0 or more"
            )
        )
        return 0


def _leading_to(cell: Cell, cells: Sequence[Cell]) -> Iterator[Join]:
    """Yield the joins of other cells, as written, that lead to a cell."""
    for each in cells:
        for join in each.order:
            if join.cell is cell and join.value is not None:
                yield join


def _text(place: Place, node: Spanned) -> str:
    """Return a node as written, on one line."""
    return " ".join(place.unit.source.text[node.start : node.end].split())
