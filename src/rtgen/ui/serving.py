"""Runs the server of a session on a loopback port until it is stopped."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from pathlib import Path
from typing import cast

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from rtgen.compiler.diagnostics import ToolError
from rtgen.ui.arrangements import Arrangements
from rtgen.ui.server import MAX_MESSAGE_SIZE, PAGE, Served, Tokens, application

MAX_CONNECTIONS = 320
"""Maximum number of connections that are not those of pages: requests, and silent ones."""
_AT_ONCE = 64
"""Maximum number of connections that are accepted before the oldest are ended."""
_PATIENCE = 2
"""Time for pages to close their sockets when the server ends [s]."""


class Server:
    """The server of a session, with new tokens, and without stored arrangements, by default.

    Raises ToolError if the port is taken.
    """

    def __init__(
        self,
        session: Served,
        host: str,
        port: int,
        page: Path = PAGE,
        tokens: Tokens | None = None,
        arrangements: Arrangements | None = None,
    ) -> None:
        self.tokens = tokens or Tokens()
        self._session = session
        # asyncio sets TCP_NODELAY only where the protocol is named.
        self._socket = socket.socket(
            socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP
        )
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            session.close()
            raise ToolError(
                f"cannot listen at {host}:{port}: {error.strerror}",
                hint="another --port, or 0 for any that is free",
            ) from error
        self.host, self.port = self._socket.getsockname()
        self._server = uvicorn.Server(
            uvicorn.Config(
                application(session, self.tokens, page, arrangements),
                log_level="error",
                lifespan="off",
                ws="websockets-sansio",
                http=_bounded(),
                backlog=_AT_ONCE,
                ws_max_size=MAX_MESSAGE_SIZE,
                ws_per_message_deflate=False,  # loopback has no need of it
                timeout_graceful_shutdown=_PATIENCE,
            )
        )

    def address(self, *, full: bool) -> str:
        """Return the address of the page, with the token."""
        token = self.tokens.full if full else self.tokens.read_only
        return f"http://{self.host}:{self.port}/?token={token}"

    async def run(self, ready: Callable[[], None]) -> None:
        """Serve until SIGINT, SIGTERM, SIGHUP, or `stop`; then end the run."""
        self._session.runner.start()
        try:
            self._socket.listen()
            ready()
            await self._server.serve(sockets=[self._socket])
        finally:
            # Nobody waits for those who do not read the answer.
            for each in self._server.server_state.connections:
                if isinstance(each, H11Protocol):
                    each.transport.abort()
            self._session.close()

    def stop(self) -> None:
        """End `run`; from any thread."""
        self._server.should_exit = True


def _bounded() -> type[H11Protocol]:
    """Return a protocol of which at most MAX_CONNECTIONS wait or are served.

    A further one ends that which began first, so that who opens many, and asks for nothing, neither
    takes the files of the process nor keeps others out.
    """
    begun: list[H11Protocol] = []

    class Bounded(H11Protocol):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(cast(asyncio.Transport, transport))
            # Those that have ended, or have become sockets of pages, are no longer in the set.
            begun[:] = [each for each in begun if each in self.connections]
            begun.append(self)
            if len(begun) > MAX_CONNECTIONS:
                begun.pop(0).transport.abort()

    return Bounded
