"""Regions: scopes of cells, plug-ins between regions."""

from cdl_stages import CELLTYPES, analysed

from rtgen.compiler.model.tecs import Cell, Region


def test_a_region_is_a_scope() -> None:
    table, _ = analysed(
        CELLTYPES
        + "region rBoard { cell tMotor Left {}; };\n"
        + "cell tMain Main { cMotor = rBoard::Left.eMotor; };"
    )
    assert [type(d) for d in table.model() if isinstance(d, Region)] == [Region]
    left = table.root.scopes["rBoard"].entities["Left"].declaration
    assert isinstance(left, Cell)
    assert left.region == ("rBoard",)
    assert left.name == ("rBoard", "Left")


def test_a_region_is_opened_again_under_its_name() -> None:
    table, _ = analysed(
        CELLTYPES + "region r { cell tMotor A {}; };\nregion r { cell tMotor B {}; };\n"
    )
    assert list(table.root.scopes["r"].entities) == ["A", "B"]
    assert len([d for d in table.model() if isinstance(d, Region)]) == 1
