"""`~/get_type_description`: the answers, compared with those of a node of rclpy."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import media
import pytest
from ros2_peers import DISTRIBUTIONS, installation

from rtgen.ros2.rosidl import load
from rtgen.runtime.ros2.descriptions import SERVICE, TypeDescriptions, described
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.ros2.network import (
    RosNetwork,
    RosNode,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.tools.recording.schema_types import message_classes as classes_of
from rtgen.tools.running.ros2_classes import message_classes
from rtgen.tools.running.ros2_definitions import definitions

ORACLE = Path(__file__).with_name("type_description_oracle.py")
PACKAGES = (
    *("std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "std_srvs", "test_msgs"),
    *("lifecycle_msgs", "rcl_interfaces", "diagnostic_msgs", "trajectory_msgs"),
)
DAMAGED = ("wstring_value_default2", "wstring_value_default3")
"""Defaults of test_msgs/msg/WStrings that rosidl's generator escapes, and cuts.

It cuts the texts of files with such characters, or with a backslash, too.
"""


def repaired(answer: dict[str, Any]) -> dict[str, Any]:
    whole = answer["type_description"]
    for type_ in (whole["type_description"], *whole["referenced_type_descriptions"]):
        for field in type_["fields"]:
            if field["name"] in DAMAGED:
                field["default_value"] = ""
    for each in answer["type_sources"]:
        text = each["raw_file_contents"]
        if "\\" in text or not text.isascii():
            each["raw_file_contents"] = ""
    return answer


def as_told(answer: dict[str, Any]) -> dict[str, Any]:
    """Return the members of an answer with those that are zero."""
    whole = answer.get("type_description", {})
    empty = {"type_name": "", "fields": []}
    return {
        "failure_reason": "",
        "type_sources": [],
        "extra_information": [],
        **answer,
        "type_description": {
            "type_description": whole.get("type_description", empty),
            "referenced_type_descriptions": whole.get(
                "referenced_type_descriptions", []
            ),
        },
    }


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.waits
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_answers_are_those_of_rclpy(distribution: str) -> None:
    """Of all messages and services of the packages: types, defaults, sources, failures."""
    ros2 = installation(distribution)
    files = sorted(
        file
        for package in PACKAGES
        for kind in ("msg", "srv")
        for file in (ros2.share / package / kind).glob(f"*.{kind}")
    )
    info = ros2.share / f"{EVENT_INFO}.msg"
    classes = classes_of(load([*files, info], root=ros2.share).model)
    used: dict[str, RosTopic | RosService] = {}
    for file in files:
        name = f"{file.parent.parent.name}/{file.parent.name}/{file.stem}"
        if file.suffix == ".srv":
            ends = (classes[f"{name}_{end}"] for end in ("Request", "Response"))
            used[name] = RosService(*ends, "/x", classes[EVENT_INFO])
        else:
            used[name] = RosTopic("/x", classes[name])
    assert len(used) > 100
    asked = [[name, end.type_hash] for name, end in used.items()]
    header = used["std_msgs/msg/Header"].type_hash
    failing = [["std_msgs/msg/Header", ""], ["std_msgs/msg/Header", "RIHS01_0"]]
    failing += [["std_msgs/msg/Bool", header]]
    failing += [["std_msgs/msg/Header", "RIHS01_" + 64 * "0"]]
    lines = ros2.output(
        ORACLE,
        text=json.dumps([len(asked), *asked, *failing]) + "\n",
        domain=media.own_domain(),
    ).splitlines()
    source = definitions([ros2.share])
    for (name, type_hash), line in zip([*asked, *failing], lines, strict=True):
        request = SimpleNamespace(
            type_name=name, type_hash=type_hash, include_type_sources=True
        )
        ours = as_told(described(used, request, source))
        assert repaired(ours) == repaired(json.loads(line)), name


def test_a_node_serves_the_types_that_it_uses() -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    from rtgen.runtime.ros2.dds import open_dds

    domain = media.own_domain()
    classes = message_classes(SERVICE, EVENT_INFO, "nav_msgs/msg/Odometry")
    network: RosNetwork = open_dds(RosNode("process", "/lab", domain))
    other: RosNetwork = open_dds(RosNode("other", "/lab", domain))
    topic = RosTopic("/odom", classes["nav_msgs/msg/Odometry"], "Base0")
    network._use(topic)
    served = TypeDescriptions(
        network, {"Base0": "/lab/Base0"}, classes, classes[EVENT_INFO], definitions([])
    )
    request, response = (classes[f"{SERVICE}_{k}"] for k in ("Request", "Response"))
    name = "/lab/Base0/get_type_description"
    call = other.client(RosService(request, response, name, classes[EVENT_INFO]))
    wanted = request(
        type_name="nav_msgs/msg/Odometry",
        type_hash=topic.type_hash,
        include_type_sources=True,
    )
    answer = decoded(response, call(encoded(wanted), 20.0))
    assert answer.successful
    whole = answer.type_description
    assert whole.type_description.type_name == "nav_msgs/msg/Odometry"
    names = [each.type_name for each in whole.referenced_type_descriptions]
    assert names == sorted(names)
    assert "geometry_msgs/msg/TwistWithCovariance" in names
    assert {each.encoding for each in answer.type_sources} == {"msg"}
    # The service is one of its types, too.
    wanted = request(
        type_name=SERVICE, type_hash=network.used["Base0"][SERVICE].type_hash
    )
    assert decoded(response, call(encoded(wanted), 20.0)).successful
    served.close()
    other.close()
    network.close()


def test_derived_types_and_unknown_ones() -> None:
    source = definitions([])
    request = source("type_description_interfaces/srv/GetTypeDescription_Request")
    assert request is not None
    assert (request.encoding, request.text) == ("implicit", "")
    assert request.defaults == {"include_type_sources": "True"}
    for end in ("_SendGoal_Request", "_FeedbackMessage", "_GetResult"):
        found = source(f"tf2_msgs/action/LookupTransform{end}")
        assert found is not None
        assert found.encoding == "implicit"
    assert source("lab/msg/Nothing") is None
