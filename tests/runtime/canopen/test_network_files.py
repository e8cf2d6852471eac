"""The files of a network: descriptions of nodes, start-up and timing as reports."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.backends.canopen.network_files import configured, network_files
from rtgen.compiler.backends.canopen.objects_module import is_remapped, objects_module
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import eds
from rtgen.compiler.frontends.bus import load
from rtgen.compiler.layouts.can_messages import messages
from rtgen.compiler.layouts.can_startup import concise_dcf, start_up
from rtgen.compiler.layouts.can_timing import response_times
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import Device
from rtgen.compiler.typemap.canopen.ports import DevicePorts

CASE = Path(__file__).parents[2] / "golden/cases/canopen_devices/input/specs"
OPTIONS = Options(package="lab", skeleton_package="mylab", version="0")
KEEPER = """[1F22]
ParameterName=Concise DCF
ObjectType=0x8
SubNumber=3
[1F22sub0]
ParameterName=Highest sub-index supported
DataType=0x0005
AccessType=const
DefaultValue=4
[1F22sub3]
ParameterName=Concise DCF 3
DataType=0x000F
AccessType=rw
[1F22sub4]
ParameterName=Concise DCF 4
DataType=0x000F
AccessType=rw
[2001]"""


@pytest.fixture
def bus(tmp_path: Path) -> Bus:
    """Return the network of the golden case, whose devices can store configurations of others."""
    return changed(tmp_path, "[2001]", KEEPER)


def changed(folder: Path, old: str, new: str) -> Bus:
    """Return the network of the golden case with another text in its files."""
    for path in CASE.iterdir():
        text = path.read_text(encoding="utf-8").replace(old, new)
        (folder / path.name).write_text(text, encoding="utf-8")
    result = load(folder / "bench.toml", root=folder)
    assert not has_errors(result.diagnostics)
    assert result.bus is not None
    return result.bus


def text_of(bus: Bus, name: str) -> str:
    artifacts, findings = network_files([bus], OPTIONS)
    assert not findings
    [artifact] = [a for a in artifacts if a.path.endswith(f"networks/{name}")]
    return artifact.text


def read(text: str, folder: Path) -> Device:
    path = folder / "node.dcf"
    path.write_text(text, encoding="utf-8")
    return eds.load([path], root=folder).model.devices[0]


def test_a_dcf_has_the_place_and_the_values_of_its_node(
    bus: Bus, tmp_path: Path
) -> None:
    device = read(text_of(bus, "bench/first.dcf"), tmp_path)
    commissioning = device.commissioning
    assert commissioning is not None
    assert (
        commissioning.node_id,
        commissioning.node_name,
        commissioning.bit_rate,
        commissioning.network_name,
    ) == (
        *(3, "first", 500),
        "bench",
    )
    assert device.file_info.last_eds == "sampler.eds"
    for index, subindex, value in ((0x1017, 0, 50), (0x2030, 0, "left bench")):
        variable = device.find(index, subindex)
        assert variable is not None
        assert variable.value == value
    assert device.further == (("Maker", (("Colour", "green"),)),)


def test_a_configuration_from_a_dcf_is_that_of_the_bus_file(
    bus: Bus, tmp_path: Path
) -> None:
    """Writing the values of a DCF, in that order, configures the node."""
    for node in bus.nodes:
        device = read(text_of(bus, f"bench/{node.name}.dcf"), tmp_path)
        wanted = {
            (w.variable.index, w.variable.subindex): w.value for w in start_up(node)
        }
        for (index, subindex), value in wanted.items():
            variable = device.find(index, subindex)
            assert variable is not None
            assert variable.value is not None, (hex(index), value)


def test_others_configurations_are_kept_as_concise_dcf(
    bus: Bus, tmp_path: Path
) -> None:
    first, second = bus.nodes
    device = read(eds_text(configured(bus, first)), tmp_path)
    kept = {v.subindex: v.value for v in device.variables if v.index == 0x1F22}
    assert kept == {0: None, 3: None, 4: concise_dcf(start_up(second))}
    device = read(eds_text(configured(bus, second)), tmp_path)
    kept = {v.subindex: v.value for v in device.variables if v.index == 0x1F22}
    assert kept == {0: None, 3: concise_dcf(start_up(first)), 4: None}


def test_the_report_on_start_up_has_every_write_in_order(bus: Bus) -> None:
    text = text_of(bus, "bench_start_up.txt")
    found = re.findall(r"write +([0-9A-F:]+) .*?  ((?:[0-9A-F]{2} ?)+)$", text, re.M)
    wanted = []
    for node in bus.nodes:
        for write in start_up(node):
            subindex = write.variable.subindex
            place = f"{write.variable.index:04X}" + (
                f":{subindex:X}" if subindex else ""
            )
            wanted.append((place, write.value.hex(" ").upper()))
    assert found == wanted


def test_the_report_on_timing_has_every_message(bus: Bus) -> None:
    text = text_of(bus, "bench_timing.txt")
    timings = list(response_times(messages(bus), bus.bit_rate))
    rows = re.findall(r"^([0-9A-F]{3})h +(\S.*?)  +\d .* ([\d.]+)$", text, re.M)
    assert rows == [
        (
            f"{t.message.identifier:03X}",
            t.message.name,
            f"{(t.response or 0) / 1000:g}",
        )
        for t in timings
    ]
    assert "no bound" not in text


def test_values_of_a_kind_remap_its_pdos(tmp_path: Path) -> None:
    values = '[device.sensor.values]\n"1A02:0" = 1\n'
    made = changed(tmp_path, "[device.sensor.values]\n", values)
    tables: dict[str, Any] = {}
    kind = made.kinds[0]
    module = objects_module("d.py", DevicePorts(kind.device, kind), OPTIONS)
    exec(module.text, tables)
    entries = ((0x2011, 1, 48), (0x2041, 0, 16))
    assert tables["DESCRIPTION"].pdo("tpdo", 3).mapping == entries
    [pdo] = [p for p in tables["REMAPPED"] if (p.direction, p.number) == ("tpdo", 3)]
    assert pdo.mapping == entries[:1]
    writes = [(w.index, w.subindex, w.octets(5).hex()) for w in tables["CONFIGURATION"]]
    off, on = (("1802", 1, "85030080"), ("1802", 1, "85030000"))
    assert [(f"{i:04X}", s, v) for i, s, v in writes if i == 0x1802] == [off, on]
    assert [(s, v) for i, s, v in writes if i == 0x1A02] == [
        (0, "00"), (1, "30011120"), (0, "01"),
    ]  # fmt: skip
    assert not is_remapped(made.kinds[1])
