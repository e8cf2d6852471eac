"""Joins: targets, signatures, unconnected call ports."""

from cdl_stages import CELLTYPES, analysed, cell

from rtgen.compiler.model.tecs import Cell

MOTOR = "cell tMotor Left {};\n"


def test_a_join_finds_its_target() -> None:
    table, found = analysed(
        CELLTYPES + MOTOR + "cell tMain Main { cMotor = Left.eMotor; };"
    )
    assert not found
    (join,) = cell(table, "Main").order
    assert join.cell is cell(table, "Left")
    declaration = table.root.entities["Main"].declaration
    assert isinstance(declaration, Cell)
    (lowered,) = declaration.joins
    assert (lowered.target, lowered.target_port) == (("Left",), "eMotor")
    assert lowered.signature == ("sMotor",)


def test_a_call_port_that_is_not_joined() -> None:
    _, found = analysed(CELLTYPES + "cell tMain Main {};")
    assert len(found) == 1
    assert "cMotor" in found[0]


def test_a_target_that_is_unknown() -> None:
    _, found = analysed(CELLTYPES + "cell tMain Main { cMotor = Right.eMotor; };")
    assert found
    assert "Right" in found[0]


def test_a_target_of_another_signature() -> None:
    text = (
        "signature sOther { void f(void); };\n"
        "celltype tOther { entry sOther eOther; };\n"
        "cell tOther Other {};\n"
    )
    _, found = analysed(
        CELLTYPES + text + "cell tMain Main { cMotor = Other.eOther; };"
    )
    assert any("sOther" in message for message in found)
