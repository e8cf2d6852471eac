"""Data of RT-Middleware as messages of ROS 2 by `marshaling_type=ros2:PACKAGE/TYPE`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import media
import pytest

from refrobots import rtc
from rtgen.cli import run as rtgen
from rtgen.facts.ros_marshaling import known_conversions, messages_for, parse
from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import PortStatus
from rtgen.runtime.ros2.marshaling import (
    ConstantError,
    Marshaling,
    constant_of,
    marshaling,
)
from rtgen.runtime.ros2.network import OnMessage, Publish, Ros2Error, RosTopic
from rtgen.runtime.ros2.ports import Joint, RosPorts
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.running.ros2_classes import message_classes

TIME = rtc.Time(5, 6)
HEAD = b"\x00\x01\x00\x00"


def stamp(sample: Any) -> None:
    sample.tm = TIME


def made(type_: type[Any], ros: str) -> Marshaling:
    return marshaling(type_, message_classes(ros)[ros], stamp)


NUMBERS = {
    "TimedState": 5,
    "TimedShort": 5,
    "TimedLong": 5,
    "TimedUShort": 5,
    "TimedULong": 5,
    "TimedFloat": 5.0,
    "TimedDouble": 5.0,
}


@pytest.mark.parametrize(
    ("rtm", "ros"),
    [pair for pair in known_conversions() if pair[0].startswith("Timed")],
)
def test_each_pair_there_and_back(rtm: str, ros: str) -> None:
    type_ = getattr(rtc, rtm, None)
    if type_ is None:
        from refrobots import iis

        type_ = getattr(iis, rtm)
    sample = type_(tm=TIME)
    if rtm in NUMBERS:
        sample.data = NUMBERS[rtm]
    elif rtm.removesuffix("Seq") in NUMBERS and rtm.endswith("Seq"):
        sample.data = [NUMBERS[rtm.removesuffix("Seq")]] * 2
    elif rtm == "TimedString":
        sample.data = "hé"
    conversion = made(type_, ros)
    message = conversion.to_message(sample)
    octets = HEAD + message.to_cdr(True)
    back = conversion.of_message(deserialize(conversion.message, octets))
    assert back.to_cdr(True) == sample.to_cdr(True)


def test_vectors_and_images() -> None:
    point = rtc.TimedPoint3D(TIME, rtc.Point3D(1.0, 2.0, 3.0))
    conversion = made(rtc.TimedPoint3D, "geometry_msgs/msg/PointStamped")
    message = conversion.to_message(point)
    assert (message.point.x, message.point.z, message.header.stamp.sec) == (1.0, 3.0, 5)
    assert conversion.of_message(message) == point
    image = rtc.CameraImage(TIME, 2, 2, 24, "", 1.0, bytes(range(12)))
    conversion = made(rtc.CameraImage, "sensor_msgs/msg/Image")
    message = conversion.to_message(image)
    assert (message.encoding, message.step) == ("rgb8", 6)
    # Rows of other writers have padding.
    message.step, message.data = 8, bytes((*range(6), 0, 0, *range(6, 12), 0, 0))
    back = conversion.of_message(message)
    assert (back.bpp, back.format, back.pixels) == (24, "rgb8", image.pixels)
    message.step, message.width = 1, 0
    assert conversion.of_message(message).pixels == b""
    image.bpp = 12
    with pytest.raises(ValueError, match="needs a format"):
        conversion.to_message(image)


def test_values_out_of_range_do_not_come_in() -> None:
    conversion = made(rtc.TimedShort, "std_msgs/msg/Int64")
    message = conversion.to_message(rtc.TimedShort(TIME, 7))
    message.data = 1 << 40
    with pytest.raises(CdrError):
        conversion.of_message(message)
    image = made(rtc.CameraImage, "sensor_msgs/msg/Image")
    message = image.to_message(rtc.CameraImage(TIME, 2, 2, 8, "", 1.0, bytes(4)))
    message.width = 1 << 20
    with pytest.raises(ValueError, match="are too many"):
        image.of_message(message)
    message.width, message.step, message.encoding = 1, 1 << 20, "own"
    with pytest.raises(CdrError):
        image.of_message(message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ros2:std_msgs/Float32", "std_msgs/msg/Float32"),
        ("ros2:std_msgs/msg/Float32", "std_msgs/msg/Float32"),
        ("ros2:Float32", None),
        ("std_msgs/Float32", None),
        ("cdr", None),
    ],
)
def test_texts(text: str, message: str | None) -> None:
    assert parse(text) == message


class _Loop:
    """A network that returns each message."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []
        self.take: dict[str, OnMessage] = {}

    def publisher(self, topic: RosTopic, profile: Any) -> Publish:
        assert topic.type_name == "std_msgs/msg/UInt8"
        return self.sent.append

    def subscribe(self, topic: RosTopic, profile: Any, on_message: OnMessage) -> None:
        self.take[topic.name] = on_message

    def close(self) -> None:
        """Do nothing."""


def test_ports() -> None:
    network = _Loop()
    out: OutPort[Any] = OutPort("out", rtc.TimedDouble, "a")
    in_: InPort[Any] = InPort("in", rtc.TimedDouble, "a")
    conversion = made(rtc.TimedDouble, "std_msgs/msg/UInt8")
    profile = PROFILES["default"]
    joints = [Joint(port, "/x", profile, conversion) for port in (out, in_)]
    ports = RosPorts(network, joints)
    assert out.write(rtc.TimedDouble(TIME, 7.9)) is PortStatus.PORT_OK
    assert network.sent == [HEAD + b"\x07"]
    network.take["/x"](HEAD + b"\x09")
    assert in_.read() == rtc.TimedDouble(TIME, 9.0)
    for value in (256.0, -1.0, float("nan"), float("inf")):
        assert out.write(rtc.TimedDouble(TIME, value)) is PortStatus.PORT_ERROR
    assert len(network.sent) == 1
    ports.close()


def test_other_pairs_are_refused() -> None:
    with pytest.raises(Ros2Error, match="RTC::TimedLong cannot go as std_msgs/msg/Str"):
        made(rtc.TimedLong, "std_msgs/msg/String")
    assert messages_for("RTC::TimedString") == ("std_msgs/msg/String",)


ODOMETRY = "nav_msgs/msg/Odometry"


def fixed(type_: type[Any], ros: str, **values: Any) -> Marshaling:
    message = message_classes(ros)[ros]
    constants = tuple(
        constant_of(message, path.replace("__", "."), value)
        for path, value in values.items()
    )
    return marshaling(type_, message, stamp, constants)


def test_constants() -> None:
    from refrobots import iis

    covariance = tuple(float(number) for number in range(36))
    conversion = fixed(
        iis.TimedPose2D,
        ODOMETRY,
        header__frame_id="odom",
        child_frame_id="base",
        pose__covariance=covariance,
    )
    for _ in range(2):
        message = conversion.to_message(iis.TimedPose2D(tm=TIME))
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base")
        assert tuple(message.pose.covariance) == covariance
        assert message.header.stamp.sec == TIME.sec
        message.pose.covariance[0] = 7.0
        message.to_cdr(True)
    joints = fixed(
        rtc.TimedDoubleSeq, "sensor_msgs/msg/JointState", name=("left", "right")
    )
    message = joints.to_message(rtc.TimedDoubleSeq(TIME, [1.0, 2.0]))
    assert message.name == ["left", "right"]
    assert list(message.position) == [1.0, 2.0]


WRONG_CONSTANTS = {
    ("header.fram_id", "x"): "std_msgs::msg::Header has no member 'fram_id'",
    ("heder.frame_id", "x"): "nav_msgs::msg::Odometry has no member 'heder'",
    ("header", "x"): "'header' is std_msgs::msg::Header, which is not 'x'",
    ("header.frame_id", 1): "'header.frame_id' is string, which is not 1",
    ("header.frame_id", ("a",)): "'header.frame_id' is string, which is not ['a']",
    ("header.stamp.sec", 1 << 40): "'header.stamp.sec' is long, which is not",
    ("header.stamp.sec", True): "'header.stamp.sec' is long, which is not True",
    ("header.stamp.sec", 1.5): "'header.stamp.sec' is long, which is not 1.5",
    ("pose.covariance", (1.0,) * 35): "is double[36], which is not a list of 35",
    ("pose.covariance", ("a",) * 36): "is double[36], which is not a list of 36",
    ("child_frame_id.x", "a"): "'child_frame_id' of nav_msgs::msg::Odometry is not a",
}


@pytest.mark.parametrize("case", WRONG_CONSTANTS, ids=str)
def test_wrong_constants(case: tuple[str, Any]) -> None:
    message = message_classes(ODOMETRY)[ODOMETRY]
    with pytest.raises(ConstantError) as error:
        constant_of(message, *case)
    assert WRONG_CONSTANTS[case] in str(error.value)
    if "has no member" in str(error.value):
        assert str(error.value.hint).startswith("did you mean")


SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:two:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rts:Components rts:id="RTC:me:Demo:Two:1.0.0" rts:instanceName="T0"
      rts:pathUri="localhost/T0.rtc" rts:compositeType="None" rts:isRequired="true">
    <rts:DataPorts rts:name="T0.out"/>
    <rts:DataPorts rts:name="T0.in"/>
  </rts:Components>
  <rts:DataPortConnectors rts:connectorId="c" rts:name="c" rts:dataType="IDL:RTC/TimedFloat:1.0"
      rts:interfaceType="ros2" rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort xsi:type="rtsExt:target_port_ext" rts:portName="T0.out"
        rts:instanceName="T0" rts:componentId="RTC:me:Demo:Two:1.0.0"/>
    <rts:targetDataPort xsi:type="rtsExt:target_port_ext" rts:portName="T0.in"
        rts:instanceName="T0" rts:componentId="RTC:me:Demo:Two:1.0.0"/>
    <rtsExt:Properties rtsExt:name="dataport.marshaling_type" rtsExt:value="ros2:{message}"/>
    <rtsExt:Properties rtsExt:name="dataport.ros2.topic" rtsExt:value="{topic}"/>{more}
  </rts:DataPortConnectors>
</rts:RtsProfile>
"""
MODULE = """
from refrobots.rtc import TimedFloat
from rtgen.runtime import RTC_ERROR, RTC_OK, Component, ComponentProfile

READ = []


class Two(Component):
    profile = ComponentProfile("Two", rate=100.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.out = self.add_out_port("out", TimedFloat)
        self.inside = self.add_in_port("in", TimedFloat)

    def on_execute(self, ec_id):
        self.out.write(TimedFloat(data=2.5))
        while self.inside.is_new():
            READ.append(self.inside.read())
        return RTC_ERROR if READ else RTC_OK
"""


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    monkeypatch.chdir(tmp_path)
    name = f"two_{tmp_path.name}"
    Path(f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    Path("rtgen.toml").write_text(
        f'[components]\nTwo = "{name}:Two"\n[ros2]\ndomain = {media.own_domain()}\n'
    )
    return name


RUN = ("run", "s.xml", "--clock", "real", "--ros2", "dds", "--until", "T0=ERROR", "-q")


def test_a_connection_over_a_topic(module: str) -> None:
    """The time of a sample is that of its arrival: it went through std_msgs/Float64."""
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    import importlib

    text = SYSTEM.format(message="std_msgs/Float64", topic="speed", more="")
    Path("s.xml").write_text(text)
    rtgen([*RUN])
    read = importlib.import_module(module).READ
    assert read
    assert {sample.data for sample in read} == {2.5}
    assert all(sample.tm.sec for sample in read)


REFUSED = {
    ("std_msgs/String", "x"): "RTC::TimedFloat, which cannot go as std_msgs/msg/String",
    ("std_msgs/Float32", "a b"): "the topic 'a b' of T0.out consists of words",
    ("Float32", "x"): "cdr or ros2:PACKAGE/TYPE",
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_before_the_start(
    case: tuple[str, str], module: str, capsys: pytest.CaptureFixture[str]
) -> None:
    message, topic = case
    Path("s.xml").write_text(SYSTEM.format(message=message, topic=topic, more=""))
    assert rtgen([*RUN]) == 2
    assert REFUSED[case] in capsys.readouterr().err


SET = '<rtsExt:Properties rtsExt:name="dataport.ros2.set" rtsExt:value="{}"/>'
REFUSED_CONSTANTS = {
    "data = 1.5": None,
    "dat = 1.5": "T0.out: std_msgs::msg::Float64 has no member 'dat'",
    "data = 'x'": "T0.out: 'data' is double, which is not 'x'",
    "data 1": '"MEMBER" = VALUE',
}


@pytest.mark.parametrize("text", REFUSED_CONSTANTS)
def test_constants_of_a_connection(
    text: str, module: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    import importlib

    system = SYSTEM.format(
        message="std_msgs/Float64", topic="speed", more=SET.format(text)
    )
    Path("s.xml").write_text(system)
    code, message = rtgen([*RUN]), REFUSED_CONSTANTS[text]
    if message is None:
        read = importlib.import_module(module).READ
        assert {sample.data for sample in read} == {1.5}
    else:
        assert code == 2
        assert message in capsys.readouterr().err


REFUSED_SETTINGS = {
    'set = { dat = 1.5 }, marshaling_type = "ros2:std_msgs/Float64"': (
        "has no member 'dat'",
        "did you mean 'data'?",
        "s.toml:6:",
    ),
    'set = { "data" = "x" }, marshaling_type = "ros2:std_msgs/Float64"': (
        "'data' is double, which is not 'x'",
    ),
    'set = { data = [[1]] }, marshaling_type = "ros2:std_msgs/Float64"': (
        "gives 'T0.out' `set`, which must be a table of members",
    ),
    "set = { data = 1.5 }": (
        "gives 'T0.out' `set`, which goes with a marshaling_type",
    ),
}


@pytest.mark.parametrize("text", REFUSED_SETTINGS)
def test_constants_of_a_topic(
    text: str, module: str, capsys: pytest.CaptureFixture[str]
) -> None:
    system = SYSTEM.format(message="std_msgs/Float64", topic="speed", more="")
    Path("s.xml").write_text(system.replace("ros2:std_msgs/Float64", "cdr"))
    with Path("rtgen.toml").open("a") as file:
        file.write(f'[ros2.topics]\n"T0.out" = {{ topic = "x", {text} }}\n')
    assert rtgen([*RUN]) == 2
    errors = capsys.readouterr().err
    for message in REFUSED_SETTINGS[text]:
        assert message.replace("s.toml", "rtgen.toml") in errors


PROPERTY = '<rtsExt:Properties rtsExt:name="dataport.{}" rtsExt:value="{}"/>'
QOS: dict[tuple[tuple[str, str], ...], str | None] = {
    (("ros2.qos", "sensor_data"), ("ros2.depth", "50")): None,
    (
        ("cyclone-dds.writer_qos.durability.kind", "TRANSIENT_LOCAL_DURABILITY_QOS"),
        ("fast-rtps.subscriber.topic.historyQos.depth", "100"),
    ): None,
    (("ros2.depth", "0"),): "it must be a number of messages from 1 to",
    (("ros2.deadline", "soon"),): "it must be a time in seconds, above 0",
    (("ros2.reliabilty", "reliable"),): "did you mean dataport.ros2.reliability?",
    (
        ("fast-rtps.publisher.qos.reliability.kind", "BEST_EFFORT"),
    ): "it must be RELIABLE_RELIABILITY_QOS or BEST_EFFORT_RELIABILITY_QOS",
    (
        ("ros2.reliability", "reliable"),
        ("ros2.reader_qos.reliability.kind", "BEST_EFFORT_RELIABILITY_QOS"),
    ): "state one of them",
    (
        ("ros2.history", "keep_all"),
        ("ros2.depth", "5"),
    ): "history = keep_all keeps every",
    (
        ("fast-rtps.publisher.qos.reliability.kind", "BEST_EFFORT_RELIABILITY_QOS"),
    ): "reliability is best_effort at the publisher, reliable at the subscription",
    (
        ("fast-rtps.subscriber.qos.deadline.period.seconds", "1"),
        ("fast-rtps.publisher.qos.deadline.period.seconds", "2"),
    ): "deadline is 2 at the publisher, 1 at the subscription",
}


@pytest.mark.parametrize("stated", QOS, ids=str)
def test_qos_of_a_connection(
    stated: tuple[tuple[str, str], ...],
    module: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    import importlib

    more = "".join(PROPERTY.format(*each) for each in stated)
    system = SYSTEM.format(message="std_msgs/Float64", topic="speed", more=more)
    Path("s.xml").write_text(system)
    code, message = rtgen([*RUN]), QOS[stated]
    said = capsys.readouterr().err
    if message is None:
        assert importlib.import_module(module).READ
    else:
        assert code == 2
        assert message in said
        assert "RTC058" in said
        assert "dataport." in said
