"""TECS boards in ROS 2: functions of signatures joined through `RTCPlugin` are services."""
