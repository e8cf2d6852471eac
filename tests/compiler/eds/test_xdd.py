"""Descriptions in XML (CiA 311): how their parts are read, and where they are accepted."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
import seeds
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.compiler.backends.canopen.xdd_text import xdd_text
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.canopen import (
    Access,
    Commissioning,
    DataType,
    Device,
    Variable,
)

ROOT = Path(__file__).parents[3]
SPECS = ROOT / "specs" / "canopen"
TEXT = """<?xml version="1.0"?>
<ISO15745ProfileContainer xmlns="http://www.canopen.org/xml/1.0"
 xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><ISO15745Profile>
<ProfileBody xsi:type="ProfileBody_Device_CANopen" fileVersion="2.1" fileCreationTime="13:05:00Z">
<DeviceIdentity><vendorID>302</vendorID></DeviceIdentity><ApplicationProcess>
<dataTypeList><array name="A" uniqueID="ARR"><UINT/></array>
<struct name="S" uniqueID="REC"><varDeclaration name="n"><USINT/></varDeclaration>
<varDeclaration name="x"><LREAL/></varDeclaration></struct>
<derived name="D" uniqueID="DER"><dataTypeIDRef uniqueIDRef="ENUM"/></derived>
<enum name="E" uniqueID="ENUM"><BYTE/></enum></dataTypeList>
<templateList><parameterTemplate uniqueID="T" access="write"><DINT/></parameterTemplate>
</templateList>
<parameterList><parameter uniqueID="P" {parameter}</parameter>
<parameter uniqueID="PA"><dataTypeIDRef uniqueIDRef="ARR"/></parameter>
<parameter uniqueID="PR"><dataTypeIDRef uniqueIDRef="REC"/></parameter></parameterList>
</ApplicationProcess></ProfileBody></ISO15745Profile><ISO15745Profile>
<ProfileBody xsi:type="ProfileBody_CommunicationNetwork_CANopen">
<ApplicationLayers><CANopenObjectList>
<CANopenObject index="2000" name="V" objectType="7" {attributes}/>
<CANopenObject index="2001" name="A" objectType="8" uniqueIDRef="PA">
<CANopenSubObject subIndex="00" name="n" dataType="05"/><CANopenSubObject subIndex="01" name="1"/>
</CANopenObject>
<CANopenObject index="2002" name="R" objectType="9" uniqueIDRef="PR">
<CANopenSubObject subIndex="00" name="n"/><CANopenSubObject subIndex="01" name="x"/></CANopenObject>
</CANopenObjectList></ApplicationLayers></ProfileBody></ISO15745Profile></ISO15745ProfileContainer>
"""
REFERENCE = 'uniqueIDRef="P"'


def described(folder: Path, parameter: str, attributes: str) -> Device:
    file = folder / "part.xdd"
    file.write_text(TEXT.format(parameter=parameter, attributes=attributes), "utf-8")
    result = load([file], root=folder)
    (device,) = result.model.devices or pytest.fail(str(result.diagnostics))
    return device


def variable(folder: Path, parameter: str, attributes: str = REFERENCE) -> Variable:
    found = described(folder, parameter, attributes).find(0x2000)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("access", "mapping", "expected"),
    [
        ("const", "no", Access.CONST),
        ("read", "TPDO", Access.RO),
        ("write", "RPDO", Access.WO),
        ("readWrite", "optional", Access.RW),
        ("readWrite", "default", Access.RW),
        ("readWrite", "TPDO", Access.RWR),
        ("readWrite", "RPDO", Access.RWW),
        ("readWriteInput", "no", Access.RWR),
        ("readWriteOutput", "RPDO", Access.RWW),
    ],
)
def test_access(access: str, mapping: str, expected: Access, tmp_path: Path) -> None:
    attributes = f'{REFERENCE} PDOmapping="{mapping}"'
    found = variable(tmp_path, f'access="{access}"><USINT/>', attributes)
    assert (found.access, found.pdo_mappable) == (expected, mapping != "no")


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [
        ("><BOOL/>", DataType.BOOLEAN),
        ("><WORD/>", DataType.UNSIGNED16),
        ("><LINT/>", DataType.INTEGER64),
        ("><WSTRING/>", DataType.UNICODE_STRING),
        ("><BITSTRING/>", DataType.DOMAIN),
        ('><BITSTRING/><defaultValue value="AB CD"/>', DataType.OCTET_STRING),
        ('><dataTypeIDRef uniqueIDRef="DER"/>', DataType.UNSIGNED8),
        ('templateIDRef="T">', DataType.INTEGER32),
    ],
)
def test_types(parameter: str, expected: DataType, tmp_path: Path) -> None:
    device = described(tmp_path, parameter, REFERENCE)
    types = [device.find(0x2000), device.find(0x2001, 1), device.find(0x2002, 1)]
    found = [each.data_type for each in types if each is not None]
    assert found == [expected, DataType.UNSIGNED16, DataType.REAL64]


def test_a_template_gives_what_a_parameter_does_not_say(tmp_path: Path) -> None:
    assert variable(tmp_path, 'templateIDRef="T">').access is Access.WO
    own = variable(tmp_path, 'access="read" templateIDRef="T"><UINT/>')
    assert (own.access, own.data_type) == (Access.RO, DataType.UNSIGNED16)


def test_values_of_a_parameter(tmp_path: Path) -> None:
    text = (
        'access="readWrite" multiplier="0.5"><label lang="de">Weg</label>'
        '<description lang="en">How far\n it went</description><UINT/>'
        '<defaultValue value="0x10"/><allowedValues><range><minValue value="1"/>'
        '<maxValue value="99"/></range></allowedValues>'
        '<unit multiplier="1"><label lang="en">mm</label></unit>'
    )
    found = variable(tmp_path, text)
    assert (found.default, found.low, found.high) == (16, 1, 99)
    assert (found.unit, found.factor) == ("mm", 0.5)
    assert found.description == "How far it went"
    attributes = (
        'dataType="0x0006" accessType="rw" lowLimit="2" highLimit="3" defaultValue="2"'
    )
    found = variable(tmp_path, "><UINT/>", attributes)
    assert (found.default, found.low, found.high) == (2, 2, 3)


def test_information(tmp_path: Path) -> None:
    device = described(tmp_path, "><UINT/>", REFERENCE)
    assert device.vendor_id == 302
    assert (device.file_info.version, device.file_info.revision) == (2, 1)
    assert device.file_info.created == ("", "01:05PM")


def test_what_the_schema_requires_is_written_without_a_value(tmp_path: Path) -> None:
    device = described(tmp_path, "><UINT/>", REFERENCE)
    bare = replace(device, commissioning=Commissioning())
    file = tmp_path / "bare.xdc"
    file.write_text(xdd_text(bare), encoding="utf-8")
    text = file.read_text(encoding="utf-8")
    assert (
        'NodeID="0" nodeName="" actualBaudRate="" networkNumber="0" networkName="" '
        'CANopenManager="false"' in text
    )
    assert 'supportedBaudRate value="250 Kbps"' in text
    (again,) = load([file], root=tmp_path).model.devices
    assert again.commissioning == bare.commissioning
    assert again.info == bare.info
    impossible = replace(bare.file_info, created=("13-45-2020", "25:99PM"))
    text = xdd_text(replace(bare, file_info=impossible))
    assert 'fileCreationDate="0001-01-01"' in text
    file.write_text(text, encoding="utf-8")
    (again,) = load([file], root=tmp_path).model.devices
    assert again.file_info.created == impossible.created


@pytest.mark.parametrize("name", ["NodeID", "nodeID"])
def test_a_node_id_has_one_of_two_names(name: str, tmp_path: Path) -> None:
    device = described(tmp_path, "><UINT/>", REFERENCE)
    text = xdd_text(replace(device, commissioning=Commissioning(node_id=7)))
    file = tmp_path / "one.xdc"
    file.write_text(text.replace(" NodeID=", f" {name}="), encoding="utf-8")
    (again,) = load([file], root=tmp_path).model.devices
    assert again.node_id == 7


def test_a_description_in_xml_is_a_source_of_a_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    source = (SPECS / "ftmd.eds").read_bytes()
    Path("ftmd.eds").write_bytes(source)
    assert run(["convert", "ftmd.eds", "-o", "."]) == 0
    Path("ftmd.eds").unlink()
    bus = (SPECS / "fourx.toml").read_text(encoding="utf-8")
    Path("net.toml").write_text(bus.replace("ftmd.eds", "ftmd.xdd"), encoding="utf-8")
    Path("rtgen.toml").write_text(
        '[output]\npackage = "lab"\n[sources]\npaths = ["."]\n'
    )
    assert run(["generate"]) == 0
    assert run(["check"]) == 0
    assert list(Path("generated/lab/canopen/networks").glob("*_timing.txt"))
    assert run(["diff", "ftmd.xdd", str(SPECS / "ftmd.eds")]) == 0


JUNK = (
    "",
    "&#10;",
    "0x",
    "-1",
    "9" * 30,
    "$NODEID",
    "\u00e9",
    "<",
    "00",
    "1e999",
    "&#0;",
)


@pytest.mark.random
@pytest.mark.parametrize("case", seeds.cases(300))
def test_a_damaged_description_is_read_or_its_place_is_named(
    case: int, tmp_path: Path
) -> None:
    draw = random.Random(case)
    text = TEXT.format(parameter="><UINT/>", attributes=REFERENCE)
    for _ in range(draw.randint(1, 5)):
        if draw.random() < 0.7:
            places = list(re.finditer(r'"([^"]*)"|>([^<]*)<', text))
            if not places:
                break
            chosen = draw.choice(places)
            start, end = chosen.span(1 if chosen[1] is not None else 2)
            text = text[:start] + draw.choice(JUNK) + text[end:]
        else:
            start = draw.randrange(len(text))
            text = text[:start] + text[start + draw.randrange(200) :]
    file = tmp_path / "damaged.xdd"
    file.write_text(text, encoding="utf-8")
    result = load([file], root=tmp_path)
    assert all(d.span is not None for d in result.diagnostics)
    assert result.model.devices or result.diagnostics
    for device in result.model.devices:
        file.write_text(xdd_text(device), encoding="utf-8")
        assert load([file], root=tmp_path).model.devices
