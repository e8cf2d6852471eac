"""Converts poses to and from messages."""

from __future__ import annotations

from refnav.geometry import Pose, wrap_positive
from refrobots import rtc


def pose_of(data: rtc.Pose2D) -> Pose:
    """Return a pose, its heading as it came: any angle is understood."""
    return Pose(data.position.x, data.position.y, data.heading)


def pose_message(pose: Pose) -> rtc.Pose2D:
    """Return a pose, its heading as it is."""
    return rtc.Pose2D(rtc.Point2D(pose.x, pose.y), pose.theta)


def pose_2d(pose: Pose) -> rtc.Pose2D:
    """Return a pose with its heading within 0..2 pi, for the third phase of the common
    interfaces.
    """
    return rtc.Pose2D(rtc.Point2D(pose.x, pose.y), wrap_positive(pose.theta))
