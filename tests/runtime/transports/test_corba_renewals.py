"""Connections of CORBA between two processes of rtgen that are made again by both at once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import media
import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from both_sides import FarProcess, Pair, near_side
from omniORB import CORBA
from patience import PATIENCE, until

from rtgen import runtime
from rtgen.runtime.corba.rt_objects import ports
from rtgen.runtime.corba.rt_objects.peers import PeerConnection
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import (
    PORT_SERVICE,
    ConnectorProfile,
    values,
)

pytestmark = [pytest.mark.slow, pytest.mark.waits]


class Both:
    """Both sides, with the near ends of their connections and the calls to the far ports."""

    written = 0
    """The number of the last sample of all tests."""

    def __init__(self, pair: Pair, patch: pytest.MonkeyPatch) -> None:
        self.pair = pair
        self.objects: Any = pair.near.transport.rt_objects
        self._patch = patch
        self._call = self.objects.exported.call

    def peer(self, port: str, *, receives: bool) -> PeerConnection:
        """Return the near end of the connection of a port."""
        ends = self.pair.near.transport._peers
        wanted = runtime.InPort if receives else runtime.OutPort
        [found] = [
            each
            for each in ends
            if each.here.name == port and isinstance(each.here, wanted)
        ]
        assert isinstance(found, PeerConnection)
        return found

    def port(self, peer: PeerConnection) -> PortService:
        """Return the port service of a near end."""
        found = self.objects.port(peer.here)
        assert isinstance(found, PortService)
        return found

    def other(self, peer: PeerConnection) -> Any:
        """Return the far port of a connection."""
        profile = self.port(peer).get_connector_profile(peer.name)
        [other] = [p for p in profile.ports if self.objects.exported.local(p) is None]
        return other

    def call(self, reference: Any, *what: Any) -> Any:
        """Call an object of the far process, also while calls are intercepted."""
        return self._call(reference, PORT_SERVICE, *what)

    def intercept(self, before: Callable[[str], None]) -> None:
        """Let a function see the name of each call to a far object before it is made."""

        def call(
            reference: Any, interface: Any, operation: str, *arguments: Any
        ) -> Any:
            before(operation)
            return self._call(reference, interface, operation, *arguments)

        self._patch.setattr(self.objects.exported, "call", call)

    def come(self, port: str) -> None:
        """Wait until samples from the far side come."""
        arrived = False

        def comes() -> bool:
            nonlocal arrived
            Both.written += 1
            self.pair.ask(f"write {port}", self.written)
            arrived |= any(s.tm.sec == self.written for s in self.pair.end.take(port))
            return arrived

        until(comes)

    def go(self, port: str) -> None:
        """Wait until samples reach the far side."""

        def reaches() -> bool:
            Both.written += 1
            self.pair.write(port, self.written)
            return any(n == self.written for n, _ in self.pair.taken(port))

        until(reaches)


@pytest.fixture(scope="module")
def sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    """Return the near side, connected and ACTIVE; each test leaves it so."""
    log = tmp_path_factory.mktemp("sides") / "far.txt"
    with media.transports("corba", media.LEASE) as network, near_side(network) as pair:
        assert network.address is not None
        far = FarProcess(network.address, log)
        try:
            pair.near.transport.await_others(PATIENCE)
            far.ready()
            pair.near.activate()
            yield pair
        finally:
            far.kill()


@pytest.fixture
def both(sides: Pair, monkeypatch: pytest.MonkeyPatch) -> Both:
    return Both(sides, monkeypatch)


def test_both_ends_make_it_again_and_one_attempt_fails(
    both: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The near end is about to act on its loss when the far one has made the connection."""
    both.come("many")
    peer = both.peer("many", receives=True)
    port = both.port(peer)
    waits, acted = threading.Event(), threading.Event()
    failed: list[str] = []
    attempt = peer.attempt

    def attempted(directory: Any) -> bool:
        try:
            return attempt(directory)
        finally:
            if waits.is_set():
                acted.set()

    def before(operation: str) -> None:
        if operation not in ("notify_disconnect", "connect", "notify_connect"):
            return
        if threading.current_thread() is both.pair.near.transport._keeper._thread:
            if not waits.is_set():
                waits.set()
                until(lambda: port.is_linked(peer.name))
            elif not failed:
                failed.append(operation)
                raise CORBA.TIMEOUT(0, CORBA.COMPLETED_MAYBE)

    both.intercept(before)
    monkeypatch.setattr(peer, "attempt", attempted)
    port.lose(peer.name, "the test ends it")
    assert waits.wait(PATIENCE)
    # A sample that is not taken is how the far end notices.
    both.come("many")
    assert acted.wait(PATIENCE)
    both.come("many")


@pytest.mark.parametrize("receives", [True, False])
@pytest.mark.parametrize("name", ["many", "pulled"])
def test_calls_that_timed_out_are_carried_out_late(
    both: Both, name: str, receives: bool
) -> None:
    """They are in the queue of a process that stood still, which has got a new connection."""
    flow = both.come if receives else both.go
    flow(name)
    peer = both.peer(name, receives=receives)
    port, other = both.port(peer), both.other(both.peer(name, receives=receives))
    late: list[str] = []

    def before(operation: str) -> None:
        if operation == "notify_disconnect":
            late.append(operation)
            raise CORBA.TIMEOUT(0, CORBA.COMPLETED_MAYBE)

    both.intercept(before)
    port.lose(peer.name, "the test ends it")
    until(lambda: not port.is_linked(peer.name))
    until(lambda: port.is_linked(peer.name))
    for operation in late:
        both.call(other, operation, peer.name)
    flow(name)


def test_a_loss_that_is_carried_out_late(
    both: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The thread that ends the lost connection begins when there is a new one."""
    both.go("many")
    peer = both.peer("many", receives=False)
    port, other = both.port(peer), both.other(peer)
    lost = port.live(peer.name)
    late: list[Callable[[], None]] = []

    class Late(threading.Thread):
        def start(self) -> None:
            late.append(self.run)

    with monkeypatch.context() as patch:
        patch.setattr(ports.threading, "Thread", Late)
        port.lose(peer.name, "the test ends it")
    both.call(other, "notify_disconnect", peer.name)
    until(lambda: port.live(peer.name) not in (None, lost))
    for each in late:
        each()
    assert len(late) == 1
    assert port.is_linked(peer.name)
    both.go("many")


def test_what_is_cut_on_purpose_stays_cut(both: Both) -> None:
    peer = both.peer("newest", receives=True)
    port = both.port(peer)
    both.call(both.other(peer), "disconnect", peer.name)
    until(lambda: not port.is_linked(peer.name) and not peer._in_doubt)
    assert peer.renew(both.pair.near.transport._directory)
    assert not port.is_linked(peer.name)


@pytest.mark.parametrize("receives", [True, False])
def test_a_second_request_leaves_a_connection_as_it_is(
    both: Both, receives: bool
) -> None:
    flow = both.come if receives else both.go
    flow("many")
    peer = both.peer("many", receives=receives)
    port, other = both.port(peer), both.other(peer)
    ends = [other, port.reference] if receives else [port.reference, other]
    asked = ConnectorProfile(peer.name, peer.name, ends, values(peer.requested()))
    code, _ = both.call(other, "connect", asked)
    assert code is runtime.PRECONDITION_NOT_MET
    assert port.is_linked(peer.name)
    flow("many")
