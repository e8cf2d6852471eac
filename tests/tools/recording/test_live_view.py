"""A live view and a client of Foxglove's protocol, over a real WebSocket."""

from __future__ import annotations

import json
import random
import socket
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Self

import pytest
from patience import until
from recorded_runs import MS, Counter
from websockets.exceptions import ConnectionClosed, InvalidMessage
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from refrobots._idl.canopen import ObjectDictionary, SdoAbort
from refrobots.rtc import TimedLong
from rtgen.cli import run
from rtgen.runtime import (
    RTC_OK,
    Clock,
    Component,
    ComponentProfile,
    ParameterProfile,
    RealClock,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.recording import live_relay, live_view
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.live_services import RefusedError, services_of
from rtgen.tools.recording.live_view import LiveView
from rtgen.tools.recording.mcap_reader import McapFile
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.running import pace

ROOT = Path(__file__).parents[3]
PATIENCE = 30.0
MESSAGE, TIME, REPLY = 1, 2, 3
CALL = 2


@dataclass
class Settings:
    gain: float = 1.0
    steps: int = 3
    limits: list[float] = field(default_factory=lambda: [1.0, 2.0])


class Dictionary(ObjectDictionary):
    """Objects of one node."""

    def __init__(self) -> None:
        self.objects: dict[tuple[int, int], Any] = {}

    def read(self, index: int, subindex: int) -> Any:
        if (index, subindex) not in self.objects:
            raise SdoAbort(code=0x06020000)
        return self.objects[index, subindex]

    def write(self, index: int, subindex: int, value: Any) -> None:
        self.objects[index, subindex] = value

    def get(self, index: int, subindex: int) -> Any:
        raise NotImplementedError

    def set(self, index: int, subindex: int, value: Any) -> None:
        raise NotImplementedError


class Node(Component):
    """A component with parameters, which provides an object dictionary."""

    profile: ClassVar[ComponentProfile] = ComponentProfile(
        "Node",
        configuration=(
            ParameterProfile("gain", "gain", "double", "1.0", 0.0, 10.0, unit="1/s"),
            ParameterProfile("steps", "steps", "short", "3"),
            ParameterProfile("limits", "limits", "sequence<double>", "1.0,2.0"),
        ),
    )

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.config = self.add_configuration(Settings())
        self.add_provider("objects", "od", ObjectDictionary).set_servant(Dictionary())

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return RTC_OK


class Client:
    """A client of Foxglove's protocol."""

    def __init__(self, address: str) -> None:
        self.open = ExitStack()
        self.connection: ClientConnection = self.open.enter_context(
            connect(
                address,
                subprotocols=[Subprotocol("foxglove.sdk.v1")],
                close_timeout=0.1,
            )
        )
        self.info = self.text("serverInfo")
        self.channels: dict[str, Any] = {}
        self.services: dict[str, Any] = {}
        while not (self.channels and self.services):
            found = self.received()
            if found.get("op") == "advertise":
                self.channels |= {c["topic"]: c for c in found["channels"]}
            if found.get("op") == "advertiseServices":
                self.services |= {s["name"]: s for s in found["services"]}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.open.close()

    def send(self, **message: Any) -> None:
        self.connection.send(json.dumps(message))

    def received(self) -> dict[str, Any]:
        octets = self.connection.recv(PATIENCE)
        if isinstance(octets, str):
            found: dict[str, Any] = json.loads(octets)
            return found
        match octets[0]:
            case 1:
                subscription, stamp = struct.unpack_from("<IQ", octets, 1)
                of = {"subscription": subscription, "time": stamp, "data": octets[13:]}
                return {"op": "message", **of}
            case 2:
                return {"op": "time", "time": struct.unpack_from("<Q", octets, 1)[0]}
            case 3:
                service, call, length = struct.unpack_from("<III", octets, 1)
                value = json.loads(octets[13 + length :])
                return {"op": "reply", "service": service, "call": call, "value": value}
        raise AssertionError(octets)

    def text(self, op: str, where: Callable[[Any], bool] = lambda _: True) -> Any:
        """Return the next message of a kind."""
        return self.next_of(lambda m: m["op"] == op and where(m))

    def next_of(self, wanted: Callable[[Any], bool]) -> Any:
        limit = time.monotonic() + PATIENCE
        while not wanted(found := self.received()):
            assert time.monotonic() < limit
        return found

    def subscribe(self, topic: str, number: int = 7) -> None:
        channel = {"id": number, "channelId": self.channels[topic]["id"]}
        self.send(op="subscribe", subscriptions=[channel])

    def parameters(self, *names: str) -> dict[str, Any]:
        self.send(op="getParameters", parameterNames=names, id="get")
        found = self.text("parameterValues", lambda m: m.get("id") == "get")
        return {p["name"]: p.get("value") for p in found["parameters"]}

    def set(self, name: str, value: Any) -> dict[str, Any]:
        parameter = {"name": name, "value": value}
        self.send(op="setParameters", parameters=[parameter], id="set")
        found = self.text("parameterValues", lambda m: m.get("id") == "set")
        return {p["name"]: p.get("value") for p in found["parameters"]}

    def call(self, name: str, request: Any) -> Any:
        """Return the reply of a service, or the text of its failure."""
        body = request if isinstance(request, bytes) else json.dumps(request).encode()
        head = struct.pack("<BIII", CALL, self.services[name]["id"], 5, 4)
        self.connection.send(head + b"json" + body)
        found = self.next_of(lambda m: m["op"] in ("reply", "serviceCallFailure"))
        return found["value" if found["op"] == "reply" else "message"]


@contextmanager
def running(clock: Clock) -> Iterator[tuple[System, LiveView]]:
    """Yield a running counter and node, and their live view at a free port."""
    over = threading.Event()
    with System(clock) as system:
        system.add(Counter("Counter0"), 100.0)
        system.add(Node("Node0"), 100.0)
        view = LiveView(system, "test", port=0)
        system.activate("Counter0")
        system.activate("Node0")
        if isinstance(clock, SimulatedClock):
            system.every(10 * MS, lambda: time.sleep(0.002))
        thread = threading.Thread(
            target=system.run, args=(None, lambda _: over.is_set())
        )
        thread.start()
        try:
            yield system, view
        finally:
            over.set()
            thread.join()
            view.close()


@pytest.fixture(params=[SimulatedClock, RealClock])
def seen(request: pytest.FixtureRequest) -> Iterator[tuple[System, LiveView]]:
    with running(request.param()) as found:
        yield found


def test_samples_and_time(seen: tuple[System, LiveView]) -> None:
    system, view = seen
    assert view.address.startswith("ws://127.0.0.1:")
    with Client(view.address) as client:
        assert {"parameters", "services", "time"} <= {*client.info["capabilities"]}
        channel = client.channels["/Counter0/count"]
        schema = channel["schemaName"], channel["schemaEncoding"], channel["encoding"]
        assert schema == ("RTC::TimedLong", "omgidl", "cdr")
        assert "struct TimedLong" in channel["schema"]
        assert channel["metadata"]["instance"] == "Counter0"
        client.subscribe("/Counter0/count")
        messages = [client.text("message") for _ in range(5)]
        values = [deserialize(TimedLong, m["data"]).data for m in messages]
        assert values == [*range(values[0], values[0] + 5)]
        if isinstance(system.clock, SimulatedClock):
            # The first sample is written at 0.
            assert [m["time"] for m in messages] == [(v - 1) * 10 * MS for v in values]
        before = client.text("time")["time"]
        assert client.text("time")["time"] > before


def test_subscriptions_are_no_failures_of_the_server(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with running(SimulatedClock()) as (_, view), Client(view.address) as client:
        client.subscribe("/Counter0/count")
        client.text("message")
        client.send(op="unsubscribe", subscriptionIds=[7])
        client.send(op="subscribeParameterUpdates", parameterNames=["Node0.gain"])
        client.send(op="unsubscribeParameterUpdates", parameterNames=["Node0.gain"])
        client.parameters("Node0.gain")
    assert "failed" not in caplog.text + capfd.readouterr().err


def test_values_are_set_at_once_in_the_set_that_is_active_then(
    seen: tuple[System, LiveView],
) -> None:
    """The run need not have executed anything for the next request to see them."""
    from foxglove import Parameter

    system, view = seen
    system.configure("Node0", "gain", "7", "fast")
    given = (("gain", 2.0), ("gain", 11.0), ("configuration.active_config", "fast"))
    pairs = [Parameter(f"Node0.{name}", value=value) for name, value in given]
    pairs.append(Parameter("Node0.gain", value=8.0))
    values = [found.get_value() for found in view.set_parameters(pairs)]
    assert values == [2.0, 2.0, "fast", 8.0]
    sets = system.component("Node0").configuration_sets
    assert (sets.texts("default")["gain"], sets.texts("fast")["gain"]) == ("2.0", "8.0")


def test_parameters_are_set_within_their_ranges(seen: tuple[System, LiveView]) -> None:
    system, view = seen
    node: Any = system.component("Node0")
    with Client(view.address) as client:
        names = ("Node0.gain", "Node0.limits", "Node0.configuration.active_config")
        assert client.parameters(*names) == {
            "Node0.gain": 1.0,
            "Node0.limits": [1.0, 2.0],
            "Node0.configuration.active_config": "default",
        }
        assert client.parameters().keys() > {*names, "Node0.steps"}
        assert client.set("Node0.gain", 2.5) == {"Node0.gain": 2.5}
        assert client.set("Node0.limits", [3, 4.5]) == {"Node0.limits": [3.0, 4.5]}
        # A request is executed after those before it.
        client.call("/Node0/reset", {})
        until(lambda: (node.config.gain, node.config.limits) == (2.5, [3.0, 4.5]))
        for value in (11, -1, "much", [1, 2], {"a": 1}, True):
            assert client.set("Node0.gain", value) == {"Node0.gain": 2.5}
        client.set("Node0.steps", 1 << 15)
        client.set("Node0.nothing", 1)
        client.set("Nobody.gain", 1)
        client.set("Node0.configuration.active_config", "none")
        assert client.parameters("Node0.steps") == {"Node0.steps": 3}
        assert node.config.gain == 2.5


def test_a_refused_value_is_a_status(seen: tuple[System, LiveView]) -> None:
    with Client(seen[1].address) as client:
        parameter = {"name": "Node0.gain", "value": 11}
        client.send(op="setParameters", parameters=[parameter], id="x")
        status = client.text("status")
        assert "Node0.gain" in status["message"]
        assert "at most 10" in status["message"]


def test_a_set_is_made_the_active_one(seen: tuple[System, LiveView]) -> None:
    system, view = seen
    node: Any = system.component("Node0")
    system.configure("Node0", "gain", "7", "fast")
    with Client(view.address) as client:
        name = "Node0.configuration.active_config"
        assert client.set(name, "fast") == {name: "fast"}
        until(lambda: node.config.gain == 7.0)
        assert client.parameters("Node0.gain") == {"Node0.gain": 7.0}


def test_life_cycle_and_operations(seen: tuple[System, LiveView]) -> None:
    system, view = seen
    with Client(view.address) as client:
        services = {name for name in client.services if name.startswith("/Node0/")}
        assert services == {
            *(f"/Node0/{request}" for request in ("activate", "deactivate", "reset")),
            *(f"/Node0/objects/od/{name}" for name in ("read", "write", "get", "set")),
        }
        until(lambda: system.state("Node0").name == "ACTIVE_STATE")
        write, read = "/Node0/objects/od/write", "/Node0/objects/od/read"
        given = {"index": 0x2000, "subindex": 1, "value": [1, 2, 255]}
        assert client.call(write, given) == {}
        assert [*client.call(read, {"index": 0x2000, "subindex": 1}).values()] == [
            [1, 2, 255]
        ]
        for request, what in (
            ({"index": 1, "subindex": 1}, "SdoAbort"),
            ({"index": 1}, "subindex is missing"),
            ({"index": 1 << 16, "subindex": 1}, "index"),
            ({"index": "1", "subindex": 1}, "index: '1' is not an integer"),
            ({"index": 1, "subindex": 1, "more": 1}, "no parameter 'more'"),
            ([], "not a JSON object"),
            (b"{", "not JSON"),
            (b"[" * 100_000, "not JSON"),
        ):
            assert what in client.call(read, request)
        assert client.call("/Node0/deactivate", {}) == {"result": "RTC_OK"}
        until(lambda: system.state("Node0").name == "INACTIVE_STATE")
        assert "not active" in client.call(read, {"index": 0x2000, "subindex": 1})
        again = client.call("/Node0/deactivate", {})
        assert again == {"result": "PRECONDITION_NOT_MET"}
        assert "no members" in client.call("/Node0/activate", {"now": True})
        assert client.call("/Node0/activate", {}) == {"result": "RTC_OK"}


def test_a_client_that_reads_nothing_or_goes_holds_nothing_up() -> None:
    with running(SimulatedClock()) as (system, view):
        address = "127.0.0.1", int(view.address.rpartition(":")[2])
        counter: Any = system.component("Counter0")
        with socket.create_connection(address), Client(view.address) as gone:
            # The first never finishes its handshake, the second leaves without a message.
            gone.subscribe("/Counter0/count")
            gone.connection.socket.shutdown(socket.SHUT_RDWR)
            with Client(view.address) as idle:
                idle.subscribe("/Counter0/count")
                before = counter.number
                until(lambda: counter.number > before + 300)
                with Client(view.address) as client:
                    client.subscribe("/Counter0/count")
                    assert client.text("message")["op"] == "message"


def test_a_run_is_recorded_and_seen_at_once(tmp_path: Path) -> None:
    def recorded(name: str, *, live: bool) -> list[tuple[str, int, bytes]]:
        path = tmp_path / name
        with McapWriter(path) as writer, System(SimulatedClock()) as system:
            system.add(Counter("Counter0"), 100.0)
            system.activate("Counter0")
            recorder = Recorder(system, writer)
            view = LiveView(system, "test", port=0) if live else None
            system.run(100 * MS)
            recorder.end(through=False)
            if view is not None:
                view.close()
        messages = McapFile(path).messages()
        return [(m.channel.topic, m.time, m.data) for m in messages]

    found = recorded("a.mcap", live=True)
    assert len(found) > 10
    assert found == recorded("b.mcap", live=False)


def test_a_call_is_refused_when_nothing_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_view, "_CALL_TIMEOUT", 0.05)
    monkeypatch.setattr(live_view, "_MAX_WAITING", 5)
    with System(SimulatedClock()) as system:
        system.add(Node("Node0"), 100.0)
        view = LiveView(system, "test", port=0)
        with Client(view.address) as client:
            for _ in range(5):
                assert "did not answer" in client.call("/Node0/activate", {})
            assert "too many" in client.call("/Node0/activate", {})
        view.close()
        view.close()


def test_a_client_that_floods_has_only_its_own_calls_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(live_view, "_CALL_TIMEOUT", 0.05)
    monkeypatch.setattr(live_view, "_MAX_WAITING", 3)
    with System(SimulatedClock()) as system:
        system.add(Node("Node0"), 100.0)
        view = LiveView(system, "test", port=0)
        with Client(view.address) as flooding, Client(view.address) as other:
            for _ in range(3):
                assert "did not answer" in flooding.call("/Node0/activate", {})
            assert "too many" in flooding.call("/Node0/activate", {})
            assert "did not answer" in other.call("/Node0/activate", {})
        view.close()


def test_a_client_that_sends_without_end_has_to_wait(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(live_relay, "_RATE", 0.01)
    names = ["name" * 10_000]
    question = json.dumps({"op": "getParameters", "parameterNames": names, "id": "f"})
    with running(RealClock()) as (_, view), ExitStack() as clients:
        other = clients.enter_context(Client(view.address))
        flooding = clients.enter_context(Client(view.address))
        sent = 0

        def flood() -> None:
            nonlocal sent
            with suppress(ConnectionClosed):
                while True:
                    flooding.connection.send(question)
                    sent += 1

        thread = threading.Thread(target=flood)
        thread.start()
        for _ in range(10):
            assert other.call("/Node0/deactivate", {}) == {"result": "RTC_OK"}
            assert other.call("/Node0/activate", {}) == {"result": "RTC_OK"}
        looks = deque[int](maxlen=20)

        def waits() -> bool:
            looks.append(sent)
            return looks.count(sent) == looks.maxlen

        until(waits)
        assert thread.is_alive()
        flooding.connection.socket.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_more_clients_than_the_view_has_room_for_are_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(live_relay, "MAX_CLIENTS", 2)
    with running(RealClock()) as (_, view), Client(view.address):
        gone = (ConnectionError, ConnectionClosed, InvalidMessage, EOFError)
        with Client(view.address), pytest.raises(gone):
            Client(view.address)
        # There is room again when the connection has ended on both sides.
        again: list[Client] = []

        def connects() -> bool:
            with suppress(*gone):
                again.append(Client(view.address))
            return bool(again)

        until(connects)
        again[0].open.close()


@pytest.mark.parametrize("seed", range(20))
def test_frames_are_counted_however_they_are_divided(seed: int) -> None:
    drawn = random.Random(seed)
    octets = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"
    count = drawn.randrange(40)
    for _ in range(count):
        length = drawn.choice((0, 1, 125, 126, 300, 70_000))
        extended = {True: b"", False: struct.pack(">H", length % 65_536)}[length < 126]
        if length > 65_535:
            extended = struct.pack(">Q", length)
        code = {0: length, 2: 126, 8: 127}[len(extended)]
        octets += bytes((0x82, 0x80 | code)) + extended + drawn.randbytes(4 + length)
    frames, counted, position = live_relay.Frames(), 0, 0
    while position < len(octets):
        size = drawn.choice((1, 2, 3, 50, 2048))
        counted += frames.count(octets[position : position + size])
        position += size
    assert counted == 1 + count  # and the handshake


def test_a_port_that_is_taken_is_an_error() -> None:
    with System(SimulatedClock()) as system, System(SimulatedClock()) as other:
        view = LiveView(system, "test", port=0)
        port = int(view.address.rpartition(":")[2])
        with pytest.raises(RecordingError, match=f"cannot listen at 127.0.0.1:{port}"):
            LiveView(other, "test", port=port)
        view.close()


def test_an_address_of_another_machine_is_named() -> None:
    with System(SimulatedClock()) as system, pytest.raises(RecordingError) as caught:
        LiveView(system, "test", host="203.0.113.1", port=0)
    assert caught.value.hint is not None
    assert caught.value.hint.startswith("203.0.113.1 is not this machine's")


def test_without_the_sdk_the_message_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(live_view, "find_spec", lambda name: None)
    with System() as system, pytest.raises(RecordingError) as caught:
        LiveView(system, "test")
    assert (
        caught.value.hint == "pip install ./runtime '.[foxglove]' in a clone of rtgen"
    )


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("--foxglove", "x.xml"), "'x.xml' is not PORT or HOST:PORT"),
        (("--foxglove", "99999"), "99999 is not a port: they are 0 to 65535"),
        (("--foxglove", "65536"), "65536 is not a port"),
        (("--rate", "0"), "--rate"),
        (("--rate", "1", "--clock", "real"), "--rate goes with --clock sim"),
    ],
)
def test_options_that_cannot_be(
    arguments: tuple[str, ...], what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    system = ROOT / "specs" / "navigation" / "rh3_goal.xml"
    code = run(["run", str(system), "--until", "0.01", *arguments])
    assert code == 2
    assert what in capsys.readouterr().err


def test_a_run_at_a_pace_with_a_view(capsys: pytest.CaptureFixture[str]) -> None:
    system = ROOT / "specs" / "navigation" / "rh3_goal.xml"
    arguments = ("--until", "0.1", "--rate", "10", "--foxglove", "0")
    assert run(["run", str(system), *arguments]) == 0
    error = capsys.readouterr().err
    assert "Foxglove: ws://127.0.0.1:" in error
    assert "Traceback" not in error


def test_a_pace_waits_for_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    now, waits = 100.0, []

    def sleep(seconds: float) -> None:
        nonlocal now
        if seconds:
            waits.append(seconds)
        now += seconds

    monkeypatch.setattr(pace.time, "monotonic", lambda: now)
    clock = pace.Pace(0.5, sleep)
    clock.wait(0)
    clock.wait(2000 * MS)
    clock.wait(1000 * MS)
    clock.wait(2502_000 * MS)
    assert waits == [4.0, 3600.0, 1400.0]


def test_requests_that_wait_are_refused_at_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At once, not after the time-out of a call."""
    monkeypatch.setattr(live_view, "_CALL_TIMEOUT", 10_000.0)
    with System(SimulatedClock()) as system:
        system.add(Node("Node0"), 100.0)
        view = LiveView(system, "test", port=0)
        service = next(services_of(system))
        found: list[str] = []

        def call() -> None:
            try:
                view._called(service, b"{}")
            except RefusedError as error:
                found.append(str(error))

        thread = threading.Thread(target=call)
        thread.start()
        until(lambda: not view._waiting.empty())
        view.close()
        thread.join()
        assert found == ["the run is over"]


def test_requests_that_go_on_coming_do_not_hold_the_run_up() -> None:
    """Each instant executes a bounded number of them."""
    with System(SimulatedClock()) as system:
        system.add(Node("Node0"), 100.0)
        view = LiveView(system, "test", port=0)
        done: list[int] = []

        def again() -> None:
            done.append(len(done))
            assert len(done) <= 100
            view._submit(again)

        view._submit(again)
        view._carry_out()
        assert len(done) == 100
        view.close()


def test_a_list_whose_items_have_commas_is_refused(
    seen: tuple[System, LiveView],
) -> None:
    _, view = seen
    from foxglove import Parameter

    before = view.parameters(["Node0.limits"])[0].get_value()
    [found] = view.set_parameters([Parameter("Node0.limits", value=["1,2", "3"])])
    assert found.get_value() == before
