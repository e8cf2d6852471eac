"""Bags of ROS 2 as `rtgen log` reads them, whole, damaged and hostile."""

from __future__ import annotations

import random
import shutil
import sqlite3
import struct
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import seeds
from bags import FORMS, HUMBLE, START, STEP, STORE, write

from rtgen.cli import run as rtgen
from rtgen.tools.recording.bag_files import open_recording
from rtgen.tools.recording.errors import RecordingError, SchemaError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.schema_types import type_of
from rtgen.tools.recording.schemas import Schema

ALL = (*FORMS, HUMBLE)


def values(path: Path) -> list[Any]:
    """Return the numbers of a bag."""
    events = Log(path).events(lambda head: head["port"] == "/robot/goal")
    return [event["value"]["data"] for event in events]


def file_of(bag: Path) -> Path:
    [file] = [each for each in bag.iterdir() if each.name != "metadata.yaml"]
    return file


@pytest.mark.parametrize("form", ALL)
def test_forms(form: str, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", form)
    log = Log(bag)
    events = [*log.events()]
    assert log.losses() == []
    assert log.start == START
    assert [e["value"]["data"] for e in events[1:]] == [*range(50)]
    assert events[0] == {
        "t": 0,
        "event": "sample",
        "instance": "",
        "port": "/note",
        "value": {"data": "here"},
    }
    assert [e["t"] for e in events[1:]] == [n * STEP for n in range(50)]
    if form != "sqlite3-messages":
        assert values(file_of(bag)) == [*range(50)]
    (bag / "metadata.yaml").unlink()
    if form != "sqlite3-messages":
        again = Log(bag)
        assert len([*again.events()]) == 51
        assert again.losses() == ["no metadata.yaml: the writer was killed"]


def test_commands_take_topics(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = str(write(tmp_path / "bag", "sqlite3"))
    other = str(write(tmp_path / "other", "mcap", [0, 1, 3]))
    assert rtgen(["log", "csv", bag, "/robot/goal.data"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert lines[:3] == ["t,/robot/goal.data", "0.0,0.0", "0.02,1.0"]
    assert rtgen(["log", "cat", bag, "/note"]) == 0
    assert '"port": "/note"' in capfd.readouterr().out
    assert rtgen(["log", "diff", bag, other, "/robot/goal"]) == 1
    assert "value.data is 2.0, and 3.0" in capfd.readouterr().out
    assert rtgen(["log", "info", bag]) == 0
    assert capfd.readouterr().out.startswith("bag: sqlite3, a bag of ROS 2\n")
    picture = tmp_path / "x.svg"
    assert rtgen(["log", "plot", bag, "/robot/goal", "-o", str(picture)]) == 0
    assert picture.exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["csv", "{bag}", "/goal.data"],
        ["plot", "{bag}", "/robot/gaol"],
        ["cat", "{bag}", "/goal"],
        ["play", "{bag}", "/robot/golas", "--rate", "1e6"],
        ["diff", "{bag}", "{bag}", "/Robot/goal"],
    ],
)
def test_unknown_topics(
    arguments: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = str(write(tmp_path / "bag"))
    assert rtgen(["log", *(each.replace("{bag}", bag) for each in arguments)]) == 2
    error = capfd.readouterr().err
    assert "error[SYS0008]" in error
    assert "did you mean /robot/goal?" in error


@pytest.mark.parametrize("form", ["mcap", "mcap-chunks", "sqlite3"])
def test_files_cut_anywhere(form: str, tmp_path: Path) -> None:
    """What is read is the beginning of the whole, with a loss unless all of it is there."""
    bag = write(tmp_path / "bag", form, range(3_000))
    file = file_of(bag)
    content = file.read_bytes()
    lengths = [random.Random(seed).randrange(len(content)) for seed in seeds.cases(20)]
    cut = tmp_path / file.name
    most = 0
    for length in (*lengths, len(content) - 1):
        cut.write_bytes(content[:length])
        try:
            log = Log(cut)
            read = [
                event["value"]["data"]
                for event in log.events(lambda head: head["port"] == "/robot/goal")
            ]
        except RecordingError:
            continue
        assert read == [*range(len(read))]
        assert log.losses()
        most = max(most, len(read))
    assert most or form == "mcap-chunks"


@pytest.mark.parametrize("form", ["mcap", "sqlite3", "sqlite3-messages", "mcap-file"])
def test_damaged_octets(form: str, tmp_path: Path) -> None:
    """A bag with octets that are others is read, or refused by a RecordingError."""
    bag = write(tmp_path / "bag", form, range(20))
    file = file_of(bag)
    content = file.read_bytes()
    for seed in seeds.cases(60):
        numbers = random.Random(seed)
        damaged = bytearray(content)
        for _ in range(numbers.choice([1, 1, 4, 32])):
            damaged[numbers.randrange(len(damaged))] = numbers.randrange(256)
        file.write_bytes(damaged)
        try:
            log = Log(bag)
            events = [*log.events()]
        except RecordingError:
            continue
        assert len(events) <= 25


def test_a_damaged_bag_is_refused_or_read_with_a_warning(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = write(tmp_path / "bag", "sqlite3", range(3_000))
    file = file_of(bag)
    file.write_bytes(file.read_bytes()[:-6_000])
    assert rtgen(["log", "csv", str(bag), "/robot/goal.data"]) == 0
    streams = capfd.readouterr()
    assert streams.out.startswith("t,/robot/goal.data\n0.0,0.0\n")
    assert f"warning[SYS0034]: {bag}: bag.db3: cut off" in streams.err


METADATA = "rosbag2_bagfile_information:\n  version: 9\n  "


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a: [", "metadata.yaml:"),
        ("rosbag2_bagfile_information: &a\n  a: *a", "names no files"),
        ("[" * 1_000, "nested too deep"),
        ("a: 1", "has no section rosbag2_bagfile_information"),
        (METADATA + "relative_file_paths: 7", "names no files"),
        (METADATA + "relative_file_paths: []", "names no files"),
        (METADATA + "relative_file_paths: [../x.mcap]", "is not in the bag"),
        (METADATA + "relative_file_paths: [/x.mcap]", "is not in the bag"),
        (METADATA + 'relative_file_paths: ["a\\0b"]', "is not in the bag"),
        (METADATA + "relative_file_paths: [x.mcap]", "files of the bag are missing"),
        (METADATA + "relative_file_paths: [metadata.yaml]", "neither MCAP nor sqlite3"),
        (METADATA + "relative_file_paths: [sub]", "neither MCAP nor sqlite3"),
        (
            METADATA
            + "relative_file_paths: [x.mcap]\n  compression_format: lz9\n  compression_mode: file",
            "compressed by 'lz9'",
        ),
    ],
)
def test_hostile_metadata(text: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(RecordingError) as caught:
        open_recording(tmp_path)
    assert what in str(caught.value)


def test_split_bags(tmp_path: Path) -> None:
    """Files of one bag are read one after the other; a missing one is a loss."""
    bag = tmp_path / "bag"
    bag.mkdir()
    names = []
    for number in range(12):
        part = write(tmp_path / f"part{number}", "mcap", [number])
        names.append(f"bag_{number}.mcap")
        shutil.copy(file_of(part), bag / names[-1])
    assert values(bag) == [*range(12)]
    text = f"{METADATA}relative_file_paths: {names}\n"
    (bag / "metadata.yaml").write_text(text)
    assert values(bag) == [*range(12)]
    (bag / names[3]).unlink()
    log = Log(bag)
    assert len([*log.events()]) == 22
    assert log.losses() == ["bag_3.mcap is missing"]


HOSTILE_TABLES = {
    "endless": (
        "CREATE VIEW messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)"
        " SELECT 1 AS topic_id, x AS timestamp, zeroblob(1000000) AS data FROM c"
    ),
    "text": "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)",
    "columns": "CREATE TABLE messages(a)",
    "none": "CREATE TABLE other(a)",
    "virtual": "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)",
    "computed": (
        "CREATE TABLE messages(topic_id, timestamp, data GENERATED ALWAYS AS (zeroblob(9)))"
    ),
    "computed once": (
        "CREATE TABLE messages(topic_id, data, timestamp AS (instr(data, data)) STORED)"
    ),
}


@pytest.mark.parametrize("kind", HOSTILE_TABLES)
def test_hostile_tables(kind: str, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", "sqlite3")
    file = file_of(bag)
    with closing(sqlite3.connect(file)) as database:
        database.execute("DROP TABLE messages")
        database.execute(HOSTILE_TABLES[kind])
        if kind == "text":
            row = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)"
            for values_ in ((1, "now", b""), ("x", 1, b""), (99, 1, b""), (1, 1, 5)):
                database.execute(row, values_)
        database.commit()
    if kind == "text":
        log = Log(bag)
        assert [*log.events()] == []
        assert log.losses() == ["bag.db3: rows that are not messages, left out: 4"]
        return
    if kind == "columns":
        log = Log(bag)
        assert [*log.events()] == []
        assert "no such column" in log.losses()[0]
        return
    with pytest.raises(RecordingError, match="no tables of messages and topics"):
        Log(bag)


LEVELS, CHILDREN = 6, 100
"""Pages that lead to each other, and how often each leads to the next one."""


def let_pages_repeat(file: Path, table: str) -> None:
    """Let each page above those of a table lead to the same one again and again."""
    with closing(sqlite3.connect(file)) as database:
        (size,) = database.execute("PRAGMA page_size").fetchone()
        (root,) = database.execute(
            "SELECT rootpage FROM sqlite_master WHERE name = ?", [table]
        ).fetchone()
    octets = file.read_bytes()
    pages = [octets[at : at + size] for at in range(0, len(octets), size)]
    pages.append(pages[root - 1])
    for level in range(LEVELS):
        child = struct.pack(">I", len(pages))
        cell = child + b"\1"
        at = size - len(cell)
        head = struct.pack(">BHHHB", 5, 0, CHILDREN, at, 0) + child
        page = head + struct.pack(">H", at) * CHILDREN
        page += bytes(at - len(page)) + cell
        if level < LEVELS - 1:
            pages.append(page)
        else:
            pages[root - 1] = page
    pages[0] = pages[0][:28] + struct.pack(">I", len(pages)) + pages[0][32:]
    file.write_bytes(b"".join(pages))


@pytest.mark.parametrize("table", ["messages", "topics"])
def test_pages_that_repeat_are_read_a_number_of_times(
    table: str, tmp_path: Path
) -> None:
    bag = write(tmp_path / "bag", "sqlite3", [1])
    let_pages_repeat(file_of(bag), table)
    assert file_of(bag).stat().st_size < 1 << 17
    recording = open_recording(file_of(bag))
    assert recording is not None
    assert recording.earliest is not None
    if table == "topics":
        with pytest.raises(RecordingError, match="rows"):
            next(recording.messages())


def test_names_of_topics_are_read_up_to_a_size(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", "sqlite3")
    with closing(sqlite3.connect(file_of(bag))) as database:
        database.execute("DROP TABLE topics")
        database.execute("CREATE TABLE topics(id, name, type, serialization_format)")
        row = "INSERT INTO topics VALUES (?, CAST(zeroblob(?) AS TEXT), 'a', 'cdr')"
        for number in range(2):
            database.execute(row, [number, 40 << 20])
        database.commit()
    with pytest.raises(RecordingError, match="topics and schemas have over"):
        [*Log(bag).events()]


@pytest.mark.parametrize(
    ("name", "encoding", "text", "what"),
    [
        ("lab/msg/A", "ros2msg", "int33 x\n", "declares no int33"),
        ("lab/msg/A", "ros2msg", "uint8 x y\n", "line 1 of a message"),
        ("lab/msg/A", "ros2msg", "lab/A a\n", "contains itself"),
        ("lab/msg/A", "ros2msg", "x" * (1 << 21), "over 1048576 characters"),
        ("../msg/A", "", "", "no definition"),
        ("lab/msg/A", "", "", "no definition of the message"),
        ("lab/msg/A", "ros2idl", "struct", "schema"),
        ("lab/msg/A", "ros2idl", "", "declares no"),
    ],
)
def test_hostile_schemas(name: str, encoding: str, text: str, what: str) -> None:
    with pytest.raises(SchemaError, match=what):
        type_of(Schema(name, text, encoding))


@pytest.mark.parametrize(
    ("encoding", "schema"), [("ros1", "ros1msg"), ("cdr", "jsonschema"), ("cdr", "x")]
)
def test_unknown_encodings(
    encoding: str, schema: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bag.mcap"
    with McapWriter(file, profile="ros2") as writer:
        number = writer.schema("std_msgs/msg/Float32", schema, "float32 data\n")
        channel = writer.channel("/robot/goal", encoding, number, {})
        writer.message(channel, START, b"\0\1\0\0\0\0\0\0")
    assert rtgen(["log", "cat", str(file)]) == 2
    error = capfd.readouterr().err
    assert f"error[SYS0033]: {file}: /robot/goal: no decoder for {encoding}" in error


def test_schemas_of_idl(tmp_path: Path) -> None:
    """As rosbag2 writes them for packages that have IDL alone."""
    name = "geometry_msgs/msg/Twist"
    definition, _ = STORE.generate_msgdef(name, ros_version=2)
    idl = f"""{"=" * 80}
IDL: geometry_msgs/msg/Twist
// generated from rosidl_adapter/resource/msg.idl.em
#include "geometry_msgs/msg/Vector3.idl"
module geometry_msgs {{ module msg {{
  struct Twist {{
    geometry_msgs::msg::Vector3 linear;
    geometry_msgs::msg::Vector3 angular;
  }};
}}; }};
{"=" * 80}
IDL: geometry_msgs/msg/Vector3
module geometry_msgs {{ module msg {{
  struct Vector3 {{ double x; double y; double z; }};
}}; }};
"""
    own = idl.replace("struct Vector3", "@verbatim(language=1) union U switch(long)")
    from rtgen.runtime.ros2.types import type_hash

    types = [
        type_of(Schema(name, text, encoding))
        for text, encoding in ((definition, "ros2msg"), (idl, "ros2idl"))
    ]
    assert {type_hash(each) for each in types} == {STORE.hash_rihs01(name)}
    with pytest.raises(SchemaError):
        type_of(Schema(name, own, "ros2idl"))
