"""ROS 2 interface files (`.msg`, `.srv`, `.action`) to the model: lines, types, declarations."""

from rtgen.frontends.rosidl.pipeline import load

__all__ = ["load"]
