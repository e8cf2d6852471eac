"""Packages of `rtgen new ros2-package`, built by colcon and run beside nodes of rclpy."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, Installation, installation
from rosidl_values import hashes
from seeds import budget
from test_new_ros2_package import project

from rtgen.cli import run
from rtgen.compiler.kit.resources import ros_file
from rtgen.ros2.rosidl import load

pytestmark = [pytest.mark.peer, pytest.mark.nightly]

HERE = Path(__file__).parent
LAUNCH = "share/rover_ros/launch/two_drives.launch.py"
MORE_IDL = """
#include "std_msgs/msg/Header.idl"
module Lab {
    module Sensors {
        struct Part { octet kind[2]; };
        /** What 表 sees: C:\\\\users. */
        struct View {
            std_msgs::msg::Header header;
            @default("a \\"#=\\" b") string text;
            @default(TRUE) boolean known;
            sequence<wstring<9> > names;
            sequence<Lab::Sensors::Part, 3> parts;
        };
    };
};
"""


class Workspace:
    """A project with packages that colcon has built, and programs in its environment."""

    def __init__(self, ros2: Installation, folder: Path) -> None:
        self.ros2 = ros2
        self.folder = folder
        self.domain = 100 + os.getpid() % 100

    def command(self, *command: str) -> list[str]:
        setup = self.folder / "install" / "local_setup.bash"
        source = f'[ ! -f {setup} ] || . {setup}; exec "$@"'
        return ["bash", "-c", source, "bash", *command]

    @property
    def environment(self) -> dict[str, str]:
        prefix = str(self.ros2.folder)
        path = f"{prefix}/bin{os.pathsep}{os.environ['PATH']}"
        own = {"AMENT_PREFIX_PATH": prefix, "CMAKE_PREFIX_PATH": prefix, "PATH": path}
        return {**self.ros2.environment(self.domain), **own}

    def output(self, *command: str) -> str:
        return subprocess.run(
            self.command(*command),
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout

    @contextmanager
    def started(self, *command: str) -> Iterator[None]:
        """Run a program, which is interrupted at the end and then ends by itself."""
        process = subprocess.Popen(
            self.command(*command), cwd=self.folder, env=self.environment
        )
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait() in (0, 130)


@pytest.fixture(scope="module", params=DISTRIBUTIONS[: budget(2)])
def workspace(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Workspace:
    ros2 = installation(request.param, builds=True)
    folder = project(tmp_path_factory.mktemp("ws") / "rover")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        (folder / "idl/more.idl").write_text(MORE_IDL, encoding="utf-8")
        for name, text in {
            "lab_msgs/srv/Ask.srv": "string text\n---\nlab_msgs/Load[<=3] loads\n",
            "lab_msgs/action/Go.action": "float64 x 1\n---\nLoad load\n---\nbyte b\n",
        }.items():
            (folder / name).parent.mkdir()
            (folder / name).write_text(text)
        assert run(["new", "ros2-package", "rover_ros"]) == 0
    made = Workspace(ros2, folder)
    made.output("colcon", "build", "--base-paths", "ros2")
    return made


def test_hashes(workspace: Workspace) -> None:
    """What rosidl has installed has the hashes of rtgen."""
    packages = workspace.folder / "ros2"
    files = [
        path
        for kind in ("msg", "srv", "action")
        for path in packages.glob(f"*/{kind}/*.{kind}")
    ]
    assert len(files) == 7
    event = ros_file("service_msgs/msg/ServiceEventInfo.msg")
    result = load([*files, event], root=packages)
    assert not result.diagnostics
    theirs = {}
    for path in (workspace.folder / "install").glob("*/share/*/*/*.json"):
        for entry in json.loads(path.read_text())["type_hashes"]:
            theirs[entry["type_name"]] = entry["hash_string"]
    own = hashes(result.model)
    assert {"lab_sensors/msg/View", "lab/srv/ArmMove", "lab_msgs/action/Go_Goal"} <= {
        *own
    }
    for name, each in own.items():
        if name.startswith("lab"):
            assert theirs[name] == each, name


def test_a_program(workspace: Workspace) -> None:
    """Its components stay inactive until a node makes one active; the node reads its samples."""
    program = workspace.folder / "install/rover_ros/lib/rover_ros/two_drives"
    with workspace.started(str(program), "--inactive"):
        peer = str(HERE / "colcon_peer.py")
        output = workspace.output(workspace.ros2.python, peer, "/lab/Left0")
    assert output == "2.5\n"


def test_the_launch_file(workspace: Workspace) -> None:
    """Its transitions make the components active."""
    python = workspace.ros2.python
    found = subprocess.run(
        [python, "-c", "import launch_ros.actions"],
        env=workspace.environment,
        check=False,
    )
    if found.returncode:
        pytest.skip("launch_ros is missing, which no package index has")
    install = workspace.folder / "install/rover_ros"
    script = str(HERE / "launch_peer.py")
    with workspace.started(python, script, str(install / LAUNCH)):
        peer = str(HERE / "colcon_peer.py")
        assert workspace.output(python, peer) == "2.5\n"
