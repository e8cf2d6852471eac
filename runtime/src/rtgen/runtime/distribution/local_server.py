"""Serves a run to programs of the same user on this machine, which `local_listener` lets in.

They watch and control its components as other processes do over a medium (`control`), receive
samples of OutPorts, and give samples to InPorts. The run waits for none of them, and pays for
samples only while somebody is connected.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Hashable
from contextlib import suppress
from functools import partial
from typing import Any, Final

import msgspec

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.control import BURST, SHARE, Control
from rtgen.runtime.distribution.data import Feed, encoder
from rtgen.runtime.distribution.local_requests import Doing, InRun
from rtgen.runtime.distribution.local_runs import (
    MAX_CLIENTS,
    Answer,
    Ask,
    Changed,
    Do,
    Done,
    End,
    Event,
    Give,
    Hello,
    Listen,
    Noted,
    OnBoard,
    OnBus,
    Request,
    Status,
    Value,
    Wire,
    packed,
)
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.distribution.workers import Desk, Workers
from rtgen.runtime.errors import RtcError
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.system.joining import instances_of
from rtgen.runtime.system.latency import Latency
from rtgen.runtime.system.records import Record, StateRecord, Viewer
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import BoardCall, BusFrame
from rtgen.runtime.timing.traffic import Event as Happening

_MAX_VALUES: Final = 2000
"""Maximum number of samples that wait for a client; more are dropped, and so are further ones while
more than `MAX_LENGTH` octets wait."""
_MAX_WAITING: Final = 4096
"""Maximum number of all messages that wait for a client; it is left beyond, and so is one for which
more than twice `MAX_LENGTH` octets wait."""
_FLUSH: Final = 1 / 30
"""Time between two messages with samples [s]."""
_TELL: Final = 0.1
"""Time between two messages about the time of the run [s]."""
_TELL_WIRES: Final = 0.5
_TELL_CHAINS: Final = 1.0
_SPAN: Final = SECOND
"""The time of the run over which samples are counted [ns]."""
_FAREWELL: Final = 1.0
"""Time for the last messages at the end of a run [s]."""


class RunServer:
    """The connected programs of a run. `in_run` executes work in the thread of a simulated run."""

    def __init__(
        self,
        system: System,
        hello: Hello,
        in_run: InRun | None,
        doing: Doing | None = None,
    ) -> None:
        self.system = system
        self.doing = doing
        self.hello = hello
        self.desk = Desk(SHARE, BURST)
        self._workers = Workers()
        self._in_run = in_run
        self._feeds: dict[InPort[Any], Feed] = {}
        self._clients: tuple[_Client, ...] = ()
        self._lock = threading.Lock()
        self._tap = _Tap(self)
        self._closed = False

    def accept(self, stream: socket.socket) -> None:
        """Serve one more program, unless there are too many."""
        with self._lock:
            if self._closed or len(self._clients) >= MAX_CLIENTS:
                # Short, so that a program that does not read delays nobody.
                hello = msgspec.structs.replace(self.hello, full=True, plan=(), doc="")
                with stream, suppress(OSError):
                    stream.send(packed(hello))
                return
            client = _Client(self, stream)
            self._clients += (client,)
            if len(self._clients) == 1:
                self.system.add_listener(self._tap)
                self.system.clock.traffic.watch(self._tap.on_traffic)
            # `close` waits for the threads of each client.
            client.start()

    def leave(self, client: _Client) -> None:
        """Forget a client."""
        with self._lock:
            self._clients = tuple(each for each in self._clients if each is not client)
            if not self._clients and not self._closed:
                self._remove_tap()
        if self.doing is not None:
            self.doing.left(client.name)

    def _remove_tap(self) -> None:
        self.system.clock.traffic.unwatch(self._tap.on_traffic)
        self.system.remove_listener(self._tap)

    def tell(self, kind: str, instance: str, text: str) -> None:
        """Tell the clients that something has happened."""
        self.put_event(Noted(self.system.time, kind, instance, text))

    def put_event(self, event: Event) -> None:
        """Send an event to the clients that have room for it; changes of state to all."""
        for client in self._clients:
            if isinstance(event, Changed):
                client.put(event)
            elif client.has_room():
                client.put_value(event)

    def end(self, reason: str) -> None:
        """Tell the clients that the run is over, and why."""
        for client in self._clients:
            client.put(End(self.system.time, reason))

    def close(self) -> None:
        """Serve no more; messages that wait are sent, for a second at most."""
        with self._lock:
            self._closed = True
            self._remove_tap()
        deadline = time.monotonic() + _FAREWELL
        for client in self._clients:
            client.close(max(deadline - time.monotonic(), 0.0))
        for feed in self._feeds.values():
            feed.close()
        self.desk.close()
        self._workers.close()

    # What clients ask for.

    def control(self, component: Component) -> Control:
        """Return the control service of a component for a client."""
        if self._in_run is None:
            return Control(self.desk, self._workers, component, lambda: self.system)
        desk = _ByKind(self._in_run, self.desk)
        return Control(desk, self._in_run, component, lambda: self.system)

    def give(self, instance: str, port: str, octets: bytes) -> None:
        """Give a sample to an InPort. Raises RtcError, CdrError."""
        there = self.system.component(instance).in_ports.get(port)
        if there is None:
            raise RtcError(f"{instance} has no InPort {port!r}")
        value = received(there.type, octets)
        feed = self._feeds.get(there)
        if feed is None:
            feed = self._feeds[there] = Feed(there, "attached")
        feed.give(value)

    def in_turn(self, client: Hashable, work: Callable[[], None]) -> bool:
        """Execute work where samples may be given; return False if too much waits."""
        return (self._in_run or self.desk).submit(work, client)

    # What they are told.

    def wanted(self, instance: str, port: str) -> list[_Client]:
        """Return the clients that receive the samples of a port now."""
        key = instance, port
        return [e for e in self._clients if key in e.listened and e.has_room()]

    def wires(self) -> list[Wire]:
        """Describe the connections within the run."""
        rates = self._tap.rates()
        return [_wire(each, rates) for each in self.system.connectors]


def _wire(connector: Any, rates: dict[tuple[str, str], float] | None) -> Wire:
    source, target = instances_of(connector)
    ends = tuple(
        (instance, str(port).removeprefix(f"{instance}."))
        for instance, port in (
            (source, connector.source),
            (target, connector.target),
        )
    )
    rate, losses = -1.0, {}
    if isinstance(connector, DataConnector):
        rate = -1.0 if rates is None else rates.get(ends[0], 0.0)
        losses = connector.losses
    properties = dict(getattr(connector, "properties", {}))
    return Wire(connector.name, ends[0], ends[1], properties, rate, losses)


class _Tap(Viewer):
    """Counts the samples of all OutPorts, and passes on those that clients want."""

    def __init__(self, run: RunServer) -> None:
        self._run = run
        self._counts: Counter[tuple[str, str]] = Counter()
        self._before: Counter[tuple[str, str]] = Counter()
        self._since: int | None = None
        self._rates: dict[tuple[str, str], float] | None = None

    def __call__(self, record: Record) -> None:
        """Tell the clients of a change of state."""
        if isinstance(record, StateRecord):
            self._run.put_event(
                Changed(
                    record.time,
                    record.instance,
                    record.ec_id,
                    record.before.name,
                    record.after.name,
                    record.reason,
                )
            )

    def on_traffic(self, happening: Happening) -> None:
        """Tell the clients of a frame or a call."""
        match happening:
            case BusFrame():
                self._run.put_event(OnBus(self._run.system.time, happening))
            case BoardCall():
                self._run.put_event(OnBoard(self._run.system.time, happening))

    def rates(self) -> dict[tuple[str, str], float] | None:
        """Return the samples of OutPorts in a second of the run; None if not counted yet."""
        now = self._run.system.time
        if self._since is None:
            self._since, self._before = now, self._counts.copy()
        elif now - self._since >= _SPAN:
            counts = self._counts.copy()
            span = (now - self._since) / SECOND
            self._rates = {
                key: (count - self._before[key]) / span for key, count in counts.items()
            }
            self._since, self._before = now, counts
        return self._rates

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """See `SampleWriter`."""
        key = port.owner, port.name
        counts, wanted = self._counts, self._run.wanted
        encode = encoder(port.type)

        def write(value: Any) -> None:
            counts[key] += 1
            clients = wanted(*key)
            if not clients:
                return
            try:
                octets = encode(value)
            except CdrError:
                return  # The connections report it.
            message = Value(*key, elapsed(), octets)
            for client in clients:
                client.put_value(message)

        return write


class _ByKind(msgspec.Struct):
    """Executes requests for states in the run, and the others beside it."""

    _in_run: InRun
    _desk: Desk

    def submit(
        self, work: Callable[[], None], client: Hashable, *, first: bool = False
    ) -> bool:
        """See `control.Work`."""
        chosen = self._in_run if first else self._desk
        return chosen.submit(work, client, first=first)


class _Told:
    """What a client has been told of the run."""

    def __init__(self) -> None:
        self._instances: list[str] = []
        self._wires: list[Wire] | None = None
        self._chains: list[Latency] | None = None
        self._next, self._next_wires, self._next_chains = 0.0, 0.0, 0.0

    def status(self, run: RunServer, dropped: int) -> bytes:
        """Return the message about the run that is due; else nothing."""
        now, system = time.monotonic(), run.system
        if now < self._next:
            return b""
        self._next = now + _TELL
        if now < self._next_wires:
            return packed(Status(system.time, None, None, dropped))
        self._next_wires = now + _TELL_WIRES
        instances, wires, chains = [*system.instances], run.wires(), self._chains
        if now >= self._next_chains:
            self._next_chains = now + _TELL_CHAINS
            chains = [*system.latencies]
        status = Status(
            system.time,
            None if instances == self._instances else instances,
            None if wires == self._wires else wires,
            dropped,
            None if chains == self._chains else chains,
        )
        self._instances, self._wires, self._chains = instances, wires, chains
        return packed(status)


class _Client:
    """A connected program: a thread reads what it asks for, another one sends."""

    def __init__(self, run: RunServer, stream: socket.socket) -> None:
        self.listened: frozenset[tuple[str, str]] = frozenset()
        self._run = run
        self._stream = stream
        self.name = os.urandom(16)
        self._controls: dict[Component, Control] = {}
        self._changed = threading.Condition()
        self._waiting: deque[bytes] = deque([packed(run.hello)])
        self._values = self._octets = 0
        """How many of them are samples, and the length of all."""
        self._dropped = 0
        self._is_urgent = True
        self._closing = False
        self._threads = [
            threading.Thread(target=each, name="rtgen attached", daemon=True)
            for each in (self._read, self._write)
        ]

    def start(self) -> None:
        """Begin to serve."""
        for each in self._threads:
            each.start()

    def close(self, seconds: float) -> None:
        """Send what waits, for at most this time."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._threads[1].join(seconds)
        self._hang_up()

    def put(self, message: Any) -> None:
        """Send a message; a client that does not read what it has asked for is left."""
        data = packed(message)
        with self._changed:
            length = self._octets + len(data)
            if (
                len(self._waiting) < _MAX_WAITING
                and length <= 2 * local_runs.MAX_LENGTH
            ):
                self._waiting.append(data)
                self._octets = length
                self._is_urgent = True
                self._changed.notify_all()
                return
        self._shut()

    def has_room(self) -> bool:
        """Return whether a sample can be sent; else it is counted as dropped."""
        if self._values < _MAX_VALUES and self._octets <= local_runs.MAX_LENGTH:
            return True
        self._dropped += 1
        return False

    def put_value(self, value: Value | Event) -> None:
        """Send a sample or an event; one that is too long is dropped."""
        try:
            data = packed(value)
        except ValueError:
            self._dropped += 1
            return
        with self._changed:
            self._values += 1
            self._octets += len(data)
            self._waiting.append(data)

    def _write(self) -> None:
        told = _Told()
        try:
            while True:
                with self._changed:
                    self._changed.wait_for(
                        lambda: self._closing or self._is_urgent, _FLUSH
                    )
                    data = b"".join(self._waiting)
                    self._waiting.clear()
                    self._values = self._octets = 0
                    self._is_urgent = False
                    closing = self._closing
                if not closing:
                    data += told.status(self._run, self._dropped)
                self._stream.sendall(data)
                if closing:
                    return
        except OSError:
            return  # The client has left.
        finally:
            self._hang_up()

    def _shut(self) -> None:
        """End both threads, also while they wait for the client."""
        with suppress(OSError):
            self._stream.shutdown(socket.SHUT_RDWR)

    def _hang_up(self) -> None:
        self._shut()
        self._stream.close()

    def _read(self) -> None:
        try:
            while (request := local_runs.receive(self._stream, Request)) is not None:
                self._answer(request)
        except (OSError, ValueError):
            pass  # The client has left, or is none of ours.
        finally:
            with self._changed:
                self._closing = True
                self._changed.notify_all()
            self._run.leave(self)

    def _answer(self, request: Request) -> None:
        match request:
            case Listen(instance, port, on):
                key = {(instance, port)}
                self.listened = self.listened | key if on else self.listened - key
            case Ask(number, instance, octets):
                reply = partial(self._reply, number)
                try:
                    component = self._run.system.component(instance)
                except RtcError as error:
                    reply(msgspec.json.encode({"error": str(error)}))
                    return
                control = self._controls.get(component)
                if control is None:
                    control = self._controls[component] = self._run.control(component)
                control.request(self.name, octets, reply)
            case Do(number, what, octets):
                work = partial(self._do, number, what, octets)
                if not self._run.in_turn(self.name, work):
                    self._reply_done(number, Done("too many requests wait"))
            case Give(number, instance, port, octets):
                work = partial(self._give, number, instance, port, octets)
                if not self._run.in_turn(self.name, work):
                    self._reply(number, b"too many samples wait")

    def _do(self, number: int, what: str, octets: bytes) -> None:
        doing = self._run.doing
        if doing is None:
            self._reply_done(number, Done(f"this run cannot do that: {what}"))
            return
        try:
            done = Done(octets=doing.do(self.name, what, octets))
        except (RtcError, ValueError) as error:
            done = Done(str(error) or type(error).__name__)
        self._reply_done(number, done)

    def _reply_done(self, number: int, done: Done) -> None:
        self._reply(number, msgspec.msgpack.encode(done))

    def _give(self, number: int, instance: str, port: str, octets: bytes) -> None:
        refused = ""
        try:
            self._run.give(instance, port, octets)
        except (RtcError, CdrError) as error:
            refused = str(error)
        self._reply(number, refused.encode())

    def _reply(self, number: int, octets: bytes) -> None:
        try:
            self.put(Answer(number, octets))
        except ValueError as error:
            refused = msgspec.json.encode({"error": str(error)})
            self.put(Answer(number, refused))
