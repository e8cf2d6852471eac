"""Classes of the ROS 2 interfaces that ship with rtgen."""

from __future__ import annotations

from typing import Any

from rtgen.compiler.kit.resources import ros_file


def message_classes(*interfaces: str) -> dict[str, Any]:
    """Return the classes of interfaces that ship with rtgen, and of contained ones, by name."""
    from rtgen.ros2.rosidl import load
    from rtgen.tools.recording.schema_types import message_classes

    files = [ros_file(f"{name}.{name.split('/')[1]}") for name in interfaces]
    return message_classes(load(files, root=files[0].parents[2]).model)
