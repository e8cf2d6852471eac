"""The mirrored profile for a proxy: every PDO in the other direction, its number + 400h."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.backends.canopen.mirror import SHIFT, measured, mirrored
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.can_bus import kind_of
from rtgen.compiler.model.canopen import NO_RTR, Access, Device, NodeRelative, Pdo
from rtgen.compiler.typemap.canopen.ports import DevicePorts

ROOT = Path(__file__).parents[3]
SAMPLER = ROOT / "tests/golden/cases/canopen_devices/input/specs/sampler.eds"
FILES = [*sorted((ROOT / "specs/canopen").glob("*.eds")), SAMPLER]
TURNED = {"tpdo": "rpdo", "rpdo": "tpdo"}

ODD = {
    "EDS0503",  # fields with fewer bits than their types
    "EDS0509",  # a gap, which only RPDOs may have
}


def read(path: Path) -> Device:
    return load([path], root=path.parent).model.devices[0]


@pytest.fixture(params=FILES, ids=lambda path: path.stem)
def pair(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Device, Device]:
    """Return a device, and its mirror as parsed from the file."""
    device = read(request.param)
    path = tmp_path / "mirror.eds"
    path.write_text(eds_text(mirrored(device, path.name)), encoding="utf-8")
    result = load([path], root=tmp_path)
    assert {d.code for d in result.diagnostics} <= ODD
    return device, result.model.devices[0]


def test_factors_and_units_of_the_bus_file_are_in_the_mirror(tmp_path: Path) -> None:
    device = read(ROOT / "specs/canopen/epos_drive.eds")
    kind = replace(
        kind_of(device), factors=(((0x6064, 0), 0.25),), units=(((0x6064, 0), "rad"),)
    )
    path = tmp_path / "mirror.eds"
    made = mirrored(measured(DevicePorts(device, kind)), path.name)
    path.write_text(eds_text(made), encoding="utf-8")
    position, velocity = (read(path).find(index) for index in (0x6064, 0x606C))
    assert (position.factor, position.unit) == (0.25, "rad")
    assert (velocity.factor, velocity.unit) == (None, "")


def by_place(device: Device) -> dict[tuple[str, int], Pdo]:
    return {(pdo.direction.value, pdo.number): pdo for pdo in device.pdos}


def test_pdos_are_turned(pair: tuple[Device, Device]) -> None:
    device, mirror = pair
    theirs = by_place(mirror)
    assert len(theirs) == len(device.pdos)
    for pdo in device.pdos:
        other = theirs[TURNED[pdo.direction.value], pdo.number]
        assert other.entries == pdo.entries
        assert without_rtr(other) == without_rtr(pdo)
        if pdo.transmission_type not in (252, 253):
            assert other.transmission_type == pdo.transmission_type


def without_rtr(pdo: Pdo) -> object:
    if isinstance(pdo.cob_id, NodeRelative):
        return NodeRelative(pdo.cob_id.offset & ~NO_RTR)
    return None if pdo.cob_id is None else pdo.cob_id & ~NO_RTR


def test_objects_lie_400h_away(pair: tuple[Device, Device]) -> None:
    device, mirror = pair
    known = {thing.index for thing in mirror.objects}
    for thing in device.objects:
        if 0x1400 <= thing.index < 0x1800:
            assert thing.index + SHIFT in known
        elif 0x1800 <= thing.index < 0x1C00:
            assert thing.index - SHIFT in known
    assert (mirror.info.rpdos, mirror.info.tpdos) == (
        device.info.tpdos,
        device.info.rpdos,
    )


def test_what_is_mapped_can_be_mapped(pair: tuple[Device, Device]) -> None:
    _, mirror = pair
    for pdo in mirror.pdos:
        for entry in pdo.entries:
            if entry.dummy:
                continue
            variable = mirror.find(entry.index, entry.subindex)
            assert variable is not None
            access = variable.access
            assert access.in_tpdo if pdo.direction == "tpdo" else access.in_rpdo


def test_the_mirror_of_the_mirror_is_the_device(pair: tuple[Device, Device]) -> None:
    device, mirror = pair
    again = mirrored(mirror, "again.eds")
    names = {thing.index: thing.name for thing in device.objects}
    for thing in again.objects:
        assert thing.name == names[thing.index]


def test_pdos_on_request_and_sync_starts_have_no_mirror() -> None:
    device = read(SAMPLER)

    objects = tuple(
        replace(
            thing,
            variables=tuple(
                replace(v, default=253) if (v.index, v.subindex) == (0x1801, 2) else v
                for v in thing.variables
            ),
        )
        for thing in device.objects
    )
    mirror = mirrored(replace(device, objects=objects), "mirror.eds")
    type_ = mirror.find(0x1401, 2)
    assert type_ is not None
    assert type_.default == 255
    accesses = {v.name: v.access for thing in mirror.objects for v in thing.variables}
    assert accesses["Raw value"] is Access.RWW
    assert accesses["Ticks 56"] is Access.RWR
