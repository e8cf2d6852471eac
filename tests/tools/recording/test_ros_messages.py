"""Schemas of types of ROS 2, read by rosbags and by rtgen."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.model import Model, Struct
from rtgen.compiler.typemap.data_classes import Types
from rtgen.ros2.rosidl import load
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.tools.recording.errors import SchemaError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.recording.schema_types import type_of
from rtgen.tools.recording.schemas import Schema, schema_of

SEPARATOR = "=" * 80
POSE = f"""\
lab/Header header
lab/Where where
lab/Where[2] two
lab/Where[] more
lab/Where[<=3] few
string<=8 name
byte raw
bool[] flags
{SEPARATOR}
MSG: lab/Header
uint32 seq
{SEPARATOR}
MSG: lab/Where
float64 x
lab/Empty nothing
{SEPARATOR}
MSG: lab/Empty
"""


def ros_schema(name: str, text: str) -> Schema:
    return Schema(name, text, "ros2msg")


STORE = get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope="module")
def shipped() -> Model:
    """Return the messages that ship with rtgen."""
    files = [ros_file(name) for name in ros_interfaces()]
    return load(files, root=files[0].parents[2]).model


@pytest.fixture(scope="module")
def classes(
    shipped: Model, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ModuleType]:
    """Import the generated package of these messages."""
    folder = tmp_path_factory.mktemp("recorded_ros")
    for artifact in BACKEND.emit(shipped, Options("recorded_ros", "", "0")).artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield importlib.import_module("recorded_ros")


def test_every_shipped_message_has_the_fields_that_rosbags_knows(
    shipped: Model,
) -> None:
    types = Types(shipped)
    compared = 0
    for declaration in shipped.declarations:
        if not isinstance(declaration, Struct):
            continue
        name = "/".join(declaration.name)
        schema = schema_of(types.named(declaration.name))
        assert (schema.name, schema.encoding) == (name, "ros2msg")
        assert schema_of(type_of(schema)._descriptor_) == schema
        found = get_types_from_msg(schema.text, name)
        for message, (_, fields) in found.items():
            expected = STORE.fielddefs.get(message, (None, None))[1]
            if (
                expected is not None and fields
            ):  # An empty message has a placeholder field.
                # `char` is a name of uint8.
                assert repr(fields) == repr(expected).replace("'char'", "'uint8'")
                compared += 1
    assert compared > 150


class Source(Component):
    """A component that writes a grid once a tick."""

    profile = ComponentProfile("Source")

    def __init__(self, name: str, classes: ModuleType) -> None:
        super().__init__(name)
        self.messages = importlib.import_module(f"{classes.__name__}.nav_msgs.msg")
        self.grid = self.add_out_port("grid", self.messages.OccupancyGrid)
        self.number = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.number += 1
        grid = self.messages.OccupancyGrid()
        grid.header.frame_id = f"map{self.number}"
        grid.info.resolution = 0.5
        grid.info.origin.position.x = float(self.number)
        grid.data = [*range(-1, self.number)]
        self.grid.write(grid)
        return RTC_OK


def test_a_recording_is_read_by_rosbags_and_by_our_own_log(
    classes: ModuleType, tmp_path: Path
) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer, System(SimulatedClock()) as system:
        system.add(Source("Source0", classes), 100.0)
        Recorder(system, writer)
        system.activate("Source0")
        system.run(50_000_000)
    with path.open("rb") as stream:
        found = [*make_reader(stream).iter_messages(topics=["/Source0/grid"])]
    assert len(found) == 5
    store = get_typestore(Stores.EMPTY)
    schema = found[0][0]
    assert schema is not None
    assert (schema.name, schema.encoding) == ("nav_msgs/msg/OccupancyGrid", "ros2msg")
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    own = [e["value"] for e in Log(path).events() if e["event"] == "sample"]
    assert len(own) == 5
    for number, ((_, _, message), value) in enumerate(zip(found, own, strict=True), 1):
        grid: Any = store.deserialize_cdr(message.data, schema.name)
        assert grid.header.frame_id == value["header"]["frame_id"] == f"map{number}"
        assert grid.info.origin.position.x == float(number)
        assert [*grid.data] == value["data"] == [*range(-1, number)]
        assert value["info"]["resolution"] == 0.5


def test_octets_after_a_message_of_a_bag_are_ignored(tmp_path: Path) -> None:
    """Wide strings have the octets of ROS 2, whatever their schema's classes are used for."""
    path = tmp_path / "bag.mcap"
    octets = b"\x00\x01\x00\x00\x01\x00\x00\x00a\x00\x00\x00\x07"
    with McapWriter(path) as writer:
        text = "wstring text\nuint8 last\n"
        schema = writer.schema("lab/msg/Text", "ros2msg", text)
        channel = writer.channel("/text", "cdr", schema, {})
        for time, more in enumerate((b"", b"\x00", b"\xff" * 20)):
            writer.message(channel, time, octets + more)
    values = [event["value"] for event in Log(path).events() if "value" in event]
    assert values == [{"text": "a", "last": 7}] * 3


def test_everything_that_a_message_can_have() -> None:
    schema = ros_schema("lab/msg/Pose", POSE)
    described: Any = type_of(schema)._descriptor_
    assert schema_of(described) == schema
    members = {member.name: str(member.type) for member in described.members}
    assert members["few"] == "sequence<lab::msg::Where,3>"
    assert members["name"] == "string<8>"
    assert members["raw"] == "octet"


@pytest.mark.parametrize(
    ("name", "idl"),
    [
        ("lab::Pose", "module lab { struct Pose { long x; }; };"),
        ("lab::msg::pose", "module lab { module msg { struct pose { long x; }; }; };"),
        ("lab::msg::A", "module lab { module msg { struct A { long X; }; }; };"),
        ("lab::msg::A", "module lab { module msg { struct A { wstring x; }; }; };"),
        ("lab::msg::A", "module lab { module msg { struct A { char x; }; }; };"),
        ("lab::msg::A", "module lab { module msg { struct A { long x[2][2]; }; }; };"),
        (
            "lab::msg::A",
            "module lab { module msg { struct A { @optional long x; }; }; };",
        ),
        (
            "lab::msg::A",
            "module lab { module msg { @mutable struct A { long x; }; }; };",
        ),
        (
            "lab::msg::A",
            "module lab { struct B { long x; }; module msg { struct A { B b; }; }; };",
        ),
    ],
)
def test_what_a_message_cannot_have_is_recorded_with_idl(name: str, idl: str) -> None:
    schema = schema_of(type_of(Schema(name, idl))._descriptor_)
    assert (schema.name, schema.encoding) == (name, "omgidl")


def chain(length: int) -> str:
    """Return a message that contains another one, which contains another one ..."""
    parts = [f"MSG: lab/M{n}\nlab/M{n + 1} m\n" for n in range(1, length)]
    parts.append(f"MSG: lab/M{length}\nuint8 x\n")
    return f"{SEPARATOR}\n".join(("lab/M1 m\n", *parts))


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("lab/msg/A", "float65 x\n", "declares no float65"),
        ("lab/msg/A", "uint8 x y z\n", "line 1 of a message"),
        ("lab/msg/A", "lab/B b\n", "declares no lab/msg/B"),
        ("lab/msg/A", "A a\n", "contains itself"),
        ("lab/msg/A", f"B b\n{SEPARATOR}\nMSG: lab/B\nA a\n", "contains itself"),
        ("lab/msg/A", f"uint8 x\n{SEPARATOR}\nuint8 y\n", "expected `MSG:"),
        ("lab/msg/A", f"uint8 x\n{SEPARATOR}\nMSG: ../B\nuint8 y\n", "not a message"),
        ("lab/msg/A", "uint8 x\n---\nuint8 y\n", "not of one message"),
        ("A", "uint8 x\n", "A is not a message"),
        ("lab/msg/A", chain(5000), "levels of messages"),
        ("lab/msg/A", "#" * ((1 << 20) + 1), "has over"),
    ],
)
def test_a_wrong_schema_is_an_error(name: str, text: str, what: str) -> None:
    with pytest.raises(SchemaError, match=what):
        type_of(ros_schema(name, text))
