"""Pairs of RT-Middleware data and ROS 2 messages that adapters convert, with their units.

The last part of its name identifies a type of RT-Middleware, so `RTC::TimedPose2D` and
`IIS::TimedPose2D` are converted alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

_POSE: Final = {
    "data.position.x": "m",
    "data.position.y": "m",
    "data.heading": "rad",
}
_VELOCITY: Final = {"data.vx": "m/s", "data.vy": "m/s", "data.va": "rad/s"}
_RANGES: Final = {
    "ranges": "m",
    "config.minAngle": "rad",
    "config.maxAngle": "rad",
    "config.angularRes": "rad",
    "config.minRange": "m",
    "config.maxRange": "m",
    "config.frequency": "Hz",
}
_SCAN: Final = {
    "angle_min": "rad",
    "angle_max": "rad",
    "angle_increment": "rad",
    "scan_time": "s",
    "range_min": "m",
    "range_max": "m",
    "ranges": "m",
}
_MAP: Final = {
    "config.xScale": "m/cell",
    "config.yScale": "m/cell",
    "config.origin.position.x": "m",
    "config.origin.position.y": "m",
    "config.origin.heading": "rad",
    "map.cells": None,
}


class Pair(NamedTuple):
    """A pair with the unit of each converted member (None without one); `stamped`: it has a time.

    `read` and `write` are functions of `rtgen.runtime.ros2.conversions`: from and to ROS.
    """

    rtm: str
    ros: str
    rtm_units: Mapping[str, str | None]
    ros_units: Mapping[str, str | None]
    read: str
    write: str
    stamped: bool = True


PAIRS: Final = (
    Pair(
        *("TimedPose2D", "geometry_msgs::msg::PoseStamped", _POSE),
        {"pose.position.x": "m", "pose.position.y": "m", "pose.orientation": None},
        *("pose_of_pose_stamped", "pose_to_pose_stamped"),
    ),
    Pair(
        *("TimedPose2D", "nav_msgs::msg::Odometry", _POSE),
        {"pose.pose.position.x": "m", "pose.pose.position.y": "m", "twist": None},
        *("pose_of_odometry", "pose_to_odometry"),
    ),
    Pair(
        *("TimedVelocity2D", "geometry_msgs::msg::Twist", _VELOCITY),
        {"linear": "m/s", "angular": "rad/s"},
        *("velocity_of_twist", "velocity_to_twist"),
        stamped=False,
    ),
    Pair(
        *("TimedVelocity2D", "geometry_msgs::msg::TwistStamped", _VELOCITY),
        {"twist.linear": "m/s", "twist.angular": "rad/s"},
        *("velocity_of_twist_stamped", "velocity_to_twist_stamped"),
    ),
    Pair(
        *("RangeData", "sensor_msgs::msg::LaserScan", _RANGES, _SCAN),
        *("ranges_of_scan", "ranges_to_scan"),
    ),
    Pair(
        *("TimedDoubleSeq", "sensor_msgs::msg::JointState"),
        {"data": "rad"},
        {"name": None, "position": "rad"},
        *("angles_of_joints", "angles_to_joints"),
    ),
    Pair(
        *("OccupancyGridMap", "nav_msgs::msg::OccupancyGrid", _MAP),
        {"info.resolution": "m", "info.origin": None, "data": None},
        *("map_of_grid", "map_to_grid"),
    ),
)


def pair_of(source: str, target: str) -> tuple[Pair, bool] | None:
    """Return the pair of two scoped names, and whether ROS is the target; None without one."""
    for pair in PAIRS:
        if target == pair.ros and source.rpartition("::")[2] == pair.rtm:
            return pair, True
        if source == pair.ros and target.rpartition("::")[2] == pair.rtm:
            return pair, False
    return None
