"""`marshaling_type=ros2:PACKAGE/TYPE`: the ROS 2 message for each type of RT-Middleware.

The types and pairs are those of OpenRTM-aist 2.0 (ROS2Transport, ROS2Serializer), and the pairs of
adapters. The last part of its name identifies a type of RT-Middleware.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Final, NamedTuple

DEFAULT_TOPIC: Final = "chatter"
"""OpenRTM's default topic, for connectors without `dataport.ros2.topic`."""

_MARSHALING: Final = re.compile(r"ros2:([a-z][a-z0-9_]*)/(?:msg/)?([A-Z]\w*)", re.ASCII)

_NUMBERS: Final = ("State", "Short", "Long", "UShort", "ULong", "Float", "Double")
_SEQUENCES: Final = ("Short", "Long", "UShort", "ULong", "Float", "Double")
_ROS_NUMBERS: Final = (
    *("Float32", "Float64", "Int8", "Int16", "Int32", "Int64"),
    *("UInt8", "UInt16", "UInt32", "UInt64"),
)


class Conversion(NamedTuple):
    """Functions of `rtgen.runtime.ros2.conversions`; `stamped`: the message has a time."""

    read: str
    write: str
    stamped: bool


@cache
def known_conversions() -> Mapping[tuple[str, str], Conversion]:
    """Return conversions by the last part of the data's name, and by message.

    A message is given as in `std_msgs/msg/Float32`.
    """
    # Each start of a component imports this module for `parse`.
    from rtgen.facts.ros_adapters import PAIRS

    conversions = {
        ("TimedString", "std_msgs/msg/String"): Conversion(
            "text_of_string", "text_to_string", False
        )
    }
    for ros in _ROS_NUMBERS:
        kind = "real" if ros.startswith("Float") else "integer"
        for rtm in _NUMBERS:
            own = "real" if rtm in ("Float", "Double") else "integer"
            conversions[f"Timed{rtm}", f"std_msgs/msg/{ros}"] = Conversion(
                f"data_to_{own}", f"data_to_{kind}", False
            )
        for rtm in _SEQUENCES:
            own = "reals" if rtm in ("Float", "Double") else "integers"
            conversions[f"Timed{rtm}Seq", f"std_msgs/msg/{ros}MultiArray"] = Conversion(
                f"data_to_{own}", f"data_to_{kind}s", False
            )
    for rtm, ros, name in (
        ("TimedPoint3D", "geometry_msgs/msg/PointStamped", "point"),
        ("TimedVector3D", "geometry_msgs/msg/Vector3Stamped", "vector"),
        ("TimedQuaternion", "geometry_msgs/msg/QuaternionStamped", "quaternion"),
        ("CameraImage", "sensor_msgs/msg/Image", "image"),
    ):
        conversions[rtm, ros] = Conversion(
            f"{name}_of_message", f"{name}_to_message", True
        )
    for pair in PAIRS:
        key = pair.rtm, pair.ros.replace("::", "/")
        conversions[key] = Conversion(pair.read, pair.write, pair.stamped)
    return conversions


def parse(text: str) -> str | None:
    """Return the message of a marshaling type, `std_msgs/msg/Float32`; None for another form."""
    match = _MARSHALING.fullmatch(text)
    return None if match is None else f"{match[1]}/msg/{match[2]}"


def messages_for(scoped: str) -> tuple[str, ...]:
    """Return the messages as which data of a scoped name can be sent."""
    name = scoped.rpartition("::")[2]
    return tuple(ros for rtm, ros in known_conversions() if rtm == name)
