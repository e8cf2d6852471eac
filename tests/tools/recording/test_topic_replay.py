"""`rtgen replay` of bags of ROS 2: components driven by topics that their ports are bound to."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from bags import FORMS, HUMBLE, START, STEP, STORE, write
from rosbags.rosbag2 import Reader

from rtgen.cli import run as rtgen
from rtgen.tools.recording.mcap_writer import McapWriter

IDL = """
#include "std_msgs/msg/Float32.idl"
#include "BasicDataType.idl"

/** Doubles numbers. */
@rtc(category="Demo", vendor="me", rate=100.0)
component Doubler {
    consumes std_msgs::msg::Float32 number;
    publishes std_msgs::msg::Float32 twice;
};

/** Adds what it reads, with the time of its tick. */
@rtc(category="Demo", vendor="me", rate=50.0)
component Adder {
    consumes RTC::TimedFloat number;
    publishes RTC::TimedDouble total;
};
"""
DOUBLER = '''"""Doubles."""

from lab.components.doubler import DoublerBase
from lab.std_msgs.msg import Float32
from rtgen.runtime import RTC_OK


class Doubler(DoublerBase):
    """Doubles numbers."""

    def on_execute(self, ec_id):
        """Each number that has come."""
        while self.number.is_new():
            self.twice.write(Float32(2 * self.number.read().data))
        return RTC_OK
'''
ADDER = '''"""Adds."""

from lab.components.adder import AdderBase
from lab.rtc import TimedDouble
from rtgen.runtime import RTC_OK


class Adder(AdderBase):
    """Adds what it reads."""

    def on_activated(self, ec_id):
        """Begin with nothing."""
        self.sum = 0.0
        return RTC_OK

    def on_execute(self, ec_id):
        """Each number that has come."""
        while self.number.is_new():
            self.sum += self.number.read().data
        sample = TimedDouble(data=self.sum)
        self.stamp(sample)
        self.total.write(sample)
        return RTC_OK
'''
SETTINGS = """[sources]
paths = ["lab.idl"]
[output]
package = "lab"
skeletons = "parts"
[ros2]
namespace = "/robot"
[ros2.topics]
"Doubler0.number" = "goal"
"Doubler0.twice" = { topic = "twice", qos = "sensor_data" }
[ros2.topics."Adder0.number"]
topic = "twice"
qos = "sensor_data"
marshaling_type = "ros2:std_msgs/Float32"
"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:lab:1.0.0" rts:version="0.2" rts:abstract=""
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
{parts}</rts:RtsProfile>
"""
PART = """  <rts:Components rts:id="RTC:me:Demo:{0}:1.0.0" rts:instanceName="{0}0"
      rts:pathUri="localhost/{0}0.rtc" rts:compositeType="None" rts:isRequired="true">
    <rts:DataPorts rts:name="{0}0.number"/><rts:DataPorts rts:name="{0}0.{1}"/>
  </rts:Components>
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a project of two components, whose topics are a chain."""
    folder = tmp_path_factory.mktemp("lab")
    for name, text in {
        "lab.idl": IDL,
        "parts/doubler.py": DOUBLER,
        "parts/adder.py": ADDER,
        "rtgen.toml": SETTINGS,
        "s.xml": SYSTEM.format(
            parts=PART.format("Doubler", "twice") + PART.format("Adder", "total")
        ),
    }.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
    return folder


@pytest.fixture
def inside(project: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Work in the project; return a folder for results."""
    monkeypatch.chdir(project)
    for name in [n for n in sys.modules if n.partition(".")[0] in ("lab", "parts")]:
        monkeypatch.delitem(sys.modules, name)
    return tmp_path


def replayed(bag: Path, record: Path, *options: str) -> None:
    arguments = ["replay", str(bag), "--into", "s.xml", "--record", str(record), "-q"]
    assert rtgen([*arguments, *options]) == 0


def read(bag: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return times and numbers by topic, as rosbags reads them."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with Reader(bag) as reader:
        for connection, time, raw in reader.messages():
            value: Any = STORE.deserialize_cdr(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time - START, value.data))
    return found


@pytest.mark.sampled(2)
@pytest.mark.parametrize("form", [*FORMS, HUMBLE])
def test_a_bag_drives_components(form: str, inside: Path) -> None:
    """Twice: the results are equal, bit for bit."""
    bag = write(inside / "bag", form, [0.5, 1.5, 2.5])
    for name in ("one", "two"):
        replayed(bag, inside / f"{name}.mcap")
    for kind in ("", ".rtgen"):
        one, two = ((inside / f"{n}{kind}.mcap").read_bytes() for n in ("one", "two"))
        assert one == two
    topics = read(inside / "one.mcap")
    numbers = [(n * STEP, n + 0.5) for n in range(3)]
    assert topics["/robot/goal"] == numbers
    # Messages come after the ticks of their instant.
    delay = 10_000_000
    assert topics["/robot/twice"] == [
        (time + delay, 2 * value) for time, value in numbers[:2]
    ]


def test_components_have_the_time_of_the_bag(
    inside: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = write(inside / "bag", "mcap", range(100))
    replayed(bag, inside / "run")
    capfd.readouterr()
    events = inside / "run" / "rtgen.mcap"
    assert rtgen(["log", "cat", str(events), "Adder0.total"]) == 0
    samples = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    last = samples[-1]["value"]
    assert last["data"] == sum(2 * n for n in range(99))
    stamp = last["tm"]["sec"] * 10**9 + last["tm"]["nsec"]
    assert stamp == START + samples[-1]["t"]
    assert (inside / "run" / "metadata.yaml").exists()


def test_recorded_topics_play_for_absent_components(inside: Path) -> None:
    """With --only, what another component has published comes from the bag."""
    first = write(inside / "bag", "mcap", range(20))
    replayed(first, inside / "all")
    replayed(inside / "all", inside / "sum", "--only", "Adder0")
    whole, part = read(inside / "all"), read(inside / "sum")
    assert part == {"/robot/twice": whole["/robot/twice"]}


def test_end_and_pace(inside: Path) -> None:
    bag = write(inside / "bag", "mcap", range(20))
    replayed(bag, inside / "run", "--until", "0.1", "--rate", "1000")
    assert len(read(inside / "run")["/robot/goal"]) == 5


def test_messages_are_played_in_the_order_of_their_times(inside: Path) -> None:
    times = [40_000_000, 0, 20_000_000]
    bag = write(inside / "bag", "sqlite3", [2, 0, 1], times=times)
    replayed(bag, inside / "run")
    assert read(inside / "run")["/robot/goal"] == [(n * STEP, n) for n in range(3)]


def test_octets_after_a_message_are_ignored(inside: Path) -> None:
    """As rclpy's `serialize_message` adds them."""
    text = "float32 data\n"
    with McapWriter(inside / "bag.mcap", profile="ros2") as writer:
        schema = writer.schema("std_msgs/msg/Float32", "ros2msg", text)
        channel = writer.channel("/robot/goal", "cdr", schema, {})
        for n in range(3):
            octets = b"\0\1\0\0\0\0\x80\x3f" + b"\xff" * 3
            writer.message(channel, START + n * STEP, octets)
    replayed(inside / "bag.mcap", inside / "run")
    assert [value for _, value in read(inside / "run")["/robot/twice"]] == [2, 2]


def refusal(
    bag: Path, capfd: pytest.CaptureFixture[str], *options: str, code: int = 2
) -> str:
    assert rtgen(["replay", str(bag), "--into", "s.xml", *options]) == code
    return capfd.readouterr().err


def test_unknown_topics(inside: Path, capfd: pytest.CaptureFixture[str]) -> None:
    bag = write(inside / "bag", topic="/robot2/goal")
    error = refusal(bag, capfd)
    assert "error[SYS0008]" in error
    assert "has no topic /robot/goal, which Doubler0.number reads" in error
    assert "did you mean /robot2/goal?" in error


def test_a_bag_with_some_of_the_topics(
    inside: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    settings = Path("rtgen.toml").read_text()
    apart = settings.replace('topic = "twice"\n', 'topic = "sum"\n')
    Path("rtgen.toml").write_text(apart)
    try:
        bag = write(inside / "bag")
        error = refusal(bag, capfd, code=0)
    finally:
        Path("rtgen.toml").write_text(settings)
    assert "warning[SYS0035]" in error
    assert "has no topic /robot/sum, which Adder0.number reads" in error


FLOAT64_HASH = STORE.hash_rihs01("std_msgs/msg/Float64")


@pytest.mark.parametrize(
    ("name", "encoding", "text", "metadata", "what"),
    [
        ("std_msgs/msg/Float64", "ros2msg", "float64 data\n", {}, "Float64; the port"),
        ("std_msgs/msg/Float32", "ros2msg", "float64 data\n", {}, "another definition"),
        (
            "std_msgs/msg/Float32",
            "ros2msg",
            "float32 data\n",
            {"topic_type_hash": FLOAT64_HASH},
            "another definition",
        ),
        ("std_msgs/msg/Float32", "ros2msg", "float32 d d\n", {}, "line 1 of a message"),
        ("std_msgs/msg/Float32", "ros2idl", "struct {", {}, "line"),
        ("std_msgs/msg/Float32", "jsonschema", "{}", {}, "not those of ROS 2"),
        ("std_msgs/Float32", "ros2msg", "float32 data\n", {}, ""),
    ],
)
def test_other_types(
    name: str,
    encoding: str,
    text: str,
    metadata: dict[str, str],
    what: str,
    inside: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    bag = inside / "bag.mcap"
    with McapWriter(bag, profile="ros2") as writer:
        schema = writer.schema(name, encoding, text)
        channel = writer.channel("/robot/goal", "cdr", schema, metadata)
        writer.message(channel, START, b"\0\1\0\0\0\0\x80\x3f")
    error = refusal(bag, capfd, code=2 if what else 0)
    assert ("error[SYS0033]" in error) == bool(what)
    assert not what or str(bag) in error
    assert what in error


@pytest.mark.parametrize(
    ("times", "what"),
    [
        ([0, 1 << 62], "is not a time since 1970"),
        ([0, 10**18], "--until ends the replay before"),
    ],
)
def test_wrong_times(
    times: list[int], what: str, inside: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = write(inside / "bag", "sqlite3", [0, 1], times=times)
    assert what in refusal(bag, capfd)


def test_a_message_that_cannot_be_decoded(
    inside: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """It is left out with a warning, as one that a node sends."""
    with McapWriter(inside / "bag.mcap", profile="ros2") as writer:
        schema = writer.schema("std_msgs/msg/Float32", "ros2msg", "float32 data\n")
        channel = writer.channel("/robot/goal", "cdr", schema, {})
        for n, octets in enumerate((b"\0\1\0\0\0", b"\0\1\0\0\0\0\x80\x3f", b"")):
            writer.message(channel, START + n * STEP, octets)
        writer.message(channel, START + 4 * STEP, b"\0\1\0\0\0\0\x80\x3f")
    assert rtgen(["replay", str(inside / "bag.mcap"), "--into", "s.xml", "-q"]) == 0
    assert "a message cannot be decoded" in caplog.text
