"""Messages for tests, generated from the packages that ship with rtgen."""

from __future__ import annotations

import importlib
import sys
from types import ModuleType

import pytest

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.kit.resources import ros_file
from rtgen.ros2.rosidl import load

MESSAGES = (
    "std_msgs/msg/Float32",
    "nav_msgs/msg/Odometry",
    "sensor_msgs/msg/LaserScan",
)


@pytest.fixture(scope="session")
def messages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ModuleType]:
    """Return modules of generated classes by package."""
    files = [ros_file(f"{name}.msg") for name in MESSAGES]
    model = load(files, root=files[0].parents[2]).model
    folder = tmp_path_factory.mktemp("ros2")
    for artifact in BACKEND.emit(
        model, Options("ros2_types", "skeletons", "0")
    ).artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        packages = ("std_msgs", "nav_msgs", "sensor_msgs", "geometry_msgs")
        return {
            name: importlib.import_module(f"ros2_types.{name}.msg") for name in packages
        }
    finally:
        sys.path.remove(str(folder))
