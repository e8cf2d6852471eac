"""`[ros2.tf]` of a run: ports of poses as transforms, judged before it starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.project.ros2 import Ros2Settings, TransformEntry
from rtgen.compiler.systems.rules import ROS_TOPIC
from rtgen.facts.ros_transforms import POSES, StaticTransform

if TYPE_CHECKING:
    from rtgen.runtime.ros2.network import RosNetwork
    from rtgen.runtime.ros2.transforms import Frames, Transforms


def frames_of(
    settings: Ros2Settings, running: runtime.System, nodes: Mapping[str, str]
) -> list[Frames]:
    """Return the ports with their frames. Raises InputError for all invalid ones."""
    from rtgen.runtime.ros2.transforms import Frames

    found: list[Frames] = []
    diagnostics: list[Diagnostic] = []
    for entry in settings.transforms:
        problem = _problem(entry, running)
        if problem is not None:
            diagnostics.append(ROS_TOPIC.at(entry.span, problem))
            continue
        port = running.component(entry.instance).out_ports[entry.port]
        node = nodes.get(entry.instance, "")
        found.append(Frames(port, entry.parent, entry.child, node))
    if diagnostics:
        raise InputError(diagnostics)
    return found


def publish_transforms(
    network: RosNetwork,
    settings: Ros2Settings,
    frames: list[Frames],
    class_: type[Any],
    now: int,
) -> Transforms:
    """Publish the transforms. Raises Ros2Error."""
    from rtgen.runtime.ros2.transforms import Transforms

    static = [_static(table) for table in settings.static_transforms]
    return Transforms(network, class_, frames, static, now)


def _static(table: Mapping[str, Any]) -> StaticTransform:
    from rtgen.runtime.ros2.transforms import quaternion

    def numbers(*keys: str) -> list[float]:
        return [float(table.get(key, 0.0)) for key in keys]

    x, y, z = numbers("x", "y", "z")
    if any(key in table for key in ("qx", "qy", "qz", "qw")):
        qx, qy, qz, qw = numbers("qx", "qy", "qz", "qw")
        rotation = qx, qy, qz, qw
    else:
        rotation = quaternion(*numbers("roll", "pitch", "yaw"))
    return StaticTransform(table["parent"], table["child"], (x, y, z), rotation)


def _problem(entry: TransformEntry, running: runtime.System) -> str | None:
    """Return why a port cannot be a transform."""
    if entry.instance not in running.instances:
        names = ", ".join(running.instances)
        return f"there is no component {entry.instance!r}; known: {names}"
    ports = running.component(entry.instance).out_ports
    if entry.port not in ports:
        names = ", ".join(ports) or "none"
        return f"{entry.instance} has no OutPort {entry.port!r}; known: {names}"
    name = str(ports[entry.port].type._descriptor_.name)
    known = POSES.get(name.rpartition("::")[2])
    whole = f"{entry.instance}.{entry.port}"
    if known is None:
        return f"{whole} carries {name}, which is no pose; known: {', '.join(POSES)}"
    for has, stated, end in zip(
        known, (entry.parent, entry.child), ("parent", "child"), strict=True
    ):
        if not has and not stated:
            return f"{whole} carries {name}, which has no frames: {end} is missing"
    return None
