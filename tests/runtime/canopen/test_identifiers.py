"""Identifiers that a description does not state, or that its services cannot have.

The generated device, its proxy and `rtgen can` agree; only NMT commands stand on 000h.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pytest
from can_nodes import description
from conformance_nodes import report_of
from device_bench import Bench

from rtgen.compiler.frontends.eds import load
from rtgen.runtime.canopen.description import DeviceDescription
from rtgen.runtime.canopen.master.proxied_node import wiring
from rtgen.runtime.canopen.master.proxy_location import cob_ids
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.tools.can.decoding.decoder import Decoder
from rtgen.tools.can.decoding.node_index import read_node_index
from rtgen.tools.conformance.report import as_text

ID = 5
SAMPLER = (
    Path(__file__).parents[2] / "golden/cases/canopen_devices/input/specs/sampler.eds"
)
MISSING = ""
UNREADABLE = "CAN-ID: 80h + Node-ID"
SILENT = [MISSING, "0", "0x0", "0x00000000", UNREADABLE, "none"]


def variable(section: str, value: str, type_: int = 7, access: str = "rw") -> str:
    type_ = 5 if section == "1019" else type_
    text = (
        f"\n[{section}]\nParameterName=Object {section}\nObjectType=7\n"
        f"DataType={type_}\nAccessType={access}\nPDOMapping=0\n"
    )
    return text + (f"DefaultValue={value}\n" if value else "")


def changed_eds(path: Path, values: dict[str, str]) -> str:
    """Return a description with other defaults, and with objects that it does not have."""
    text = path.read_text(encoding="utf-8")
    for section, value in values.items():
        entry = f"DefaultValue={value}\n" if value else ""
        head, found, rest = text.partition(f"\n[{section}]\n")
        if not found:
            text += variable(section, value)
            continue
        body, end, rest = rest.partition("\n[")
        body = re.sub("(?m)^DefaultValue=.*\n?", entry, f"{body}\n", count=1)
        text = head + found + body + end + rest
    return text


def eds(folder: Path, values: dict[str, str]) -> Path:
    """Return the sampler with other defaults, and with objects that it does not have."""
    path = folder / f"sampler{len(list(folder.iterdir()))}.eds"
    path.write_text(changed_eds(SAMPLER, values), encoding="utf-8")
    return path


def device(path: Path) -> DeviceDescription:
    return description(path)


def booted(described: DeviceDescription) -> Bench:
    bench = Bench(DeviceNode(described, ID, serial_number=1))
    bench.command(NmtCommand.START)
    return bench


def findings(path: Path) -> list[str]:
    return [d.code for d in load([path], root=path.parent).diagnostics]


@pytest.mark.parametrize("stated", [*SILENT, "0x80"])
def test_emergencies_are_sent_on_the_predefined_identifier(
    stated: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1014": stated})
    described = device(path)
    bench = booted(described)
    bench.node.add_error(0x1001)
    [frame] = bench.note(bench.node.flush(bench.now))
    assert frame.can_id == 0x80 + ID
    assert bench.read(0x1014, 0) == (0x80 + ID).to_bytes(4, "little")
    assert cob_ids(described, ID, None, None)[1].value == 0x80 + ID
    assert {"EDS0408", "EDS0514"} & set(findings(path))
    decoder = Decoder(read_node_index(None, [(ID, path)]))
    assert decoder.decode(frame).kind == "emcy"
    assert decoder.decode(Frame(0, b"\x01\x10")).kind == "nmt"


@pytest.mark.parametrize("stated", ["0x1", "0x10", "0x7F", "0x585", "0x701", "0x2000"])
def test_an_identifier_of_other_services_switches_emergencies_off(
    stated: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1014": stated})
    described = device(path)
    bench = booted(described)
    bench.node.add_error(0x1001)
    assert bench.note(bench.node.flush(bench.now)) == []
    assert not cob_ids(described, ID, None, None)[1].valid
    assert "EDS0408" in findings(path)
    decoder = Decoder(read_node_index(None, [(ID, path)]))
    assert decoder.decode(Frame(0, bytes(2))).kind == "nmt"


@pytest.mark.parametrize("stated", SILENT)
def test_sync_is_heard_on_the_predefined_identifier(
    stated: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1005": stated, "1800sub2": "1"})
    described = device(path)
    bench = booted(described)
    sent = bench.give(0x80)
    assert 0x180 + ID in ids(sent)
    assert cob_ids(described, ID, None, None)[0].value == 0x80
    assert "EDS0408" in findings(path)
    decoder = Decoder(read_node_index(None, [(ID, path)]))
    assert decoder.decode(Frame(0x80)).kind == "sync"
    assert decoder.decode(Frame(0, bytes(2))).kind == "nmt"


@pytest.mark.parametrize("stated", ["0x1", "0x105", "0x40000005", "0x7FF"])
def test_a_device_without_sync_takes_nothing_for_it(
    stated: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1005": stated, "1006": "1000", "1800sub2": "1"})
    bench = booted(device(path))
    for can_id in set(range(1, 0x800)) - {0x600 + ID}:
        assert 0x180 + ID not in ids(bench.give(can_id))
    bench.now = 10**9
    assert not [i for i in ids(bench.node.poll(bench.now)) if i < 0x80]
    assert "EDS0408" in findings(path)


@pytest.mark.parametrize("stated", ["0x80000000", "0x80000102", "0xC0000000"])
def test_nmt_commands_are_no_time(stated: str, tmp_path: Path) -> None:
    bench = booted(device(eds(tmp_path, {"1012": stated})))
    times: list[int] = []
    bench.node.events.time = times.append
    bench.give(0, bytes(6))
    assert times == []
    bench.give(0x100, bytes(6))
    assert len(times) == (0 if "102" in stated else 1)


@pytest.mark.parametrize("stated", SILENT)
def test_the_first_four_pdos_have_predefined_identifiers(
    stated: str, tmp_path: Path
) -> None:
    sections = ("1400sub1", "1401sub1", "1800sub1", "1801sub1", "1803sub1")
    path = eds(tmp_path, dict.fromkeys(sections, stated))
    described = device(path)
    wanted = {
        ("rpdo", 1): 0x200 + ID,
        ("rpdo", 2): 0x300 + ID,
        ("tpdo", 1): 0x180 + ID,
        ("tpdo", 2): 0x280 + ID,
        ("tpdo", 4): 0x480 + ID,
    }
    found = {(p.direction, p.number): p.cob_id_of(ID) for p in described.pdos}
    assert {key: found[key] for key in wanted} == wanted
    bench = booted(described)
    for (direction, number), cob_id in wanted.items():
        base = 0x1400 if direction == "rpdo" else 0x1800
        read = bench.read(base + number - 1, 1)
        assert read == cob_id.to_bytes(4, "little")
    wired = wiring(described, ID)
    assert {1, 2} <= set(wired.sent)
    assert {1, 2, 4} <= set(wired.received)
    assert findings(path).count("EDS0507") == len(sections)
    decoder = Decoder(read_node_index(None, [(ID, path)]))
    assert decoder.decode(Frame(0x280 + ID, bytes(8))).kind == "tpdo2"


def test_bare_function_codes_stand_for_the_predefined_identifiers(
    tmp_path: Path,
) -> None:
    values = {"1400sub1": "0x200", "1801sub1": "0x280", "1803sub1": "0x40000480"}
    path = eds(tmp_path, values)
    assert findings(path).count("EDS0514") == len(values)
    described = device(path)
    assert described.pdo("rpdo", 1).cob_id_of(ID) == 0x200 + ID
    assert described.pdo("tpdo", 2).cob_id_of(ID) == 0x280 + ID
    assert described.pdo("tpdo", 4).cob_id_of(ID) == 0x40000480 + ID


@pytest.mark.parametrize("stated", ["0x1", "0x17F", "0x585", "0x605", "0x6E0", "0x77F"])
def test_a_pdo_on_an_identifier_of_other_services_is_off(
    stated: str, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"1400sub1": stated, "1800sub1": stated})
    described = device(path)
    bench = booted(described)
    assert not [f for f in bench.sent if f.can_id == int(stated, 16)]
    wired = wiring(described, ID)
    assert 1 not in wired.sent
    assert 1 not in wired.received
    assert findings(path).count("EDS0507") == 2


def ids(frames: Iterable[Frame]) -> list[int]:
    return [frame.can_id for frame in frames]


def test_whatever_the_application_sets_nothing_stands_on_000(tmp_path: Path) -> None:
    """Not even values that a master could not write."""
    path = eds(tmp_path, {"1005": "0x80", "1006": "0", "1014": "$NODEID+0x80"})
    bench = booted(device(path))
    for index, sub in ((0x1005, 0), (0x1014, 0), (0x1800, 1), (0x1801, 1)):
        for value in (0, 0x40000000, 0x10):
            bench.node.set(index, sub, value)
            bench.note(bench.node.flush(bench.now))
    bench.node.set(0x1006, 0, 1000)
    bench.note(bench.node.flush(bench.now))
    bench.node.add_error(0x1001)
    bench.note(bench.node.flush(bench.now))
    for _ in range(20):
        bench.now += 10**9
        bench.note(bench.node.poll(bench.now))
    assert {f.can_id for f in bench.sent if f.can_id < 0x80} == set()


@pytest.mark.parametrize(
    ("limits", "wanted"),
    [
        ("LowLimit=10\nHighLimit=100\n", 10),
        ("LowLimit=-100\nHighLimit=-7\n", -7),
        ("LowLimit=-5\nHighLimit=5\n", 0),
        ("LowLimit=3\n", 3),
        ("HighLimit=-3\n", -3),
    ],
)
def test_objects_without_a_default_begin_within_their_limits(
    limits: str, wanted: int, tmp_path: Path
) -> None:
    path = eds(tmp_path, {"2F00": ""})
    text = path.read_text().replace("DataType=7\nAccessType=rw\nPDOMapping=0\n", "", 1)
    kind = "DataType=3\nAccessType=rw\nPDOMapping=0\n"
    path.write_text(text + kind + limits)
    bench = booted(device(path))
    assert bench.node.get(0x2F00) == wanted
    bench.node.reset(bench.now)
    assert bench.node.get(0x2F00) == wanted


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "values",
    [
        {"1005": "0", "1014": "0"},
        {"1005": MISSING, "1014": UNREADABLE, "1012": "0x80000000"},
        {"1005": "0x90", "1019": "10", "1014": "0x6A0"},
        {"1800sub1": MISSING, "1400sub1": "0x200", "1801sub1": "0x40000000"},
        {"1800sub1": "0x585", "1400sub1": "0x10"},
    ],
)
def test_our_own_nodes_conform_whatever_their_identifiers_are(
    values: dict[str, str], tmp_path: Path
) -> None:
    report = report_of(eds(tmp_path, values))
    assert report.passed, as_text(report)
