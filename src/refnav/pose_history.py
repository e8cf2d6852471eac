"""Where the base was lately: for measurements that come later than what they measure."""

from __future__ import annotations

from collections import deque

from refnav.geometry import Pose, wrap
from refnav.messages import pose_of
from refrobots import iis, rtc

REMEMBERED = 128
"""How many poses are kept."""


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
        """The last pose that is not later, else the oldest; IndexError if there is none."""
        stamp = (time.sec, time.nsec)
        told = [pose for noted, pose in self._poses if noted <= stamp]
        return told[-1] if told else self._poses[0][1]

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
