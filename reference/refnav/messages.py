"""Converts poses to and from messages."""

from __future__ import annotations

from refnav.geometry import Pose, wrap_positive
from refrobots import rtc


def pose_of(data: rtc.Pose2D) -> Pose:
    """Return the pose of a message, with its heading unchanged."""
    return Pose(data.position.x, data.position.y, data.heading)


def pose_message(pose: Pose) -> rtc.Pose2D:
    """Return a message with a pose, its heading unchanged."""
    return rtc.Pose2D(rtc.Point2D(pose.x, pose.y), pose.theta)


def pose_2d(pose: Pose) -> rtc.Pose2D:
    """Return a message with a heading within 0..2 pi, as in the interfaces of the third phase."""
    return rtc.Pose2D(rtc.Point2D(pose.x, pose.y), wrap_positive(pose.theta))
