"""The start-up of a node by its proxy, which acts as master: reset, configuration, parameters."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest
from device_bench import DEVICE
from device_bench import NODE_ID as NODE
from msgspec.structs import replace
from test_proxy_and_node import Bench, SlaveProxy

from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectNumber,
    ObjectValue,
    Write,
)
from rtgen.runtime.canopen.wire.frames import NMT, SDO_REQUEST, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

OFF = 1 << 31
EMCY = (0x1014, 0)
CONFIGURED = replace(
    DEVICE,
    configuration=(
        Write(0x1014, 0, struct.pack("<I", OFF | 0x80), relative=True),
        Write(0x1014, 0, struct.pack("<I", OFF | 0xA0)),
        Write(0x1014, 0, struct.pack("<I", 0xA0)),
        Write(0x1017, 0, struct.pack("<H", 100)),
    ),
)


class Proxy(SlaveProxy):
    """A proxy with parameters."""

    description: DeviceDescription = CONFIGURED

    def __init__(self) -> None:
        super().__init__()
        self.wanted: dict[ObjectNumber, ObjectValue] = {}

    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:
        return dict(self.wanted)


@contextmanager
def bench_of(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Bench, Proxy]]:
    monkeypatch.setattr("test_proxy_and_node.SlaveProxy", Proxy)
    with Bench() as bench:
        assert isinstance(bench.proxy, Proxy)
        yield bench, bench.proxy


def activated(bench: Bench) -> None:
    bench.system.activate("Slave0")
    bench.run(1)
    assert bench.node.state is NmtState.OPERATIONAL, bench.proxy.reason
    assert bench.proxy.reason == ""


def begin(frames: list[Frame]) -> list[int]:
    """Return the commands and the first SDO request, in their order."""
    found = []
    for frame in frames:
        if frame.can_id == NMT:
            found.append(frame.data[0])
        elif frame.can_id == SDO_REQUEST + NODE and frame.can_id not in found:
            found.append(frame.can_id)
    return found


def test_a_node_is_reset_before_it_is_configured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with bench_of(monkeypatch) as (bench, _):
        for _ in range(2):
            bench.recorder.frames.clear()
            activated(bench)
            assert begin(bench.recorder.frames) == [
                NmtCommand.RESET_COMMUNICATION,
                SDO_REQUEST + NODE,
                NmtCommand.START,
            ]
            assert bench.node.get(*EMCY) == 0xA0
            # Configured anew, the node is in the same state as the first time.
            bench.system.deactivate("Slave0")
            bench.run(1)
            assert bench.node.state is NmtState.PRE_OPERATIONAL


def test_a_node_without_configuration_is_not_reset(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Proxy, "description", DEVICE)
    with bench_of(monkeypatch) as (bench, _):
        activated(bench)
        assert begin(bench.recorder.frames) == [SDO_REQUEST + NODE, NmtCommand.START]


def test_emergencies_are_heard_on_their_configured_identifier(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with bench_of(monkeypatch) as (bench, proxy):
        activated(bench)
        bench.send_all([Frame(0x80 + NODE, bytes.fromhex("0010010000000000"))])
        bench.run(0.1)
        assert proxy.reason == ""
        bench.node.add_error(0x2310)
        bench.send_all(bench.node.flush(bench.link.now()))
        bench.run(0.1)
        assert "reports EMCY 2310h" in proxy.reason


@pytest.mark.parametrize(
    ("number", "first", "second"),
    [
        (EMCY, 0xA0, 0xB0),
        ((0x1012, 0), OFF | 0x100, OFF | 0x190),
        ((0x1800, 1), 0x185, 0x195),
        ((0x1800, 3), 10, 20),
    ],
)
def test_parameters_are_written_in_the_order_of_the_start_up(
    number: ObjectNumber, first: int, second: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The node enforces CiA 301: a change in one step would be refused."""
    with bench_of(monkeypatch) as (bench, proxy):
        proxy.wanted = {number: first}
        activated(bench)
        assert bench.node.get(*number) == first
        proxy.wanted = {number: second}
        proxy._parameters_changed()
        bench.run(0.5)
        assert proxy.reason == ""
        assert bench.node.get(*number) == second
