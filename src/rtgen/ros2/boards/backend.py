"""The back end `ros-boards`: interface files of the services of TECS boards."""

from __future__ import annotations

from rtgen.compiler.backends import Emission, Options
from rtgen.compiler.model import Model
from rtgen.ros2.boards.interfaces import artifacts, interfaces


class RosBoardsBackend:
    """Writes `ros2/PACKAGE/srv/Name.srv` for each function, and messages of structs."""

    name = "ros-boards"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the files, and a warning for each function that is no service."""
        of_boards = interfaces(model, options.package)
        space = options.ros_boards or "/"
        files = [
            a for each in of_boards for a in artifacts(each, space, options.version)
        ]
        findings = [finding for each in of_boards for finding in each.findings]
        return Emission(tuple(files), tuple(findings))


BACKEND = RosBoardsBackend()
