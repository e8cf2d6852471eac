"""`Component.logger`: printed and recorded by runs, on `/rosout` with ROS 2."""

from __future__ import annotations

import json
import logging
import os
from pathlib import Path
from typing import Any

import media
import pytest
from logged_process import LoggedProcess
from rclpy_node import node
from ros2_peers import installation

from rtgen.cli import run as rtgen
from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime import Component, SimulatedClock, System
from rtgen.runtime.ros2.managed import INTERFACES, ManagedNodes
from rtgen.runtime.ros2.network import OnMessage, Publish, RosService, RosTopic
from rtgen.runtime.ros2.types import decoded
from rtgen.runtime.timing.traffic import LogLine
from rtgen.tools.running.ros2_classes import message_classes

SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:talk:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Talk:1.0.0" rts:instanceName="T0"
      rts:pathUri="localhost/T0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
MODULE = """
from rtgen.runtime import RTC_OK, Component, ComponentProfile


class Talk(Component):
    profile = ComponentProfile("Talk", rate=10.0)

    def on_activated(self, ec_id):
        self.logger.debug("volts: %d", 12)
        self.logger.info("begins with %s", "all")
        self.logger.warning("low")
        return RTC_OK

    def on_execute(self, ec_id):
        self.logger.error("again")
        return RTC_OK
"""


@pytest.fixture(autouse=True)
def _in_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    name = f"talk_{tmp_path.name}"
    Path(f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    Path("s.xml").write_text(SYSTEM)
    Path("rtgen.toml").write_text(
        f'[components]\nTalk = "{name}:Talk"\n[ros2]\ndomain = {media.own_domain()}\n'
        'namespace = "/lab"\n'
    )


def test_a_run_prints_and_records_the_lines_of_components(
    capsys: pytest.CaptureFixture[str],
) -> None:
    run = ["run", "s.xml", "--until", "0.15", "--record", "r.mcap"]
    assert rtgen(run) == 0
    errors = capsys.readouterr().err
    assert "info: T0: begins with all\nwarning: T0: low\n" in errors
    assert errors.count("error: T0: again\n") == 2
    assert "volts" not in errors
    assert rtgen(["log", "cat", "r.mcap"]) == 0
    events = [
        json.loads(line)
        for line in capsys.readouterr().out.splitlines()
        if '"log"' in line
    ]
    assert [(e["t"], e["instance"], e["level"], e["text"]) for e in events] == [
        (0, "T0", 20, "begins with all"),
        (0, "T0", 30, "low"),
        (0, "T0", 40, "again"),
        (100_000_000, "T0", 40, "again"),
    ]
    assert [e["function"] for e in events] == ["on_activated"] * 2 + ["on_execute"] * 2
    assert rtgen(["run", "s.xml", "--until", "0.15", "-v"]) == 0
    assert "debug: T0: volts: 12" in capsys.readouterr().err


def test_lines_are_bounded_and_can_be_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    # A report of the test could not be sent with that text.
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    component = Component("T0")
    lines: list[Any] = []
    component._clock.traffic.watch(lines.append)
    component.logger.warning("x" * 100_000)
    component.logger.warning("a\0b\udc80")
    try:
        raise OSError("no device")
    except OSError:
        component.logger.exception("cannot open")
    assert all(isinstance(line, LogLine) for line in lines)
    assert len(lines[0].text) < 11_000
    assert lines[1].text == "ab?"
    assert lines[2].text.startswith("cannot open\nTraceback")
    assert lines[2].text.endswith("OSError: no device")


def test_instances_of_two_systems_do_not_share_a_logger() -> None:
    lines: list[Any] = []
    first, second = Component("T0"), Component("T0")
    first._clock.traffic.watch(lines.append)
    second.logger.error("of the second")
    first.logger.error("of the first")
    assert [line.text for line in lines] == ["of the first"]
    assert first.logger.name == "rtgen.components.T0"


class _Network:
    """A network that keeps what is published."""

    turns = None

    def __init__(self) -> None:
        self.sent: list[tuple[RosTopic, Any]] = []

    def publisher(self, topic: RosTopic, profile: Any) -> Publish:
        if topic.name == "/rosout":
            assert profile == PROFILES["rosout"]
        return lambda octets: self.sent.append((topic, decoded(topic.type, octets)))

    def subscribe(self, topic: RosTopic, profile: Any, take: OnMessage) -> None:
        """Do nothing."""

    def serve(self, service: RosService, take: Any) -> None:
        """Do nothing."""


@pytest.mark.parametrize(
    ("level", "told"), [(5, 10), (10, 10), (25, 20), (40, 40), (55, 50)]
)
def test_rosout(level: int, told: int) -> None:
    network: Any = _Network()
    system = System(SimulatedClock())
    component = Component("T0")
    system.add(component)
    nodes = ManagedNodes(
        network, system, {"T0": "T0"}, message_classes(*INTERFACES), "/lab"
    )
    component.logger.setLevel(logging.NOTSET + 1)
    system.run(1_500_000_000)
    component.logger.log(level, "text %d", 1)
    [(topic, line)] = [each for each in network.sent if each[0].name == "/rosout"]
    assert topic.node == "T0"
    assert (line.name, line.msg, line.level) == ("lab.T0", "text 1", told)
    assert (line.stamp.sec, line.stamp.nanosec) == (1, 500_000_000)
    assert line.function == "test_rosout"
    assert line.file == __file__
    assert line.line > 0
    nodes.close()
    component.logger.error("after the end")
    assert len([1 for topic, _ in network.sent if topic.name == "/rosout"]) == 1


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.waits
def test_a_node_of_rclpy_reads_rosout(tmp_path: Path) -> None:
    """Late, too: the lines are kept for ten seconds."""
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    with node(installation("jazzy"), "n", domain=media.own_domain()) as peer:
        peer.do("subscribe", "/rosout", "rcl_interfaces/msg/Log")
        peer.event("subscribed")
        options = ["-m", "rtgen", "run", "s.xml", "--ros2", "dds", "--clock", "real"]
        run = LoggedProcess(options, tmp_path, os.environ, tmp_path / "run.log")
        try:
            told = [peer.event("message")[1] for _ in range(5)]
        finally:
            assert run.end() == 0, run.text
    assert {m["name"] for m in told} == {"lab.T0"}
    assert {(m["level"], m["msg"]) for m in told} >= {(40, "again")}
    assert all(m["file"].endswith(".py") and m["line"] > 0 for m in told)
    assert all(m["stamp"]["sec"] > 1_700_000_000 for m in told)
