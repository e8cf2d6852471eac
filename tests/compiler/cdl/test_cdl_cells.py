"""Cells: initial values, prototypes, use."""

from cdl_stages import CELLTYPES, analysed, cell

from rtgen.compiler.model.tecs import Cell

MOTOR = "cell tMotor Left { limit = 7; };\n"
MAIN = "cell tMain Main { cMotor = Left.eMotor; };\n"


def test_attributes_that_a_cell_sets() -> None:
    table, found = analysed(CELLTYPES + MOTOR + MAIN)
    assert not found
    declaration = table.root.entities["Left"].declaration
    assert isinstance(declaration, Cell)
    assert [name for name, _ in declaration.attributes] == ["limit"]


def test_a_prototype_and_its_definition() -> None:
    table, found = analysed(CELLTYPES + "cell tMotor Left;\n" + MAIN + MOTOR)
    assert not found
    assert cell(table, "Left").defined


def test_a_cell_that_nothing_calls() -> None:
    _, found = analysed(CELLTYPES + MOTOR)
    assert found == ["nobody calls the cell Left, and it does not run by itself"]


def test_an_attribute_is_set_once() -> None:
    _, found = analysed(
        CELLTYPES + "cell tMotor Left { limit = 1; limit = 2; };\n" + MAIN
    )
    assert len(found) == 1
    assert "limit" in found[0]
