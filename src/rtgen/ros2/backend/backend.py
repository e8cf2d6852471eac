"""Writes ROS 2 interface files: `ros2/PACKAGE/msg/Name.msg`, `ros2/PACKAGE/srv/Name.srv`."""

from __future__ import annotations

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.model import Model
from rtgen.ros2.backend.packages import interface_texts

FOLDER = "ros2"
"""The folder of the packages, below the output folder."""


class RosInterfacesBackend:
    """Writes the interface files of the project's definitions, if `[ros2] interfaces` is set."""

    name = "ros-interfaces"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the files, and a warning for each omitted declaration."""
        texts, findings = interface_texts(model)
        artifacts = (
            Artifact(f"{FOLDER}/{each.path}", each.text, (each.key,)) for each in texts
        )
        return Emission(tuple(artifacts), tuple(findings))


BACKEND = RosInterfacesBackend()
