"""`rtgen can scan --eds NODE`: the description of a node without one, read from the node."""

from __future__ import annotations

import importlib
import random
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import pytest
import seeds
from can_commands import command
from can_nodes import SPECS, nodes
from eds_files import Thing, entry
from eds_files import eds as eds_of
from generated_projects import project
from random_buses import Identifiers, RandomDevice
from slaves import Slave
from stations import Recorder

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import eds
from rtgen.compiler.model.canopen import Device, PdoDirection, resolved
from rtgen.runtime import ACTIVE_STATE, SECOND, RealClock, SampleRecord, System
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SDO_REQUEST, Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.tools.can.live.dictionary_reading import DictionaryReader

NODE = 5
FAST = ("--rate", "1000000")
AREAS = ("--range", "2000-21FF", "--range", "6000-65FF")
UPLOADS = {0x40, 0x60, 0x70, 0x80, 0xA0, 0xA1, 0xA2, 0xA3}
"""The command octets of a client that only reads, and its abort."""
CHANNELS = count()


def scanned(channel: str, path: Path, *options: str) -> int:
    words = ["scan", "--eds", str(NODE), "-o", str(path), *FAST, *options]
    return command(channel, *words)


def read(path: Path) -> Device:
    result = eds.load([path], root=path.parent, node_id=NODE)
    assert not has_errors(result.diagnostics), [d.message for d in result.diagnostics]
    (device,) = result.model.devices
    return device


def channel() -> str:
    return f"node file {next(CHANNELS)}"


def read_back(source: Path, folder: Path, *options: str) -> Device:
    """Return the description that is read from a device of a file."""
    name, target = channel(), folder / "read.eds"
    with nodes(name, {NODE: source}):
        assert scanned(name, target, *(options or AREAS)) == 0
    return read(target)


def mappings(device: Device) -> dict[tuple[PdoDirection, int], tuple[Any, ...]]:
    return {
        (pdo.direction, pdo.number): (
            pdo.entries,
            resolved(pdo.cob_id, NODE),
            pdo.transmission_type or 0,
        )
        for pdo in device.pdos
    }


def agree(copy: Device, source: Device) -> None:
    """Assert that each readable object has a type of the same length, and PDOs are equal."""
    for variable in source.variables:
        if not variable.access.readable or variable.bits is None:
            continue
        same = copy.find(variable.index, variable.subindex)
        assert same is not None, f"{variable.index:04X}:{variable.subindex}"
        width = -(-variable.bits // 8)
        assert same.bits is not None, (variable, same)
        assert -(-same.bits // 8) == width, (variable, same)
        assert same.access.readable
    assert mappings(copy) == mappings(source)
    assert copy.vendor_id == source.vendor_id
    assert copy.product_code == source.product_code


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["epos_drive", "f_palette", "ftmd", "motor_core_unit"])
def test_a_node_is_described_as_its_file_does(name: str, tmp_path: Path) -> None:
    source = SPECS / f"{name}.eds"
    agree(read_back(source, tmp_path), read(source))


@pytest.mark.sampled(0)
@pytest.mark.random
@pytest.mark.parametrize("seed", seeds.cases(10))
def test_drawn_devices_are_described(seed: int, tmp_path: Path) -> None:
    chance = random.Random(seed)
    source = tmp_path / "drawn.eds"
    source.write_text(RandomDevice(chance, Identifiers(chance)).text)
    result = eds.load([source], root=tmp_path, node_id=NODE)
    (device,) = result.model.devices
    name, target = channel(), tmp_path / "read.eds"
    with nodes(name, {NODE: source}) as made:
        assert scanned(name, target, *AREAS) == 0
        dictionary = made[NODE]
    copy = read(target)
    for variable in device.variables:
        if variable.access.readable and variable.bits is not None:
            same = copy.find(variable.index, variable.subindex)
            assert same is not None, variable
            assert same.bits == variable.bits, (variable, same)
    assert {key: entries for key, (entries, *_) in mappings(copy).items()} == {
        key: entries for key, (entries, *_) in mappings(device).items()
    }
    assert dictionary.node_id == NODE


def test_types_are_those_of_length_content_and_mapping(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    things = [
        Thing("A", 0x05, "rw", default="1"),
        Thing("B", 0x01, "rw"),
        Thing("C", 0x04, "ro", default="-2"),
        Thing("D", 0x06, "wo"),
        Thing("E", 0x06, "wo"),
        Thing("F", 0x09, "rw", False, "firmware 1.2"),
        Thing("G", 0x1B, "ro", False, "7"),
        Thing("H", 0x08, "ro", False, "1.5"),
    ]
    tpdos = {1: [entry(0x2000, 8), entry(0x2001, 1), entry(0x2002, 32)]}
    source = tmp_path / "odd.eds"
    source.write_text(eds_of(things, tpdos, {1: [entry(0x2003, 16)]}))
    copy = read_back(source, tmp_path, "--range", "2000-2010")
    found = {
        v.index: (v.type_name, v.access.value)
        for v in copy.variables
        if v.index >= 0x2000
    }
    assert found == {
        0x2000: ("UNSIGNED8", "ro"),
        0x2001: ("BOOLEAN", "ro"),
        0x2002: ("UNSIGNED32", "ro"),
        0x2003: ("UNSIGNED16", "wo"),
        0x2004: ("DOMAIN", "wo"),
        0x2005: ("VISIBLE_STRING", "rw"),
        0x2006: ("UNSIGNED64", "rw"),
        0x2007: ("UNSIGNED32", "rw"),
    }
    text = (tmp_path / "read.eds").read_text()
    assert (
        "; guess: type by its 4 octets, it may be signed: -2; access by its mapping, "
        "it may be writable\n[2002]\n" in text
    )
    printed = capfd.readouterr().out
    assert "it may be REAL32: 1.5" in printed
    for index in (0x2000, 0x2007):
        line = next(x for x in printed.splitlines() if x.startswith(f"{index:04X} "))
        assert "type by its" in line


class Odd(Slave):
    """A node whose objects refuse in different ways."""

    refusing = {  # noqa: RUF012 - not changed
        (0x2100, 0): sdo.WRITE_ONLY,
        (0x2101, 0): sdo.HARDWARE_ERROR,
        (0x2102, 0): sdo.NO_SUBINDEX,
        (0x2103, 0): sdo.ACCESS_UNSUPPORTED,
    }

    def __init__(self, node_id: int) -> None:
        super().__init__(node_id)
        self.values[0x2102, 1] = bytes(2)
        self.values[0x2104, 0] = bytes(5000)
        self.values[0x2105, 0] = b"\x03"
        self.read_before_silence = -1

    def read(self, index: int, subindex: int) -> bytes:
        if (index, subindex) in self.refusing:
            raise SdoAbort(self.refusing[index, subindex])
        if index == 0x2105:
            # Such a node ignores the sub-index.
            return self.values[0x2105, 0]
        return super().read(index, subindex)

    def receive(self, frame: Frame, now: int) -> Any:
        if frame.can_id == SDO_REQUEST + self.node_id and self.read_before_silence >= 0:
            self.dead = self.dead or self.read_before_silence == 0
            self.read_before_silence -= 1
        return super().receive(frame, now)


@contextmanager
def attached(slave: Slave) -> Iterator[tuple[str, Recorder]]:
    """Yield the channel of a slave, and a record of its frames."""
    name, recorder = channel(), Recorder()
    link = open_link(RealClock(), "virtual", name)
    with link.lock:
        link.attach(recorder)
        link.attach(slave)
        link.send([slave.nmt.boot()], slave)
    try:
        yield name, recorder
    finally:
        with link.lock:
            link.detach(slave)
            link.detach(recorder)


def test_refusals_are_told_apart_and_nothing_is_written(tmp_path: Path) -> None:
    target, slave = tmp_path / "odd.eds", Odd(NODE)
    with attached(slave) as (name, recorder):
        assert scanned(name, target, "--range", "2000-2110") == 0
    device, text = read(target), target.read_text()
    found = {
        (v.index, v.subindex): ("DOMAIN" if v.domain else v.type_name, v.access.value)
        for v in device.variables
        if v.index >= 0x2100
    }
    assert found == {
        (0x2100, 0): ("DOMAIN", "wo"),
        (0x2102, 0): ("UNSIGNED8", "ro"),
        (0x2102, 1): ("UNSIGNED16", "rw"),
        (0x2104, 0): ("DOMAIN", "rw"),
        (0x2105, 0): ("UNSIGNED8", "rw"),
    }
    assert f"; Not described: 2101: {sdo.HARDWARE_ERROR:08X}h" in text
    assert f"; Not described: 2103: {sdo.ACCESS_UNSUPPORTED:08X}h" in text
    assert slave.writes == []
    requests = [f for f in recorder.frames if f.can_id == SDO_REQUEST + NODE]
    assert {f.data[0] & 0xE0 for f in requests} <= {0x40, 0x60, 0x80, 0xA0}


def test_a_stored_file_is_taken_as_it_is(tmp_path: Path) -> None:
    stored = (SPECS / "ftmd.eds").read_bytes()
    target, slave = tmp_path / "own.eds", Odd(NODE)
    slave.values |= {(0x1021, 0): stored, (0x1022, 0): b"\0"}
    with attached(slave) as (name, _):
        assert scanned(name, target) == 0
    assert target.read_bytes() == stored


@pytest.mark.sampled(1)
@pytest.mark.parametrize("stored", [b"PK\3\4 compressed", b"[FileInfo]\n", b""])
def test_a_stored_file_that_is_none_is_not_taken(stored: bytes, tmp_path: Path) -> None:
    target, slave = tmp_path / "own.eds", Odd(NODE)
    slave.values |= {(0x1021, 0): stored, (0x1022, 0): b"\0"}
    with attached(slave) as (name, _):
        assert scanned(name, target, "--range", "2000-2000") == 0
    assert read(target).find(0x2000) is not None


def test_no_file_is_overwritten(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "mine.eds"
    target.write_text("mine")
    assert scanned(channel(), target) == 2
    assert target.read_text() == "mine"
    assert "mine.eds exists" in capfd.readouterr().err
    assert scanned(channel(), tmp_path / "no" / "folder.eds") == 2


def test_a_node_that_is_not_there(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "none.eds"
    assert scanned(channel(), target, "--for", "0.01") == 3
    assert "node 5 does not answer" in capfd.readouterr().err
    assert not target.exists()


def test_a_node_that_falls_silent_leaves_a_partial_file(tmp_path: Path) -> None:
    target, slave = tmp_path / "part.eds", Odd(NODE)
    slave.read_before_silence = 70
    with attached(slave) as (name, _):
        options = ("--for", "0.5", "--range", "2000-2010")
        assert scanned(name, target, *options) == 1
    assert target.read_text().startswith("; PARTIAL: no answer from ")
    assert read(target).find(0x1000) is not None


def test_the_limit_of_time_leaves_a_partial_file(tmp_path: Path) -> None:
    target = tmp_path / "part.eds"
    with attached(Odd(NODE)) as (name, _):
        assert scanned(name, target, "--rate", "100", "--limit", "0.2") == 1
    assert target.read_text().startswith("; PARTIAL: the limit of 0.2 s ended it at ")


def test_an_interruption_leaves_a_partial_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tell = DictionaryReader._tell

    def interrupted(self: DictionaryReader, index: int) -> None:
        if index == 0x2003:
            raise KeyboardInterrupt
        tell(self, index)

    monkeypatch.setattr(DictionaryReader, "_tell", interrupted)
    target = tmp_path / "part.eds"
    with nodes(line := channel(), {NODE: "epos_drive"}):
        assert scanned(line, target, "--range", "2000-2010") == 130
    assert target.read_text().startswith("; PARTIAL: interrupted at 2003h")
    device = read(target)
    # Mapped objects come before the ranges.
    assert device.find(0x6040) is not None
    assert device.find(0x6502) is None


def test_ranges_are_checked(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for text in ("2000-1FFF", "x", "0-10", "2000-10000"):
        assert scanned(channel(), tmp_path / "x.eds", "--range", text) == 2
        assert "is not FROM-TO" in capfd.readouterr().err


@pytest.mark.sampled(0)
@pytest.mark.waits
def test_a_proxy_of_the_file_works_with_the_node(tmp_path: Path) -> None:
    line, work = channel(), tmp_path / "project"
    work.mkdir()
    with nodes(line, {NODE: "f_palette"}) as made:
        assert scanned(line, work / "unknown.eds", *AREAS) == 0
        text = (work / "unknown.eds").read_text()
        with project(work, {"unknown.eds": text}):
            module = importlib.import_module("mine.components.unknown_proxy")
            system = System(RealClock())
            proxy = module.UnknownProxy("proxy")
            for name, value in {"channel": line, "node_id": NODE, "master": 1}.items():
                proxy.configuration_sets.set(name, str(value))
            samples: list[SampleRecord] = []

            def note(record: object) -> None:
                if isinstance(record, SampleRecord) and record.port.startswith("tpdo"):
                    samples.append(record)

            system.add_listener(note)
            try:
                system.add(proxy, 100.0)
                system.activate("proxy")
                limit = system.time + 20 * SECOND
                assert system.run(limit, until=lambda _: bool(samples)), proxy.reason
                assert system.state("proxy") is ACTIVE_STATE
                vendor = read(work / "unknown.eds").find(0x1018, 1)
                assert vendor is not None
                octets = proxy.sdo.call("read", (0x1018, 1))
                assert int.from_bytes(octets, "little") == vendor.default == 0x00FFFF01
                assert made[NODE].state.name == "OPERATIONAL"
            finally:
                system.close()
