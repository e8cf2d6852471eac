"""The connection to a run of the same user on this machine (`local_server`)."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from rtgen.facts.messages import from_msgpack
from rtgen.facts.version import __version__
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.closable import Closable
from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.control import Asker
from rtgen.runtime.distribution.data import encoder
from rtgen.runtime.distribution.local_runs import (
    MAX_CLIENTS,
    MESSAGES,
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
    Report,
    Status,
    Value,
    Wire,
    packed,
)
from rtgen.runtime.distribution.medium import (
    MediumError,
    PeerLostError,
    ReplyTimeoutError,
)
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.failures import log
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.system.latency import Latency

LEFT_OUT = (
    "samples, frames or calls are left out here: they come too fast, or are too long"
)
_DOING = 15.0
"""Time for what the program does [s]: it may have to load libraries."""
_LOST = "its process has ended without a farewell: it was killed, or has crashed"


class LocalLink(Closable):
    """A connection to the run of a socket; `timeout` [s] of a request. Raises OSError.

    `time` is that of the run [ns], `end` the reason of its end, empty while it lasts, `dropped` the
    number of samples, frames and calls that the run has left out, `states` are those of components
    that have changed, with their reasons. `told` is called after each change of instances,
    connections, and at the end, `on_event` with each event of the run; from any thread.
    """

    def __init__(
        self,
        path: Path,
        told: Callable[[], None] = lambda: None,
        timeout: float = 2.0,
        on_event: Callable[[Event], None] = lambda event: None,
    ) -> None:
        self._stream, self.hello = local_runs.connect(path)
        refusal = _refusal(self.hello)
        if refusal:
            self._stream.close()
            raise OSError(refusal)
        self._timeout = timeout
        self._told = told
        self._on_event = on_event
        self.time = self.dropped = 0
        self.end = ""
        self.instances: list[str] = []
        self.wires: list[Wire] = []
        self.chains: list[Latency] = []
        self.states: dict[str, tuple[str, str]] = {}
        self._askers: dict[str, Asker] = {}
        self._numbers = itertools.count(1)
        self._answers: dict[int, SimpleQueue[bytes | None]] = {}
        self._takers: dict[tuple[str, str], Callable[[bytes], None]] = {}
        self._sending = threading.Lock()
        self._thread = threading.Thread(
            target=self._read, name="rtgen link", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """End the connection. A second call has no effect."""
        with suppress(OSError):
            self._stream.shutdown(2)
        self._stream.close()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def asker(self, instance: str) -> Asker:
        """Return a client of the instance's control service."""
        if instance not in self._askers:
            client = _Client(self, instance)
            self._askers[instance] = Asker(client, instance, self._timeout)
        return self._askers[instance]

    def listen(
        self, there: RemotePort, type_: type[Any], take: Callable[[Any], None]
    ) -> _Listening:
        """Take the values of an OutPort, in the thread of the connection. Raises MediumError."""
        warned = False

        def on_octets(octets: bytes) -> None:
            nonlocal warned
            try:
                value = received(type_, octets)
            except CdrError as error:
                if not warned:
                    log.warning("%s: a sample cannot be decoded: %s", there, error)
                warned = True
                return
            take(value)

        key = there.instance, there.port
        self._takers[key] = on_octets
        self._send(Listen(*key, on=True))
        return _Listening(self, key)

    def give(self, there: RemotePort, type_: type[Any], value: Any) -> None:
        """Give a sample to an InPort. Raises MediumError, also if it is refused; CdrError."""
        octets = encoder(type_)(value)

        def request(number: int) -> Give:
            return Give(number, there.instance, there.port, octets)

        refused = self.ask(request, self._timeout)
        if refused:
            raise MediumError(refused.decode())

    def do(self, what: str, octets: bytes = b"") -> bytes:
        """Let the program that runs the system do something. Raises MediumError."""
        answer = self.ask(lambda number: Do(number, what, octets), _DOING)
        try:
            done = from_msgpack(answer, Done)
        except ValueError as error:
            raise MediumError(f"the answer is wrong: {error}") from error
        if done.error:
            raise MediumError(done.error)
        return done.octets

    def ask(self, request: Callable[[int], Any], timeout: float) -> bytes:
        """Return the answer to a request, made with its number. Raises MediumError."""
        number = next(self._numbers)
        queue: SimpleQueue[bytes | None] = SimpleQueue()
        self._answers[number] = queue
        try:
            self._send(request(number))
            if self.end:
                raise PeerLostError(self.end)
            answer = queue.get(timeout=timeout)
        except Empty as error:
            raise ReplyTimeoutError(f"no answer within {timeout:g} s") from error
        finally:
            self._answers.pop(number, None)
        if answer is None:
            raise PeerLostError(self.end)
        return answer

    def forget(self, key: tuple[str, str]) -> None:
        """Take no more values of a port."""
        self._takers.pop(key, None)
        with suppress(MediumError):
            self._send(Listen(*key, on=False))

    def _send(self, message: Any) -> None:
        try:
            data = packed(message)
        except ValueError as error:
            raise MediumError(str(error)) from None
        try:
            with self._sending:
                self._stream.sendall(data)
        except OSError as error:
            raise PeerLostError(self.end or _LOST) from error

    def _read(self) -> None:
        try:
            while True:
                report = local_runs.receive(self._stream, Report)
                if report is None or isinstance(report, End):
                    break
                self._on_report(report)
            if report is not None:
                self.time = max(self.time, report.time)
                self.end = report.reason
        except (OSError, ValueError) as error:
            log.debug("the connection to a run has ended: %s", error)
        finally:
            self.end = self.end or _LOST
            for queue in [*self._answers.values()]:
                queue.put(None)
            self._told()

    def _on_report(self, report: Report) -> None:
        match report:
            case Value(instance, port, time, octets):
                self.time = max(self.time, time)
                taker = self._takers.get((instance, port))
                if taker is not None:
                    taker(octets)
            case Answer(number, octets):
                queue = self._answers.get(number)
                if queue is not None:
                    queue.put(octets)
            case Changed() | OnBus() | OnBoard() | Noted():
                self.time = max(self.time, report.time)
                if isinstance(report, Changed):
                    self.states[report.instance] = report.after, report.reason
                self._on_event(report)
            case Status(time, instances, wires, dropped, chains):
                self.time = max(self.time, time)
                if dropped and not self.dropped:
                    log.warning("%s: %s", self.hello.name, LEFT_OUT)
                self.dropped = dropped
                if chains is not None:
                    self.chains = chains
                if wires is not None:
                    self.wires = wires
                if instances is not None:
                    self.instances = instances
                    present = {*instances}
                    states = self.states.items()
                    self.states = {n: state for n, state in states if n in present}
                if instances is not None or wires is not None or chains is not None:
                    self._told()


def _refusal(hello: Hello) -> str:
    """Return why this program cannot attach to a run; empty if it can."""
    if hello.messages != MESSAGES:
        return (
            f"process {hello.pid} runs {hello.name} by rtgen {hello.version or 'of before'}, "
            f"to which this version, {__version__}, cannot attach: start both with the same one"
        )
    if hello.full:
        return f"{MAX_CLIENTS} programs are attached to {hello.name} already, process {hello.pid}"
    return ""


class _Client:
    """See `control.Asking`."""

    def __init__(self, link: LocalLink, instance: str) -> None:
        self._link = link
        self._instance = instance

    def call(self, octets: bytes, timeout: float) -> bytes:
        """Return the reply to a request. Raises MediumError."""

        def request(number: int) -> Ask:
            return Ask(number, self._instance, octets)

        return self._link.ask(request, timeout)

    def close(self) -> None:
        """Do nothing: the connection is that of all instances."""


class _Listening:
    """See `medium.Subscription`."""

    lost = missed_deadlines = 0

    def __init__(self, link: LocalLink, key: tuple[str, str]) -> None:
        self._link = link
        self._key = key

    def close(self) -> None:
        """Take no more values."""
        self._link.forget(self._key)
