"""Service ports as actions, with a client and a server of eclipse-zenoh alone.

The other side uses what rmw_zenoh puts on the network: it finds the key expressions by the tokens
of the graph, and packs and unpacks CDR by `struct`.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from types import ModuleType
from typing import Any
from uuid import uuid4

import pytest
from action_ends import (
    CANCELED,
    EXECUTING,
    SUCCEEDED,
    component,
    generated,
    joined,
    servant,
)
from patience import until
from test_networks import DOMAIN, zenoh_pair

from rtgen.runtime.services.servants import CommunicationFailure, ObjectNotExist

zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

HEAD = b"\x00\x01\x00\x00"
UUID = bytes(range(16))
TYPES = {
    "send_goal": "lab::action::dds_::Go_SendGoal_",
    "cancel_goal": "action_msgs::srv::dds_::CancelGoal_",
    "get_result": "lab::action::dds_::Go_GetResult_",
    "feedback": "lab::action::dds_::Go_FeedbackMessage_",
    "status": "action_msgs::msg::dds_::GoalStatusArray_",
}
FEEDBACK = struct.Struct("<16sd")
STATUS = struct.Struct("<I16siIb")
CANCEL = struct.Struct("<16siI")
CANCELING = struct.Struct("<b3xI16siI")
RESULT = struct.Struct("<b?")


@pytest.fixture(scope="module")
def go(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    return generated(tmp_path_factory.mktemp("actions"))


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


class Peer:
    """A session of Zenoh that takes part in an action."""

    def __init__(self, session: Any, action: str, kinds: tuple[str, str]) -> None:
        self.session = session
        self._kinds = kinds
        self._action = action
        self._numbers = iter(range(1, 100))
        self.keys = {name: until(lambda n=name: self._key(n)) for name in TYPES}

    def _key(self, name: str) -> str | None:
        """Return the key expression of a part of the action, from its token in the graph."""
        mangled = f"{self._action}/_action/{name}".replace("/", "%")
        kind = self._kinds[name in ("feedback", "status")]
        wanted = f"@ros2_lv/{DOMAIN}/*/*/*/{kind}/*/*/*/{mangled}/*/*/*"
        for reply in self.session.liveliness().get(wanted):
            *_, type_, hash_, _ = str(reply.ok.key_expr).split("/")
            assert type_ == TYPES[name]
            assert hash_.startswith("RIHS01_")
            return f"{DOMAIN}{self._action}/_action/{name}/{type_}/{hash_}"
        return None

    def request(self, name: str, body: bytes) -> Callable[[], bytes]:
        """Send a request; the returned function waits for the body of its response."""
        attachment = struct.pack("<qqB16s", next(self._numbers), 5, 16, bytes(16))
        replies = self.session.get(
            self.keys[name],
            payload=HEAD + body,
            attachment=attachment,
            target=zenoh.QueryTarget.ALL_COMPLETE,
            timeout=60,
        )

        def response() -> bytes:
            [reply] = list(replies)
            octets: bytes = reply.ok.payload.to_bytes()
            assert octets[:4] == HEAD
            assert reply.ok.attachment.to_bytes()[:8] == attachment[:8]
            return octets[4:]

        return response


def test_a_client_of_zenoh(go: ModuleType, stack: ExitStack) -> None:
    """It sends a goal, reads feedback and status, waits for the result beside other requests."""
    mover = component(stack, go, "mover")
    mover.goals.set_servant(servant(go, mover.events))
    network, session, _ = zenoh_pair(stack)
    name = f"/go_{uuid4().hex}"
    joined(stack, network, mover, name)
    peer = Peer(session, name, ("SS", "MP"))
    feedback: list[bytes] = []
    reading = session.declare_subscriber(
        peer.keys["feedback"], lambda sample: feedback.append(sample.payload.to_bytes())
    )
    stack.callback(reading.undeclare)
    goal = struct.pack("<16sd", UUID, 3.0)
    assert peer.request("send_goal", goal)() == struct.pack("<?3xiI", True, 0, 0)
    until(lambda: len(feedback) == 2)
    assert [FEEDBACK.unpack(o[4:]) for o in feedback] == [(UUID, 6.0), (UUID, 3.0)]
    # A late subscription gets the last status, as by rcl_action's profile.
    status: list[bytes] = []
    late = zenoh.ext.declare_advanced_subscriber(
        session,
        peer.keys["status"],
        lambda sample: status.append(sample.payload.to_bytes()),
        history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1),
    )
    stack.callback(late.undeclare)
    until(lambda: status)
    assert STATUS.unpack(status[0][4:]) == (1, UUID, 0, 0, EXECUTING)
    result = peer.request("get_result", UUID)
    cancelled = peer.request("cancel_goal", CANCEL.pack(UUID, 0, 0))()
    assert CANCELING.unpack(cancelled) == (0, 1, UUID, 0, 0)
    assert RESULT.unpack(result()) == (CANCELED, False)
    assert RESULT.unpack(peer.request("get_result", UUID)()) == (CANCELED, False)
    until(lambda: STATUS.unpack(status[-1][4:])[-1] == CANCELED)


class Server:
    """An action server of eclipse-zenoh alone."""

    def __init__(self, peer: Peer, stack: ExitStack) -> None:
        self._peer = peer
        self.queries: dict[str, list[Any]] = {name: [] for name in TYPES}
        self._ends = [
            peer.session.declare_queryable(
                peer.keys[name], self.queries[name].append, complete=True
            )
            for name in ("send_goal", "cancel_goal", "get_result")
        ]
        self.feedback = peer.session.declare_publisher(peer.keys["feedback"])
        stack.callback(self.feedback.undeclare)

    def answer(self, name: str, body: bytes) -> bytes:
        """Receive a request and reply to it; return the body of the request."""
        until(lambda: self.queries[name])
        with self.queries[name].pop() as query:
            octets: bytes = query.payload.to_bytes()
            attachment = query.attachment.to_bytes()
            assert len(attachment) == struct.calcsize("<qqB16s")
            query.reply(self._peer.keys[name], HEAD + body, attachment=attachment)
        assert octets[:4] == HEAD
        return octets[4:]

    def close(self) -> None:
        for end in self._ends:
            end.undeclare()
        for queries in self.queries.values():
            while queries:
                queries.pop().drop()


def test_a_server_of_zenoh(go: ModuleType, stack: ExitStack) -> None:
    """A component sends a goal, gets feedback in order, and the result."""
    asker = component(stack, go, "asker")
    action = go.lab.action
    came: list[float] = []

    class Events(action.Go_Events):  # type: ignore[misc, name-defined]
        def feedback(self, message: Any) -> None:
            came.append(message.feedback.left)

        def status(self, message: Any) -> None:
            raise AssertionError

    asker.events.set_servant(Events())
    network, session, _ = zenoh_pair(stack)
    name = f"/go_{uuid4().hex}"
    joined(stack, network, asker, name)
    server = Server(Peer(session, name, ("SC", "MS")), stack)
    uuid = go.unique_identifier_msgs.msg.UUID(UUID)
    done: list[Any] = []

    def sent() -> Any:
        request = action.Go_SendGoal_Request(uuid, action.Go_Goal(2.0))
        try:
            return asker.goals.send_goal(request)
        except ObjectNotExist:
            return None  # The server is still unknown.

    def ask() -> None:
        done.append(until(sent).accepted)
        result = asker.goals.get_result(action.Go_GetResult_Request(uuid))
        done.append((result.status, result.result.done))
        try:
            asker.goals.get_result(action.Go_GetResult_Request(uuid))
        except CommunicationFailure as error:
            done.append(str(error))

    thread = threading.Thread(target=ask)
    thread.start()
    goal = server.answer("send_goal", struct.pack("<?3xiI", True, 0, 0))
    assert struct.unpack("<16sd", goal) == (UUID, 2.0)
    for number in range(20):
        server.feedback.put(HEAD + FEEDBACK.pack(UUID, float(number)))
        until(lambda: len(came) > number)  # noqa: B023
    assert server.answer("get_result", RESULT.pack(SUCCEEDED, True)) == UUID
    # The server disappears while a call waits, which nothing else would end.
    until(lambda: server.queries["get_result"])
    server.close()
    thread.join()
    assert done == [
        True,
        (SUCCEEDED, True),
        f"{name}/_action/get_result is served no more",
    ]
    assert came == [float(number) for number in range(20)]
