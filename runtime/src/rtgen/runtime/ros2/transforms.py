"""Poses of OutPorts as transforms on `/tf`, and constant ones on `/tf_static` (tf2_msgs)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final, NamedTuple, TypeAlias

from rtgen.facts.ros_qos import PROFILES, Profile
from rtgen.facts.ros_transforms import StaticTransform
from rtgen.runtime.failures import log
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.ros2.conversions import time_to_stamp
from rtgen.runtime.ros2.life_cycle import Members
from rtgen.runtime.ros2.network import Ros2Error, RosNetwork, RosTopic
from rtgen.runtime.ros2.types import encoded, made
from rtgen.runtime.timing.clocks import SECOND

MESSAGE: Final = "tf2_msgs/msg/TFMessage"
_DYNAMIC: Final = Profile(100)
"""`DynamicBroadcasterQoS` of tf2_ros."""
_TOLERANCE: Final = 1e-3
"""Deviation of a quaternion's length from 1 that is corrected; tf2 refuses larger ones."""

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]


class Frames(NamedTuple):
    """A port whose poses are a transform; without a frame, it is that of the message.

    `node` is the node that shows the topic.
    """

    port: OutPort[Any]
    parent: str
    child: str
    node: str = ""


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation about the fixed axes x, y, z, in this order [rad]: x, y, z, w."""
    (sr, cr), (sp, cp), (sy, cy) = (
        (math.sin(angle / 2), math.cos(angle / 2)) for angle in (roll, pitch, yaw)
    )
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _pose_of(sample: Any) -> tuple[Vector, Quaternion]:
    """Return position and rotation of a sample of one of `facts.ros_transforms.POSES`."""
    if hasattr(sample, "data"):
        pose = sample.data
        position = pose.position
        if hasattr(pose, "heading"):
            return (position.x, position.y, 0.0), quaternion(0.0, 0.0, pose.heading)
        angles = pose.orientation
        rotation = quaternion(angles.r, angles.p, angles.y)
        return (position.x, position.y, position.z), rotation
    if hasattr(sample, "transform"):
        position, q = sample.transform.translation, sample.transform.rotation
    else:
        pose = sample.pose
        pose = pose.pose if hasattr(pose, "pose") else pose
        position, q = pose.position, pose.orientation
    return (position.x, position.y, position.z), (q.x, q.y, q.z, q.w)


def _members(
    stamp: Members, parent: str, child: str, position: Vector, q: Quaternion
) -> Members:
    """Return the members of a TransformStamped. Raises ValueError for what tf2 refuses."""
    length = math.hypot(*q)
    if not (all(map(math.isfinite, position)) and abs(length - 1.0) <= _TOLERANCE):
        raise ValueError(f"{position} with the quaternion {q} is no pose")
    if not parent or not child or parent == child:
        raise ValueError(f"no transform is from {parent!r} to {child!r}")
    return {
        "header": {"stamp": stamp, "frame_id": parent},
        "child_frame_id": child,
        "transform": {
            "translation": dict(zip("xyz", position, strict=True)),
            "rotation": {
                name: part / length for name, part in zip("xyzw", q, strict=True)
            },
        },
    }


class Transforms:
    """Publishes transforms until `close`; the network stays open."""

    def __init__(
        self,
        network: RosNetwork,
        class_: type[Any],
        frames: Iterable[Frames],
        static: Iterable[StaticTransform],
        now: int,
    ) -> None:
        """Publish the static transforms, and those of ports from now on. Raises Ros2Error.

        `class_` is that of `MESSAGE`; `now` is the time of the static ones [ns].
        """
        self._class = class_
        self._network = network
        self._writers = [_Writer(network, class_, each) for each in frames]
        seconds, rest = divmod(now, SECOND)
        stamp = {"sec": seconds, "nanosec": rest}
        constant = [
            _members(stamp, each.parent, each.child, each.position, each.rotation)
            for each in static
        ]
        if constant:
            topic = RosTopic("/tf_static", class_)
            publish = network.publisher(topic, PROFILES["static_tf"])
            publish(encoded(made(class_._descriptor_, {"transforms": constant})))

    def close(self) -> None:
        """Stop publishing."""
        for writer in self._writers:
            writer.close()


class _Writer:
    """Publishes the poses of a port."""

    def __init__(self, network: RosNetwork, class_: type[Any], frames: Frames) -> None:
        self._frames = frames
        self._class = class_
        self._has_failed = False
        topic = RosTopic("/tf", class_, frames.node)
        self._publish = network.publisher(topic, _DYNAMIC)
        frames.port.add_outlet(self.send)

    def send(self, sample: Any) -> PortStatus:
        """Publish a sample's pose; PORT_ERROR if it is none, or the network fails."""
        _, parent, child, _ = self._frames
        try:
            if hasattr(sample, "tm"):
                stamp = _Stamp()
                time_to_stamp(sample.tm, stamp)
            else:
                stamp = sample.header.stamp
                parent = parent or sample.header.frame_id
                child = child or getattr(sample, "child_frame_id", "")
            told = {"sec": stamp.sec, "nanosec": stamp.nanosec}
            members = _members(told, parent, child, *_pose_of(sample))
            message = made(self._class._descriptor_, {"transforms": [members]})
            self._publish(encoded(message))
        except (Ros2Error, ValueError) as error:
            if not self._has_failed:
                self._has_failed = True
                log.warning("%s: no transform: %s", self._frames.port, error)
            return PortStatus.PORT_ERROR
        self._has_failed = False
        return PORT_OK

    def close(self) -> None:
        """Stop publishing."""
        self._frames.port.remove_outlet(self.send)


class _Stamp:
    sec: int
    nanosec: int
