"""Back end for ROS 2 interface files: a `.msg` for each struct, a `.srv` for each operation."""

from rtgen.backends.ros_interfaces.backend import BACKEND

__all__ = ["BACKEND"]
