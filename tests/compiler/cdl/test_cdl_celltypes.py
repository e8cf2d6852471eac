"""Celltypes: ports, attributes, specifiers."""

import pytest
from cdl_stages import CELLTYPES, SIGNATURE, analysed, celltype


def test_ports_and_attributes() -> None:
    table, _ = analysed(CELLTYPES)
    motor, main = celltype(table, "tMotor"), celltype(table, "tMain")
    assert [(p.name, p.signature_name) for p in motor.ports] == [
        ("eMotor", ("sMotor",))
    ]
    assert [v.name for v in motor.variables] == ["limit"]
    assert (motor.active, main.active) == (False, True)


@pytest.mark.parametrize(
    "text",
    [
        "celltype t { entry sMotor e; call sMotor e; };",
        "celltype t { entry sMotors e; };",
        "celltype t { call sMotor c[0]; };",
        "celltype t { attr { int8_t a = 300; }; };",
    ],
)
def test_mistakes(text: str) -> None:
    assert analysed(SIGNATURE + text)[1]
