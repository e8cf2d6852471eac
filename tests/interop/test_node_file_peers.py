"""`rtgen can scan --eds NODE` with slaves that are not rtgen's.

They are by hand, of `canopen`, and programs in C: those of CANopenNode and Lely where
`RTGEN_CANOPENNODE` and `RTGEN_LELY` name one that is node 5, and `RTGEN_CANOPENNODE_EDS` and
`RTGEN_LELY_EDS` its EDS.
"""

from __future__ import annotations

import logging
import os
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from itertools import count
from pathlib import Path
from typing import Any

import can
import pytest
from patience import PATIENCE

from rtgen.cli import run
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.model.canopen import Device
from rtgen.runtime import ACTIVE_STATE, SECOND, RealClock, System

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from can_commands import command

canopen = pytest.importorskip("canopen", reason="the package canopen is not installed")

pytestmark = pytest.mark.peer

SPECS = Path(__file__).parents[2] / "specs" / "canopen"
HAND = Path(__file__).parent / "slave_peer" / "hand_slave"
NODE = 5
CHANNELS = count()
PACKAGE = "scanned_node"
RANGES = [
    word
    for indices in ("1F00-1FFF", "2000-21FF", "6000-65FF")
    for word in ("--range", indices)
]


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


@pytest.mark.nightly
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


FRAME = struct.Struct("<IB8s3x")
"""A frame of a program: identifier (800h: a remote frame), length, data."""
_REMOTE = 0x800


@contextmanager
def program(path: str, channel: str) -> Iterator[None]:
    """Connect a program to a channel: each packet of its standard input, a socket, is a frame."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with (
        theirs,
        can.Bus(interface="virtual", channel=channel) as bus,
        subprocess.Popen([path], stdin=theirs.fileno()) as process,
    ):
        booted = threading.Event()

        def from_program() -> None:
            while packet := ours.recv(FRAME.size):
                identifier, length, data = FRAME.unpack(packet)
                message = can.Message(
                    arbitration_id=identifier & ~_REMOTE,
                    is_remote_frame=bool(identifier & _REMOTE),
                    is_extended_id=False,
                    dlc=length,
                    data=None if identifier & _REMOTE else data[:length],
                )
                bus.send(message)
                booted.set()

        def to_program() -> None:
            while process.poll() is None:
                message = bus.recv(0.1)
                if message is not None:
                    remote = _REMOTE * message.is_remote_frame
                    identifier = message.arbitration_id | remote
                    data = bytes(message.data)
                    with suppress(OSError):
                        ours.send(FRAME.pack(identifier, message.dlc, data))

        threads = [threading.Thread(target=each) for each in (from_program, to_program)]
        for thread in threads:
            thread.start()
        try:
            assert booted.wait(PATIENCE), "the program does not boot up"
            yield
        finally:
            process.terminate()
            process.wait()
            ours.shutdown(socket.SHUT_RDWR)
            for thread in threads:
                thread.join()
            ours.close()


@pytest.mark.parametrize("name", ["CANOPENNODE", "LELY"])
def test_a_slave_in_c(name: str, tmp_path: Path) -> None:
    """The file of a node reads back equal, and its proxy reads what the node has."""
    path, source = (os.environ.get(f"RTGEN_{name}{end}") for end in ("", "_EDS"))
    if path is None or source is None:
        pytest.skip(f"RTGEN_{name} and RTGEN_{name}_EDS name no slave and its EDS")
    channel = f"slave in C {next(CHANNELS)}"
    with program(path, channel):
        copy = scanned(channel, tmp_path)
        described = read(Path(source))
        assert differences(copy, described, {0x1003}) == []
        assert pdos(copy) == pdos(described)
        proxy = proxy_of(tmp_path / "read.eds", tmp_path)
        with System(RealClock()) as system:
            for key, value in (
                ("interface", "virtual"),
                ("channel", channel),
                ("node_id", str(NODE)),
                ("master", "1"),
            ):
                proxy.configuration_sets.set(key, value)
            system.add(proxy, 100.0)
            system.activate("Node0")

            def is_active(each: System) -> bool:
                return each.state("Node0") is ACTIVE_STATE

            system.run(int(PATIENCE) * SECOND, until=is_active)
            assert is_active(system)
            proxy.objects.Producer_heartbeat_time = 77
            assert proxy.objects.Producer_heartbeat_time == 77


def proxy_of(file: Path, folder: Path) -> Any:
    """Generate the proxy of a description, and return one."""
    text = f'[output]\npackage = "{PACKAGE}"\n\n[sources]\npaths = ["{file.name}"]\n'
    (folder / "rtgen.toml").write_text(text, encoding="utf-8")
    with chdir(folder):
        assert run(["generate"]) == 0
    sys.path.insert(0, str(folder / "generated"))
    try:
        module = import_module(f"{PACKAGE}.components.read_proxy")
    finally:
        sys.path.pop(0)
        for each in [m for m in sys.modules if m.partition(".")[0] == PACKAGE]:
            del sys.modules[each]
    return module.ReadProxy("Node0")
