"""Calls between media: one server, at most one execution, and an end in time in any case."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial

import pytest
from collecting import ON_ROS_TOO
from patience import until

from rtgen.runtime.distribution.medium import (
    Medium,
    MediumError,
    NotServedError,
    PeerLostError,
    Reply,
    ReplyTimeoutError,
)
from rtgen.runtime.distribution.rpc_header import OctetsClient, serve_octets

Join = Callable[..., Medium]


class Server:
    """Replies with the reversed request; `held` keeps the replies back."""

    def __init__(self, *, holds: bool = False) -> None:
        self.requests: list[bytes] = []
        self.held: list[Reply] = []
        self._holds = holds

    def on_request(self, octets: bytes, reply: Reply) -> None:
        self.requests.append(octets)
        if self._holds:
            self.held.append(reply)
        else:
            threading.Thread(target=reply, args=(octets[::-1],)).start()


def served(client: OctetsClient, octets: bytes = b"probe") -> bytes:
    """Return the reply of a service that other media may not have discovered yet."""

    def attempt() -> bytes | None:
        try:
            return client.call(octets, 10)
        except NotServedError:
            return None

    reply: bytes = until(attempt)
    return reply


@pytest.fixture
def hurried() -> Iterator[None]:
    """Let Python switch between threads as often as possible."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.sampled(1)
@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize(
    ("threads", "calls"),
    [(4, 200), pytest.param(64, 30, marks=pytest.mark.nightly)],
)
def test_calls_of_many_threads_are_carried_out_once_each(
    join: Join, threads: int, calls: int
) -> None:
    here, *others = join(), join(), join()
    servers = [Server() for _ in others]
    for there, server in zip(others, servers, strict=True):
        serve_octets(there, "s/op", server.on_request)
    client = OctetsClient(here, "s/op")
    assert served(client) == b"eborp"
    wrong: list[object] = []

    def call(thread: int) -> None:
        for number in range(calls):
            octets = f"{thread} {number}".encode()
            try:
                reply = client.call(octets, 30)
            except MediumError as error:
                wrong.append(error)
                return
            if reply != octets[::-1]:
                wrong.append((octets, reply))

    callers = [threading.Thread(target=call, args=(n,)) for n in range(threads)]
    for thread in callers:
        thread.start()
    for thread in callers:
        thread.join()
    requests = [octets for server in servers for octets in server.requests]
    assert not wrong
    assert len(set(requests)) == threads * calls + 1
    assert len(requests) == threads * calls + 1


@pytest.mark.sampled(2)
@ON_ROS_TOO
def test_octets_of_any_length_travel(join: Join) -> None:
    here, there = join(), join()
    serve_octets(there, "s/op", Server().on_request)
    client = OctetsClient(here, "s/op")
    served(client)
    for octets in (b"", b"\0", bytes(range(256)) * 4096, bytes(10 << 20)):
        assert client.call(octets, 30) == octets[::-1]


def test_a_service_that_nobody_has_is_known_to_be_missing(join: Join) -> None:
    client = OctetsClient(join(), "s/op")
    join()
    with pytest.raises(NotServedError):
        client.call(b"", 10)


@ON_ROS_TOO
def test_a_reply_that_takes_too_long(join: Join) -> None:
    here, there = join(), join()
    held, quick = Server(holds=True), Server()
    serve_octets(there, "s/held", held.on_request)
    serve_octets(there, "s/quick", quick.on_request)
    client, other = OctetsClient(here, "s/held"), OctetsClient(here, "s/quick")
    served(other)
    with pytest.raises(ReplyTimeoutError):
        until(partial(_until_served, client, 0.3))
    until(lambda: held.held)
    # A late reply has no effect, and does not disturb the next call.
    for reply in held.held:
        reply(b"late")
    assert other.call(b"ab", 10) == b"ba"
    assert len(held.requests) == 1


@ON_ROS_TOO
def test_a_server_that_ends_meanwhile(join: Join) -> None:
    here, there = join(), join()
    server = Server(holds=True)
    serve_octets(there, "s/op", server.on_request)
    client = OctetsClient(here, "s/op")
    closing = threading.Thread(
        target=lambda: (until(lambda: server.held), there.close())
    )
    closing.start()
    # An engine that does not detect the loss ends the call in time.
    with pytest.raises((PeerLostError, ReplyTimeoutError)):
        until(partial(_until_served, client, 5.0))
    closing.join()
    assert len(server.requests) == 1

    def is_missing() -> bool:
        try:
            client.call(b"", 0.2)
        except NotServedError:
            return True
        except MediumError:
            return False
        return False

    until(is_missing)


def test_a_server_that_comes_again_is_found(join: Join) -> None:
    here, there = join(), join()
    client = OctetsClient(here, "s/op")
    for _ in range(3):
        token = serve_octets(there, "s/op", Server().on_request)
        assert served(client, b"abc") == b"cba"
        token.close()
        token.close()
        until(partial(_is_missing, client))


@ON_ROS_TOO
def test_calls_that_are_cancelled_end_and_others_follow(join: Join) -> None:
    here, there = join(), join()
    server = Server(holds=True)
    serve_octets(there, "s/op", server.on_request)
    client = OctetsClient(here, "s/op")
    ended = threading.Event()

    def cancel() -> None:
        # A server may hold a call whose client has not yet begun to wait, or begins another one.
        until(lambda: server.held)
        while not ended.wait(0.05):
            client.cancel()

    cancelling = threading.Thread(target=cancel)
    cancelling.start()
    with pytest.raises(PeerLostError):
        until(partial(_until_served, client, 30.0))
    ended.set()
    cancelling.join()
    held = list(server.held)
    answering = threading.Thread(
        target=lambda: (
            until(lambda: len(server.held) > len(held)),
            server.held[-1](b"answer"),
        )
    )
    answering.start()
    assert client.call(b"again", 30) == b"answer"
    answering.join()


def test_one_of_two_servers_carries_a_call_out(join: Join) -> None:
    media = join(), join()
    servers = Server(), Server()
    for medium, server in zip(media, servers, strict=True):
        serve_octets(medium, "s/op", server.on_request)
    for medium in (*media, join()):
        client = OctetsClient(medium, "s/op")
        served(client)
        before = sum(len(server.requests) for server in servers)
        assert client.call(b"once", 10) == b"ecno"
        assert sum(len(server.requests) for server in servers) == before + 1


@ON_ROS_TOO
def test_a_client_that_is_closed_ends_its_calls(join: Join) -> None:
    here, there = join(), join()
    server = Server(holds=True)
    serve_octets(there, "s/op", server.on_request)
    client = OctetsClient(here, "s/op")
    closing = threading.Thread(
        target=lambda: (until(lambda: server.held), client.close())
    )
    closing.start()
    with pytest.raises(PeerLostError):
        until(partial(_until_served, client, 30.0))
    closing.join()
    with pytest.raises(MediumError):
        client.call(b"", 1)
    # The reply of a server whose client is gone has no effect.
    server.held[0](b"late")


def _until_served(client: OctetsClient, timeout: float) -> bytes | None:
    try:
        return client.call(b"held", timeout)
    except NotServedError:
        return None


def _is_missing(client: OctetsClient) -> bool:
    try:
        client.call(b"", 5)
    except NotServedError:
        return True
    except MediumError:
        return False
    return False
