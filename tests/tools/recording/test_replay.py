"""Replays into random systems: running components write the same samples, octet by octet."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import pytest
import seeds
from recorded_runs import MS, Adder, Counter, counting, record

from refrobots.iis import TimedPose2D
from refrobots.rtc import TimedLong
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    RealClock,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_reader import McapFile
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.recording.replay import Player, Replay, course_of

Build = Callable[[System], None]
"""Adds the components, and players for the others."""
POLICIES: tuple[Mapping[str, str], ...] = (
    {},
    {"dataport.buffer.length": "3"},
    {"dataport.subscription_type": "new", "dataport.publisher.push_policy": "all"},
    {"dataport.subscription_type": "new", "dataport.publisher.push_policy": "new"},
    {
        "dataport.subscription_type": "periodic",
        "dataport.publisher.push_rate": "70",
        "dataport.publisher.push_policy": "fifo",
    },
    {"dataport.dataflow_type": "pull", "dataport.buffer.length": "5"},
)


class Mixer(Component):
    """A component that combines inputs with its state, and writes now and then."""

    profile = ComponentProfile("Mixer")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.inputs = [self.add_in_port(f"in{n}", TimedLong) for n in range(2)]
        self.outputs = [self.add_out_port(f"out{n}", TimedLong) for n in range(2)]
        self.state = sum(map(ord, instance_name))

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        for place, port in enumerate(self.inputs):
            while port.is_new():
                sample = port.read()
                assert sample is not None
                self.state = (self.state * 31 + sample.data + place) % 65521
        for place, out in enumerate(self.outputs):
            self.state = (self.state * 17 + 3) % 65521
            for _ in range(self.state % 7 - 3 - place):
                out.write(TimedLong(data=self.state))
        return RTC_OK


class Drawn:
    """A random system of mixers, with connections that come and go."""

    def __init__(self, case: int) -> None:
        draw = random.Random(case)
        count = draw.randrange(2, 7)
        self.names = [f"Mixer{n}" for n in range(count)]
        self.rates = {n: draw.choice((1000, 500, 333.3, 100, 60)) for n in self.names}
        self.links = [
            (
                (draw.choice(self.names), f"out{draw.randrange(2)}"),
                (draw.choice(self.names), f"in{draw.randrange(2)}"),
                {**draw.choice(POLICIES), "dataport.allow_dup_connection": "YES"},
                f"link{n}",
            )
            for n in range(draw.randrange(1, 3 * count))
        ]
        self.cut = {
            link[3]: draw.randrange(1, 60) * MS
            for link in self.links
            if draw.random() < 0.3
        }
        self.present = {n for n in self.names if draw.random() < 0.5} or {self.names[0]}

    def add(self, system: System, present: Collection[str]) -> None:
        """Add the components that are present, players for the others."""
        for name in self.names:
            kind = Mixer if name in present else Player
            system.add(kind(name), self.rates[name])
            system.activate(name)

    def connect(self, system: System, name: str) -> None:
        """Connect components that are present."""
        [(source, target, properties, _)] = [x for x in self.links if x[3] == name]
        system.connect(source, target, properties, name)
        if name in self.cut:
            system.at(self.cut[name], self._cutting(system, name))

    def _cutting(self, system: System, name: str) -> Callable[[], None]:
        return lambda: system.disconnect(name)


def samples(path: Path, present: Collection[str]) -> list[tuple[str, int, bytes]]:
    return [
        (m.channel.topic, m.time, m.data)
        for m in McapFile(path).messages()
        if m.channel.get("instance") in present
    ]


def replay(
    recording: Path,
    path: Path,
    add: Build,
    present: Collection[str],
    connect: Callable[[System, str], None] = lambda system, name: None,
) -> None:
    with McapWriter(path) as writer, System(SimulatedClock()) as system:
        add(system)
        course = course_of(McapFile(recording))
        player = Replay(course, present)
        player.prepare(system)
        for each in course.beginning(present):
            source, target = (end.split(".") for end in (each.source, each.target))
            if source[0] in present and target[0] in present:
                connect(system, each.name)
            else:
                ends = (source[0], source[1]), (target[0], target[1])
                system.connect(*ends, player.properties(each), each.name)
        recorder = Recorder(system, writer)
        player.run()
        recorder.end(through=course.through)


@pytest.mark.sampled(0)
@pytest.mark.random
def test_random_systems_write_what_they_wrote(tmp_path: Path) -> None:
    written = 0
    for case in seeds.cases(40, always=40):
        drawn = Drawn(case)
        first, second = tmp_path / f"{case}a.mcap", tmp_path / f"{case}b.mcap"
        with McapWriter(first) as writer, System(SimulatedClock()) as system:
            drawn.add(system, drawn.names)
            for *_, name in drawn.links:
                drawn.connect(system, name)
            recorder = Recorder(system, writer)
            system.run(80 * MS)
            recorder.end(through=False)

        def add(system: System, drawn: Drawn = drawn) -> None:
            drawn.add(system, drawn.present)

        replay(first, second, add, drawn.present, drawn.connect)
        expected = samples(first, drawn.present)
        assert samples(second, drawn.present) == expected, case
        written += len(expected)
    assert written > 1000


def adder_alone(system: System) -> None:
    system.add(Adder("Adder0"), 300.0)
    system.add(Player("Counter0"), 1000.0)
    system.activate("Adder0")


def test_a_recording_that_was_cut_off_is_replayed_to_its_end(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    with McapWriter(whole, longest=20 * MS) as writer, counting() as system:
        Recorder(system, writer)
        system.run(100 * MS)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    again = tmp_path / "again.mcap"
    replay(cut, again, adder_alone, {"Adder0"})
    expected = samples(cut, {"Adder0"})
    assert samples(again, {"Adder0"})[: len(expected)] == expected
    assert 0 < len(expected) < len(samples(whole, {"Adder0"}))


def test_two_replays_of_real_time_are_equal(tmp_path: Path) -> None:
    path = tmp_path / "real.mcap"
    with McapWriter(path) as writer, System(RealClock()) as system:
        system.add(Adder("Adder0"), 300.0)
        system.add(Counter("Counter0"), 500.0)
        system.connect(("Counter0", "count"), ("Adder0", "in"))
        system.activate("Adder0")
        system.activate("Counter0")
        recorder = Recorder(system, writer)
        system.run(60 * MS)
        recorder.end(through=False)
    again = [tmp_path / name for name in ("a.mcap", "b.mcap")]
    for file in again:
        replay(path, file, adder_alone, {"Adder0"})
    assert again[0].read_bytes() == again[1].read_bytes()
    sums = [e for e in Log(again[0]).events() if e.get("port") == "sum"]
    counts = [e for e in Log(path).events() if e.get("port") == "count"]
    assert counts
    assert sums[-1]["value"]["data"] <= sum(e["value"]["data"] for e in counts)
    assert sums[-1]["value"]["data"] > 0


def test_a_writer_has_a_reader_in_the_replay(tmp_path: Path) -> None:
    path, again = tmp_path / "a.mcap", tmp_path / "b.mcap"
    record(path)

    def counter_alone(system: System) -> None:
        system.add(Player("Adder0"), 300.0)
        system.add(Counter("Counter0"), 1000.0)
        system.activate("Counter0")
        counter: Any = system.component("Counter0")
        system.at(50 * MS, lambda: unsent.append(counter.count.unsent))

    unsent: list[int] = []
    replay(path, again, counter_alone, {"Counter0"})
    assert samples(again, {"Counter0"}) == samples(path, {"Counter0"})
    assert unsent == [0]


def test_until_ends_a_replay_before_its_end(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    record(path)
    with System(SimulatedClock()) as system:
        adder_alone(system)
        course = course_of(McapFile(path))
        player = Replay(course, {"Adder0"})
        player.prepare(system)
        [link] = course.beginning({"Adder0"})
        ends = ("Counter0", "count"), ("Adder0", "in")
        system.connect(*ends, player.properties(link), link.name)
        player.run(10 * MS)
        adder: Any = system.component("Adder0")
        assert system.time == 10 * MS
        assert 0 < adder.total <= sum(range(11))


class OtherAdder(Component):
    """A component whose port has another type, or that has no port."""

    def __init__(self, instance_name: str, port: str = "in") -> None:
        super().__init__(instance_name)
        self.add_in_port(port, TimedPose2D)


@pytest.mark.parametrize(
    ("adder", "what"),
    [
        (
            OtherAdder("Adder0"),
            "samples of RTC::TimedLong were recorded; its type is IIS::TimedPose2D now",
        ),
        (OtherAdder("Adder0", "other"), "Adder0.in: there is no such InPort now"),
    ],
)
def test_ports_that_have_changed(tmp_path: Path, adder: Component, what: str) -> None:
    path = tmp_path / "a.mcap"
    record(path)
    with System(SimulatedClock()) as system:
        system.add(adder, 300.0)
        system.add(Player("Counter0"), 1000.0)
        with pytest.raises(RecordingError, match=what):
            Replay(course_of(McapFile(path)), {"Adder0"}).prepare(system)


def test_files_of_others_cannot_be_replayed(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer:
        channel = writer.channel("/x", "json", 0, {})
        writer.message(channel, 5, b'{"a": 1}')
    with pytest.raises(RecordingError, match="not a recording of rtgen run --record"):
        course_of(McapFile(path))
    expected = {"t": 5, "event": "sample", "instance": "", "port": "/x"}
    assert [*Log(path).events()] == [expected | {"value": {"a": 1}}]
