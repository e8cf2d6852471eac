"""The packages of ROS 2 that ship with rtgen: found without a path, from `.msg` and from IDL."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.layouts.ros_types import service_hash, type_hash
from rtgen.compiler.lint import lint
from rtgen.compiler.model import Component, Const, Interface, Model, Struct
from rtgen.ros2.rosidl import load

PACKAGES = {
    *("action_msgs", "actionlib_msgs", "builtin_interfaces", "diagnostic_msgs"),
    *("geometry_msgs", "lifecycle_msgs", "nav_msgs", "rcl_interfaces"),
    *("rmw_dds_common", "rosgraph_msgs", "sensor_msgs", "service_msgs"),
    *("shape_msgs", "std_msgs", "std_srvs", "stereo_msgs", "tf2_msgs"),
    *("trajectory_msgs", "type_description_interfaces", "unique_identifier_msgs"),
    "visualization_msgs",
}


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def struct(model: Model, name: str) -> Struct:
    found = model.find(tuple(name.split("/")))
    assert isinstance(found, Struct)
    return found


@pytest.fixture(scope="module")
def shipped() -> Model:
    names = ros_interfaces()
    result = load(
        [ros_file(name) for name in names], root=ros_file(names[0]).parents[2]
    )
    assert not result.diagnostics
    return result.model


def test_each_has_a_description(shipped: Model) -> None:
    assert {name.partition("/")[0] for name in ros_interfaces()} == PACKAGES
    assert len(ros_interfaces()) == 185
    described = {d.file for d in shipped.declarations if d.doc}
    assert described == {file.name for file in shipped.files}


def test_defaults_and_units(shipped: Model) -> None:
    fields = {
        m.name: m for m in struct(shipped, "geometry_msgs/msg/Quaternion").members
    }
    annotation = fields["w"].annotation("default")
    assert annotation is not None
    assert annotation.arguments == (("value", 1.0),)
    scan = {m.name: m for m in struct(shipped, "sensor_msgs/msg/LaserScan").members}
    unit = scan["angle_min"].annotation("unit")
    assert unit is not None
    assert unit.arguments == (("value", "rad"),)
    assert scan["header"].annotation("unit") is None


SERVICES = {
    "example_interfaces/srv/AddTwoInts": (
        "int64 a\nint64 b\n---\nint64 sum\n",
        "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
    ),
}
"""Interfaces with the hashes in rmw_zenoh's design document."""


def test_hash_of_a_service(tmp_path: Path) -> None:
    for name, (text, expected) in SERVICES.items():
        path = write(tmp_path, f"{name}.srv", text)
        info = ros_file("service_msgs/msg/ServiceEventInfo.msg")
        model = load([path, info], root=tmp_path).model
        request, response = struct(model, f"{name}_Request"), struct(
            model, f"{name}_Response"
        )
        assert service_hash(model, request, response) == f"RIHS01_{expected}"
        with pytest.raises(ValueError, match="ServiceEventInfo"):
            service_hash(load([path], root=tmp_path).model, request, response)


def test_hash_of_the_graph(shipped: Model) -> None:
    """The hash of rmw_cyclonedds on `ros_discovery_info`; it has an array of `char`."""
    info = struct(shipped, "rmw_dds_common/msg/ParticipantEntitiesInfo")
    expected = "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"
    assert type_hash(shipped, info) == f"RIHS01_{expected}"


def test_found_without_a_path(tmp_path: Path) -> None:
    path = write(tmp_path, "lab/msg/Place.msg", "geometry_msgs/PoseStamped pose\n")
    result = load([path], root=tmp_path)
    assert not result.diagnostics
    keys = [file.key for file in result.model.files]
    assert keys[0] == "rtgen/rosidl/builtin_interfaces/msg/Time.msg"
    assert keys[-1] == "lab/msg/Place.msg"
    shipped = {d.path for d in result.dependencies if d.sha256 is not None}
    assert ros_file("std_msgs/msg/Header.msg") in shipped


def test_a_package_of_the_project_comes_first(tmp_path: Path) -> None:
    write(tmp_path, "share/std_msgs/msg/Header.msg", "uint8 own\n")
    path = write(tmp_path, "lab/msg/Place.msg", "std_msgs/Header header\n")
    result = load([path], root=tmp_path, include=[tmp_path / "share"])
    header = struct(result.model, "std_msgs/msg/Header")
    assert [m.name for m in header.members] == ["own"]


IDL = """
#include "std_msgs/msg/Float32.idl"
#include "nav_msgs/srv/LoadMap.idl"
component Node {
    publishes std_msgs::msg::Float32 Out;
    consumes nav_msgs::msg::OccupancyGrid Map;
};
"""


def test_included_by_idl(shipped: Model) -> None:
    model = api.compile(IDL)
    component = model.find(("Node",))
    assert isinstance(component, Component)
    for name in ("std_msgs/msg/Float32", "nav_msgs/srv/LoadMap_Response"):
        own, theirs = struct(model, name), struct(shipped, name)
        assert [(m.name, m.type) for m in own.members] == [
            (m.name, m.type) for m in theirs.members
        ]
        assert own.repository_id == theirs.repository_id
        assert type_hash(model, own) == type_hash(shipped, theirs)


def signatures(interface: Interface) -> list[tuple[object, ...]]:
    return [
        (
            o.name,
            o.returns,
            o.oneway,
            [(p.direction, p.name, p.type) for p in o.parameters],
        )
        for o in interface.operations
    ]


def test_all_can_be_included(shipped: Model) -> None:
    names = [name.rpartition(".")[0] for name in ros_interfaces()]
    model = api.compile("".join(f'#include "{name}.idl"\n' for name in names))
    for theirs in shipped.declarations:
        own = model.find(theirs.name)
        if isinstance(theirs, Struct):
            assert isinstance(own, Struct)
            assert type_hash(model, own) == type_hash(shipped, theirs)
        elif isinstance(theirs, Interface):
            assert isinstance(own, Interface)
            assert signatures(own) == signatures(theirs)
        else:
            assert isinstance(theirs, Const)
            assert isinstance(own, Const)
            assert (own.type, own.value) == (theirs.type, theirs.value)


def test_read_and_included_is_declared_once(tmp_path: Path) -> None:
    """A `.msg` file of the project replaces the IDL that is printed from it."""
    paths = [
        write(tmp_path, "lab/msg/Place.msg", "std_msgs/Header header\nbool map\n"),
        write(
            tmp_path,
            "node.idl",
            '#include "lab/msg/Place.idl"\n'
            "component Node { publishes lab::msg::Place Out; };\n",
        ),
    ]
    result = api.read(paths)
    assert not result.diagnostics
    names = [d.name for d in result.model.declarations]
    assert len(names) == len(set(names)) == 4
    node = next(file for file in result.model.files if file.name.endswith("node.idl"))
    assert node.includes == (paths[0].as_posix(),)


def test_messages_of_ros_need_no_time() -> None:
    result = api.read(IDL)
    codes = {finding.code for finding in lint(result.model, result.sources)}
    assert "LINT0008" not in codes
