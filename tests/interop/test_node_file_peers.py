"""`rtgen can scan --eds NODE` with slaves that are not rtgen's: of `canopen`, and by hand."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import module_from_spec, spec_from_file_location
from itertools import count
from pathlib import Path

import can
import pytest

from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.canopen import Device

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from can_commands import command

canopen = pytest.importorskip("canopen", reason="the package canopen is not installed")

pytestmark = pytest.mark.peer

SPECS = Path(__file__).parents[2] / "specs" / "canopen"
HAND = Path(__file__).parent / "slave_peer" / "hand_slave"
NODE = 5
CHANNELS = count()
RANGES = ("--range", "2000-21FF", "--range", "6000-65FF")


def scanned(channel: str, folder: Path) -> Device:
    """Return the description that is read from the node of a channel."""
    target = folder / "read.eds"
    words = ["scan", "--eds", str(NODE), "-o", str(target), "--rate", "100000"]
    assert command(channel, *words, *RANGES) == 0
    (device,) = load([target], root=folder, node_id=NODE).model.devices
    return device


def read(path: Path) -> Device:
    (device,) = load([path], root=path.parent, node_id=NODE).model.devices
    return device


def differences(copy: Device, source: Device, missing: set[int]) -> list[str]:
    """Return the readable numbers that have no type of the same length in the copy."""
    return [
        f"{v.index:04X}:{v.subindex}"
        for v in source.variables
        if v.access.readable and v.bits and v.index not in missing
        if (same := copy.find(v.index, v.subindex)) is None
        or same.bits is None
        or -(-same.bits // 8) != -(-v.bits // 8)
    ]


def pdos(device: Device) -> list[object]:
    return [(p.direction, p.number, p.entries) for p in device.pdos]


@contextmanager
def hand_slave(channel: str) -> Iterator[None]:
    spec = spec_from_file_location("hand_slave", HAND.with_suffix(".py"))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    ended = threading.Event()
    bus = can.Bus(interface="virtual", channel=channel)
    slave = module.Slave(bus, NODE)

    def serve() -> None:
        slave.reset()
        while not ended.is_set():
            slave.step()
        bus.shutdown()

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def test_a_slave_by_hand(tmp_path: Path) -> None:
    channel, source = f"hand file {next(CHANNELS)}", read(HAND.with_suffix(".eds"))
    with hand_slave(channel):
        copy = scanned(channel, tmp_path)
    assert differences(copy, source, set()) == []
    assert pdos(copy) == pdos(source)


@pytest.mark.parametrize("name", ["epos_drive", "f_palette"])
def test_a_local_node_of_the_package_canopen(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.CRITICAL)
    channel, source = f"local node {next(CHANNELS)}", SPECS / f"{name}.eds"
    network = canopen.Network()
    network.connect(interface="virtual", channel=channel)
    try:
        node = canopen.LocalNode(NODE, str(source))
        network.add_node(node)
        copy = scanned(channel, tmp_path)
    finally:
        network.disconnect()
    # It has no data for any sub-index of 1003h, so their number is not known.
    assert differences(copy, read(source), {0x1003}) == []
    assert copy.find(0x1003, 1) is not None
    assert copy.find(0x1003, 2) is None
    assert pdos(copy) == pdos(read(source))
