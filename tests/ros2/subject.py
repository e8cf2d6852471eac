"""The system that runs beside peers on each network of ROS 2: `conformance/*.py`, and definitions.

`Relay0` sends what it receives, of each type. `Counter0` serves, `Asker0` calls.
"""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from shutil import copytree, rmtree
from tempfile import mkdtemp

import pytest
from patience import PATIENCE

from rtgen.cli import run as rtgen
from rtgen.compiler.kit.resources import ros_interfaces

PARTS = Path(__file__).with_name("conformance")
SPACE, OTHERS = "/subject", "/peer"
"""Namespaces of the system and of the node that it asks."""
LAST = "std_msgs/msg/UInt8"
"""A type whose last message is kept for later nodes."""
COMPONENTS = ("Relay", "Counter", "Asker")
FIXED = """
#include "test_msgs/srv/BasicTypes.idl"
#include "test_msgs/action/Fibonacci.idl"
interface Basics {
    test_msgs::srv::BasicTypes_Response ask(in test_msgs::srv::BasicTypes_Request request);
};
@rtc(category="t", vendor="me", rate=100.0)
component Counter {
    provides Basics basics;
    @port("count") provides test_msgs::action::Fibonacci goals;
    @port("count") uses test_msgs::action::Fibonacci_Events events;
    @unit("m") @default(0.5) @min(0.0) @max(3.0) attribute double size;
    @default(7) attribute long number;
    @default("a") attribute string word;
    @default(TRUE) attribute boolean flag;
};
@rtc(category="t", vendor="me", rate=100.0)
component Asker {
    consumes std_msgs::msg::String task;
    publishes std_msgs::msg::String told;
    uses Basics asks;
    @port("count") uses test_msgs::action::Fibonacci goals;
    @port("count") provides test_msgs::action::Fibonacci_Events events;
};
"""
RATE = '@rtc(category="t", vendor="me", rate=50.0) '
SOURCES = """
[sources]
paths = ["t.idl"]
include = ["{share}"]
[output]
package = "subject"
skeletons = "src/parts"
"""
SETTINGS = """
[ros2]
namespace = "{space}"
{more}
[ros2.topics]
"Asker0.task" = "task"
"Asker0.told" = "told"
{topics}
[ros2.services]
"Counter0.basics.ask" = "basics"
"Asker0.asks.ask" = "{others}/basics"
[ros2.actions]
"Counter0.count" = "count"
"Asker0.count" = "{others}/count"
"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:subject:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
{components}</rts:RtsProfile>
"""
COMPONENT = """  <rts:Components rts:id="RTC:me:t:{name}:1.0.0" rts:instanceName="{name}0"
      rts:pathUri="localhost/{name}0.rtc" rts:compositeType="None" rts:isRequired="true"/>
"""


def shipped(share: Path) -> list[str]:
    """Return the names of the messages that ship with rtgen and are installed, too."""
    names = (
        name.removesuffix(".msg") for name in ros_interfaces() if name.endswith(".msg")
    )
    return [
        name
        for name in names
        if (share / f"{name}.msg").exists() and not name.startswith("rmw_dds_common/")
    ]


def port_of(type_: str) -> str:
    """Return the part of a port's name that stands for its type."""
    return type_.replace("/msg/", "_")


@cache
def _generated(share: Path) -> Path:
    """Return a folder with the project of all types, generated once for all networks."""
    folder = Path(mkdtemp(prefix="subject"))
    atexit.register(rmtree, folder)
    types = shipped(share)
    relayed = "\n".join(
        f"    consumes {scoped} in_{port_of(name)};\n    publishes {scoped} out_{port_of(name)};"
        for name in types
        for scoped in [name.replace("/", "::")]
    )
    includes = "\n".join(f'#include "{name}.idl"' for name in types)
    (folder / "t.idl").write_text(
        f"{includes}{FIXED}{RATE}component Relay {{\n{relayed}\n}};\n"
    )
    (folder / "rtgen.toml").write_text(SOURCES.format(share=share.as_posix()))
    copytree(PARTS, folder / "src/parts", ignore=lambda *_: ["__pycache__"])
    components = "".join(COMPONENT.format(name=name) for name in COMPONENTS)
    (folder / "system.xml").write_text(SYSTEM.format(components=components))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
    return folder


def create(
    folder: Path, share: Path, types: Sequence[str], more: str, others: str
) -> None:
    """Create a project with topics of these types. `more` are lines of `[ros2]`.

    `others` is the namespace of the node that serves what the system asks.
    """
    copytree(_generated(share), folder, dirs_exist_ok=True)
    topics = "\n".join(
        f'"Relay0.{way}_{port_of(name)}" = {{ topic = "{way}/{port_of(name)}", qos = "{qos}" }}'
        for name in types
        for way in ("in", "out")
        for qos in ["map" if (name, way) == (LAST, "out") else "default"]
    )
    settings = SETTINGS.format(space=SPACE, topics=topics, more=more, others=others)
    (folder / "rtgen.toml").write_text(
        SOURCES.format(share=share.as_posix()) + settings
    )


@contextmanager
def running(
    command: Sequence[str],
    network: str,
    folder: Path,
    environment: Mapping[str, str],
) -> Iterator[None]:
    """Run the system in its folder until the end of the block."""
    said = folder / f"{network}.log"
    with said.open("w") as stream:
        process = subprocess.Popen(
            [*command, "run", "system.xml", "--clock", "real", "--ros2", network],
            cwd=folder,
            env={**os.environ, **environment},
            stdout=stream,
            stderr=stream,
        )
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        code = process.wait(PATIENCE)
    assert code == 0, said.read_text()
