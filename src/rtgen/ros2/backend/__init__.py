"""Back end for ROS 2 interface files: a `.msg` for each struct, a `.srv` for each operation."""
