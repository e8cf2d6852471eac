"""Data ports as topics of ROS 2, over DDS (as rmw_cyclonedds) or Zenoh (as rmw_zenoh)."""
