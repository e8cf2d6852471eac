"""Transforms between frames, `[ros2.tf]` of rtgen.toml: ports of poses, and constant ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

POSES: Final[Mapping[str, tuple[bool, bool]]] = {
    "TimedPose2D": (False, False),
    "TimedPose3D": (False, False),
    "PoseStamped": (True, False),
    "PoseWithCovarianceStamped": (True, False),
    "Odometry": (True, True),
    "TransformStamped": (True, True),
}
"""Types of poses by the last part of their names: whether they have the parent, and the child."""
_PLACE: Final = ("x", "y", "z")
_ANGLES: Final = ("roll", "pitch", "yaw")
_QUATERNION: Final = ("qx", "qy", "qz", "qw")
_NUMBERS: Final = (*_PLACE, *_ANGLES, *_QUATERNION)
STATIC: Final = "static"
"""The key of the constant transforms."""


class StaticTransform(NamedTuple):
    """A constant transform: position in m, rotation as a quaternion x, y, z, w."""

    parent: str
    child: str
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]


def frame_violation(name: Any) -> str | None:
    """Return why a text is no frame; None if it is one."""
    if not isinstance(name, str) or not name:
        return "must be a text"
    if name.startswith("/"):
        return "begins with /, which tf2 refuses"
    if any(each.isspace() for each in name):
        return "has a space"
    return None


def static_violation(table: Any) -> str | None:
    """Return why a table is no constant transform; None if it is one."""
    if not isinstance(table, dict) or not {"parent", "child"} <= set(table):
        return "must have parent and child"
    for key, value in table.items():
        if key in ("parent", "child"):
            if why := frame_violation(value):
                return f"has the {key} {value!r}, which {why}"
        elif key not in _NUMBERS:
            return f"has the unknown key {key!r}; known: parent, child, {', '.join(_NUMBERS)}"
        elif (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not math.isfinite(value)
        ):
            return f"has the {key} {value!r}, which is no number"
    stated = set(table)
    if stated & set(_QUATERNION):
        if stated & set(_ANGLES):
            return "has both angles and a quaternion"
        length = math.hypot(*(table.get(key, 0.0) for key in _QUATERNION))
        if abs(length - 1.0) > 1e-3:
            return f"has a quaternion of the length {length:g}, not 1"
    return None


def tree_violation(pairs: Iterable[tuple[str, str]]) -> str | None:
    """Return why pairs of parent and child are no trees; empty frames are not known yet."""
    parents: dict[str, str] = {}
    for parent, child in pairs:
        if not parent or not child:
            continue
        if child in parents:
            return f"frame {child!r} has two parents: {parents[child]!r} and {parent!r}"
        parents[child] = parent
    for start in parents:
        frame, seen = start, {start}
        while frame in parents:
            frame = parents[frame]
            if frame in seen:
                return f"frame {frame!r} is above itself"
            seen.add(frame)
    return None
