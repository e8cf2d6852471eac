"""The socket at which programs of the same user find a run, and what it costs a run without them.

The first one that comes loads the rest (`local_server`).
"""

from __future__ import annotations

import itertools
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rtgen.facts.version import __version__
from rtgen.runtime.closable import Closable
from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.local_requests import InRun
from rtgen.runtime.distribution.local_runs import Hello, Planned
from rtgen.runtime.failures import log
from rtgen.runtime.sockets import await_files
from rtgen.runtime.timing.clocks import SECOND, SimulatedClock

if TYPE_CHECKING:
    from rtgen.runtime.distribution.local_requests import Doing
    from rtgen.runtime.distribution.local_server import RunServer
    from rtgen.runtime.system.system import System

_PERIOD: Final = SECOND // 10
"""Period of executing requests in a simulated run, in its time [ns]."""
_numbers = itertools.count(1)


class ServedRun(Closable):
    """Lets programs of the same user find and control a system, until it is closed.

    Created before the first `run`. `path` of the socket is None where that is not possible. `doing`
    carries out what they ask of the program itself.
    """

    def __init__(
        self,
        system: System,
        name: str,
        file: str,
        command: str,
        *,
        plan: tuple[Planned, ...] = (),
        doc: str = "",
        doing: Doing | None = None,
    ) -> None:
        self._system = system
        simulated = isinstance(system.clock, SimulatedClock)
        self._hello = Hello(
            name,
            os.getpid(),
            file,
            command,
            simulated,
            time.time(),
            __version__,
            local_runs.MESSAGES,
            plan,
            doc,
        )
        self._doing = doing
        self._in_run = InRun() if simulated else None
        self._server: RunServer | None = None
        self._lock = threading.Lock()
        self._closed = False
        self.path: Path | None = None
        self._listening: socket.socket | None = None
        try:
            if local_runs.is_supported():
                self._listening = self._listen()
        except OSError as error:
            log.debug("`rtgen ui --attach` cannot find this run: %s", error)
        if self._listening is not None and self._in_run is not None:
            system.every(_PERIOD, self._in_run.carry_out)

    def _listen(self) -> socket.socket:
        path = local_runs.folder() / (
            f"{os.getpid()}-{next(_numbers)}{local_runs.SUFFIX}"
        )
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        # A socket at which nobody listens is taken for that of a killed process, and removed.
        begun = path.with_suffix(".new")
        try:
            with suppress(FileNotFoundError):
                begun.unlink()  # of a process that was killed, whose number this one has
            listening.bind(str(begun))
            listening.listen(local_runs.MAX_CLIENTS)
            begun.replace(path)
        except OSError:
            listening.close()
            raise
        self.path = path
        threading.Thread(
            target=self._accept, args=(listening,), name="rtgen attach", daemon=True
        ).start()
        return listening

    def _accept(self, listening: socket.socket) -> None:
        while True:
            try:
                stream, _ = listening.accept()
            except OSError as error:
                if self._closed:
                    return
                await_files(error)
                continue
            server = self._begun()
            if server is None:
                stream.close()
            else:
                server.accept(stream)

    def _begun(self) -> RunServer | None:
        """Return the server of programs; None after `close`."""
        with self._lock:
            if self._server is None and not self._closed:
                from rtgen.runtime.distribution.local_server import RunServer

                self._server = RunServer(
                    self._system, self._hello, self._in_run, self._doing
                )
            return self._server

    def tell(self, kind: str, instance: str, text: str) -> None:
        """Tell those who are connected that something has happened."""
        if self._server is not None:
            self._server.tell(kind, instance, text)

    def end(self, reason: str) -> None:
        """Tell those who are connected that the run is over, and why."""
        if self._server is not None:
            self._server.end(reason)

    def close(self) -> None:
        """Serve no more. A second call has no effect."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        if self._listening is not None:
            with suppress(OSError):
                self._listening.shutdown(socket.SHUT_RDWR)
            self._listening.close()
        if self.path is not None:
            with suppress(OSError):
                self.path.unlink()
        if self._server is not None:
            self._server.close()
