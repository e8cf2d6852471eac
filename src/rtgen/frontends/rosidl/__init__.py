"""Front end for ROS 2 interface files (`.msg`, `.srv`, `.action`): lines, types, declarations."""

from rtgen.frontends.rosidl.pipeline import load

__all__ = ["load"]
