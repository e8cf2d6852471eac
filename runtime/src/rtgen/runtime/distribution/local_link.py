"""The connection to a run of the same user on this machine (`local_server`)."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

import msgspec

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.closable import Closable
from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.control import Asker
from rtgen.runtime.distribution.data import encoder
from rtgen.runtime.distribution.local_runs import (
    Answer,
    Ask,
    End,
    Give,
    Listen,
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

_LOST = "its process has ended without a farewell: it was killed, or has crashed"


class LocalLink(Closable):
    """A connection to the run of a socket; `timeout` [s] of a request. Raises OSError.

    `time` is that of the run [ns], `end` the reason of its end, empty while it lasts, `dropped` the
    number of samples that the run has left out. `told` is called after each change of instances,
    connections, and at the end; from any thread.
    """

    def __init__(
        self, path: Path, told: Callable[[], None] = lambda: None, timeout: float = 2.0
    ) -> None:
        self._stream, self.hello = local_runs.connect(path)
        self._timeout = timeout
        self._told = told
        self.time = self.dropped = 0
        self.end = ""
        self.instances: list[str] = []
        self.wires: list[Wire] = []
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
        except (OSError, ValueError, msgspec.MsgspecError) as error:
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
            case Status(time, instances, wires, dropped):
                self.time = max(self.time, time)
                if dropped and not self.dropped:
                    log.warning(
                        "%s: samples are left out here: they come too fast, or are too long",
                        self.hello.name,
                    )
                self.dropped = dropped
                if instances is not None:
                    self.instances = instances
                if wires is not None:
                    self.wires = wires
                if instances is not None or wires is not None:
                    self._told()


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
