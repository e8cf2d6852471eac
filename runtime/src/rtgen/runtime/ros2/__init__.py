"""Data ports as ROS 2 topics, over DDS (as rmw_cyclonedds) or Zenoh (as rmw_zenoh)."""
