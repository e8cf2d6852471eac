"""Recent poses of the base, for measurements with a delay."""

from __future__ import annotations

from collections import deque
from math import hypot

from refnav.geometry import Pose, wrap
from refnav.messages import pose_of
from refrobots import iis, rtc

MAX_POSES = 128
"""Number of poses kept."""
TURN_JUMP = 0.6
"""A greater change of the heading than this is not a motion of the base [rad]."""


def jumped(before: Pose, here: Pose, most: float) -> str:
    """Return why two poses cannot be successive; empty if they can.

    `most` is the greatest distance [m]; 0: any distance and turn.
    """
    if most <= 0.0 or (
        hypot(here.x - before.x, here.y - before.y) <= most
        and abs(wrap(here.theta - before.theta)) <= TURN_JUMP
    ):
        return ""
    text = "jumped from ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f})"
    return text.format(*before, *here) + "; was its source restarted?"


class PoseHistory:
    """The newest poses with their times, in order of arrival."""

    def __init__(self) -> None:
        self._poses: deque[tuple[tuple[int, int], Pose]] = deque(maxlen=MAX_POSES)

    def __bool__(self) -> bool:
        return bool(self._poses)

    def add(self, sample: iis.TimedPose2D) -> None:
        """Add a pose."""
        self._poses.append(((sample.tm.sec, sample.tm.nsec), pose_of(sample.data)))

    @property
    def newest(self) -> Pose:
        """The newest pose; IndexError if there is none."""
        return self._poses[-1][1]

    def at(self, time: rtc.Time) -> Pose:
        """Return the last pose that is not later, else the oldest; IndexError if there is none."""
        stamp = (time.sec, time.nsec)
        earlier = [pose for noted, pose in self._poses if noted <= stamp]
        return earlier[-1] if earlier else self._poses[0][1]

    def move(self, x: float, y: float, theta: float) -> None:
        """Move every pose [m, rad], for a correction that also holds for the past."""
        self._poses = deque(
            (
                (time, Pose(pose.x + x, pose.y + y, wrap(pose.theta + theta)))
                for time, pose in self._poses
            ),
            maxlen=MAX_POSES,
        )

    def clear(self) -> None:
        """Remove all poses."""
        self._poses.clear()
