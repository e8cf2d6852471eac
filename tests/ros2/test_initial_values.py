"""New messages equal those of rclpy: of packages that ship with rtgen, and of installed ones."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import pytest
from ros2_peers import DISTRIBUTIONS, Installation, installation

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.kit.resources import ros_file
from rtgen.compiler.model import Struct
from rtgen.ros2.rosidl import load
from rtgen.tools.recording.schema_types import message_classes

pytestmark = pytest.mark.peer

HERE = Path(__file__).parent
FILLER = "structure_needs_at_least_one_member"
INTERNAL = "rmw_dds_common"
"""A package whose messages have no module in Python."""


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


def interface_files(root: Path) -> list[Path]:
    """Return the files of all packages in a folder."""
    kinds = ("msg", "srv", "action")
    return sorted(path for kind in kinds for path in root.glob(f"*/{kind}/*.{kind}"))


def started(ros2: Installation, packages: set[str]) -> dict[str, Any]:
    """Return the fields of new messages of rclpy, by the names of their types."""
    lines = ros2.output(HERE / "rclpy_initial.py", *sorted(packages)).splitlines()
    return dict(map(json.loads, lines))


def told(value: Any) -> Any:
    """Return a value as the node of rclpy tells it."""
    if hasattr(value, "_descriptor_"):
        return {
            m.name: told(getattr(value, m.attribute))
            for m in value._descriptor_.members
            if m.name != FILLER
        }
    if isinstance(value, (str, bool, int, float)):
        return value
    return [told(each) for each in value]


def generated(model: Any, folder: Path, package: str) -> dict[str, Any]:
    """Return the generated classes of all structs, by the names of ROS 2."""
    emission = BACKEND.emit(model, Options(package, "skeletons", "0.0.0"))
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        for path in sorted((folder / package / "_idl").rglob("[a-z]*.py")):
            name = ".".join(path.relative_to(folder).with_suffix("").parts)
            for value in vars(importlib.import_module(name)).values():
                described = getattr(value, "_descriptor_", None)
                if getattr(value, "__module__", "") == name and described is not None:
                    found[described.name.replace("::", "/")] = value
        for name in [name for name in sys.modules if name.startswith(package)]:
            del sys.modules[name]
    return found


def compare(ros2: Installation, model: Any, folder: Path) -> tuple[set[str], set[str]]:
    """Compare new messages, of generated and of recorded types, with those of rclpy.

    Returns the names of the messages, and of those that only rclpy has.
    """
    structs = {"/".join(d.name) for d in model.declarations if isinstance(d, Struct)}
    packages = {name.partition("/")[0] for name in structs} - {INTERNAL}
    peers = started(ros2, packages)
    recorded = message_classes(model)
    classes = generated(model, folder, f"started_{ros2.distribution}")
    both = structs & peers.keys()
    for name in both:
        assert told(classes[name]()) == peers[name], name
        assert told(recorded[name]()) == peers[name], name
    return both, peers.keys() - structs


@pytest.mark.nightly
def test_installed_messages(ros2: Installation, tmp_path: Path) -> None:
    result = load(interface_files(ros2.share), root=ros2.share)
    found, others = compare(ros2, result.model, tmp_path)
    assert len(found) > 200
    assert {"test_msgs/msg/Defaults", "geometry_msgs/msg/Quaternion"} <= found
    # The events of services are for introspection; Kilted has some messages in IDL alone.
    others -= {name for name in others if name.endswith("_Event")}
    assert not [name for name in others if (ros2.share / f"{name}.msg").exists()]


def test_shipped_messages(tmp_path: Path) -> None:
    root = ros_file("std_msgs/msg/Header.msg").parents[2]
    result = load(interface_files(root), root=root)
    found, _ = compare(installation("jazzy"), result.model, tmp_path)
    assert len(found) > 150
