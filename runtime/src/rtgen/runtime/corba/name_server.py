"""A private naming service: a process with omniNames on the loopback interface."""

from __future__ import annotations

import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

from rtgen.runtime.closable import Closable
from rtgen.runtime.corba.orb import LOOPBACK
from rtgen.runtime.errors import TransportError

_ATTEMPTS = 3
_START_TIMEOUT = 10.0
"""Time-out in seconds for the start of omniNames."""
_POLL_INTERVAL = 0.02
_HEADER = struct.Struct("<4s4BI")
"""Magic, version 1.0, little endian, type and length of a message (CORBA 3.3, part 2, 9.4.1)."""
_LOCATED = struct.Struct("<II")
"""A LocateReply: the number of the request and the status (CORBA 3.3, part 2, 9.4.6)."""
_LOCATE_REQUEST = 3


_UNTIL_END_OF_INPUT = """
import os, subprocess, sys, threading
def end():
    os.read(0, 1)
    server.terminate()
with subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL) as server:
    threading.Thread(target=end, daemon=True).start()
"""
"""A program that runs another one until that ends, or the standard input does.

The input ends with the process that holds its other end, even if that process is killed.
"""


class NameServer(Closable):
    """An omniNames process on a free port; `close`, or the end of this process, ends it.

    Raises TransportError.
    """

    def __init__(self) -> None:
        program = _program()
        self._folder = tempfile.TemporaryDirectory(prefix="rtgen-names-")
        for _ in range(_ATTEMPTS):
            port = _free_port()
            self.address = f"{LOOPBACK}:{port}"
            self._process = _started(program, port, self._folder.name)
            if _answers(self._process, port):
                return
            self._end()
        self._folder.cleanup()
        raise TransportError(f"{program} does not start")

    def close(self) -> None:
        """End the process and delete its data."""
        self._end()
        self._folder.cleanup()

    def _end(self) -> None:
        self._process.communicate()  # The input ends, so the process does.


def _program() -> str:
    # The command installed by the wheel is a wrapper around this process, which would outlive it.
    spec = find_spec("jeteve_omniorb")
    if spec is not None and spec.origin is not None:
        inside = Path(spec.origin).with_name("bin") / "omniNames"
        if inside.is_file():
            return str(inside)
    found = shutil.which("omniNames")
    if found is None:
        raise TransportError("the program omniNames is not there")
    return found


def _free_port() -> int:
    with socket.create_server((LOOPBACK, 0)) as server:
        port: int = server.getsockname()[1]
        return port


def _started(program: str, port: int, folder: str) -> subprocess.Popen[bytes]:
    command = [program, "-start", str(port), "-always", "-datadir", folder]
    command += ["-ignoreport", "-ORBendPoint", f"giop:tcp:{LOOPBACK}:{port}"]
    # In a separate session: Ctrl-C is for the processes that must still unbind their names.
    return subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", _UNTIL_END_OF_INPUT, *command],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _answers(process: subprocess.Popen[bytes], port: int) -> bool:
    deadline = time.monotonic() + _START_TIMEOUT
    while process.poll() is None and time.monotonic() < deadline:
        if _has_root(port):
            return True
        time.sleep(_POLL_INTERVAL)
    return False


def _has_root(port: int) -> bool:
    """Return whether the root context exists, which omniNames creates after it listens."""
    key = b"NameService"
    body = struct.pack("<II", 1, len(key)) + key
    header = _HEADER.pack(b"GIOP", 1, 0, 1, _LOCATE_REQUEST, len(body))
    length = _HEADER.size + _LOCATED.size
    try:
        with socket.create_connection((LOOPBACK, port), timeout=1.0) as connection:
            connection.sendall(header + body)
            with connection.makefile("rb") as stream:
                reply = stream.read(length)
    except OSError:
        return False
    # The reply has the byte order of the server, which runs on this machine.
    status = reply[_HEADER.size + 4 :]
    return len(reply) == length and any(status)
