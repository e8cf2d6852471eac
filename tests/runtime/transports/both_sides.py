"""The near side of a transport in this process, and the far side in a process of its own."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import media
from far_side import FAR, NEAR, TIMEOUT, Side, sample
from patience import PATIENCE, until

from rtgen import runtime

HERE = Path(__file__).parent


class FarProcess:
    """The far side in a process of its own."""

    def __init__(self, address: str, log: Path, *last_step: str) -> None:
        paths = [str(HERE), str(HERE.parent), *filter(None, sys.path)]
        self._log = log
        with log.open("w", encoding="utf-8") as errors:
            self._process = subprocess.Popen(
                [sys.executable, str(HERE / "far_side.py"), address, *last_step],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            )

    @property
    def log(self) -> str:
        """Its standard error."""
        return self._log.read_text(encoding="utf-8")

    def ready(self) -> None:
        """Wait until the far side is connected and ACTIVE."""
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n", self.log

    def freeze(self) -> None:
        """Stop the process as a debugger does; `thaw` continues it."""
        self._process.send_signal(signal.SIGSTOP)
        os.waitpid(self._process.pid, os.WUNTRACED)

    def thaw(self) -> None:
        """Continue the process."""
        self._process.send_signal(signal.SIGCONT)

    def has_died(self) -> None:
        """Wait until the process has killed itself."""
        self._process.communicate(timeout=PATIENCE)
        assert self._process.returncode == -signal.SIGKILL, self.log

    def kill(self) -> None:
        """Kill the process."""
        self._process.kill()
        self._process.communicate()

    def close(self) -> None:
        """End the process in order."""
        self._process.communicate(timeout=PATIENCE)
        assert self._process.returncode == 0, self.log


class Pair:
    """The near side in this process, with calls to the far one."""

    def __init__(self, near: Side) -> None:
        self.near = near
        self.end = near.end
        self.rpc: Any = near.end.rpc.object

    def ask(self, request: str, number: int = 0) -> bytes:
        """Call the far component; return its reply."""
        reply: bytes = self.rpc.begin(request.encode(), number)
        return reply

    def answers(self) -> bool:
        """Return whether a call is answered."""
        try:
            return self.ask("echo x", 2) == b"xx"
        except runtime.ServiceError:
            return False

    def write(self, port: str, number: int, octets: bytes = b"") -> Any:
        """Return the status of a write."""
        return self.end.out_ports[port].write(sample(number, octets))

    def taken(self, port: str) -> list[tuple[int, int]]:
        """Return number and size of the samples received by the far side since the last call."""
        return [*struct.iter_unpack("<II", self.ask(f"take {port}"))]

    def numbers(self, port: str, count: int) -> list[int]:
        """Return numbers of `count` samples at the far side, and of those received with them."""
        found: list[int] = []

        def are_there() -> bool:
            found.extend(number for number, _ in self.taken(port))
            return len(found) >= count

        until(are_there)
        return found


@contextmanager
def near_side(network: media.Transports, timeout: float = TIMEOUT) -> Iterator[Pair]:
    """Return the near side, before its connections are established."""
    with Side(network.open(timeout), NEAR) as near:
        near.connect_data()
        near.system.connect((NEAR, "taken"), (FAR, "given"))
        yield Pair(near)
