"""RH3 on CANopen drives, FourX, and PDO linking: whole systems in simulated time."""

from __future__ import annotations

import io
import json
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from math import hypot, pi, sin
from pathlib import Path

import can
import pytest
from pipeline import MAX_DURATION, NAVIGATION, at_end, goal, profile

from refnav.geometry import Pose, wrap
from refrobots.components import f_palette_proxy as palette
from refrobots.components import motor_core_unit_proxy as motor
from rtgen.cli import run
from rtgen.compiler.project import load
from rtgen.compiler.systems.timeline import assignment, parse
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    JsonLinesRecorder,
    LifeCycleState,
    Record,
    SampleRecord,
    SimulatedClock,
    StateRecord,
    System,
)
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

CANOPEN = NAVIGATION.parent / "canopen"
BEEGO = CANOPEN / "rh3_beego.xml"
FOURX = CANOPEN / "fourx.xml"
LINKING = CANOPEN / "pdo_linking.xml"
SILENCE = (CANOPEN / "timelines" / "heartbeat_lost.toml").read_text()
TIMEOUT = 300_000_000
"""The heartbeat time-out of the drives' proxies [ns]."""
PERIOD = SECOND // 10
"""The period of heartbeats [ns]."""
CYCLE = SECOND // 100


class Sniffer:
    """A station that records every frame of a simulated bus."""

    identifiers = None
    deadline = None

    def __init__(self) -> None:
        self.frames: list[tuple[int, Frame]] = []

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.frames.append((now, frame))
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        return ()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()

    def sent(self, can_id: int, begin: int = 0) -> list[tuple[int, bytes]]:
        return [
            (t, f.data) for t, f in self.frames if f.can_id == can_id and t >= begin
        ]


@contextmanager
def build(
    file: Path, settings: Sequence[str] = (), timeline: str = ""
) -> Iterator[tuple[System, Sniffer]]:
    system = profile(file)
    values = [assignment(text, system) for text in settings]
    steps = parse(timeline, "timeline.toml", system)
    clock = SimulatedClock()
    with assemble(system, Factories(load()), clock, values, steps) as running:
        sniffer = Sniffer()
        open_link(clock).attach(sniffer)
        yield running, sniffer


def truth(system: System, base: str) -> Pose:
    return Pose(*system.observable(f"{base}.truth"))


def assert_at(pose: Pose, x: float, y: float, theta: float) -> None:
    assert hypot(pose.x - x, pose.y - y) < 0.05
    assert abs(wrap(pose.theta - theta)) < 0.03


class States:
    """The times of the components' changes of state."""

    def __init__(self) -> None:
        self.changes: list[tuple[int, str, LifeCycleState]] = []

    def __call__(self, record: Record) -> None:
        if isinstance(record, StateRecord):
            self.changes.append((record.time, record.instance, record.after))

    def of(self, instance: str) -> list[tuple[int, LifeCycleState]]:
        return [(time, state) for time, name, state in self.changes if name == instance]


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("file", "base", "nodes", "end"),
    [
        (BEEGO, "RefHardRh3Canopen0", (1, 2), (3.4, 7.7, -1.57)),
        pytest.param(
            *(FOURX, "RefHardFourX0", (1, 2, 3, 4), (0.8, 0.5, -1.57)),
            marks=pytest.mark.nightly,
        ),
    ],
)
def test_the_base_reaches_its_goal(
    file: Path, base: str, nodes: Sequence[int], end: tuple[float, float, float]
) -> None:
    """RH3: that of the reference run."""
    with build(file, goal(*end)) as (system, sniffer):
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system, base), *end)
        assert {system.statistics(name).lost for name in system.instances} == {0}
        states = [system.state(name) for name in system.instances]
        assert states.count(ACTIVE_STATE) == len(states) - 1
        # SYNC every 10 ms, and each drive sends its position with it.
        beats = [time for time, _ in sniffer.sent(0x080)]
        assert len(beats) == system.time // CYCLE
        for node in nodes:
            assert len(sniffer.sent(0x280 + node)) >= len(beats) - 20
            assert len(sniffer.sent(0x400 + node)) >= len(beats) - 40


@pytest.mark.nightly
@pytest.mark.slow
def test_a_drive_that_falls_silent_stops_the_base_and_the_run_goes_on() -> None:
    states = States()
    speeds: list[tuple[int, tuple[float, ...]]] = []
    with build(BEEGO, timeline=SILENCE) as (system, sniffer):
        system.add_listener(states)
        system.every(
            CYCLE,
            lambda: speeds.append(
                (
                    system.time,
                    tuple(
                        system.observable(f"{side}Drive0.speed")[0]
                        for side in ("Left", "Right")
                    ),
                )
            ),
        )
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system, "RefHardRh3Canopen0"), 3.4, 7.7, -1.57)
        silent = [
            (a, b)
            for (a, _), (b, _) in zip(
                sniffer.sent(0x701), sniffer.sent(0x701)[1:], strict=False
            )
            if b - a > 2 * PERIOD
        ]
        # Before the end of the system and its components.
        wheel = [(t, s) for t, s in states.of("LeftWheel0") if t > SECOND]
        assert [s for t, s in states.of("RightWheel0") if t > SECOND] == []
    [(last, again)] = silent
    assert 12 * SECOND - PERIOD <= last <= 12 * SECOND + CYCLE
    assert [state for _, state in wheel] == [ERROR_STATE, INACTIVE_STATE, ACTIVE_STATE]
    lost = wheel[0][0]
    assert TIMEOUT <= lost - last <= TIMEOUT + CYCLE
    assert 14 * SECOND < again < wheel[2][0] < 15 * SECOND + CYCLE
    # The drive runs until then; both wheels stop soon afterwards, until it is back.
    assert min(map(abs, next(v for t, v in speeds if t == 12 * SECOND))) > 10.0
    still = [v for t, v in speeds if lost + 3 * SECOND // 10 <= t <= wheel[1][0]]
    assert len(still) > 100
    assert {abs(round(speed, 3)) for pair in still for speed in pair} == {0.0}
    assert any(min(map(abs, v)) > 10.0 for t, v in speeds if t > wheel[2][0])


def test_a_drive_stops_by_itself_when_the_manager_is_lost() -> None:
    with build(BEEGO, goal(2.0, 0.0, 0.0)) as (system, _):
        system.run(5 * SECOND)
        assert abs(system.observable("LeftDrive0.speed")[0]) > 10.0
        manager = system.component("CanopenManager0")
        bus = open_link(system.clock)
        bus.cut(manager.station)  # type: ignore[attr-defined]
        system.run(6 * SECOND)
        for side in ("Left", "Right"):
            assert system.state(f"{side}Drive0") is ERROR_STATE
            assert "node 127 is lost" in system.statistics(f"{side}Drive0").reason
            assert system.observable(f"{side}Drive0.speed")[0] == 0.0


@pytest.mark.nightly
def test_two_runs_with_a_lost_drive_give_the_same_bytes() -> None:
    logs = []
    for _ in range(2):
        stream = io.StringIO()
        timeline = SILENCE
        for late, early in (("12.0", "2.0"), ("14.0", "3.0"), ("15.0", "3.5")):
            timeline = timeline.replace(f"t = {late}", f"t = {early}")
        with build(BEEGO, goal(0.5, 0.1, 0.5), timeline) as (system, sniffer):
            system.add_listener(JsonLinesRecorder(stream))
            assert system.run(MAX_DURATION, at_end)
            assert_at(truth(system, "RefHardRh3Canopen0"), 0.5, 0.1, 0.5)
        logs.append((stream.getvalue(), sniffer.frames))
    assert logs[0] == logs[1]


Series = list[tuple[int, int]]


def zip_latest(
    values: Series, others: Series
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield each value with the newest of the others at its time."""
    times = [time for time, _ in others]
    for time, value in values:
        place = bisect_right(times, time)
        if place:
            yield (time, value), others[place - 1]


@pytest.mark.sampled(0)
def test_a_motor_follows_a_potentiometer_with_no_master(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    samples: list[SampleRecord] = []
    with build(LINKING) as (system, sniffer):
        system.add_listener(
            lambda record: (
                samples.append(record) if isinstance(record, SampleRecord) else None
            )
        )
        assert system.run(20 * SECOND) is False
        assert {system.state(name) for name in system.instances} == {ACTIVE_STATE}
        assert {system.statistics(name).lost for name in system.instances} == {0}
    # After the motor is enabled, only the two nodes send.
    begin = SECOND
    seen = {frame.can_id for time, frame in sniffer.frames if time >= begin}
    assert seen == {0x181, 0x281, 0x282, 0x482, 0x701, 0x702}
    # A master's PDO never occurs: only the linked board sends an RPDO's identifier.
    ids = {frame.can_id for _, frame in sniffer.frames}
    assert not ids & {
        base + node for base in (0x200, 0x300, 0x400, 0x500) for node in (1, 2)
    }
    references = [(t, *palette.decode_tpdo4(d)) for t, d in sniffer.sent(0x482, begin)]
    angles = [(t, motor.decode_tpdo2(d)[0]) for t, d in sniffer.sent(0x281, begin)]
    assert len(references) > 1800
    assert len(angles) > 1800
    for time, reference in references:
        turned = sin(2 * pi * 0.1 * time / SECOND)
        assert reference == pytest.approx(90_000 * turned, abs=700)
    for (time, angle), (_, reference) in zip_latest(angles, references):
        assert angle == pytest.approx(reference, abs=1500), time
    places = [angle for _, angle in angles]
    assert max(places) == pytest.approx(90_000, abs=500)
    assert min(places) == pytest.approx(-90_000, abs=500)
    # The decoded record of the frames has the values of the proxies.
    record = tmp_path / "run.log"
    with can.Logger(record) as logger:
        for time, frame in sniffer.frames:
            logger(
                can.Message(
                    timestamp=time / SECOND,
                    arbitration_id=frame.can_id,
                    is_extended_id=False,
                    data=frame.data,
                )
            )
    bus = str(LINKING.with_suffix(".toml"))
    assert run(["can", "replay", str(record), "--decode", "--json", "--bus", bus]) == 0
    decoded = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert len(decoded) == len(sniffer.frames)
    for proxy, port, node, field in (
        ("Palette0", "tpdo4", "palette", "Angle_reference"),
        ("Motor0", "tpdo2", "motor", "Position_actual_value"),
    ):
        received = [
            round(getattr(s.value, field), 6)
            for s in samples
            if (s.instance, s.port) == (proxy, port)
        ]
        shown = [
            line["values"][0]["value"]
            for line in decoded
            if (line.get("name"), line["kind"]) == (node, port)
        ]
        # The proxies receive from their activation on; the last frame came after their last tick.
        assert len(received) > 1900
        more = len(shown) - len(received)
        assert any(shown[n:][: len(received)] == received for n in range(more + 1))
