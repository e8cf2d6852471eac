"""The devices of specs/canopen: no findings, and the content required by the source and CiA."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.compiler.frontends.eds import load
from rtgen.compiler.layouts.pdo import Mapped, layout
from rtgen.compiler.model.canopen import (
    Access,
    DataType,
    Device,
    Pdo,
    PdoDirection,
    resolved,
)
from rtgen.compiler.typemap.canopen.names import field_names

FOLDER = Path(__file__).parents[2] / "specs/canopen"
NAMES = sorted(path.stem for path in FOLDER.glob("*.eds"))
DRIVES = ("epos_drive", "ftmd", "motor_core_unit")


def device(name: str) -> Device:
    result = load([FOLDER / f"{name}.eds"], root=FOLDER)
    assert result.diagnostics == ()
    [found] = result.model.devices
    return found


def pdo(of: Device, direction: PdoDirection, number: int) -> Pdo:
    [found] = [p for p in of.pdos if (p.direction, p.number) == (direction, number)]
    return found


def default(of: Device, index: int, subindex: int = 0) -> object:
    variable = of.find(index, subindex)
    assert variable is not None
    return variable.default


def test_all_are_there() -> None:
    assert NAMES == ["epos_drive", "f_palette", "ftmd", "motor_core_unit"]
    codes = {device(name).product_code for name in NAMES}
    assert len(codes) == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_pdo_has_a_codec(name: str) -> None:
    found = device(name)
    names = field_names(found.variables)
    for one in found.pdos:
        entries = []
        for entry in one.entries:
            variable = found.find(entry.index, entry.subindex)
            assert variable is not None
            field = names[entry.index, entry.subindex]
            entries.append(Mapped(field, variable.data_type, entry.bits))
        assert layout(entries).size == one.bits // 8


@pytest.mark.parametrize("name", NAMES)
def test_communication(name: str) -> None:
    found = device(name)
    assert found.info.lss
    assert default(found, 0x1017) == 100
    assert found.find(0x1016, 1) is not None
    assert resolved(found.find(0x1014).default, 5) == 0x85  # type: ignore[union-attr]
    for one in found.pdos:
        predefined = 0x180 if one.direction is PdoDirection.TPDO else 0x200
        cob_id = resolved(one.cob_id, 5)
        assert isinstance(cob_id, int)
        assert cob_id & 0x7FF == predefined + 0x100 * (one.number - 1) + 5


@pytest.mark.parametrize("name", DRIVES)
def test_drives_are_of_cia_402(name: str) -> None:
    found = device(name)
    device_type = default(found, 0x1000)
    assert isinstance(device_type, int)
    assert device_type & 0xFFFF == 402
    wanted = {
        0x6040: (DataType.UNSIGNED16, Access.RWW),
        0x6041: (DataType.UNSIGNED16, Access.RO),
        0x6060: (DataType.INTEGER8, Access.RWW),
        0x6061: (DataType.INTEGER8, Access.RO),
        0x6064: (DataType.INTEGER32, Access.RO),
        0x606C: (DataType.INTEGER32, Access.RO),
        0x6071: (DataType.INTEGER16, Access.RWW),
        0x6077: (DataType.INTEGER16, Access.RO),
        0x607A: (DataType.INTEGER32, Access.RWW),
        0x60FF: (DataType.INTEGER32, Access.RWW),
    }
    for index, kind in wanted.items():
        variable = found.find(index)
        assert variable is not None
        assert (variable.data_type, variable.access) == kind
        assert variable.pdo_mappable
    assert default(found, 0x1029, 1) == 2  # stops if the manager's heartbeat is lost


def test_limits_of_the_motor_core_unit() -> None:
    """Tables 5 and 6: 15 and 30 Nm, 60 rpm, 7 and 10 A, 10 to 60 V."""
    found = device("motor_core_unit")
    torque, current = default(found, 0x6076), default(found, 0x6075)
    assert (torque, current) == (15_000, 7_000)
    assert torque * default(found, 0x6072) == 30_000 * 1000  # type: ignore[operator]
    assert round(current * default(found, 0x6073) / 1e6) == 10  # type: ignore[operator]
    assert default(found, 0x607F) == 60 * 360 * 1000 // 60
    supply = found.find(0x6079)
    assert supply is not None
    assert (supply.low, supply.high) == (10_000, 60_000)
    modes = default(found, 0x6502)
    assert isinstance(modes, int)
    assert all(modes >> mode - 1 & 1 for mode in (1, 3, 4, 8))


def test_the_angle_reference_fits_the_motor() -> None:
    """TPDO 4 of the board and RPDO 2 of the motor unit carry one INTEGER32 each (Fig 120)."""
    sent = pdo(device("f_palette"), PdoDirection.TPDO, 4)
    taken = pdo(device("motor_core_unit"), PdoDirection.RPDO, 2)
    assert [e.bits for e in sent.entries] == [e.bits for e in taken.entries] == [32]
    assert not sent.valid


def test_f_palette_is_of_cia_401() -> None:
    found = device("f_palette")
    assert default(found, 0x1000) == 0x000F0191
    counts = {
        index: default(found, index) for index in (0x6000, 0x6200, 0x6401, 0x6411)
    }
    assert counts == {0x6000: 2, 0x6200: 2, 0x6401: 8, 0x6411: 4}
    assert default(found, 0x6423) == 0
