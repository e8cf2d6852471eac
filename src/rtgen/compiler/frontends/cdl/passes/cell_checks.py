"""Checks all cells after `joins`: use of prototypes, fixed joins, ids; adds nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names import entities as known
from rtgen.compiler.frontends.cdl.names.scopes import Scope
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.rules import cells as rules


def check_use(declared: Iterable[known.Cell], report: known.Report) -> None:
    """Report unused prototypes and cells, and fixed joins that are joined elsewhere."""
    for cell in declared:
        span = cell.span or cell.entity.place
        if not cell.defined and cell.used:
            message = f"the cell {cell.name} is used, and has a prototype only"
            hint = f"write cell {cell.celltype_name} {cell.name} {{ ... }};"
            report(rules.UNDEFINED_CELL.at(span, message, hint=hint))
        elif not cell.defined:
            message = f"the cell {cell.name} is neither used nor defined"
            report(rules.UNUSED_PROTOTYPE.at(span, message))
        elif not cell.used and cell.celltype is not None and cell.celltype.inactive:
            message = (
                f"nobody calls the cell {cell.name}, and it does not run by itself"
            )
            report(rules.UNUSED_CELL.at(span, message))
        _check_callers(cell, report)


def _check_callers(cell: known.Cell, report: known.Report) -> None:
    for port, name in cell.celltype.fixed() if cell.celltype is not None else ():
        if cell.callers.get(name, 0) > 1:
            report(
                rules.MANY_CALLERS.at(
                    cell.span or cell.entity.place,
                    f"{cell.name}.{name} has a fixed join, and is joined elsewhere, too",
                    related=[Related(port.span, "the fixed join")],
                )
            )


def check_ids(
    cells: Iterable[known.Cell], regions: Regions, report: known.Report
) -> None:
    """Check that the cells of a celltype in a link unit have the ids 1 to n."""
    counts: dict[Scope, Counter[known.Celltype]] = {}
    groups: dict[tuple[known.Celltype, Scope], list[known.Cell]] = {}
    for cell in cells:
        if cell.celltype is None:
            continue
        unit = regions.link_unit(cell.region)
        counts.setdefault(unit, Counter()).update(cell.celltype.real())
        groups.setdefault((cell.celltype, unit), []).append(cell)
    for (type_, unit), members in groups.items():
        count = counts[unit][type_]
        taken: dict[int, known.Cell] = {}
        for cell in members:
            if cell.id is None:
                continue
            assert cell.id_span is not None
            number = cell.id if cell.id > 0 else count + 1 + cell.id
            first = taken.setdefault(number, cell)
            if not 1 <= number <= count:
                plural = "is 1 cell" if count == 1 else f"are {count} cells"
                message = f"there {plural} of {type_.name}, so no id {cell.id}"
                report(rules.ID_TAKEN.at(cell.id_span, message))
            elif first is not cell:
                assert first.id_span is not None
                report(
                    rules.ID_TAKEN.at(
                        cell.id_span,
                        f"the id {cell.id} of {cell.name} is that of {first.name}",
                        related=[Related(first.id_span, "taken here")],
                    )
                )
