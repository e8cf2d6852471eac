"""The board of examples/board: both halves of its CDL file.

The robot's half, and the system that calls a stand-in of Python, need rtgen alone. tecsgen and gcc
build the board itself, which is called over TCP.
"""

from __future__ import annotations

import importlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir, closing, contextmanager, suppress
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from logged_process import LoggedProcess
from patience import until
from programs import tecs_board_tools

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import (
    E_ID,
    E_OBJ,
    E_OK,
    E_PAR,
    E_RPC,
    MERCD,
    ArgumentError,
    TcpChannel,
    TcpServer,
    check_signature,
)

EXAMPLE = Path(__file__).parents[2] / "examples" / "board"
NAME = "two wheels"
LONG = 30.0


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Copy the example, generate the robot's half, and make it importable."""
    folder = tmp_path_factory.mktemp("example") / "board"
    made = shutil.ignore_patterns("build", "generated", "base_client.py")
    shutil.copytree(EXAMPLE, folder, ignore=made)
    with chdir(folder):
        assert run(["generate", "-q"]) == 0
    sys.path.insert(0, str(folder / "generated"))
    yield folder
    sys.path.remove(str(folder / "generated"))


@pytest.fixture(scope="module")
def built(project: Path) -> Path:
    """Build the board."""
    tools = tecs_board_tools()
    program = f"{sys.executable} -m rtgen"
    made = subprocess.run(
        ["make", f"RTGEN={program}"],
        cwd=project,
        env={**os.environ, **tools},
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    assert "warning" not in made.stderr
    return project / "build" / "board"


def start(program: Path, log: Path, port: int = 0) -> tuple[LoggedProcess, int]:
    """Start the board; return it with its port."""
    environment = {**os.environ, "BOARD_PORT": str(port)}
    board = LoggedProcess([], program.parent, environment, log, program=str(program))
    board.says("listening 127.0.0.1:")
    found = until(lambda: re.search(r"listening 127\.0\.0\.1:(\d+)\n", board.text))
    return board, int(found[1])


@contextmanager
def running(program: Path, log: Path) -> Iterator[Any]:
    """Start the board and yield a proxy of it."""
    marshaller = importlib.import_module("two_wheels.tecs.base.base_marshaller")
    board, port = start(program, log)
    try:
        with closing(TcpChannel("127.0.0.1", port, timeout=LONG)) as channel:
            yield marshaller.BaseProxy(channel)
        assert board.runs, board.text
    finally:
        board.end()


def drive(project: Path, port: int, log: Path) -> LoggedProcess:
    """Start the system of the example with the board at a port."""
    setting = f"OpaqueRpcCommunication0.port={port}"
    words = ["-m", "rtgen", "run", "--until", "600", "-v", "--set", setting]
    return LoggedProcess(words, project, os.environ, log)


def test_the_robots_half_is_sound(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with chdir(project):
        assert run(["check"]) == 0
        assert run(["lint"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (project / "generated/two_wheels/tecs/base/RTCPlugin.rb").exists()


@pytest.mark.waits
def test_the_system_calls_a_stand_in(project: Path, tmp_path: Path) -> None:
    server = importlib.import_module("two_wheels.tecs.base.base_server")
    types = importlib.import_module("two_wheels.tecs.base._types")
    target = Mock(spec=server.BaseTarget)
    target.identify.return_value = E_OK, NAME
    target.drive.return_value = E_OK, types.tagOdometry(x=1.5, count=[0, 0])
    target.stop.return_value = None
    with TcpServer(server.BaseUnmarshaller(target), timeout=LONG) as tcp:
        system = drive(project, tcp.address[1], tmp_path / "system.log")
        system.says(f"Driver0: {NAME}")
        until(lambda: target.drive.call_count >= 3)
        system.end(signal.SIGINT)
        until(lambda: target.stop.called)
    speeds, count = target.drive.call_args.args
    assert (speeds, count) == (pytest.approx([2.0, 6.0]), 2)


@pytest.mark.peer
@pytest.mark.waits
def test_each_function_of_the_board(built: Path, tmp_path: Path) -> None:
    with running(built, tmp_path / "board.log") as base:
        check_signature(base.channel, base.codec)
        assert base.identify() == (E_OK, NAME)
        assert base.getTrace(2, 4) == (E_ID, [], 0)

        assert base.drive([1.0], 1)[0] == E_PAR
        assert base.drive([1.0, 20.5], 2)[0] == E_PAR
        assert base.drive([1.0, float("nan")], 2)[0] == E_PAR
        code, odometry = base.drive([1.0, 2.0], 2)
        assert (code, odometry.stopped) == (E_OK, False)
        moved = until(lambda: _beyond(base, 0.05), LONG)
        assert moved.heading > 0.0
        assert moved.count[1] > moved.count[0] > 0
        assert moved.time > odometry.time
        code, speeds, count = base.getTrace(1, 3)
        assert (code, speeds, count) == (E_OK, [2.0] * 3, 3)
        assert len(base.getTrace(0, 16)[1]) == 16

        base.stop()
        code, odometry = base.drive([1.0, 1.0], 2)
        assert (code, odometry.stopped) == (E_OBJ, True)
        until(lambda: base.getTrace(1, 1)[1] == [0.0], LONG)
        assert base.release() == E_OK
        assert base.drive([0.0, 0.0], 2)[0] == E_OK


def _beyond(base: Any, x: float) -> Any:
    """Return the odometry once the base has gone that far [m]."""
    code, odometry = base.getOdometry()
    assert code == E_OK
    return odometry if odometry.x > x else None


@pytest.mark.peer
def test_parameters_of_the_board(built: Path, tmp_path: Path) -> None:
    with running(built, tmp_path / "board.log") as base:
        assert base.setParameter("limit", 5.0) == (E_OK, 20.0)
        assert base.setParameter("limit", 8.0) == (E_OK, 5.0)
        assert base.drive([0.0, 9.0], 2)[0] == E_PAR
        for wrong in (0.0, -1.0, float("inf"), float("nan")):
            assert base.setParameter("limit", wrong) == (E_PAR, 8.0)
        assert base.setParameter("ramp", 40.0) == (E_OK, 50.0)
        for unknown in ("lim", "limits", "", "x" * 31):
            assert base.setParameter(unknown, 1.0) == (E_OBJ, 1.0)


@pytest.mark.peer
def test_a_refused_request_ends_the_connection_only(
    built: Path, tmp_path: Path
) -> None:
    unknown_function = b"\x67\x2a\x00\x63\x5a\x3c"
    with running(built, tmp_path / "board.log") as base:
        address = base.channel.address, base.channel.port
        for octets in (unknown_function, b"GET / HTTP/1.0\r\n", bytes(5000)):
            with socket.create_connection(address, timeout=LONG) as link:
                link.sendall(octets)
                with suppress(ConnectionResetError):
                    assert link.recv(1) == b""
        with pytest.raises(ArgumentError):
            base.drive([1.0, 2.0, 3.0], 3)
        assert MERCD(base.getTrace(0, -1)[0]) == E_RPC
        assert base.identify() == (E_OK, NAME)


@pytest.mark.peer
@pytest.mark.waits
def test_the_board_is_started_anew_while_the_system_runs(
    built: Path, project: Path, tmp_path: Path
) -> None:
    board, port = start(built, tmp_path / "first.log")
    system = drive(project, port, tmp_path / "system.log")
    try:
        system.says(f"Driver0: {NAME}")
        board.end(signal.SIGKILL)
        system.says("Driver0: no board")
        board, again = start(built, tmp_path / "second.log", port)
        assert again == port
        system.says(f"Driver0: {NAME}", times=2)
        assert "Traceback" not in system.text
    finally:
        system.end(signal.SIGINT)
        board.end()
