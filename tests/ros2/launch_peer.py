"""Launches a launch file: run in an installation of ROS 2 with launch_ros, without rtgen.

launch_peer.py FILE [ARGUMENT:=VALUE]...
"""

from __future__ import annotations

import sys

from launch import LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource


def main() -> int:
    service = LaunchService()
    arguments = [each.split(":=") for each in sys.argv[2:]]
    source = PythonLaunchDescriptionSource(sys.argv[1])
    service.include_launch_description(
        IncludeLaunchDescription(source, launch_arguments=arguments)
    )
    return int(service.run())


if __name__ == "__main__":
    raise SystemExit(main())
