"""Mappings that a description configures reach the node, also without a network."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from device_bench import Bench

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.objects_module import objects_module
from rtgen.compiler.frontends import eds
from rtgen.compiler.model.can_bus import kind_of
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.runtime.canopen.description import DeviceDescription, Write
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import Frame

HEAD = """
[DeviceInfo]
VendorName=rtgen
NrOfTXPDO=1
Granularity=8
{commissioning}
[MandatoryObjects]
SupportedObjects=2
1=0x1000
2=0x1001
[OptionalObjects]
SupportedObjects=2
1=0x1800
2=0x1A00
[ManufacturerObjects]
SupportedObjects=2
1=0x2000
2=0x2001
[1000]
ParameterName=Device type
DataType=7
AccessType=ro
[1001]
ParameterName=Error register
DataType=5
AccessType=ro
[2000]
ParameterName=Speed
DataType=3
AccessType=ro
PDOMapping=1
DefaultValue=0x1234
[2001]
ParameterName=Torque
DataType=2
AccessType=ro
PDOMapping=1
DefaultValue=0x56
[1800]
ParameterName=TPDO 1
ObjectType=9
[1800sub0]
ParameterName=Highest
DataType=5
AccessType=const
DefaultValue=2
[1800sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x80000180
ParameterValue=$NODEID+0x180
[1800sub2]
ParameterName=Type
DataType=5
AccessType=rw
DefaultValue=255
ParameterValue=1
"""
COMPACT = """
[1A00]
ParameterName=Mapping
ObjectType=9
DataType=7
AccessType=rw
DefaultValue=0
CompactSubObj=2
[1A00Value]
NrOfEntries=2
1=0x20000010
2=0x20010008
"""
PLAIN = """
[1A00]
ParameterName=Mapping
ObjectType=9
[1A00sub0]
ParameterName=Count
DataType=5
AccessType=rw
DefaultValue=0
ParameterValue=2
[1A00sub1]
ParameterName=First
DataType=7
AccessType=rw
DefaultValue=0
ParameterValue=0x20000010
[1A00sub2]
ParameterName=Second
DataType=7
AccessType=rw
DefaultValue=0
ParameterValue=0x20010008
"""
COMMISSIONING = "[DeviceComissioning]\nNodeID=5\nNodeName=drive\nBaudrate=500"


def made(folder: Path, text: str) -> dict[str, Any]:
    """Return the module `objects` of a description."""
    (folder / "drive.eds").write_text(text, encoding="utf-8")
    (device,) = eds.load([folder / "drive.eds"], root=folder).model.devices
    tables: dict[str, Any] = {"__name__": "drive"}
    options = Options("drives", "", "0")
    module = objects_module("d.py", DevicePorts(device, kind_of(device)), options)
    exec(module.text, tables)
    return tables


@pytest.mark.parametrize("mapping", [COMPACT, PLAIN], ids=["compact", "plain"])
@pytest.mark.parametrize("commissioning", ["", COMMISSIONING], ids=["EDS", "DCF"])
def test_a_node_as_delivered_gets_the_mapping(
    tmp_path: Path, mapping: str, commissioning: str
) -> None:
    tables = made(tmp_path, HEAD.format(commissioning=commissioning) + mapping)
    delivered = HEAD.format(commissioning="") + mapping.partition("[1A00Value]")[0]
    lines = [x for x in delivered.splitlines() if not x.startswith("ParameterValue")]
    plain: DeviceDescription = made(tmp_path, "\n".join(lines))["DESCRIPTION"]
    writes: tuple[Write, ...] = tables["CONFIGURATION"]
    assert [(f"{w.index:04X}:{w.subindex}", w.octets(5).hex()) for w in writes] == [
        ("1800:1", "85010080"),
        ("1800:2", "01"),
        ("1A00:0", "00"),
        ("1A00:1", "10000020"),
        ("1A00:2", "08000120"),
        ("1A00:0", "02"),
        ("1800:1", "85010000"),
    ]
    node = DeviceNode(plain, 5)
    bench = Bench(node)
    for write in writes:
        bench.write(write.index, write.subindex, write.octets(5))
    bench.start()
    assert bench.give(0x80) == [Frame(0x185, b"\x34\x12\x56")]
    known = tables.get("REMAPPED", tables["DESCRIPTION"].pdos)
    assert known[0].mapping == ((0x2000, 0, 16), (0x2001, 0, 8))
    assert known[0].transmission_type == 1


def test_a_description_without_values_configures_nothing(tmp_path: Path) -> None:
    text = HEAD.format(commissioning="") + PLAIN
    lines = [x for x in text.splitlines() if not x.startswith("ParameterValue")]
    tables = made(tmp_path, "\n".join(lines))
    assert not {"CONFIGURATION", "REMAPPED"} & set(tables)


def test_a_value_that_cannot_be_sent_is_left_out(tmp_path: Path) -> None:
    named = "ParameterName=Type\nDataType="
    text = HEAD.format(commissioning="").replace(f"{named}5", f"{named}0x40") + PLAIN
    written = [(w.index, w.subindex) for w in made(tmp_path, text)["CONFIGURATION"]]
    assert (0x1800, 1) in written
    assert (0x1800, 2) not in written
