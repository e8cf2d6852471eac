"""The stages of the CDL front end one by one, for texts without files."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.cdl.names.entities import Cell, Celltype, component
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.analysis import Analysis
from rtgen.compiler.frontends.cdl.syntax import statements
from rtgen.compiler.frontends.cdl.syntax.parser import parse
from rtgen.compiler.frontends.cdl.syntax.unit import TypeNames, Unit
from rtgen.compiler.frontends.cdl.text.source import Source

SIGNATURE = (
    "signature sMotor { void stop(void); int32_t speed([in] int32_t wheel); };\n"
)
CELLTYPES = (
    SIGNATURE
    + "celltype tMotor { entry sMotor eMotor; attr { int32_t limit = 5; }; };\n"
    + "[active] celltype tMain { call sMotor cMotor; };\n"
)


class _NoImports:
    lacks_types = False

    def import_file(self, statement: statements.Import, unit: Unit) -> None:
        raise AssertionError("the text imports a file")

    def import_header(self, statement: statements.ImportC, unit: Unit) -> None:
        raise AssertionError("the text imports a header")


def source(text: str) -> Source:
    """Return the text as a file."""
    return Source("some.cdl", "some.cdl", Path("some.cdl"), text.encode(), "utf8")


def parsed(text: str) -> tuple[Unit, list[Diagnostic]]:
    """Return the unit with its statements, and the syntax errors."""
    found: list[Diagnostic] = []
    unit = Unit(source(text))
    unit.items = parse(unit, TypeNames(frozenset()), _NoImports(), found.append)
    return unit, found


def analysed(text: str) -> tuple[Table, list[str]]:
    """Return the table of a text without syntax errors, and the messages of all passes."""
    unit, errors = parsed(text)
    assert not errors
    found: list[Diagnostic] = []
    table = Table(found.append)
    Analysis(table).run(unit)
    return table, [diagnostic.message for diagnostic in found]


def celltype(table: Table, name: str) -> Celltype:
    """Return the entry of a celltype."""
    found = component(table.root.entities[name])
    assert isinstance(found, Celltype)
    return found


def cell(table: Table, name: str) -> Cell:
    """Return the entry of a cell at file scope."""
    found = component(table.root.entities[name])
    assert isinstance(found, Cell)
    return found
