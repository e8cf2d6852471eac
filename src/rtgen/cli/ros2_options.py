"""The option `--ros2` of the commands that run a system."""

from __future__ import annotations

from typing import Any

import click

from rtgen.tools.running.ros2_networks import AUTOMATIC, NETWORKS


class _Network(click.types.StringParamType):
    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the name of a network. Raises click.BadParameter."""
        if value not in (AUTOMATIC, *NETWORKS):
            names = ", ".join(NETWORKS)
            self.fail(
                f"'{value}' is none of {names}; a system goes before --ros2.",
                param,
                ctx,
            )
        return str(value)


ROS2_OPTION = click.option(
    "--ros2",
    type=_Network(),
    is_flag=False,
    flag_value=AUTOMATIC,
    metavar="[rclpy|dds|zenoh]",
    help="Be nodes of ROS 2; default: rclpy, or else dds.",
)
