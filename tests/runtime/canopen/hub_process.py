"""A hub in a process of its own."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from types import TracebackType

from free_ports import free_port

from rtgen.runtime import RealClock
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link

_WITHOUT_UVLOOP = """
import sys
sys.modules["uvloop"] = None
from rtgen.__main__ import main
main()
"""


class HubProcess:
    """`rtgen can hub` with options, until the end of the `with` statement."""

    def __init__(self, *options: str, port: int = 0, uvloop: bool = True) -> None:
        program = ["-m", "rtgen"] if uvloop else ["-c", _WITHOUT_UVLOOP]
        self._process = subprocess.Popen(
            [
                sys.executable,
                *program,
                "can",
                "hub",
                "--port",
                str(port or free_port()),
                *options,
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.stderr = ""
        self.code: int | None = None
        self.host, _, number = self.line().removeprefix("listening ").rpartition(":")
        self.port = int(number)
        self.ptys = [
            self.line().removeprefix("slcan ")
            for _ in range(options.count("--slcan-pty"))
        ]

    def __enter__(self) -> HubProcess:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.end()

    def line(self) -> str:
        assert self._process.stdout is not None
        line: str = self._process.stdout.readline()
        return line.rstrip("\n")

    def error_line(self) -> str:
        """Return the next line on standard error."""
        assert self._process.stderr is not None
        line: str = self._process.stderr.readline()
        return line.rstrip("\n")

    def tell(self, number: int) -> None:
        """Send a signal to the hub."""
        os.kill(self._process.pid, number)

    def end(self, how: int = signal.SIGINT) -> str:
        """End the hub; return its output on standard error since the last call."""
        if self._process.returncode is None:
            os.kill(self._process.pid, how)
            _, rest = self._process.communicate(timeout=30)
            self.stderr = rest
            self.code = self._process.returncode
        return self.stderr

    def options(self, more: str = "") -> str:
        return f"host={self.host},port={self.port},tcp_tune=True{more}"

    def link(self, channel: str = "can0", more: str = "") -> Link:
        """Return a link of this process; `more` creates further ones."""
        return open_link(RealClock(), "socketcand", channel, 0, self.options(more))

    def connect(self) -> socket.socket:
        """Return a connection without any message yet."""
        end = socket.create_connection((self.host, self.port), 20)
        assert end.recv(256) == b"< hi >"
        return end

    def raw(self, channel: str = "can0") -> socket.socket:
        """Return a connection in raw mode."""
        end = self.connect()
        for command in (f"< open {channel} >", "< rawmode >"):
            end.sendall(command.encode())
            assert end.recv(256) == b"< ok >"
        return end
