"""Bags of ROS 2 written by rosbags, in all forms that rosbag2 has."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import (
    CompressionFormat,
    CompressionMode,
    StoragePlugin,
    Writer,
)
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
START = 1_700_000_000_000_000_000
STEP = 20_000_000
FORMS = {
    "sqlite3": (StoragePlugin.SQLITE3, CompressionMode.NONE),
    "sqlite3-messages": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    "sqlite3-file": (StoragePlugin.SQLITE3, CompressionMode.FILE),
    "mcap": (StoragePlugin.MCAP, CompressionMode.NONE),
    "mcap-chunks": (StoragePlugin.MCAP, CompressionMode.STORAGE),
    "mcap-file": (StoragePlugin.MCAP, CompressionMode.FILE),
}
HUMBLE = "humble"


def float32(value: float) -> bytes:
    """Return a message of std_msgs/msg/Float32."""
    message: Any = STORE.types["std_msgs/msg/Float32"]
    return bytes(STORE.serialize_cdr(message(value), "std_msgs/msg/Float32"))


def write(
    path: Path,
    form: str = "mcap",
    values: Sequence[float] = tuple(range(50)),
    topic: str = "/robot/goal",
    *,
    times: Sequence[int] | None = None,
) -> Path:
    """Write a bag of numbers on a topic, and one text on `/note`; return its path."""
    plugin, mode = FORMS["sqlite3" if form == HUMBLE else form]
    writer = Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(
            topic, "std_msgs/msg/Float32", typestore=STORE
        )
        note = writer.add_connection("/note", "std_msgs/msg/String", typestore=STORE)
        text: Any = STORE.types["std_msgs/msg/String"]
        octets = STORE.serialize_cdr(text("here"), "std_msgs/msg/String")
        writer.write(note, START, octets)
        for number, value in enumerate(values):
            time = number * STEP if times is None else times[number]
            writer.write(connection, START + time, float32(value))
    if form == HUMBLE:
        with closing(sqlite3.connect(path / f"{path.name}.db3")) as database:
            database.execute("DROP TABLE message_definitions")
            database.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
            database.execute("UPDATE schema SET schema_version = 3")
            database.commit()
    return path
