"""Ports of poses on `/tf`, constant transforms on `/tf_static`, read by rosbags."""

from __future__ import annotations

import math
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import media
import pytest
from patience import until
from rosbags.typesys import Stores, get_typestore

from refrobots import iis, rtc
from rtgen.cli import run as rtgen
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.project import load
from rtgen.facts.ros_qos import PROFILES, Durability
from rtgen.facts.ros_transforms import StaticTransform
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import PortStatus
from rtgen.runtime.ros2.network import Publish, RosNode, RosTopic
from rtgen.runtime.ros2.transforms import MESSAGE, Frames, Transforms, quaternion
from rtgen.runtime.ros2.types import type_hash
from rtgen.tools.running.ros2_classes import message_classes

CLASSES = message_classes(
    *(MESSAGE, "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"),
    "geometry_msgs/msg/PoseWithCovarianceStamped",
)
STORE = get_typestore(Stores.ROS2_JAZZY)
HALF = math.sqrt(0.5)


class _Network:
    """A network whose messages are decoded by rosbags."""

    def __init__(self) -> None:
        self.sent: dict[str, list[Any]] = {}

    def publisher(self, topic: RosTopic, profile: Any) -> Publish:
        keeps = profile.durability is Durability.TRANSIENT_LOCAL
        assert keeps == (topic.name == "/tf_static")
        assert profile.depth == (1 if keeps else 100)
        sent = self.sent.setdefault(topic.name, [])
        return lambda octets: sent.extend(
            STORE.deserialize_cdr(octets, MESSAGE).transforms
        )


def told(type_: type[Any], sample: Any, parent: str = "", child: str = "") -> Any:
    """Return the transform of a sample of a port."""
    network: Any = _Network()
    port: OutPort[Any] = OutPort("pose", type_, "Base0")
    frames = [Frames(port, parent, child, "Base0")]
    transforms = Transforms(network, CLASSES[MESSAGE], frames, (), 0)
    assert port.write(sample) is PortStatus.PORT_OK
    transforms.close()
    port.write(sample)
    [found] = network.sent["/tf"]
    return found


def parts(found: Any) -> tuple[float, ...]:
    place, rotation = found.transform.translation, found.transform.rotation
    return tuple(
        round(float(each), 9)
        for each in (
            *(place.x, place.y, place.z),
            *(rotation.x, rotation.y, rotation.z, rotation.w),
        )
    )


def test_the_type_is_that_of_ros() -> None:
    digest = STORE.generate_msgdef(MESSAGE)[0]
    assert "geometry_msgs/TransformStamped" in digest
    assert type_hash(CLASSES[MESSAGE]) == STORE.hash_rihs01(MESSAGE)


def test_a_pose_in_the_plane() -> None:
    sample = iis.TimedPose2D(tm=rtc.Time(5, 6))
    sample.data.position.x, sample.data.heading = 2.0, math.pi / 2
    found = told(iis.TimedPose2D, sample, "odom", "base_link")
    assert (found.header.frame_id, found.child_frame_id) == ("odom", "base_link")
    assert (found.header.stamp.sec, found.header.stamp.nanosec) == (5, 6)
    assert parts(found) == (2, 0, 0, 0, 0, round(HALF, 9), round(HALF, 9))


def test_a_pose_in_space() -> None:
    sample = rtc.TimedPose3D(tm=rtc.Time(5, 6))
    sample.data.position = rtc.Point3D(1.0, 2.0, 3.0)
    sample.data.orientation.r = math.pi / 2
    found = told(rtc.TimedPose3D, sample, "map", "arm")
    assert parts(found) == (1, 2, 3, round(HALF, 9), 0, 0, round(HALF, 9))


@pytest.mark.parametrize(
    ("name", "frames"),
    [
        ("nav_msgs/msg/Odometry", ("", "")),
        ("nav_msgs/msg/Odometry", ("world", "robot")),
        ("geometry_msgs/msg/PoseStamped", ("", "base")),
        ("geometry_msgs/msg/PoseWithCovarianceStamped", ("", "base")),
        ("geometry_msgs/msg/TransformStamped", ("", "")),
    ],
)
def test_messages_with_frames(name: str, frames: tuple[str, str]) -> None:
    sample = CLASSES[name]()
    sample.header.frame_id, sample.header.stamp.sec = "odom", 7
    if hasattr(sample, "child_frame_id"):
        sample.child_frame_id = "base"
    if hasattr(sample, "transform"):
        place, rotation = sample.transform.translation, sample.transform.rotation
    else:
        pose = getattr(sample.pose, "pose", sample.pose)
        place, rotation = pose.position, pose.orientation
    place.x, rotation.z, rotation.w = 1.5, 0.6, 0.8
    found = told(CLASSES[name], sample, *frames)
    parent, child = frames
    assert found.header.frame_id == (parent or "odom")
    assert found.child_frame_id == (child or "base")
    assert found.header.stamp.sec == 7
    assert parts(found) == (1.5, 0, 0, 0, 0, 0.6, 0.8)


def test_what_is_no_pose_is_not_sent(caplog: pytest.LogCaptureFixture) -> None:
    network: Any = _Network()
    class_ = CLASSES["geometry_msgs/msg/PoseStamped"]
    port: OutPort[Any] = OutPort("pose", class_, "Base0")
    Transforms(network, CLASSES[MESSAGE], [Frames(port, "odom", "base")], (), 0)
    sample = class_()
    for rotation in (0.0, 2.0, math.nan):
        sample.pose.orientation.w = rotation
        assert port.write(sample) is PortStatus.PORT_ERROR
    sample.pose.orientation.w, sample.pose.position.x = 1.0, math.inf
    assert port.write(sample) is PortStatus.PORT_ERROR
    assert network.sent["/tf"] == []
    assert caplog.text.count("Base0.pose: no transform: ") == 1


@pytest.mark.parametrize(
    "angles", [(0.3, -0.2, 2.5), (0.0, 0.0, 0.0), (3.0, 1.5, -3.0)]
)
def test_angles_are_about_fixed_axes(angles: tuple[float, float, float]) -> None:
    """The rotation of a vector is that of the matrices about x, then y, then z."""
    x, y, z, w = quaternion(*angles)
    v = (0.3, -1.0, 2.0)
    cross = (y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0])
    again = tuple(c + w * e for c, e in zip(cross, v, strict=True))
    turned = (
        v[0] + 2 * (y * again[2] - z * again[1]),
        v[1] + 2 * (z * again[0] - x * again[2]),
        v[2] + 2 * (x * again[1] - y * again[0]),
    )
    for (i, j), angle in zip(((1, 2), (2, 0), (0, 1)), angles, strict=True):
        u = list(v)
        u[i] = v[i] * math.cos(angle) - v[j] * math.sin(angle)
        u[j] = v[i] * math.sin(angle) + v[j] * math.cos(angle)
        v = (u[0], u[1], u[2])
    assert turned == pytest.approx(v)


def test_constant_transforms_are_there_for_late_nodes() -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    from rtgen.runtime.ros2.dds import open_dds

    laser = StaticTransform("base", "laser", (0.2, 0.0, 0.1), (0.0, 0.0, 1.0, 0.0))
    camera = StaticTransform("base", "camera", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))
    with ExitStack() as stack:
        network = open_dds(RosNode("process", "/", media.own_domain()))
        stack.callback(network.close)
        Transforms(network, CLASSES[MESSAGE], (), [laser, camera], 5 * 10**9)
        late = open_dds(RosNode("late", "/", media.own_domain()))
        stack.callback(late.close)
        found: list[Any] = []
        topic = RosTopic("/tf_static", CLASSES[MESSAGE])
        late.subscribe(topic, PROFILES["static_tf"], found.append)
        [octets] = until(lambda: found)
    first, second = STORE.deserialize_cdr(octets, MESSAGE).transforms
    assert (first.child_frame_id, second.child_frame_id) == ("laser", "camera")
    assert parts(first) == (0.2, 0, 0.1, 0, 0, 1, 0)
    assert first.header.stamp.sec == 5


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


WRONG = {
    '"A.p" = "odom"': "which must be { parent",
    '"A" = { parent = "odom" }': "which is not INSTANCE.PORT",
    '"A.p" = { parent = "/odom" }': "gives 'A.p' the parent '/odom', which begins with /",
    '"A.p" = { parent = "a b" }': "has a space",
    '"A.p" = { parent = "a", child = "a" }': "frame 'a' is above itself",
    '"A.p" = { parent = "a", child = "b" }\n"B.p" = { parent = "c", child = "b" }': (
        "frame 'b' has two parents: 'a' and 'c'"
    ),
    'static = [{ parent = "a" }]': "must have parent and child",
    'static = [{ parent = "a", child = "b", w = 1 }]': "has the unknown key 'w'",
    'static = [{ parent = "a", child = "b", x = "1" }]': "has the x '1', which is no",
    'static = [{ parent = "a", child = "b", x = inf }]': "has the x inf, which is no",
    'static = [{ parent = "a", child = "b", qz = 0.5 }]': "of the length 0.5, not 1",
    'static = [{ parent = "a", child = "b", qw = 1, yaw = 1 }]': "has both angles",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_sections(text: str) -> None:
    Path("rtgen.toml").write_text(f"[ros2.tf]\n{text}\n")
    with pytest.raises(InputError) as error:
        load()
    [finding] = error.value.diagnostics
    assert WRONG[text] in finding.message
    assert finding.span is not None


SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:base:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Base:1.0.0" rts:instanceName="B0"
      rts:pathUri="localhost/B0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
MODULE = """
from refrobots.iis import TimedPose2D
from refrobots.rtc import TimedLong
from rtgen.runtime import RTC_OK, Component, ComponentProfile


class Base(Component):
    profile = ComponentProfile("Base", rate=10.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.pose = self.add_out_port("pose", TimedPose2D)
        self.add_out_port("count", TimedLong)

    def on_execute(self, ec_id):
        self.pose.write(TimedPose2D())
        return RTC_OK
"""
JUDGED = {
    '"B0.pose" = { parent = "odom", child = "base" }': None,
    '"B0.pose" = { parent = "odom" }': "B0.pose carries IIS::TimedPose2D, which has no fr",
    '"B0.count" = { parent = "odom", child = "b" }': "RTC::TimedLong, which is no pose",
    '"B0.none" = { parent = "odom", child = "b" }': "B0 has no OutPort 'none'; known: po",
    '"B1.pose" = { parent = "odom", child = "b" }': "there is no component 'B1'",
}


@pytest.mark.parametrize("text", JUDGED)
def test_ports_are_judged_before_the_run(
    text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    name = f"base_{tmp_path.name}"
    Path(f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    Path("s.xml").write_text(SYSTEM)
    Path("rtgen.toml").write_text(
        f'[components]\nBase = "{name}:Base"\n[ros2]\nmanaged_nodes = false\n'
        f"domain = {media.own_domain()}\n[ros2.tf]\n{text}\n"
        'static = [{ parent = "base", child = "laser", yaw = 3.14 }]\n'
    )
    run = ["run", "s.xml", "--ros2", "dds", "--clock", "real", "--until", "0.2"]
    code, message = rtgen(run), JUDGED[text]
    assert code == (0 if message is None else 2)
    errors = capsys.readouterr().err
    if message is not None:
        assert message in errors
        assert "rtgen.toml:7:" in errors
