"""Devices: compact and modular forms, DCF, PDOs, and how they are shown."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.inspection.models import inspect, tree
from rtgen.compiler.model.canopen import (
    Access,
    DataType,
    Device,
    NodeRelative,
    ObjectType,
    PdoEntry,
)
from rtgen.compiler.typemap.canopen.names import module_name

BASE = Path(__file__).parents[2] / "golden/eds_errors/base.eds"


def device(
    folder: Path, text: str, name: str = "a.eds", node: int | None = None
) -> Device:
    """Return the device of a text without errors."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    result = load([path], root=folder, node_id=node)
    assert not has_errors(result.diagnostics), result.diagnostics
    [found] = result.model.devices
    return found


def test_keys_and_sections_in_any_case(tmp_path: Path) -> None:
    text = "[DEVICEINFO]\nnrofrxpdo=0\nBAUDRATE_100=1\nBaudrate_500=1\n[2a0f]\n"
    text += "parametername=Speed\nDATATYPE=5\naccesstype=RW\n[2B00]\nParameterName=B\n"
    text += "ObjectType=9\n[2b00SUBa]\nParameterName=C\nDataType=7\nAccessType=Const\n"
    found = device(tmp_path, text)
    assert [(v.index, v.subindex, v.access) for v in found.variables] == [
        (0x2A0F, 0, Access.RW),
        (0x2B00, 10, Access.CONST),
    ]
    assert found.info.bit_rates == (100, 500)
    assert found.info.rpdos == 0


def test_compact_sub_objects(tmp_path: Path) -> None:
    text = """[2000]
ParameterName=Valve
ObjectType=0x8
DataType=0x0006
AccessType=rw
DefaultValue=7
HighLimit=9
PDOMapping=1
CompactSubObj=3

[2000sub3]
ParameterName=Main valve
DataType=0x0006
AccessType=ro

[2000Name]
NrOfEntries=1
2=Second valve

[2000Value]
NrOfEntries=2
2=8
3=0x0A

[2000Denotation]
NrOfEntries=1
1=inlet
"""
    found = device(tmp_path, text, "a.dcf")
    first, one, two, three = found.objects[0].variables
    assert (first.data_type, first.access, first.default) == (
        DataType.UNSIGNED8,
        Access.RO,
        3,
    )
    assert (one.name, one.current, one.denotation) == ("Valve1", 7, "inlet")
    assert (two.name, two.default, two.value, two.current) == ("Second valve", 7, 8, 8)
    assert (three.name, three.access, three.current) == ("Main valve", Access.RO, 10)
    assert two.pdo_mappable
    assert two.high == 9
    assert not three.pdo_mappable


def test_mapping_of_a_compact_record(tmp_path: Path) -> None:
    """The mapping as one generator of master DCFs writes it."""
    text = BASE.read_text(encoding="ascii")
    start, end = text.index("[1A00]"), text.index("[2000]")
    compact = """[1A00]
ParameterName=TPDO mapping parameter
ObjectType=0x09
DataType=0x0007
AccessType=rw
CompactSubObj=1

[1A00Value]
NrOfEntries=1
1=0x60000108

"""
    text = text[:start] + compact + text[end:]
    found = device(tmp_path, text + "[DeviceComissioning]\nNodeID=0x0C\n", "a.dcf")
    assert found.pdos[0].entries == (PdoEntry(0x6000, 1, 8),)
    assert found.pdos[0].default_entries == ()
    assert found.node_id == 12


@pytest.mark.parametrize(
    ("section", "index", "subindex", "expected"),
    [
        ("1000", 0x1000, 0, DataType.UNSIGNED32),
        ("1008", 0x1008, 0, DataType.VISIBLE_STRING),
        ("1017", 0x1017, 0, DataType.UNSIGNED16),
        ("1200sub1", 0x1200, 1, DataType.UNSIGNED32),
        ("1280sub3", 0x1280, 3, DataType.UNSIGNED8),
        ("1400sub2", 0x1400, 2, DataType.UNSIGNED8),
        ("1805sub5", 0x1805, 5, DataType.UNSIGNED16),
        ("1A00sub1", 0x1A00, 1, DataType.UNSIGNED32),
    ],
)
def test_communication_objects_without_a_type(
    tmp_path: Path, section: str, index: int, subindex: int, expected: DataType
) -> None:
    """They have the types of CiA 301."""
    text = f"[{section}]\nParameterName=A\nAccessType=rw\n"
    if subindex:
        text = f"[{section[:4]}]\nParameterName=R\nObjectType=9\n" + text
    found = {(v.index, v.subindex): v for v in device(tmp_path, text).variables}
    assert found[index, subindex].data_type is expected


def test_pdos_of_the_file_and_of_its_values(tmp_path: Path) -> None:
    text = BASE.read_text(encoding="ascii")
    found = device(tmp_path, text, node=5)
    tpdo, rpdo = found.pdos
    assert tpdo.cob_id == NodeRelative(0x40000180)
    assert tpdo.valid
    assert rpdo.entries == (PdoEntry(0x6200, 1, 8), PdoEntry(5, 0, 8))
    assert [e.dummy for e in rpdo.entries] == [False, True]
    configured = text.replace(
        "DefaultValue=$NODEID+0x200",
        "DefaultValue=$NODEID+0x200\nParameterValue=0x80000201",
    )
    configured = configured.replace(
        "DefaultValue=2\n\n[1600sub1]", "ParameterValue=1\n\n[1600sub1]"
    )
    rpdo = device(tmp_path, configured, "b.dcf").pdos[1]
    assert rpdo.cob_id == 0x80000201
    assert not rpdo.valid
    assert rpdo.entries == (PdoEntry(0x6200, 1, 8),)
    assert rpdo.default_entries == ()


def test_implied_pdos(tmp_path: Path) -> None:
    text = BASE.read_text(encoding="ascii")
    text = text.replace("NrOfTXPDO=1", "NrOfTXPDO=6\nCompactPDO=0x13")
    found = device(tmp_path, text)
    tpdos = [p for p in found.pdos if p.direction == "tpdo"]
    assert [p.number for p in tpdos] == [1, 2, 3, 4, 5, 6]
    assert [p.cob_id for p in tpdos[1:5]] == [
        NodeRelative(0x280),
        NodeRelative(0x380),
        NodeRelative(0x480),
        1 << 31,
    ]
    assert {v.subindex for v in found.variables if v.index == 0x1801} == {0, 1, 2, 5}
    assert sum(v.index == 0x1A05 for v in found.variables) == 65
    assert not tpdos[4].valid


def test_modules(tmp_path: Path) -> None:
    text = BASE.read_text(encoding="ascii") + """
[SupportedModules]
NrOfEntries=2
[M1ModuleInfo]
ProductName=Eight inputs
OrderCode=IN-8
[M1SubExt6000]
ParameterName=Inputs
ObjectType=7
DataType=0x0005
AccessType=ro
PDOMapping=1
Count=2
[M2ModuleInfo]
ProductName=Drive
[M2FixedObjects]
NrOfEntries=1
1=0x6040
[M2Fixed6040]
ParameterName=Controlword
ObjectType=7
DataType=6
AccessType=rw
[ConnectedModules]
NrOfEntries=3
1=1
2=2
3=1
[DeviceComissioning]
NodeID=3
"""
    found = device(tmp_path, text, "a.dcf")
    assert [(m.number, m.product_name, m.order_code) for m in found.modules] == [
        (1, "Eight inputs", "IN-8"),
        (2, "Drive", ""),
    ]
    assert found.connected == (1, 2, 1)
    inputs = [v for v in found.variables if v.index == 0x6000]
    assert [v.subindex for v in inputs] == [0, 1, 2, 3, 4, 5]
    assert inputs[0].default == 5
    assert found.find(0x6040) is not None


def test_ranges_of_an_editor(tmp_path: Path) -> None:
    text = """[2000]
ParameterName=Speed
DataType=0x00A0
AccessType=rw
DefaultValue=-2
[A0]
ParameterName=Range
ObjectType=9
[A0sub1]
ParameterName=Type
DataType=5
AccessType=ro
DefaultValue=0x02
"""
    found = device(tmp_path, text)
    assert found.find(0x2000).data_type is DataType.INTEGER8  # type: ignore[union-attr]
    assert found.find(0x2000).default == -2  # type: ignore[union-attr]
    assert [o.index for o in found.objects] == [0x2000]


def test_commissioning_and_what_else_a_dcf_tells(tmp_path: Path) -> None:
    text = """[FileInfo]
LastEDS=drive.eds
[DeviceComissioning]
NodeID=0x05
NodeName=left drive
Baudrate=0x1F4
NetNumber=1
CANopenManager=0
LSS_SerialNumber=0x12
[2000]
ParameterName=Program
ObjectType=2
DataType=0x000F
AccessType=rw
UploadFile=up.bin
DownloadFile=down.bin
ObjFlags=3
[2000ObjectLinks]
ObjectLinks=1
1=0x2001
[Comments]
Lines=2
Line1=One
Line2=Two
[Own]
Key=Value
"""
    found = device(tmp_path, text, "a.DCF")
    commissioning = found.commissioning
    assert commissioning is not None
    assert (
        commissioning.node_id,
        commissioning.bit_rate,
        commissioning.serial_number,
    ) == (5, 500, 18)
    assert found.objects[0].type is ObjectType.DOMAIN
    assert found.objects[0].links == (0x2001,)
    [variable] = found.variables
    assert (variable.upload_file, variable.download_file) == ("up.bin", "down.bin")
    assert variable.flags == 3
    assert found.comments == "One\nTwo"
    assert found.file_info.last_eds == "drive.eds"
    assert found.further == (("Own", (("Key", "Value"),)),)


@pytest.mark.parametrize(
    ("data", "name"),
    [
        ("[2000]\nParameterName=Größe\n".encode("cp1252"), "Größe"),
        ("[2000]\nParameterName=Größe\n".encode(), "Größe"),
        ("[2000]\nParameterName=Größe\n".encode("utf-8-sig"), "Größe"),
        ("[2000]\r\nParameterName=Gr\r\n".encode("utf-16"), "Gr"),
        (b"[2000]\rParameterName=A \x81\r", "A \x81"),
    ],
)
def test_encodings(tmp_path: Path, data: bytes, name: str) -> None:
    path = tmp_path / "a.eds"
    rest = b"DataType=5\nAccessType=ro\n"
    text = data + (
        rest.decode().encode("utf-16-le") if data[:2] == b"\xff\xfe" else rest
    )
    path.write_bytes(text)
    result = load([path], root=tmp_path)
    [found] = result.model.devices
    assert found.objects[0].name == name
    assert "EDS0005" in [d.code for d in result.diagnostics]


def test_inspect_as_json(monkeypatch: pytest.MonkeyPatch, update_golden: bool) -> None:
    folder = BASE.parent
    monkeypatch.chdir(folder)
    expected = Path(__file__).with_name("base.json")
    for node, key in ((None, "without"), (5, "node 5")):
        result = load([Path("base.eds")], root=folder, node_id=node)
        shown = inspect(result.model, result.diagnostics)
        if update_golden:
            kept = json.loads(expected.read_text()) if expected.exists() else {}
            expected.write_text(json.dumps(kept | {key: shown}, indent=1) + "\n")
        assert shown == json.loads(expected.read_text())[key]


def test_inspect_for_people(tmp_path: Path) -> None:
    path = tmp_path / "left-drive.eds"
    name = b"ParameterName=Speed\n"
    path.write_bytes(BASE.read_bytes().replace(name, name + b"Factor=0.1\nUnit=rpm\n"))
    lines = tree(load([path], root=tmp_path).model).splitlines()
    assert lines[0] == path.as_posix()
    assert "  device LeftDrive" in lines
    assert "    tpdo 1: COB-ID $NODEID+0x40000180, transmission type 255" in lines
    assert "      0: UNSIGNED8 rw Speed = 12 times 0.1 [rpm]" in lines


def test_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "drive.eds").write_bytes(BASE.read_bytes())
    (tmp_path / "types.idl").write_text("struct S { long a; };\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))

    def shown(*arguments: str) -> Any:
        assert run(["inspect", "--json", *arguments]) == 0
        return json.loads(capfd.readouterr().out)

    for _ in range(2):
        assert shown(".")["files"] == ["types.idl", "drive.eds"]
    [plain] = shown("drive.eds")["declarations"]
    [resolved] = shown("--node-id", "5", "drive.eds")["declarations"]
    assert plain["pdos"][0]["cob_id"] == "$NODEID+0x40000180"
    assert resolved["pdos"][0]["cob_id"] == 0x40000185
    assert run(["inspect", "--node-id", "128", "drive.eds"]) == 2
    (tmp_path / "drive.eds").write_text("[2000]\nParameterName=Speed\n")
    assert run(["inspect", "drive.eds"]) == 2
    assert "EDS0304" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("motor-core_unit", "MotorCoreUnit"),
        ("605.3150 drive", "Device6053150Drive"),
        ("Gerät", "Gerat"),
        ("EPOS2", "EPOS2"),
        ("", "Device"),
        ("漢字", "Device"),
    ],
)
def test_module_names(stem: str, name: str) -> None:
    assert module_name(stem) == name


@pytest.mark.parametrize(
    ("name", "text", "hint"),
    [
        ("drive.eds", "<ISO15745ProfileContainer/>\n", "call an XDD (CiA 311) *.xdd"),
        ("drive.xdd", "[FileInfo]\nFileName=drive.eds\n", "call it *.eds or *.dcf"),
        ("drive.xpd", "<ISO15745ProfileContainer/>\n", "call that of a device *.xdd"),
    ],
)
def test_a_description_under_the_name_of_the_other_form(
    name: str,
    text: str,
    hint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(text, encoding="utf-8")
    assert run(["inspect", name]) == 2
    assert hint in capfd.readouterr().err


def test_many_objects_that_are_written_out(tmp_path: Path) -> None:
    head = "[FileInfo]\nFileName=a.eds\n[DeviceInfo]\n[1000]\nParameterName=T\nDataType=7\n"
    one = "[{:X}]\nParameterName=Object\nDataType=7\nAccessType=rw\n"
    path = tmp_path / "a.eds"
    path.write_text(head + "".join(one.format(0x2000 + n) for n in range(16_000)))
    result = load([path], root=tmp_path)
    [device] = result.model.devices
    assert len(device.objects) == 16_001
