"""A TECS board in a process of its own, called by services of ROS 2: over DDS and Zenoh.

The other sides are cyclonedds and Zenoh alone, with names and types as ROS 2 has them.
"""

from __future__ import annotations

import importlib
import os
import re
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from free_ports import free_port
from logged_process import LoggedProcess
from patience import until
from test_networks import DOMAIN, dds_network, participant, reliable

from rtgen.cli import run as cli
from rtgen.ros2.rosidl import load
from rtgen.runtime.opaque_rpc import E_OBJ, E_RPC, ERCD, TcpServer
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.tools.recording.schema_types import message_classes

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

from rtgen.runtime.ros2.zenoh import configuration  # noqa: E402

pytestmark = pytest.mark.waits

ROOT = Path(__file__).resolve().parents[2]
TYPE = "refrobots_board/srv/MotorBoard"
EMPTY = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:nothing:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"/>
"""


def rtgen(
    tmp_path: Path, name: str, *arguments: str, folder: Path = ROOT
) -> LoggedProcess:
    environment = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN)}
    command = ["-m", "rtgen", "run", *arguments, "--clock", "real"]
    return LoggedProcess(command, folder, environment, tmp_path / name, sys.executable)


@pytest.fixture
def system(tmp_path: Path) -> Path:
    file = tmp_path / "nothing.xml"
    file.write_text(EMPTY)
    return file


Call = Callable[..., Any]


def over_dds(name: str) -> Call:
    """Return a function that calls a service of the board by cyclonedds alone."""
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import (
        array,
        float64,
        int32,
        int64,
        sequence,
        uint8,
        uint32,
        uint64,
    )
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    service = f"{TYPE}{name}"
    shown = "".join(f"_{c.lower()}" if c.isupper() else c for c in name)[1:]
    dds = service.replace("/", "::").replace("::MotorBoard", "::dds_::MotorBoard")
    state = make_idl_struct(
        "TagWheelState_",
        "refrobots_board::msg::dds_::TagWheelState_",
        {
            "time": uint32,
            "count": array[int32, 2],
            "speed": array[float64, 2],
            "stopped": bool,
            "watchdog": bool,
        },
    )
    head = {"rmw_client": uint64, "rmw_sequence": int64}
    asked: dict[str, Any] = {
        "Drive": {"speed": sequence[float64, 2], "count": int32},
        "SetLimits": {"speed": float64, "acceleration": float64},
    }.get(name, {"structure_needs_at_least_one_member": uint8})
    told: dict[str, Any] = {"success": bool, "message": str, "return_value": int32}
    if name in ("Drive", "GetState"):
        told["state"] = state
    if name == "Identify":
        told["name"] = str
    if name == "Stop":
        del told["return_value"]
    request = make_idl_struct("Req", f"{dds}_Request_", {**head, **asked})
    reply = make_idl_struct("Rep", f"{dds}_Response_", {**head, **told})
    part = participant()
    topics = (
        Topic(part, f"rq/rh3/board/{shown}Request", request),
        Topic(part, f"rr/rh3/board/{shown}Reply", reply),
    )
    writer = DataWriter(part, topics[0], reliable("clientid"))
    reader = DataReader(part, topics[1], reliable("clientid"))
    until(writer.get_matched_subscriptions)
    until(reader.get_matched_publications)
    numbers = iter(range(1, 1_000_000))

    def call(*values: Any) -> Any:
        number = next(numbers)
        writer.write(request(7, number, *(values or (0,))))
        [found] = until(lambda: reader.take(8))
        assert (found.rmw_client, found.rmw_sequence) == (7, number)
        return found

    return call


@pytest.fixture
def on_loopback() -> Iterator[None]:
    """A network of this process sets the interface of the domain."""
    network = dds_network()
    yield
    network.close()


@pytest.mark.sampled(0)
@pytest.mark.usefixtures("on_loopback")
def test_a_board_is_moved_over_dds(tmp_path: Path, system: Path) -> None:
    """By [ros2] alone: the system has no component."""
    port = free_port()
    board_set = ("--set", f"SimulatedMotorBoard0.port={port}")
    board = rtgen(tmp_path, "board.log", "specs/tecs/board.xml", *board_set)
    link = ("--set", f"OpaqueRpcCommunication0.port={port}")
    run = rtgen(tmp_path, "run.log", str(system), "--ros2", "dds", *link)
    try:
        board.says("SimulatedMotorBoard0 ACTIVE")
        run.says("MotorBoardMarshaller0 ACTIVE")
        found = over_dds("Identify")()
        assert (found.success, found.name) == (True, "RH3 motor board, simulated")
        assert over_dds("SetLimits")(20.0, 50.0).success
        drive = over_dds("Drive")
        first = drive([3.0, 3.0], 2)
        assert (first.success, first.message, first.return_value) == (True, "", 0)
        until(lambda: min(drive([3.0, 3.0], 2).state.count) > max(first.state.count))
        wrong = drive([3.0, 3.0], 1)
        assert not wrong.success
        assert "2 elements, 1 are needed" in wrong.message
        assert over_dds("Stop")().success
        assert until(over_dds("GetState")).state.stopped
        board.end()
        lost = drive([3.0, 3.0], 2)
        assert not lost.success
        assert lost.message
        assert lost.return_value < 0
        refused = drive([3.0, 3.0], 2)
        assert refused.return_value == ERCD(E_RPC, E_OBJ)
        assert "Connection refused (E_OBJ)" in refused.message
    finally:
        for each in (run, board):
            if each.runs:
                each.end()


LAMP = """
signature sLamp {
    ER dim( [in] int8_t percent, [out] int8_t *before );
    uint8_t level( void );
    [oneway] void off( void );
};
celltype tLamp { entry sLamp eLamp; };
[active] celltype tSwitch { call sLamp cLamp; };
cell tLamp Lamp { };
cell tSwitch Switch {
    [through( RTCPlugin, "port=%d" )]
    cLamp = Lamp.eLamp;
};
"""
SETTINGS = """
[sources]
paths = ["lamp.cdl"]
[output]
package = "lit"
[ros2]
namespace = "/room"
zenoh = "zenoh.json5"
"""


def test_a_board_in_python_is_called_over_zenoh(
    tmp_path: Path, system: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a project that has a CDL file alone; its board is in this process."""
    port, place = free_port(), f"tcp/127.0.0.1:{free_port()}"
    (tmp_path / "lamp.cdl").write_text(LAMP % port)
    (tmp_path / "rtgen.toml").write_text(SETTINGS)
    config = configuration(connect=place)
    (tmp_path / "zenoh.json5").write_text(str(config))
    monkeypatch.chdir(tmp_path)
    assert cli(["generate", "-q", "--no-cache"]) == 0
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    server = importlib.import_module("lit.tecs.lamp.lamp_server")

    class Lamp(server.LampTarget):  # type: ignore[misc, name-defined]
        percent = 100

        def dim(self, percent: int) -> tuple[int, int]:
            before = self.percent
            if percent == 3:
                return -17, 0
            self.percent = percent
            return 0, before

        def level(self) -> int:
            return self.percent & 0xFF

        def off(self) -> None:
            self.percent = 0

    session = zenoh.open(configuration(connect=None, listen=place))
    run = rtgen(tmp_path, "run.log", str(system), "--ros2", "zenoh", folder=tmp_path)
    try:
        with TcpServer(server.LampUnmarshaller(Lamp()), port=port):
            run.says("LampMarshaller0 ACTIVE")
            dim = Caller(session, tmp_path, "Dim")
            assert dim(percent=-7) == (True, "", 0, 100)
            assert dim(percent=50) == (True, "", 0, -7)
            assert dim(percent=3) == (False, "E_PAR (-17)", -17, 0)
            level = Caller(session, tmp_path, "Level")
            assert level() == (True, "", 50)
            off = Caller(session, tmp_path, "Off")
            assert off() == (True, "")
            until(lambda: level() == (True, "", 0))
        success, message, returned = level()
        assert not success
        assert message
        assert returned == 0
        assert not run.end()
    finally:
        session.close()
        if run.runs:
            run.end()


class Caller:
    """A client of a service of the lamp, by Zenoh alone."""

    def __init__(self, session: Any, folder: Path, name: str) -> None:
        root = folder / "generated" / "ros2"
        made = message_classes(
            load([root / f"lit_lamp/srv/Lamp{name}.srv"], root=root).model
        )
        self._request, self._response = (
            made[f"lit_lamp/srv/Lamp{name}_{end}"] for end in ("Request", "Response")
        )
        text = (root / f"lit_lamp/srv/Lamp{name}.srv").read_text()
        [type_hash] = re.findall(r"RIHS01_\w+", text)
        dds = f"lit_lamp::srv::dds_::Lamp{name}_"
        self._key = f"{DOMAIN}/room/lamp/{name.lower()}/{dds}/{type_hash}"
        self._session = session

    def __call__(self, **values: Any) -> tuple[Any, ...]:
        attachment = struct.pack("<qqB16s", 1, 5, 16, bytes(range(16)))

        def replies() -> list[Any]:
            found = self._session.get(
                self._key,
                target=zenoh.QueryTarget.ALL_COMPLETE,
                payload=encoded(self._request(**values)),
                attachment=attachment,
            )
            return [reply.ok for reply in found if reply.ok]

        [sample] = until(replies)
        answer = decoded(self._response, sample.payload.to_bytes())
        return tuple(getattr(answer, name) for name in answer.__struct_fields__)
