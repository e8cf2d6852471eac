"""Killed or frozen processes: the others detect it, continue, and find the next one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import media
import pytest
from collecting import TOPIC, Changes, Samples, Sender
from patience import until

from rtgen.runtime.distribution.medium import (
    Medium,
    NotServedError,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
)
from rtgen.runtime.distribution.rpc_header import OctetsClient

Join = Callable[..., Medium]
HERE = Path(__file__).parent
pytestmark = [pytest.mark.slow, pytest.mark.waits]


class Peer:
    """A process of `peer.py`."""

    def __init__(self, address: str, *tasks: str) -> None:
        paths = [str(HERE), str(HERE.parent), *filter(None, sys.path)]
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "peer.py"), address, *tasks],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        )
        self.expect("ready")

    def expect(self, line: str) -> None:
        """Wait for a line."""
        assert self.process.stdout is not None
        assert any(found == f"{line}\n" for found in self.process.stdout), line

    def freeze(self) -> None:
        """Stop the process as a debugger does; `thaw` continues it."""
        self.process.send_signal(signal.SIGSTOP)
        os.waitpid(self.process.pid, os.WUNTRACED)

    def thaw(self) -> None:
        self.process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            assert stream is not None
            stream.close()


@pytest.fixture
def start(engine: media.Engine) -> Iterator[Callable[..., Peer]]:
    address = engine.address
    if address is None:
        pytest.skip("one process alone")
    with ExitStack() as stack:

        def started(*tasks: str) -> Peer:
            peer = Peer(address, *tasks)
            stack.callback(peer.kill)
            return peer

        yield started


@pytest.mark.sampled(1)
def test_a_publisher_is_killed_and_comes_again(
    join: Join, start: Callable[..., Peer]
) -> None:
    medium = join()
    got, seen = Samples(), Changes()
    medium.subscribe(TOPIC, Qos(), got.on_sample)
    medium.watch("peer", seen.on_change)
    for round_ in (1, 2):
        peer = start("publish", "announce")
        until(lambda round_=round_: len({s.source for s in got}) == round_)
        until(lambda: seen and seen[-1] == ("peer/1", True))
        before = len(got)
        until(lambda before=before: len(got) > before + 20)
        peer.kill()
        until(lambda: seen[-1] == ("peer/1", False))
    octets = [(sample.source, sample.octets) for sample in got]
    assert len(set(octets)) == len(octets)
    assert seen == [("peer/1", True), ("peer/1", False)] * 2


@pytest.mark.sampled(2)
def test_a_reader_that_is_killed_holds_nobody_up(
    join: Join, start: Callable[..., Peer]
) -> None:
    medium = join()
    publisher = medium.publisher(TOPIC, Qos(depth=None, patience=30))
    peer = start("subscribe")
    until(lambda: publisher.matched)
    sender = Sender(publisher)
    for number in range(100):
        sender.send(number)
    peer.expect("sample")
    peer.kill()
    got = Samples()
    join().subscribe(TOPIC, Qos(depth=None), got.on_sample)
    sender.reach(1000, got)
    for number in range(5000, 5500):
        sender.send(number)
    until(lambda: len(got) >= 500)


@pytest.mark.sampled(2)
def test_a_publisher_is_frozen_and_goes_on(
    join: Join, start: Callable[..., Peer]
) -> None:
    medium = join()
    got, seen = Samples(), Changes()
    medium.subscribe(TOPIC, Qos(), got.on_sample)
    medium.watch("peer", seen.on_change)
    peer = start("publish", "announce")
    until(lambda: len(got) > 20 and seen == [("peer/1", True)])
    peer.freeze()
    until(lambda: seen[-1] == ("peer/1", False))
    before = len(got)
    peer.thaw()
    until(lambda: seen[-1] == ("peer/1", True))
    until(lambda: len(got) > before + 20)
    octets = [(sample.source, sample.octets) for sample in got]
    assert len(set(octets)) == len(octets)


@pytest.mark.sampled(2)
def test_a_server_is_frozen_during_a_call_and_goes_on(
    join: Join, start: Callable[..., Peer]
) -> None:
    client = OctetsClient(join(), "s/op")
    peer = start("serve")
    assert until(partial(_attempt, client)) == b"request"
    peer.freeze()
    with pytest.raises((PeerLostError, ReplyTimeoutError)):
        client.call(b"frozen", 1.0)
    peer.thaw()
    # The late reply answers no later call.
    assert until(partial(_again, client)) == b"request"


@pytest.mark.sampled(1)
def test_a_server_is_killed_before_during_and_after_a_call(
    join: Join, start: Callable[..., Peer]
) -> None:
    client = OctetsClient(join(), "s/op")
    during = start("hold")
    with ExitStack() as stack:
        killing = _thread(lambda: (during.expect("request"), during.kill()))
        stack.callback(killing.join)
        with pytest.raises((PeerLostError, ReplyTimeoutError)):
            until(partial(_attempt, client))
    until(lambda: _is_missing(client))
    after = start("serve")
    assert until(partial(_attempt, client)) == b"request"
    after.kill()
    until(lambda: _is_missing(client))
    start("serve")
    assert until(partial(_attempt, client)) == b"request"


def _thread(work: Callable[[], object]) -> threading.Thread:
    made = threading.Thread(target=work)
    made.start()
    return made


def _attempt(client: OctetsClient) -> bytes | None:
    try:
        return client.call(b"request", 10)
    except NotServedError:
        return None


def _again(client: OctetsClient) -> bytes | None:
    try:
        return _attempt(client)
    except (PeerLostError, ReplyTimeoutError):
        return None


def _is_missing(client: OctetsClient) -> bool:
    try:
        client.call(b"", 0.2)
    except NotServedError:
        return True
    except (PeerLostError, ReplyTimeoutError):
        return False
    return False
