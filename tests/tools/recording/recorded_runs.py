"""Small systems whose runs are recorded."""

from __future__ import annotations

from pathlib import Path

from refrobots.iis import TimedPose2D
from refrobots.rtc import TimedLong
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder

MS = 1_000_000


class Counter(Component):
    """A component that counts, and reports its position."""

    profile = ComponentProfile("Counter")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.count = self.add_out_port("count", TimedLong)
        self.pose = self.add_out_port("pose", TimedPose2D)
        self.number = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.number += 1
        sample = TimedLong(data=self.number)
        self.stamp(sample)
        self.count.write(sample)
        if self.number % 3 == 0:
            self.pose.write(TimedPose2D(id=[self.number]))
        return RTC_OK


class Adder(Component):
    """A component that adds the samples that it reads."""

    profile = ComponentProfile("Adder")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.read = self.add_in_port("in", TimedLong)
        self.sum = self.add_out_port("sum", TimedLong)
        self.total = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        while self.read.is_new():
            sample = self.read.read()
            assert sample is not None
            self.total += sample.data
        self.sum.write(TimedLong(data=self.total))
        return RTC_OK


def counting(clock: SimulatedClock | None = None, check: str = "first") -> System:
    """Return a system of a counter at 1000 Hz and an adder at 300 Hz."""
    system = System(clock or SimulatedClock(), check_values=check)
    system.add(Adder("Adder0"), 300.0)
    system.add(Counter("Counter0"), 1000.0)
    properties = {"dataport.buffer.length": "64"}
    system.connect(("Counter0", "count"), ("Adder0", "in"), properties, "counts")
    system.activate("Adder0")
    system.activate("Counter0")
    return system


def record(path: Path, milliseconds: int = 100, compression: str = "zstd") -> None:
    """Record the system above."""
    with McapWriter(path, compression) as writer, counting() as system:
        recorder = Recorder(system, writer)
        system.run(milliseconds * MS)
        recorder.end(through=False)
