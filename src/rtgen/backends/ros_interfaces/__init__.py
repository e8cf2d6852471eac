"""Back end for interface files of ROS 2: a `.msg` for each struct, a `.srv` for each operation."""

from rtgen.backends.ros_interfaces.backend import BACKEND

__all__ = ["BACKEND"]
