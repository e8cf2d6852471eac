"""The server of a session on loopback: serves the built page, and a WebSocket by token."""

from __future__ import annotations

import asyncio
import hmac
import re
import secrets
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from mimetypes import guess_type
from pathlib import Path
from typing import Any, Final

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    Response,
)
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from rtgen.compiler.kit.translation import ENGLISH, LANGUAGES, language
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.requests import Client, Rates
from rtgen.ui.arrangements import MAX_OCTETS, Arrangements, is_arrangement, is_key
from rtgen.ui.commands import Commands
from rtgen.ui.errors import BAD_MESSAGE
from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.recorded import Recorded
from rtgen.ui.session import Session

Served = Session | Recorded
"""The kinds of session that pages can show."""
_Commands = Commands | Recorded

PAGE: Final = Path(__file__).parent / "page"
"""The folder of the built page, which is in the wheel."""
SUBPROTOCOL: Final = "rtgen-ui.1"
WRONG_TOKEN: Final = 4401
WRONG_ORIGIN: Final = 4403
MAX_MESSAGE_SIZE: Final = (1 << 20) + (1 << 16)
"""Maximum length of a message from a page [octets]; longer ones close the socket."""
MAX_PAGES: Final = 64
"""Maximum number of pages with full rights, and of pages that may only look."""
TOO_MANY: Final = 1013
"""The code that closes the socket of a further page (RFC 6455, 7.4.2)."""
JOINS: Final = 20.0
"""Sockets of pages without full rights that are opened at once, and in each second after."""
MAX_JOINING: Final = 320
"""Maximum number of such sockets that wait; further ones are closed."""
_LONGEST_JOIN: Final = 5.0
"""Longest time for which such a socket waits [s]."""
_WAITING: Final = {True: 64, False: 8}
"""Maximum number of waiting requests of a page, by whether it has full rights."""
_ENCODING: Final = {
    full: ThreadPoolExecutor(1, f"rtgen-ui-{name}")
    for full, name in ((True, "full"), (False, "read"))
}
"""The threads that encode messages, by the rights of pages."""
_MIN_INTERVAL: Final = 1 / 30
"""Minimum interval between two messages to a page [s]."""
_ASSET: Final = re.compile(r"\w[\w.-]{0,200}", re.ASCII)
"""The name of a file of the built page."""
_LANG: Final = '<html lang="en">'
"""What the built page begins with."""
_HOSTS: Final = ("127.0.0.1", "localhost", "[::1]")
_HEADERS: Final = (
    (
        b"content-security-policy",
        b"default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:;"
        b" connect-src 'self'; worker-src 'self' blob:; object-src 'none'; base-uri 'none';"
        b" form-action 'none'; frame-ancestors 'none'",
    ),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
)
_NEWEST: Final = (b"cache-control", b"no-store")
_LASTING: Final = (b"cache-control", b"public, max-age=31536000, immutable")
"""The names of assets contain hashes of their contents."""

_LEFT: Final = (WebSocketDisconnect, OSError, RuntimeError)
"""Exceptions of sending to a page that has left."""


@dataclass(frozen=True, slots=True)
class Tokens:
    """The secrets of a server: one gives full rights, one read-only rights."""

    full: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    read_only: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    def right(self, token: str) -> bool | None:
        """Return whether a token gives full rights; None for an invalid one."""
        if hmac.compare_digest(token.encode(), self.full.encode()):
            return True
        if hmac.compare_digest(token.encode(), self.read_only.encode()):
            return False
        return None


def application(
    session: Served,
    tokens: Tokens,
    page: Path = PAGE,
    arrangements: Arrangements | None = None,
) -> Starlette:
    """Return the ASGI application. The session's runner must be started.

    Without `arrangements`, each page arranges its wiring.
    """
    commands = session if isinstance(session, Recorded) else Commands(session)
    # Compiled while the first page is on its way.
    _ENCODING[True].submit(lambda: (ui.ServerMessage.to_cdr, ui.ClientMessage.from_cdr))
    pages = Counter[bool]()
    joins = Rates(JOINS, JOINS, JOINS)
    joining: set[WebSocket] = set()

    async def socket(websocket: WebSocket) -> None:
        right = _right(websocket, tokens)
        is_crowded = not right and len(joining) >= MAX_JOINING
        if not right and not is_crowded:
            joining.add(websocket)
            try:
                await asyncio.sleep(min(joins.delay(None, 1), _LONGEST_JOIN))
            finally:
                joining.discard(websocket)
        offered = websocket.scope.get("subprotocols", ())
        # A page can only read the code of a socket that was open, which needs its protocol.
        await websocket.accept(
            subprotocol=SUBPROTOCOL if SUBPROTOCOL in offered else None
        )
        if not is_same_origin(websocket.headers):
            await websocket.close(WRONG_ORIGIN)
        elif right is None:
            await websocket.close(WRONG_TOKEN)
        elif is_crowded or pages[right] >= MAX_PAGES:
            await websocket.close(TOO_MANY)
        else:
            pages[right] += 1
            try:
                await _serve(websocket, session, commands, full=right)
            finally:
                pages[right] -= 1

    routes = [
        Route("/", _index(page)),
        Route("/assets/{path:path}", _file(page, lambda r: _asset(r.path_params))),
        Route("/texts/{language}.json", _texts),
        Route(
            "/arrangements/{key}",
            _arrangement(tokens, arrangements),
            methods=["GET", "PUT"],
        ),
        WebSocketRoute("/socket", socket),
    ]
    return Starlette(routes=routes, middleware=[Middleware(_Guarded)])


def _right(request: HTTPConnection, tokens: Tokens) -> bool | None:
    """Return the right of a request by its token."""
    return tokens.right(request.query_params.get("token", ""))


def is_same_origin(headers: Any) -> bool:
    """Return whether Host is a loopback name, and Origin, if there is one, that of this server.

    Another site's page could otherwise connect (RFC 6455, 10.2), also by a name of its own that
    resolves to loopback.
    """
    host = headers.get("host", "")
    name = host if host.endswith("]") else host.rpartition(":")[0] or host
    origin = headers.get("origin")
    return name in _HOSTS and origin in (None, f"http://{host}")


def _asset(parameters: dict[str, Any]) -> str:
    """Return the name of a file of the folder `assets`; empty for a path that cannot be one."""
    name = parameters["path"]
    return f"assets/{name}" if _ASSET.fullmatch(name) else ""


def _index(page: Path) -> Callable[[Request], Awaitable[Response]]:
    """Return a handler for the built page, which it tells the language."""

    async def serve(_: Request) -> Response:
        file = page / "index.html"
        if not file.is_file():
            message = "this installation of rtgen has no page: it was not built"
            return PlainTextResponse(message, 503)
        if language() == ENGLISH:
            return FileResponse(file)
        text = file.read_text(encoding="utf-8")
        return HTMLResponse(text.replace(_LANG, f'<html lang="{language()}">', 1))

    return serve


def _file(
    page: Path, name: Callable[[Request], str]
) -> Callable[[Request], Awaitable[Response]]:
    """Return a handler for files of the page's folder, and no others."""

    async def serve(request: Request) -> Response:
        path = page / name(request)
        if path.is_file():
            # Whole: a page waits for all of it.
            return Response(path.read_bytes(), media_type=guess_type(path)[0])
        return PlainTextResponse("not found", 404)

    return serve


def _texts(request: Request) -> Response:
    """Return the texts of the page in a language."""
    wanted = request.path_params["language"]
    if wanted not in LANGUAGES:
        return PlainTextResponse("not found", 404)
    from rtgen.compiler.kit.translation.catalogue import texts_of_page

    return JSONResponse(texts_of_page(wanted))


def _arrangement(
    tokens: Tokens, arrangements: Arrangements | None
) -> Callable[[Request], Awaitable[Response]]:
    """Return a handler for arrangements, which only pages with full rights store.

    No content is the answer if there is none, since browsers report a 404 as an error.
    """

    async def serve(request: Request) -> Response:
        key, right = request.path_params["key"], _right(request, tokens)
        if right is None or not is_key(key):
            return PlainTextResponse("not found", 404)
        stores = right and arrangements is not None
        headers = {"allow": "GET, PUT" if stores else "GET"}
        if request.method == "PUT":
            if arrangements is None or not stores:
                return PlainTextResponse("not stored", 405, headers)
            data = await _body(request, MAX_OCTETS)
            if not is_arrangement(data):
                return PlainTextResponse("not an arrangement", 400)
            await run_in_threadpool(arrangements.put, key, data)
        elif arrangements is not None:
            stored = await run_in_threadpool(arrangements.get, key)
            if stored is not None:
                return Response(stored, 200, headers, "application/json")
        return Response(None, 204, headers)

    return serve


async def _body(request: Request, limit: int) -> bytes:
    """Return the body of a request, of a longer one the begin."""
    data = b""
    async for part in request.stream():
        data += part
        if len(data) > limit:
            break
    return data


class _Guarded:
    """Refuses requests for other hosts, and adds headers that keep other content out."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        is_begun = False

        async def send_noted(message: Message) -> None:
            nonlocal is_begun
            is_begun = True
            await send(message)

        try:
            await self._answer(scope, receive, send_noted)
        except asyncio.CancelledError:
            # The server ends, and does not wait for clients that are slow.
            if is_begun:
                return
            if scope["type"] == "websocket":
                await send({"type": "websocket.close"})
            else:
                refusal = PlainTextResponse("the server has ended", 503)
                await refusal(scope, receive, send)

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                is_asset = message["status"] < 400 and scope["path"].startswith(
                    "/assets/"
                )
                cached = _LASTING if is_asset else _NEWEST
                message["headers"] = [*message["headers"], *_HEADERS, cached]
            await send(message)

        if is_same_origin(Request(scope).headers):
            await self._app(scope, receive, send_guarded)
        else:
            refusal = PlainTextResponse("another host or origin", 403)
            await refusal(scope, receive, send_guarded)


async def _serve(
    websocket: WebSocket, session: Served, commands: _Commands, *, full: bool
) -> None:
    """Exchange messages with a page until it leaves."""
    loop = asyncio.get_running_loop()
    news = asyncio.Event()

    def wake() -> None:
        # After the end of the loop, there is nothing to wake.
        if not news.is_set() and not loop.is_closed():
            loop.call_soon_threadsafe(news.set)

    wanted = websocket.query_params.get("language")
    reading = wanted if wanted in LANGUAGES else ENGLISH
    outbox = Outbox(wake, full=full, language=reading)
    requests = session.runner.requests
    # A page that may only look gets an answer before its next request is executed.
    client = requests.join(
        _WAITING[full], first=full, ready=lambda: full or not outbox.owes
    )
    page = _Page(websocket, session, commands, outbox, client)
    client.put(lambda: session.join(outbox))
    # A page that has left ends one of them, perhaps while the other one waits.
    both = [asyncio.create_task(each) for each in (page.receive(), page.send(news))]
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
    finally:
        outbox.closed = True
        requests.leave(client)
        session.leave(outbox)
        for task in both:
            task.cancel()
        results = await asyncio.gather(*both, return_exceptions=True)
    for result in results:
        if isinstance(result, Exception) and not isinstance(result, _LEFT):
            raise result


@dataclass(frozen=True, slots=True)
class _Page:
    """A page: its socket, its requests and what it is sent."""

    websocket: WebSocket
    session: Served
    commands: _Commands
    outbox: Outbox
    client: Client

    async def send(self, news: asyncio.Event) -> None:
        """Send waiting messages; a page that does not read delays only this."""
        loop, full = asyncio.get_running_loop(), self.outbox.full
        while True:
            await news.wait()
            news.clear()
            # Long messages of one page do not delay those of others.
            message = await loop.run_in_executor(_ENCODING[full], self._message)
            self.session.runner.requests.wake()
            if message:
                await self.websocket.send_bytes(message)
            await asyncio.sleep(_MIN_INTERVAL)

    def _message(self) -> bytes:
        """Return the waiting messages; answers to the page count as time of its requests."""
        owed, begun = self.outbox.owes, time.thread_time()
        message = self.outbox.take()
        if owed:
            self.client.charge(time.thread_time() - begun)
        return message

    async def receive(self) -> None:
        """Pass the page's commands to the runner; a page that sends more is not read meanwhile."""
        while True:
            message = await self.websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            while self.client.is_full or self.outbox.is_crowded:
                await asyncio.sleep(_MIN_INTERVAL)
            begun = time.thread_time()
            request = self._request(message.get("bytes"))
            self.client.charge(time.thread_time() - begun)
            if request is not None:
                self.client.put(request)

    def _request(self, data: bytes | None) -> Callable[[], None] | None:
        """Return the request of a message, None for a text; None if it has been executed."""
        try:
            if data is None:
                raise CdrError("ClientMessage", "a message of text")
            message = ui.ClientMessage.from_cdr(data)
        except CdrError as error:
            return partial(self.outbox.put, _failure(0, BAD_MESSAGE, str(error)))
        if self.client.is_idle and self.commands.is_urgent(self.outbox, message):
            self.commands.execute(self.outbox, message)
            return None

        def carry_out() -> None:
            if not self.outbox.closed:
                self.commands.execute(self.outbox, message)

        return carry_out


def _failure(request: int, code: str, message: str) -> ui.Event:
    return ui.Event.of_outcome(
        ui.Result(request=request, done=False, code=code, message=message)
    )
