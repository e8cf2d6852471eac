"""TECS boards in ROS 2: each function of a signature that is joined through `RTCPlugin` is a service."""
