"""What rclpy says of two QoS profiles: run in an installation of ROS 2, without rtgen.

Its input is a list of pairs of profiles in JSON, each `[reliability, durability, liveliness,
deadline, lease]`, times in nanoseconds. Its output is a list of booleans: whether they fit.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    QoSCompatibility,
    QoSProfile,
    qos_check_compatible,
)


def profile(values: list[Any]) -> QoSProfile:
    """Return a profile of rclpy."""
    reliability, durability, liveliness, deadline, lease = values
    times = {}
    if deadline is not None:
        times["deadline"] = Duration(nanoseconds=deadline)
    if lease is not None:
        times["liveliness_lease_duration"] = Duration(nanoseconds=lease)
    return QoSProfile(
        depth=1,
        reliability=reliability,
        durability=durability,
        liveliness=liveliness,
        **times,
    )


def fit(pair: list[list[Any]]) -> bool:
    """Return whether a publisher's profile satisfies a subscription's."""
    offered, requested = map(profile, pair)
    result, _ = qos_check_compatible(offered, requested)
    return bool(result == QoSCompatibility.OK)


print(json.dumps([fit(pair) for pair in json.load(sys.stdin)]))
