"""Written EDS and DCF files, read back by rtgen and by the `canopen` package."""

from __future__ import annotations

import logging
import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from rtgen.compiler.backends.canopen.eds_text import eds_text, value_text
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.canopen import DataType, Device, Variable, resolved
from rtgen.compiler.typemap.canopen.values import object_value
from rtgen.runtime.canopen.values import encode

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT.parent / "shared" / "golden" / "eds"
FILES = [
    *sorted((ROOT / "specs").rglob("*.eds")),
    *sorted(p for p in GOLDEN.glob("*") if p.suffix.lower() in (".eds", ".dcf")),
]

canopen = pytest.importorskip("canopen", reason="the package canopen is not installed")

NODE = 5
"""The node-id for the comparison of values."""

_PLACES = {"span", "value_span", "written_access"}
_OF_THE_FILE = {"file", "key", "sha256", "modules", "connected"}


def read(path: Path, node_id: int | None = None) -> Device | None:
    """Return the device of a file, None if the file has errors."""
    result = load([path], root=path.parent, node_id=node_id)
    if has_errors(result.diagnostics):
        return None
    return result.model.devices[0]


def content(thing: Any) -> Any:
    """Return the content of a part of the model, without positions."""
    if isinstance(thing, tuple):
        return tuple(map(content, thing))
    if not isinstance(thing, msgspec.Struct):
        return repr(thing)
    left_out = _PLACES | (_OF_THE_FILE if isinstance(thing, Device) else set())
    return {
        name: content(getattr(thing, name))
        for name in thing.__struct_fields__
        if name not in left_out
    }


def of_variables(device: Device) -> Iterator[tuple[int, int]]:
    for variable in device.variables:
        yield variable.index, variable.subindex


@pytest.mark.sampled(4)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_what_is_written_reads_back_equal(path: Path, tmp_path: Path) -> None:
    device = read(path)
    if device is None:
        pytest.skip("a file with errors gives no device")
    again = tmp_path / path.name
    again.write_text(eds_text(device, ["A comment."]), encoding="utf-8")
    copy = read(again)
    assert copy is not None
    assert content(copy) == content(device)
    assert eds_text(copy, ["A comment."]) == again.read_text(encoding="utf-8")


@pytest.mark.sampled(4)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_canopen_package_reads_what_is_written(path: Path, tmp_path: Path) -> None:
    device = read(path, NODE)
    if device is None:
        pytest.skip("a file with errors gives no device")
    again = tmp_path / path.name
    again.write_text(eds_text(device), encoding="utf-8")
    logging.disable(logging.CRITICAL)
    try:
        dictionary = canopen.import_od(str(again), NODE)
    finally:
        logging.disable(logging.NOTSET)
    theirs = {
        (v.index, v.subindex): v
        for thing in dictionary.values()
        for v in getattr(thing, "subindices", {0: thing}).values()
        if v.index >= 0x1000
    }
    assert set(theirs) == set(of_variables(device))
    for variable in device.variables:
        same(variable, theirs[variable.index, variable.subindex])


def same(ours: Variable, theirs: Any) -> None:
    """Check that the package has the same name, type, access and mapping."""
    place = (ours.index, ours.subindex)
    assert theirs.name == ours.name.partition(" ;")[0], place
    assert theirs.access_type == ours.access.value, place
    assert theirs.pdo_mappable == ours.pdo_mappable, place
    if int(ours.data_type) > 0x1B:
        return
    assert theirs.data_type == ours.data_type, place
    for mine, other in ((ours.default, theirs.default), (ours.value, theirs.value)):
        value = resolved(mine, NODE)
        if isinstance(value, str):
            value = value.partition(" ;")[0]
        not_finite = isinstance(value, float) and not math.isfinite(value)
        assert other == (None if not_finite else value), place


REAL = """[FileInfo]
FileName=real.eds
[DeviceInfo]
ProductName=Real
[MandatoryObjects]
SupportedObjects=0
[ManufacturerObjects]
SupportedObjects=1
1=0x2000
[2000]
ParameterName=Gain
ObjectType=0x7
DataType=0x0008
AccessType=rw
DefaultValue={text}
"""


@pytest.mark.parametrize("text", ["12.345", "-0.1", "3.4028235e+38", "1e-45", "7"])
def test_a_decimal_of_a_real32_keeps_its_bits(text: str, tmp_path: Path) -> None:
    """From a default of an EDS to the octets on the wire, and to a DCF that is read again."""
    file = tmp_path / "real.eds"
    for _ in range(2):
        file.write_text(REAL.format(text=text), encoding="ascii")
        device = load([file], root=tmp_path).model.devices[0]
        variable = device.find(0x2000, 0)
        assert variable is not None
        value = object_value(variable.data_type, variable.default)
        assert isinstance(value, float)
        assert encode("r32", value) == struct.pack("<f", float(text))
        written = value_text(variable.default, variable.data_type)
        assert written is not None
        text = written


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (12.0, "12"),
        (-3.0, "-3"),
        (12.345, "12.345"),
        (0.0, "0"),
        (-0.0, "-0.0"),
        (1e300, "1e+300"),
    ],
)
def test_whole_reals_are_whole_numbers(value: float, text: str) -> None:
    """Lely's checker accepts no others; the `canopen` package reads decimals only."""
    assert value_text(value, DataType.REAL64) == text
    assert struct.pack("<d", float(text)) == struct.pack("<d", value)
