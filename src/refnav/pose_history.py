"""Recent poses of the base, for measurements that arrive late."""

from __future__ import annotations

from collections import deque
from math import hypot

from refnav.geometry import Pose, wrap
from refnav.messages import pose_of
from refrobots import iis, rtc

REMEMBERED = 128
"""How many poses are kept."""
TURN_JUMP = 0.6
"""A heading this far from the one before is not a motion of the base [rad]."""


def jumped(before: Pose, here: Pose, most: float) -> str:
    """Why one pose cannot follow upon the other, by `most` [m]; empty if it can, or `most` is 0."""
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
        self._poses: deque[tuple[tuple[int, int], Pose]] = deque(maxlen=REMEMBERED)

    def __bool__(self) -> bool:
        return bool(self._poses)

    def add(self, sample: iis.TimedPose2D) -> None:
        """Note a pose."""
        self._poses.append(((sample.tm.sec, sample.tm.nsec), pose_of(sample.data)))

    @property
    def newest(self) -> Pose:
        """The pose noted last; IndexError if there is none."""
        return self._poses[-1][1]

    def at(self, time: rtc.Time) -> Pose:
        """Return the last pose that is not later, else the oldest; IndexError if there is none."""
        stamp = (time.sec, time.nsec)
        earlier = [pose for noted, pose in self._poses if noted <= stamp]
        return earlier[-1] if earlier else self._poses[0][1]

    def move(self, x: float, y: float, theta: float) -> None:
        """Move every pose by so much [m, rad]: what was found out later was true before."""
        self._poses = deque(
            (
                (time, Pose(pose.x + x, pose.y + y, wrap(pose.theta + theta)))
                for time, pose in self._poses
            ),
            maxlen=REMEMBERED,
        )

    def clear(self) -> None:
        """Forget everything."""
        self._poses.clear()
