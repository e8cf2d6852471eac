"""RPDOs sent by a proxy: the newest value once per SYNC, inhibit times, every value otherwise."""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import pairwise

import pytest
from msgspec.structs import replace
from proxy_bench import DESCRIPTION, MS, NODE, Bench, DriveProxy

from refrobots.rtc import Time, TimedLong
from rtgen.runtime import Component
from rtgen.runtime.canopen.wire.frames import SYNC, Frame


@pytest.fixture
def drive(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Bench]:
    """Return a maker of an ACTIVE bench with these parameters of the RPDO, and a writer."""

    def made(**changes: int) -> Bench:
        pdos = tuple(
            replace(pdo, **changes) if pdo.direction == "rpdo" else pdo  # type: ignore[arg-type]
            for pdo in DESCRIPTION.pdos
        )
        described = replace(DESCRIPTION, pdos=pdos)
        monkeypatch.setattr(DriveProxy, "description", described)
        bench = Bench()
        bench.with_node()
        bench.system.add(Component("Writer0"))
        bench.system.component("Writer0").add_out_port("out", TimedLong)
        bench.system.connect(
            ("Writer0", "out"),
            ("Drive0", "rpdo1"),
            {"dataport.subscription_type": "flush", "dataport.buffer.length": "200"},
        )
        bench.run(0.05)
        bench.activate()
        return bench

    return made


def write(bench: Bench, *values: int) -> None:
    port = bench.system.component("Writer0").out_ports["out"]
    for value in values:
        port.write(TimedLong(Time(0, 0), value))


def sync(bench: Bench) -> None:
    bench.link.send([Frame(SYNC)])


def targets(bench: Bench) -> list[int]:
    return [
        struct.unpack("<i", frame.data)[0]
        for frame in bench.recorder.frames
        if frame.can_id == 0x200 + NODE
    ]


def times(bench: Bench) -> list[int]:
    frames = zip(bench.recorder.frames, bench.recorder.times, strict=True)
    return [time for frame, time in frames if frame.can_id == 0x200 + NODE]


def overwritten(bench: Bench) -> float:
    (count,) = bench.proxy.observables["overwritten"]()
    return count


@pytest.mark.parametrize("kind", [0, 1, 240])
def test_a_synchronous_one_has_the_newest_value_once_per_sync(
    drive: Callable[..., Bench], kind: int
) -> None:
    with drive(transmission_type=kind) as bench:
        write(bench, *range(100))
        bench.run(0.1)
        assert targets(bench) == [], "it waits for SYNC"
        sync(bench)
        bench.run(0.01)
        assert targets(bench) == [99]
        sync(bench)
        bench.run(0.01)
        assert targets(bench) == [99], "nothing new"
        assert overwritten(bench) == 99
        for value in range(3):
            write(bench, value)
            bench.run(0.02)
            sync(bench)
            bench.run(0.001)
        assert targets(bench) == [99, 0, 1, 2]
        assert (overwritten(bench), bench.proxy.lost) == (99, 0)


def test_sync_has_no_meaning_to_others(drive: Callable[..., Bench]) -> None:
    with drive() as bench:
        write(bench, *range(5))
        bench.run(0.02)
        assert targets(bench) == [0, 1, 2, 3, 4]
        sync(bench)
        bench.run(0.02)
        assert len(targets(bench)) == 5


def test_an_inhibit_time_lets_the_newest_value_through(
    drive: Callable[..., Bench],
) -> None:
    with drive(inhibit_time=500) as bench:
        write(bench, 1, 2, 3)
        bench.run(0.04)
        assert targets(bench) == [1]
        bench.run(0.05)
        assert targets(bench) == [1, 3]
        for value in range(100):
            write(bench, value)
            bench.run(0.01)
        bench.run(0.1)
        sent = times(bench)
        assert min(b - a for a, b in pairwise(sent)) == 50 * MS
        assert targets(bench)[-1] == 99


def test_what_waits_is_forgotten_when_the_proxy_leaves_active(
    drive: Callable[..., Bench],
) -> None:
    with drive(transmission_type=1) as bench:
        write(bench, 7)
        bench.run(0.02)
        bench.system.deactivate("Drive0")
        bench.until("INACTIVE")
        sync(bench)
        bench.run(0.05)
        bench.activate()
        sync(bench)
        bench.run(0.05)
        assert targets(bench) == []


def test_a_bus_that_goes_and_comes_back_sends_nothing_old(
    drive: Callable[..., Bench],
) -> None:
    with drive(transmission_type=1) as bench:
        write(bench, 7)
        bench.run(0.02)
        bench.bus.cut()
        bench.until("ERROR")
        bench.bus.mend()
        sync(bench)
        bench.run(0.1)
        assert targets(bench) == []
