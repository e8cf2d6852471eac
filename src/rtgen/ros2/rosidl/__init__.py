"""Front end for ROS 2 interface files (`.msg`, `.srv`, `.action`): lines, types, declarations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.stage import Settings
from rtgen.ros2.rosidl.pipeline import load

__all__ = ["load", "read"]


def read(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    """Read files with the settings of all front ends, as the stage of front ends calls it."""
    return load(
        paths,
        root=settings.root,
        include=settings.include,
        encoding=settings.encoding,
    )
