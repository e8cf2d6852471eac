"""The time of runs and nodes: `/clock` from a run in simulated time, and from a node for a run."""

from __future__ import annotations

import importlib
import logging
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import media
import pytest
from rclpy_node import node
from ros2_peers import installation

from rtgen.cli import run as rtgen
from rtgen.runtime import Component, ComponentProfile, SimulatedClock, System
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.ros2 import clock as ros_clock
from rtgen.runtime.ros2.clock import CLOCK, ClockError, FollowedClock, publish_clock
from rtgen.runtime.ros2.network import OnMessage, Publish, RosTopic
from rtgen.runtime.ros2.turns import Turns
from rtgen.runtime.ros2.types import decoded, encoded, made
from rtgen.runtime.services.servants import CallEnded
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.running.ros2_classes import message_classes

CLASS = message_classes(CLOCK)[CLOCK]


def time_message(seconds: float) -> bytes:
    sec, nanosec = divmod(round(seconds * SECOND), SECOND)
    members = {"clock": {"sec": sec, "nanosec": nanosec}}
    return encoded(made(CLASS._descriptor_, members))


class _Network:
    """A network whose messages are given by tests, as those of a network thread."""

    def __init__(self) -> None:
        self.turns = Turns()
        self.sent: list[bytes] = []

    def publisher(self, topic: RosTopic, profile: Any) -> Publish:
        assert (topic.name, profile.depth) == ("/clock", 1)
        return self.sent.append

    def subscribe(self, topic: RosTopic, profile: Any, take: OnMessage) -> None:
        self._take = take

    def give(self, *seconds: float) -> None:
        """Receive times."""
        for each in seconds:
            octets = time_message(each)
            self.turns.post(partial(self._take, octets))


class _Watch(Component):
    """Notes the time at each tick."""

    profile = ComponentProfile("Watch", rate=10.0)

    def __init__(self) -> None:
        super().__init__("W0")
        self.seen: list[float] = []
        self.at_tick: dict[int, Any] = {}

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.seen.append(round(self.now() / SECOND, 3))
        self.at_tick.get(len(self.seen), int)()
        return RTC_OK


def following() -> tuple[System, _Watch, _Network, FollowedClock]:
    system, watch, network = System(SimulatedClock()), _Watch(), _Network()
    system.add(watch)
    system.activate("W0")
    return (
        system,
        watch,
        network,
        FollowedClock(network, system, CLASS, network.turns),
    )


def test_a_run_publishes_its_time() -> None:
    system, network = System(SimulatedClock()), _Network()
    publish_clock(network, system, CLASS, 10.0)
    system.run(SECOND // 20)
    found = [decoded(CLASS, octets).clock for octets in network.sent]
    assert [(t.sec, t.nanosec) for t in found] == [
        (0, 10_000_000 * i) for i in range(5)
    ]


def test_a_run_has_the_time_of_the_topic() -> None:
    system, watch, network, followed = following()
    network.give(1000.0)
    followed.begin(0.0)
    network.give(1000.05, 1000.2, 1000.31)
    assert not system.run(SECOND * 3 // 10)
    assert watch.seen == [1000.0, 1000.1, 1000.2]
    assert system.time == SECOND * 3 // 10


def test_the_run_waits_for_a_time_that_stands(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(ros_clock, "_STANDS", 0.0)
    monkeypatch.setattr(ros_clock, "_SLICE", 0.001)
    system, watch, network, followed = following()
    network.give(5.0)
    followed.begin(0.0)
    reported = threading.Event()

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if "stands" in record.getMessage():
                reported.set()

    handler = Handler()
    logging.getLogger("rtgen.runtime").addHandler(handler)

    def go_on() -> None:
        assert reported.wait(20)
        network.give(6.0)

    thread = threading.Thread(target=go_on)
    thread.start()
    with caplog.at_level(logging.INFO, "rtgen.runtime"):
        system.run(SECOND // 2)
    thread.join()
    logging.getLogger("rtgen.runtime").removeHandler(handler)
    assert watch.seen == [5.0, 5.1, 5.2, 5.3, 5.4]
    assert "/clock stands at 5.00" in caplog.text
    monkeypatch.setattr(ros_clock, "_LONGEST_STAND", 0.0)
    with pytest.raises(ClockError, match="has stood for 0 s"):
        system.run(2 * SECOND)


def test_a_time_that_leaps(caplog: pytest.LogCaptureFixture) -> None:
    """The run goes on, and its time for components is that of the topic."""
    system, watch, network, followed = following()
    network.give(50.0, 50.2)
    followed.begin(0.0)
    watch.at_tick = {
        3: lambda: network.give(20.0, 20.3),
        5: lambda: network.give(720.0, 721.0),
    }
    with caplog.at_level(logging.INFO, "rtgen.runtime"):
        system.run(SECOND)
    assert watch.seen[:3] == [50.0, 50.1, 50.2]
    assert watch.seen[3:5] == [20.1, 20.2]
    assert watch.seen[6:8] == [pytest.approx(720.1), pytest.approx(720.2)]
    assert len(watch.seen) == 10
    assert "leaps back by 30.200 s" in caplog.text
    assert "leaps forward by 699.7" in caplog.text


def test_no_time_at_all() -> None:
    *_, followed = following()
    with pytest.raises(ClockError, match="no time came from /clock within"):
        followed.begin(0.01)


def test_the_end_of_a_run_that_waits() -> None:
    system, _, network, followed = following()
    network.give(1.0)
    followed.begin(0.0)
    network.turns.post(lambda: system.end_run(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        system.run(SECOND)


def test_calls_wait_for_their_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns()
    callers: list[object] = []

    def note_caller() -> int:
        callers.append(threading.current_thread())
        return 7

    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(turns.call, note_caller)
        turns.rest(20.0, lambda: bool(callers))
        assert call.result(20.0) == 7
    assert callers == [threading.main_thread()]
    monkeypatch.setattr("rtgen.runtime.ros2.turns._PATIENCE", 0.01)
    with pytest.raises(CallEnded):
        turns.call(int)


SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:sim:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Two:1.0.0" rts:instanceName="T0"
      rts:pathUri="localhost/T0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
MODULE = """
from refrobots.rtc import TimedDouble
from rtgen.runtime import RTC_ERROR, RTC_OK, Component, ComponentProfile

READ = []


class Two(Component):
    profile = ComponentProfile("Two", rate=100.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.out = self.add_out_port("out", TimedDouble)
        self.inside = self.add_in_port("in", TimedDouble)

    def on_execute(self, ec_id):
        self.out.write(TimedDouble(data=self.now() / 1e9))
        while self.inside.is_new():
            READ.append((self.inside.read().data, self.now() / 1e9))
        return RTC_ERROR if len(READ) > 20 else RTC_OK
"""


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    monkeypatch.chdir(tmp_path)
    name = f"sim_{tmp_path.name}"
    Path(f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    Path("s.xml").write_text(SYSTEM)
    Path("rtgen.toml").write_text(
        f'[components]\nTwo = "{name}:Two"\n[ros2]\ndomain = {media.own_domain()}\n'
        '[ros2.topics]\n"T0.out" = { topic = "out", marshaling_type = "ros2:std_msgs/Float64" }\n'
        '"T0.in" = { topic = "in", marshaling_type = "ros2:std_msgs/Float64" }\n'
    )
    return name


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.waits
def test_a_node_of_rclpy_follows_a_run_at_ten_times_real_time(module: str) -> None:
    """Its timer of 0.2 s fires by the time of the run, which is never behind the node's."""
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    with node(installation("jazzy"), "n", domain=media.own_domain()) as peer:
        peer.do("follow", "/in", 0.2)
        peer.event("following")
        rtgen(
            ["run", "s.xml", "--ros2", "dds", "--rate", "10", "--until", "T0=ERROR,900"]
        )
    read = importlib.import_module(module).READ
    assert len(read) > 20
    told = [theirs for theirs, _ in read]
    assert told == sorted(told)
    assert told[-1] - told[0] >= 20 * 0.2 - 0.2
    assert all(0.0 < theirs <= ours + 0.011 for theirs, ours in read)


@pytest.mark.peer
@pytest.mark.waits
@pytest.mark.nightly
def test_a_run_follows_a_clock_of_rclpy(module: str) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    with node(installation("jazzy"), "n", domain=media.own_domain()) as peer:
        peer.do("subscribe", "/out", "std_msgs/msg/Float64", 1000)
        peer.event("subscribed")
        peer.do("lead", 1000, 0.02, 0.01, "/out")
        run = ["run", "s.xml", "--ros2", "dds", "--clock", "ros", "--until", "2"]
        assert rtgen(run) == 0
        peer.event("leading")
        peer.do("nodes")
        peer.event("nodes")
        told = [e[2]["data"] for e in peer.events if e[0] == "message"]
    assert told
    assert told == sorted(told)
    assert 1000.0 <= told[0] < told[-1]
    assert told[-1] - told[0] < 2.0
    steps = [round(b - a, 6) for a, b in pairwise(told)]
    assert set(steps) == {0.01}


REFUSED = {
    ("--ros2", "dds"): "--ros2 needs --clock real, --clock ros, or simulated time at a",
    ("--clock", "ros"): "--clock ros goes with --ros2",
    ("--clock", "ros", "--ros2", "dds", "--rate", "2"): "--rate goes with --clock sim",
}


@pytest.mark.parametrize("options", REFUSED)
def test_refused(
    options: tuple[str, ...], module: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert rtgen(["run", "s.xml", "--until", "1", *options]) == 2
    assert REFUSED[options] in capsys.readouterr().err
