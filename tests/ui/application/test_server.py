"""The server of a session over real sockets of loopback."""

from __future__ import annotations

import asyncio
import gc
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from http.client import HTTPConnection
from pathlib import Path
from select import select
from socket import IPPROTO_TCP, SHUT_WR, TCP_NODELAY, create_connection, socket
from typing import Any

import pytest
from patience import PATIENCE
from ui_bench import GOAL, QUIET
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from rtgen.runtime import SimulatedClock
from rtgen.ui.arrangements import Arrangements
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.server import MAX_MESSAGE_SIZE
from rtgen.ui.serving import Server
from rtgen.ui.session import Session


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("page")
    (folder / "page" / "assets").mkdir(parents=True)
    (folder / "page" / "index.html").write_text("<title>rtgen</title>")
    (folder / "page" / "assets" / "page.js").write_text("export {};")
    (folder / "secret.txt").write_text("secret")
    with serving(folder / "page") as server:
        yield server


@contextmanager
def serving(page: Path, arrangements: Arrangements | None = None) -> Iterator[Server]:
    """Serve a session, and end the server."""
    session = Session(CommandProject(QUIET, [str(GOAL)]), str(GOAL), SimulatedClock)
    server = Server(session, "127.0.0.1", 0, page, arrangements=arrangements)
    ready = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    thread.start()
    assert ready.wait(60)
    yield server
    server.stop()
    thread.join(60)
    assert not thread.is_alive()


def get(server: Server, path: str, **headers: str) -> tuple[int, bytes, Any]:
    connection = HTTPConnection(server.host, server.port, timeout=60)
    try:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read(), answer.headers
    finally:
        connection.close()


def opened(server: Server, token: str, **options: Any) -> ClientConnection:
    address = f"ws://{server.host}:{server.port}/socket?token={token}"
    # On a busy machine an answer to a ping of the client may take its time.
    options |= {"max_size": None, "ping_interval": None}
    return connect(address, subprotocols=["rtgen-ui.1"], **options)


def events(socket: ClientConnection) -> list[ui.Event]:
    data = socket.recv(60)
    assert isinstance(data, bytes)
    return list(ui.ServerMessage.from_cdr(data).events)


def joined(socket: ClientConnection) -> ui.SystemState:
    """Return the state that a page receives when it has joined."""
    while True:
        for event in events(socket):
            if event.discriminator is ui.EventKind.EVENT_SYSTEM:
                return event.whole


def ask(socket: ClientConnection, branch: str, value: Any) -> ui.Result:
    asked = getattr(ui.Command, f"of_{branch}")(value)
    socket.send(ui.ClientMessage(request=9, asked=asked).to_cdr())
    return outcome(socket)


def outcome(socket: ClientConnection) -> ui.Result:
    while True:
        for event in events(socket):
            if event.discriminator is ui.EventKind.EVENT_RESULT:
                return event.outcome


def test_only_the_page_is_served(served: Server) -> None:
    status, body, headers = get(served, "/?token=any")
    assert (status, body) == (200, b"<title>rtgen</title>")
    assert "default-src 'self'" in headers["content-security-policy"]
    assert headers["cache-control"] == "no-store"
    status, _, headers = get(served, "/assets/page.js")
    assert (status, "immutable" in headers["cache-control"]) == (200, True)
    assert get(served, "/assets/none.js")[2]["cache-control"] == "no-store"
    for path in (
        "/secret.txt",
        "/../secret.txt",
        "/assets/../../secret.txt",
        "/assets/%2e%2e/%2e%2e/secret.txt",
        "/assets//etc/passwd",
        "/assets/",
    ):
        assert get(served, path)[0] == 404, path


@pytest.mark.parametrize(
    "path",
    [
        "/assets/%00",
        "/assets/page.js%00",
        "/assets/%ff",
        "/assets/%2e",
        "/assets/page.js/",
        f"/assets/{'a' * 300}",
        f"/assets/{'a' * 5000}",
        f"/assets/{'a/' * 3000}",
        "/%00",
        "/socket",
        f"/{'%41' * 3000}",
    ],
)
def test_paths_that_no_file_can_have_are_not_found(
    served: Server, path: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert get(served, path)[0] == 404
    assert capfd.readouterr().err == ""


def test_requests_that_are_none_are_refused(
    served: Server, capfd: pytest.CaptureFixture[str]
) -> None:
    for request in (
        b"GET /" + b"a" * (1 << 17) + b" HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        b"\0" * 100 + b"\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: example.org\r\n\r\n",
        b"GET /\xff\x00 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        b"GET /socket?token=%00%ff HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        b"Upgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
    ):
        with (
            create_connection((served.host, served.port), 60) as raw,
            suppress(OSError),  # the server has not read all
        ):
            raw.sendall(request)
            raw.shutdown(SHUT_WR)
            answer = raw.recv(1 << 16)
            assert answer.startswith(b"HTTP/1.1 4"), request[:40]
    assert "Traceback" not in capfd.readouterr().err
    assert get(served, "/")[0] == 200


def test_other_hosts_and_origins_are_refused(served: Server) -> None:
    own = f"127.0.0.1:{served.port}"
    assert get(served, "/", Host="example.org")[0] == 403
    assert get(served, "/", Host=own, Origin="http://example.org")[0] == 403
    assert get(served, "/", Host=own, Origin=f"http://{own}")[0] == 200
    for origin in ("http://example.org", f"https://{own}", "null"):
        with opened(served, served.tokens.full, origin=origin) as socket:
            with pytest.raises(ConnectionClosed):
                socket.recv(60)
            assert socket.close_code == 4403
    with opened(served, served.tokens.full, origin=f"http://{own}") as socket:
        assert events(socket)


def test_a_token_is_needed(served: Server) -> None:
    for token in ("", "wrong", served.tokens.full[:-1], "\u00e9"):
        with opened(served, token) as socket:
            assert socket.subprotocol == "rtgen-ui.1"
            with pytest.raises(ConnectionClosed):
                socket.recv(60)
            assert socket.close_code == 4401
    with opened(served, served.tokens.read_only) as socket:
        assert not events(socket)[0].greeting.full
        assert ask(socket, "played", True).code == "UIS0002"


def test_small_answers_do_not_wait_for_an_acknowledgement(served: Server) -> None:
    # Head and body are two segments: by Nagle's algorithm the second one waits up to 40 ms.
    connection = HTTPConnection(served.host, served.port, timeout=60)
    connection.request("GET", "/")
    connection.getresponse().read()
    peer = connection.sock.getsockname()
    ends = []
    for each in gc.get_objects():
        if type(each) is socket and each.fileno() >= 0:
            with suppress(OSError):  # those without a peer
                if each.getpeername() == peer:
                    ends.append(each.getsockopt(IPPROTO_TCP, TCP_NODELAY))
    connection.close()
    assert ends == [1]


def test_two_pages_stay_in_step_and_one_that_reloads_finds_the_state(
    served: Server,
) -> None:
    with (
        opened(served, served.tokens.full) as one,
        opened(served, served.tokens.full) as other,
    ):
        assert one.subprotocol == "rtgen-ui.1"
        first, second = events(one), events(other)
        assert first[0].greeting.server == second[0].greeting.server
        moved = ui.Moved("Odometry0", ui.Location(11.0, 12.0))
        assert ask(one, "place", moved).done
        found = False
        while not found:
            found = any(
                e.discriminator is ui.EventKind.EVENT_MOVED and e.place == moved
                for e in events(other)
            )
    with opened(served, served.tokens.full) as again:
        whole = joined(again)
        [component] = [c for c in whole.components if c.instance == "Odometry0"]
        assert (component.where.x, component.where.y) == (11.0, 12.0)
        assert ask(again, "undone", True).done


def test_time_passes_and_stands_still(served: Server) -> None:
    with opened(served, served.tokens.full) as socket:
        events(socket)
        assert ask(socket, "speed", 0.0).done
        assert ask(socket, "played", True).done
        now = 0.0
        while now < 1.0:
            for event in events(socket):
                if event.discriminator is ui.EventKind.EVENT_TIME:
                    now = event.clock.now
        assert ask(socket, "paused", True).done
        assert ask(socket, "time", 0.0).done


def test_what_is_not_a_message_is_answered(served: Server) -> None:
    with opened(served, served.tokens.full) as socket:
        events(socket)
        for data in (b"", b"\xff" * 40, b"\0" * 8):
            socket.send(data)
            assert outcome(socket).code == "UIS0001"
        assert ask(socket, "paused", True).done


def test_a_page_that_does_not_read_slows_nobody(served: Server) -> None:
    full = served.tokens.full
    with (
        opened(served, full, max_queue=1, close_timeout=0.1) as lazy,
        opened(served, full) as other,
    ):
        state = joined(other)
        watched = [c.id for c in state.channels]
        for socket in (lazy, other):
            message = ui.ClientMessage(asked=ui.Command.of_channels(watched))
            socket.send(message.to_cdr())
        assert ask(other, "time", 0.0).done
        assert ask(other, "step", 5.0).done
        assert ask(other, "time", 0.0).done


def ended_with(socket: ClientConnection) -> int | None:
    """Return the code with which the server closes a socket."""
    with suppress(ConnectionClosed):
        while True:
            socket.recv(60)
    return socket.close_code


def test_texts_and_messages_that_are_too_long_are_refused(
    served: Server, capfd: pytest.CaptureFixture[str]
) -> None:
    with opened(served, served.tokens.read_only) as socket:
        joined(socket)
        socket.send("text")
        assert outcome(socket).code == "UIS0001"
        socket.send(bytes(MAX_MESSAGE_SIZE + 1))
        assert ended_with(socket) == 1009
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.sampled(0)
def test_a_page_that_floods_waits_for_the_others(served: Server) -> None:
    tokens = served.tokens
    ends = ui.Command.of_ends(ui.PortAddress("Odometry0", "OdometryPosition"))
    many = 2000
    with (
        opened(served, tokens.read_only) as flooding,
        opened(served, tokens.read_only) as other,
        opened(served, tokens.full) as operator,
    ):
        for socket in (flooding, other, operator):
            joined(socket)
        answered = threading.Semaphore(0)

        def read() -> None:
            with suppress(ConnectionClosed):
                while True:
                    outcome(flooding)
                    answered.release()

        def flood() -> None:
            with suppress(ConnectionClosed):
                for number in range(many):
                    message = ui.ClientMessage(request=number, asked=ends)
                    flooding.send(message.to_cdr())

        for work in (read, flood):
            threading.Thread(target=work, daemon=True).start()
        assert answered.acquire(timeout=PATIENCE)
        assert ask(operator, "played", True).done
        for _ in range(3):
            assert ask(other, "ends", ends.ends).fits
            assert ask(operator, "speed", 1.0).done
        assert ask(operator, "paused", True).done
        # Those that were sent later were executed while most of the flood waited.
        assert answered._value < many / 4
        assert ask(operator, "time", 0.0).done


def test_pages_beyond_the_limit_are_refused_by_their_rights(
    served: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtgen.ui.server.MAX_PAGES", 2)
    read_only = served.tokens.read_only
    with opened(served, read_only), opened(served, read_only):
        with opened(served, read_only) as third:
            assert ended_with(third) == 1013
        with opened(served, served.tokens.full) as operator:
            assert joined(operator).components
    with opened(served, read_only) as again:
        assert joined(again).components


def test_connections_that_ask_for_nothing_keep_nobody_out(
    served: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtgen.ui.serving.MAX_CONNECTIONS", 4)
    monkeypatch.setattr("rtgen.ui.server.MAX_JOINING", 0)
    place = served.host, served.port
    with ExitStack() as stack, opened(served, served.tokens.full) as operator:
        for beginning in (b"", b"GET / HTTP/1.1\r\n", b"PUT /x HTTP/1.1\r\nX: "):
            silent = [stack.enter_context(create_connection(place)) for _ in range(4)]
            for each in silent:
                each.settimeout(PATIENCE)
                each.sendall(beginning)
            assert get(served, "/")[0] == 200
            with suppress(ConnectionResetError):
                assert silent[0].recv(1) == b""
        with opened(served, served.tokens.read_only) as crowding:
            assert ended_with(crowding) == 1013
        assert joined(operator).components


def test_a_server_ends_beside_clients_that_neither_read_nor_finish(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("rtgen.ui.serving._PATIENCE", 0)
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<title>rtgen</title>")
    (tmp_path / "assets" / "page.js").write_bytes(bytes(1 << 24))
    with ExitStack() as stack, serving(tmp_path, Arrangements(tmp_path)) as server:
        place = server.host, server.port
        host = f"HTTP/1.1\r\nHost: {server.host}:{server.port}\r\n"
        token = server.tokens.full
        put = f"PUT /arrangements/{'a' * 64}?token={token} {host}"
        for text in (
            f"GET /assets/page.js {host}\r\n" * 4,
            f"{put}Expect: 100-continue\r\nContent-Length: 9\r\n\r\n",
        ):
            client = stack.enter_context(create_connection(place))
            client.settimeout(PATIENCE)
            client.sendall(text.encode())
            assert client.recv(1)
        assert get(server, "/")[0] == 200
    assert "Traceback" not in capfd.readouterr().err


def test_a_missing_page_is_told(served: Server, tmp_path: Path) -> None:
    from starlette.requests import Request

    from rtgen.ui.server import _index

    request = Request({"type": "http", "path_params": {}, "headers": []})
    answer = asyncio.run(_index(tmp_path)(request))
    assert answer.status_code == 503


def test_pages_that_may_only_look_join_one_after_the_other(served: Server) -> None:
    """The last test of this server: its pages without full rights wait for some time."""
    place = served.host, served.port
    opening = (
        f"GET /socket?token={served.tokens.read_only} HTTP/1.1\r\n"
        f"Host: {served.host}:{served.port}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    ).encode()
    with ExitStack() as stack:
        flood = [stack.enter_context(create_connection(place)) for _ in range(300)]
        for each in flood:
            each.sendall(opening)
        assert flood[0].recv(1)
        with opened(served, served.tokens.full) as operator:
            assert joined(operator).components
        # The operator has not waited for those who came before.
        answered, _, _ = select(flood, [], [], 0)
        assert 0 < len(answered) < len(flood) / 2
