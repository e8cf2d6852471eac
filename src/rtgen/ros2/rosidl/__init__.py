"""Front end for ROS 2 interface files (`.msg`, `.srv`, `.action`): lines, types, declarations."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.ros2.rosidl.pipeline import load, read

__all__ = ["load", "read"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.ros2.rosidl.pipeline", __all__)
