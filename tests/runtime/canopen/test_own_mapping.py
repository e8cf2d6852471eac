"""Mappings that a description has itself: of objects that nobody may map, and multiplexed ones."""

from __future__ import annotations

from pathlib import Path

import pytest
from can_nodes import description
from device_bench import Bench
from start_up_runs import problems, problems_of_devices, read
from test_device_pdos import remap
from test_identifiers import ID, SAMPLER, booted, changed_eds, eds, findings

from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.bus import load as load_bus
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.layouts.can_startup import start_up
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


BOARD = Path(__file__).parents[2] / "golden/eds_errors/base.eds"
LONG, FLAG, INPUTS, OUTPUTS = 0x20100040, 0x20110001, 0x60000108, 0x62000108
MORE = """
[2010]
ParameterName=Long
ObjectType=7
DataType=0x1B
AccessType=rw
PDOMapping=1
[2011]
ParameterName=Flag
ObjectType=7
DataType=1
AccessType=rw
PDOMapping=1
"""
IMPOSSIBLE, DOUBTFUL = "EDS0705", "EDS0715"
ODD = {
    # Entries of a TPDO or RPDO; the finding of the description; that of a bus file.
    "two long ones": (0x1800, [LONG, LONG], "EDS0504", IMPOSSIBLE),
    "no object": (0x1800, [0x23450008], "EDS0501", IMPOSSIBLE),
    "no object, received": (0x1400, [0x23450008], "EDS0501", IMPOSSIBLE),
    "not mappable": (0x1800, [0x20000008], "EDS0502", IMPOSSIBLE),
    "not mappable, received": (0x1400, [0x20000008], "EDS0502", IMPOSSIBLE),
    "outputs that are sent": (0x1800, [OUTPUTS], "EDS0505", IMPOSSIBLE),
    "inputs that are received": (0x1400, [INPUTS], "EDS0505", IMPOSSIBLE),
    "an empty entry": (0x1800, [0], "EDS0513", IMPOSSIBLE),
    "no bits": (0x1800, [INPUTS & ~0xFF], "EDS0513", IMPOSSIBLE),
    "a gap that is sent": (0x1800, [0x00050008], "EDS0509", IMPOSSIBLE),
    "another type of gap": (0x1400, [0x00070020], "EDS0509", IMPOSSIBLE),
    "another length of a gap": (0x1400, [0x00050010], "EDS0509", IMPOSSIBLE),
    "more bits than the type": (0x1800, [INPUTS + 8], "EDS0503", DOUBTFUL),
    "a part of an object": (0x1800, [INPUTS - 4], "EDS0503", DOUBTFUL),
    "finer than the granularity": (0x1800, [FLAG], "EDS0511", DOUBTFUL),
    "mapped twice": (0x1800, [INPUTS, INPUTS], "EDS0512", ""),
    "more than there are entries": (0x1800, [INPUTS] * 9, "EDS0506", IMPOSSIBLE),
}


@pytest.mark.sampled(20)
@pytest.mark.parametrize("who", ["own", "own, off", "own, switched on", "bus file"])
@pytest.mark.parametrize("what", ODD)
def test_odd_mappings(what: str, who: str, tmp_path: Path) -> None:
    """What is accepted works with generated devices, and with nodes that enforce CiA 301."""
    index, entries, own, other = ODD[what]
    mapping = index + 0x200
    written = {0: len(entries), **dict(enumerate(entries[:2], 1))}
    defaults: dict[str, str] = {}
    values: dict[str, int] = {}
    if who == "bus file":
        values = {f"{mapping:04X}:{sub}": value for sub, value in written.items()}
    else:
        defaults = {f"{mapping:04X}sub{s}": f"0x{v:X}" for s, v in written.items()}
        if who != "own":
            defaults[f"{index:04X}sub1"] = "0x80000000"
        if who == "own, switched on":
            values = {f"{index:04X}:1": 0x181 if index == 0x1800 else 0x201}
    (tmp_path / "board.eds").write_text(changed_eds(BOARD, defaults) + MORE)
    (tmp_path / "bus.toml").write_text(
        '[bus]\nbit_rate = 500\n[device.board]\neds = "board.eds"\n[node.one]\n'
        'device = "board"\nid = 1\n[device.board.values]\n'
        + "".join(f'"{number}" = {value}\n' for number, value in values.items())
    )
    bus, diagnostics = read(tmp_path / "bus.toml")
    codes = {d.code for d in diagnostics}
    too_long = what == "two long ones" and who != "own, off"
    wanted = {other} if who == "bus file" else {IMPOSSIBLE} if too_long else set()
    assert codes & {IMPOSSIBLE, DOUBTFUL} == wanted - {""}
    assert (own in codes) is (who != "bus file")
    assert (bus is None) is (IMPOSSIBLE in wanted)
    if bus is not None:
        assert not list(problems(bus, diagnostics))
        assert not list(problems_of_devices(bus, diagnostics))
