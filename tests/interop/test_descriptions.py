"""Descriptions of devices in the forms of CiA 306 and 311: there and back, and other readers.

`RTGEN_XDD_SCHEMAS` names schemas for XDD and XDC: files, or folders of files of one schema.
"""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from test_eds_writer import FILES, ROOT, content, read

from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.canopen import Device
from rtgen.compiler.typemap.canopen.xdd import NAMESPACES
from rtgen.tools.can.descriptions.conversion import converted_device
from rtgen.tools.kit.console import Console

OWN = [
    *sorted((ROOT / "specs").rglob("*.eds")),
    *sorted((ROOT / "tests" / "interop").rglob("*.eds")),
    *sorted((ROOT / "tests" / "golden" / "cases").rglob("input/**/*.eds")),
]
DESCRIPTIONS = [path for path in OWN if read(path) is not None]
CASES = [
    *(
        pytest.param(path, id=f"{path.parent.parent.name}/{path.name}")
        for path in DESCRIPTIONS
    ),
    *(
        pytest.param(path, id=path.name, marks=pytest.mark.nightly)
        for path in FILES
        if path not in DESCRIPTIONS
    ),
]
XML = {".eds": "xdd", ".dcf": "xdc"}
ADDED = {0x1000, 0x1001, 0x1018, *range(0x1600, 0x1800), *range(0x1A00, 0x1C00)}
"""The objects that a repair may add."""
SCHEMAS = os.environ.get("RTGEN_XDD_SCHEMAS", "").split(os.pathsep)
OF_A_DCF = ("value", "denotation", "upload_file", "download_file")
"""What an EDS leaves out."""


@pytest.fixture(autouse=True)
def _quiet() -> Any:
    logging.disable(logging.CRITICAL)
    yield
    logging.disable(logging.NOTSET)


def converted(path: Path, form: str, folder: Path) -> Path:
    """Write a description in a form, and return its path."""
    result = converted_device(Console("text"), path, form, None)
    return result.write(folder)


def objects(device: Device, configured: bool) -> dict[int, Any]:
    """Return the content of the objects, without configured values if it is an EDS."""
    found = {thing.index: content(thing) for thing in device.objects}
    for thing in found.values() if not configured else ():
        thing["denotation"] = None
        for variable in thing["variables"]:
            variable.update(dict.fromkeys(OF_A_DCF))
    return found


def device_of(path: Path) -> Device:
    device: Device | None = read(path)
    if device is None:
        pytest.skip("a file with errors gives no device")
    return device


@pytest.mark.sampled(2)
@pytest.mark.parametrize("path", CASES)
def test_an_eds_comes_back_from_xml(path: Path, tmp_path: Path) -> None:
    is_configured = path.suffix.lower() == ".dcf"
    source = objects(device_of(path), is_configured)
    in_xml = converted(path, XML[path.suffix.lower()], tmp_path / "xml")
    back = converted(in_xml, path.suffix.lower()[1:], tmp_path / "back")
    same = converted(path, path.suffix.lower()[1:], tmp_path / "same")
    for each in (in_xml, back, same):
        found = objects(device_of(each), is_configured)
        added = set(found) - set(source)
        assert added <= ADDED
        for index, thing in source.items():
            if index != 0x1018:  # a vendor number is added
                assert found[index] == thing, f"{index:04X}h in {each}"
    first, second = (p.read_text(encoding="utf-8").split("\n", 1) for p in (back, same))
    assert first[1] == second[1]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("path", CASES)
def test_the_package_canopen_reads_what_is_converted(
    path: Path, tmp_path: Path
) -> None:
    canopen = pytest.importorskip("canopen", reason="the package canopen is missing")
    device_of(path)
    file = converted(path, path.suffix.lower()[1:], tmp_path)
    theirs = canopen.import_od(str(file), 5)
    described = {o.index for o in device_of(file).objects if o.variables}
    assert described == {i for i in theirs if i >= 0x1000}


@pytest.mark.peer
@pytest.mark.sampled(2)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("path", CASES)
def test_dcfgen_reads_what_is_converted(path: Path, tmp_path: Path) -> None:
    import dcf

    device_of(path)
    file = converted(path, path.suffix.lower()[1:], tmp_path)
    device = dcf.Device.from_dcf(str(file), {"NODEID": 5})
    ours = load([file], root=tmp_path, node_id=5).model.devices[0]
    assert set(device) == {o.index for o in ours.objects if o.variables}


def schema_of(path: Path) -> tuple[etree.XMLSchema, bool]:
    """Return a schema, and whether it has CiA 311's `nodeID`, which CANopenEditor calls NodeID."""
    files = sorted(path.glob("*.xsd")) if path.is_dir() else [path]
    places = "".join(f'<include schemaLocation="{f.resolve()}"/>' for f in files)
    start = f'<schema xmlns="http://www.w3.org/2001/XMLSchema" targetNamespace="{NAMESPACES[0]}">'
    schema = etree.XMLSchema(etree.fromstring(f"{start}{places}</schema>"))
    return schema, any('"nodeID"' in f.read_text(encoding="utf-8") for f in files)


@pytest.mark.peer
def test_schemas_accept_what_is_converted(tmp_path: Path) -> None:
    if SCHEMAS == [""]:
        pytest.skip(
            "RTGEN_XDD_SCHEMAS names no schema of XDD files: CANopenEditor's, CiA 311's"
        )
    schemas = [schema_of(Path(each)) for each in SCHEMAS]
    refused = []
    for number, path in enumerate({*DESCRIPTIONS, *FILES}):
        if read(path) is None:
            continue
        for form in XML.values():
            text = converted(path, form, tmp_path / str(number)).read_bytes()
            for schema, is_camel in schemas:
                name = b" nodeID=" if is_camel else b" NodeID="
                tree = etree.fromstring(text.replace(b" NodeID=", name))
                if not schema.validate(tree):
                    refused.append(f"{path.name} as {form}: {schema.error_log}")
                (listed,) = tree.iter("{*}CANopenObjectList")
                listed[0].set("objectType", "many")
                assert not schema.validate(tree)
    assert refused == []
