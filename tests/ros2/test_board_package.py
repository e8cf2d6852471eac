"""A TECS board called by clients of rclpy, with the package of its services as colcon builds it."""

from __future__ import annotations

import importlib
import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from free_ports import free_port
from logged_process import LoggedProcess
from media import own_domain
from ros2_peers import installation
from test_colcon import Workspace

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import E_OBJ, E_RPC, ERCD, TcpServer

pytestmark = [pytest.mark.peer, pytest.mark.nightly, pytest.mark.waits]

CLIENT = Path(__file__).with_name("board_client.py")
LAMP = """
struct tagPlace { double64_t x; int16_t cells[2]; };
signature sLamp {
    ER move( [in] int8_t percent, [in] const struct tagPlace *place,
             [in,size_is(count)] const float32_t *levels, [in] int32_t count,
             [inout] int32_t *total, [out] struct tagPlace *before );
    uint8_t level( void );
};
celltype tLamp { entry sLamp eLamp; };
[active] celltype tSwitch { call sLamp cLamp; };
cell tLamp Lamp { };
cell tSwitch Switch {
    [through( RTCPlugin, "" )]
    cLamp = Lamp.eLamp;
};
"""
SETTINGS = """
[sources]
paths = ["lamp.cdl"]
[output]
package = "colcon_lit"
[ros2]
namespace = "/room"
"""
MOVE = "/room/lamp/move", "colcon_lit_lamp.srv.LampMove"
LEVEL = "/room/lamp/level", "colcon_lit_lamp.srv.LampLevel"
CHANGE = "lifecycle_msgs.srv.ChangeState"
RTCS = ("OpaqueRpcCommunication0", "LampMarshaller0")
HERE = {"x": -1.5, "cells": [1, -2]}
THERE = {"x": 2.25, "cells": [300, -32768]}


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """Return a project without a system, whose packages colcon has built."""
    made = Workspace(installation("jazzy", builds=True), tmp_path_factory.mktemp("lit"))
    made.domain = own_domain()
    (made.folder / "lamp.cdl").write_text(LAMP)
    (made.folder / "rtgen.toml").write_text(SETTINGS)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made.folder)
        assert run(["new", "ros2-package", "lit_ros"]) == 0
    made.output("colcon", "build", "--base-paths", "ros2")
    return made


@pytest.fixture(scope="module")
def server(workspace: Workspace) -> Iterator[ModuleType]:
    """Return the generated module of the board's side."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(workspace.folder / "generated"))
        yield importlib.import_module("colcon_lit.tecs.lamp.lamp_server")


class Client:
    """A process with clients of rclpy."""

    def __init__(self, workspace: Workspace) -> None:
        self.process = subprocess.Popen(
            workspace.command(workspace.ros2.python, str(CLIENT)),
            env=workspace.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def call(self, service: tuple[str, str], **request: Any) -> Any:
        assert self.process.stdin
        assert self.process.stdout
        print(json.dumps([*service, request]), file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline())

    def end(self) -> int:
        self.process.communicate()
        return self.process.returncode


@pytest.mark.parametrize("installed", [False, True])
def test_a_board_is_called(
    workspace: Workspace, server: ModuleType, tmp_path: Path, *, installed: bool
) -> None:
    """By `rtgen run` without a system, and by the program that colcon has installed.

    Its components are made active as by its launch file.
    """
    types = importlib.import_module("colcon_lit.tecs.lamp._types")

    class Lamp(server.LampTarget):  # type: ignore[misc, name-defined]
        percent = 100
        place = types.tagPlace(x=-1.5, cells=[1, -2])

        def move(self, *values: Any) -> Any:
            percent, place, levels, count, total = values
            if percent == 3:
                return -17, 0, place
            before, self.place, self.percent = self.place, place, percent
            return 0, total + round(sum(levels[:count])), before

        def level(self) -> int:
            return self.percent & 0xFF

    port = free_port()
    link = ("--set", f"OpaqueRpcCommunication0.port={port}")
    program = workspace.folder / "install/lit_ros/lib/lit_ros/boards"
    command = (
        [str(program), "--inactive"]
        if installed
        else [workspace.ros2.rtgen, "run", "--clock", "real", "--ros2", "rclpy"]
    )
    process = LoggedProcess(
        workspace.command(*command, *link)[1:],
        tmp_path if installed else workspace.folder,
        workspace.environment,
        tmp_path / "run.log",
        "bash",
    )
    client = Client(workspace)
    wanted = {"levels": [1.5, 2.5], "count": 2, "total": 2**30}
    try:
        with TcpServer(server.LampUnmarshaller(Lamp()), port=port):
            for name in RTCS if installed else ():
                service = f"/room/{name}/change_state", CHANGE
                changed = client.call(service, transition={"id": 3})
                assert changed["success"]
            process.says("LampMarshaller0 ACTIVE")
            moved = client.call(MOVE, percent=-7, place=THERE, **wanted)
            assert moved == {
                "success": True,
                "message": "",
                "return_value": 0,
                "total": 2**30 + 4,
                "before": HERE,
            }
            level = {"success": True, "message": "", "return_value": 249}
            assert client.call(LEVEL) == level
            refused = client.call(MOVE, percent=3, place=HERE, **wanted)
            assert not refused["success"]
            assert refused["message"] == "E_PAR (-17)"
            assert refused["return_value"] == -17
            assert client.call(LEVEL) == level
        lost = client.call(LEVEL)
        assert not lost["success"]
        assert lost["message"]
        assert lost["return_value"] == 0
        refused = client.call(MOVE, percent=5, place=HERE, **wanted)
        assert not refused["success"]
        assert "Connection refused (E_OBJ)" in refused["message"]
        assert refused["return_value"] == ERCD(E_RPC, E_OBJ)
        assert not client.end()
        assert not process.end()
    finally:
        for each in (client.process, process.process):
            if each.poll() is None:
                each.kill()
                each.wait()
