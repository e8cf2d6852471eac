"""Back end for ROS 2 interface files: a `.msg` for each struct, a `.srv` for each operation."""

from rtgen.ros2.backend.backend import BACKEND

__all__ = ["BACKEND"]
