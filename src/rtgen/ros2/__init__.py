"""The world of ROS 2: interfaces read, printed and generated."""
