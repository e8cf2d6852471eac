"""Conversions between data of RT-Middleware and messages of ROS 2, for generated adapters.

Each fills its second argument from the first. Units are SI on both sides: m, rad, s. What the
other side does not have keeps its value: frames, covariances, ids.
"""

from __future__ import annotations

import math
from typing import Any, Final

_LAST_SECOND: Final = (1 << 31) - 1
"""builtin_interfaces/msg/Time counts seconds with a sign."""


def time_to_stamp(tm: Any, stamp: Any) -> None:
    """`RTC::Time` to builtin_interfaces/msg/Time; times after 2038 are cut."""
    stamp.sec, stamp.nanosec = min(tm.sec, _LAST_SECOND), tm.nsec


def time_of_stamp(stamp: Any, tm: Any) -> None:
    """The other way; times before 1970 are 0."""
    tm.sec, tm.nsec = (stamp.sec, stamp.nanosec) if stamp.sec >= 0 else (0, 0)


def heading_of(q: Any) -> float:
    """The rotation about z of a quaternion, in (-pi, pi] rad; 0 for no rotation at all."""
    return math.atan2(
        2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z
    )


def _pose_to(data: Any, pose: Any) -> None:
    pose.position.x, pose.position.y = data.position.x, data.position.y
    pose.position.z = 0.0
    orientation = pose.orientation
    orientation.x = orientation.y = 0.0
    orientation.z, orientation.w = math.sin(data.heading / 2), math.cos(
        data.heading / 2
    )


def _pose_of(pose: Any, data: Any) -> None:
    data.position.x, data.position.y = pose.position.x, pose.position.y
    data.heading = heading_of(pose.orientation)


def _velocity_to(data: Any, twist: Any) -> None:
    twist.linear.x, twist.linear.y, twist.linear.z = data.vx, data.vy, 0.0
    twist.angular.x = twist.angular.y = 0.0
    twist.angular.z = data.va


def _velocity_of(twist: Any, data: Any) -> None:
    data.vx, data.vy, data.va = twist.linear.x, twist.linear.y, twist.angular.z


def pose_to_pose_stamped(sample: Any, made: Any) -> None:
    """TimedPose2D to geometry_msgs/msg/PoseStamped."""
    time_to_stamp(sample.tm, made.header.stamp)
    _pose_to(sample.data, made.pose)


def pose_of_pose_stamped(sample: Any, made: Any) -> None:
    """geometry_msgs/msg/PoseStamped to TimedPose2D: the part in the plane."""
    time_of_stamp(sample.header.stamp, made.tm)
    _pose_of(sample.pose, made.data)


def pose_to_odometry(sample: Any, made: Any) -> None:
    """TimedPose2D to nav_msgs/msg/Odometry; the velocity stays 0."""
    time_to_stamp(sample.tm, made.header.stamp)
    _pose_to(sample.data, made.pose.pose)


def pose_of_odometry(sample: Any, made: Any) -> None:
    """nav_msgs/msg/Odometry to TimedPose2D."""
    time_of_stamp(sample.header.stamp, made.tm)
    _pose_of(sample.pose.pose, made.data)


def velocity_to_twist(sample: Any, made: Any) -> None:
    """TimedVelocity2D to geometry_msgs/msg/Twist."""
    _velocity_to(sample.data, made)


def velocity_of_twist(sample: Any, made: Any) -> None:
    """geometry_msgs/msg/Twist to TimedVelocity2D, whose time the adapter sets."""
    _velocity_of(sample, made.data)


def velocity_to_twist_stamped(sample: Any, made: Any) -> None:
    """TimedVelocity2D to geometry_msgs/msg/TwistStamped."""
    time_to_stamp(sample.tm, made.header.stamp)
    _velocity_to(sample.data, made.twist)


def velocity_of_twist_stamped(sample: Any, made: Any) -> None:
    """geometry_msgs/msg/TwistStamped to TimedVelocity2D."""
    time_of_stamp(sample.header.stamp, made.tm)
    _velocity_of(sample.twist, made.data)


def ranges_to_scan(sample: Any, made: Any) -> None:
    """RangeData to sensor_msgs/msg/LaserScan."""
    config = sample.config
    time_to_stamp(sample.tm, made.header.stamp)
    made.angle_min, made.angle_max = config.minAngle, config.maxAngle
    made.angle_increment = config.angularRes
    made.scan_time = 1.0 / config.frequency if config.frequency > 0 else 0.0
    made.range_min, made.range_max = config.minRange, config.maxRange
    made.ranges = list(sample.ranges)


def ranges_of_scan(sample: Any, made: Any) -> None:
    """sensor_msgs/msg/LaserScan to RangeData."""
    config = made.config
    time_of_stamp(sample.header.stamp, made.tm)
    config.minAngle, config.maxAngle = sample.angle_min, sample.angle_max
    config.angularRes = sample.angle_increment
    config.frequency = 1.0 / sample.scan_time if sample.scan_time > 0 else 0.0
    config.minRange, config.maxRange = sample.range_min, sample.range_max
    made.ranges = list(sample.ranges)


def angles_to_joints(sample: Any, made: Any) -> None:
    """TimedDoubleSeq of angles to sensor_msgs/msg/JointState, whose names the adapter sets."""
    time_to_stamp(sample.tm, made.header.stamp)
    made.position = list(sample.data)


def angles_of_joints(sample: Any, made: Any) -> None:
    """sensor_msgs/msg/JointState to TimedDoubleSeq: the angles in the order of the message."""
    time_of_stamp(sample.header.stamp, made.tm)
    made.data = list(sample.position)
