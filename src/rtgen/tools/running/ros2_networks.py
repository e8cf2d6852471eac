"""The networks of the option `--ros2`: rclpy of a sourced installation, DDS, Zenoh."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project import Project
from rtgen.compiler.project.ros2 import Ros2Settings
from rtgen.facts.extras import installation
from rtgen.tools.kit.console import Console
from rtgen.tools.running.engines import INTERFACE_HINT

if TYPE_CHECKING:
    from rtgen.runtime.ros2.network import RosNetwork, RosNode

AUTOMATIC: Final = "auto"
NETWORKS: Final = ("rclpy", "dds", "zenoh")
"""The values of the option; without one it is rclpy if that can be imported, else DDS."""
_LIBRARIES: Final = {"zenoh": "eclipse-zenoh"}
"""Names of packages that differ from those of their modules."""
_SOURCED: Final = (
    "source the setup file of ROS 2 (/opt/ros/DISTRIBUTION/setup.bash), and run rtgen with its "
    "Python; --ros2 dds needs no installation of ROS 2"
)


def open_network(
    kind: str, node: RosNode, project: Project, console: Console
) -> RosNetwork:
    """Open a network of `NETWORKS`, or the automatic one, and say which. Raises ToolError,
    Ros2Error.
    """
    settings = project.ros2
    chosen = _automatic(console) if kind == AUTOMATIC else kind
    try:
        if chosen == "rclpy":
            return _rclpy(node, settings, console)
        if chosen == "dds":
            network = _dds(node, settings.interface)
        else:
            network = _zenoh(node, settings.zenoh, project)
    except ImportError as error:
        missing = (error.name or "a library").partition(".")[0]
        missing = _LIBRARIES.get(missing, missing)
        message = f"--ros2 {chosen} needs {missing}, which is not installed"
        hint = installation(chosen)
        if kind == AUTOMATIC:
            message, hint = (
                f"{message}, nor is rclpy",
                f"{_SOURCED.partition(';')[0]}, or {hint}",
            )
        raise ToolError(message, hint=hint) from error
    if kind == AUTOMATIC:
        console.say(f"ROS 2: {chosen}")
    return network


def _automatic(console: Console) -> str:
    try:
        import rclpy  # noqa: F401
    except ModuleNotFoundError as error:
        if error.name == "rclpy":
            return "dds"
        console.say(f"ROS 2: rclpy cannot be imported: {error}")
        return "dds"
    except ImportError as error:
        console.say(f"ROS 2: rclpy cannot be imported: {error}")
        return "dds"
    return "rclpy"


def _rclpy(node: RosNode, settings: Ros2Settings, console: Console) -> RosNetwork:
    """Return the network of rclpy. Raises ToolError, Ros2Error."""
    try:
        from rtgen.runtime.ros2.rclpy import middleware, open_rclpy
    except ImportError as error:
        message = f"--ros2 rclpy needs rclpy, which cannot be imported: {error}"
        raise ToolError(message, hint=_SOURCED) from error
    for key in ("interface", "zenoh"):
        if getattr(settings, key) is not None:
            console.say(
                f"[ros2] {key} is not for --ros2 rclpy, which takes the settings of its middleware"
            )
    network = open_rclpy(node)
    console.say(f"ROS 2: rclpy, {middleware()}")
    return network


def _zenoh(node: RosNode, config: str | None, project: Project) -> RosNetwork:
    """Return the network of Zenoh. Raises Ros2Error, ImportError."""
    from rtgen.runtime.ros2.zenoh import open_zenoh

    place = None if config is None else Path(project.root, config)
    return open_zenoh(node, config=place)


def _dds(node: RosNode, interface: str | None) -> RosNetwork:
    """Return the network of DDS. Raises ToolError, Ros2Error, ImportError."""
    from rtgen.runtime.ros2.dds import open_dds
    from rtgen.runtime.ros2.network import Ros2Error

    try:
        return open_dds(node, interface=interface)
    except Ros2Error as error:
        if interface is None:
            raise
        message = f"[ros2] interface: Cyclone DDS does not start with {interface!r}"
        raise ToolError(message, hint=INTERFACE_HINT) from error
