"""Mappings that a description has itself: of objects that nobody may map, and multiplexed ones."""

from __future__ import annotations

from pathlib import Path

import pytest
from can_nodes import description
from device_bench import Bench
from test_device_pdos import remap
from test_identifiers import ID, SAMPLER, booted, eds, findings

from rtgen.backends.canopen.eds_text import eds_text
from rtgen.diagnostics import has_errors
from rtgen.frontends.bus import load as load_bus
from rtgen.frontends.eds import load
from rtgen.layouts.can_startup import start_up
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.pdo_mapping import entry_of
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import SdoAbort

BYTE = (0x2005, 0, 8)
"""An object that TPDO 2 of the sampler maps."""
BUS = """
[bus]
bit_rate = 500
[device.sampler]
eds = "sampler.eds"
[node.first]
device = "sampler"
id = 5
[device.sampler.values]
"""


def unmappable(folder: Path) -> Path:
    """Return the sampler with an object that it maps, and that has no PDOMapping=1."""
    head, found, rest = SAMPLER.read_text(encoding="utf-8").partition("\n[2005]\n")
    body, end, rest = rest.partition("\n[")
    assert "PDOMapping=1" in body
    body = body.replace("PDOMapping=1", "PDOMapping=0")
    path = folder / "sampler.eds"
    path.write_text(head + found + body + end + rest, encoding="utf-8")
    return path


def test_a_device_takes_the_mapping_of_its_description(tmp_path: Path) -> None:
    path = unmappable(tmp_path)
    assert "EDS0502" in findings(path)
    bench = booted(description(path))
    own = [BYTE, (0x2014, 0, 24), (0x2013, 0, 32)]
    read = [int.from_bytes(bench.read(0x1A01, place), "little") for place in (1, 2, 3)]
    assert read == [entry_of(*entry) for entry in own]
    remap(bench, 0x1801, *own)
    remap(bench, 0x1800, BYTE)
    assert bench.read(0x1A00, 0) == b"\1"


def test_a_device_refuses_other_mappings_of_it(tmp_path: Path) -> None:
    bench = Bench(DeviceNode(description(unmappable(tmp_path)), ID, serial_number=1))
    for index, entry in ((0x1400, BYTE), (0x1800, (0x2005, 0, 16))):
        with pytest.raises(SdoAbort) as caught:
            remap(bench, index, entry)
        assert caught.value.code == sdo.NOT_MAPPABLE


def test_a_bus_file_may_map_what_the_description_maps(tmp_path: Path) -> None:
    unmappable(tmp_path)
    for values, code in (
        ('"1A00:0" = 1\n"1A00:1" = 0x20050008\n', None),
        ('"1600:0" = 1\n"1600:1" = 0x20050008\n', "EDS0705"),
    ):
        (tmp_path / "bus.toml").write_text(BUS + values)
        result = load_bus(tmp_path / "bus.toml", root=tmp_path)
        codes = {d.code for d in result.diagnostics}
        assert has_errors(result.diagnostics) is (code is not None)
        assert code is None or code in codes


@pytest.mark.parametrize("count", ["0xFE", "0xFF"])
def test_a_multiplexed_pdo_keeps_its_number_of_objects(
    count: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1A02sub0": count})
    assert "EDS0515" in findings(path)
    (device,) = load([path], root=tmp_path).model.devices
    [pdo] = [p for p in device.pdos if (p.direction, p.number) == ("tpdo", 3)]
    assert pdo.multiplexed
    assert pdo.entries == ()
    written = tmp_path / "again.eds"
    written.write_text(eds_text(device))
    assert description(written).by_number[0x1A02, 0].default == int(count, 0)
    bench = booted(description(path))
    assert bench.read(0x1A02, 0) == bytes((int(count, 0),))
    bench.node.reset(bench.now)
    assert bench.read(0x1A02, 0) == bytes((int(count, 0),))
    assert 0x380 + ID not in {frame.can_id for frame in bench.sent}
    path.rename(tmp_path / "sampler.eds")
    (tmp_path / "bus.toml").write_text(BUS)
    bus = load_bus(tmp_path / "bus.toml", root=tmp_path).bus
    assert bus is not None
    assert start_up(bus.nodes[0]) == ()
