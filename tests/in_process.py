"""A medium within one process: several media of one `Network` see each other."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from itertools import count
from typing import Any

from rtgen.runtime.distribution.deadlines import Deadline
from rtgen.runtime.distribution.medium import (
    MediumError,
    NotServedError,
    OnChange,
    OnRequest,
    OnSample,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
    Sample,
    ServiceTypes,
    Topic,
    check_name,
    type_name,
)


class Network:
    """Connects the media of one process; deliveries happen in the thread of the sender."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.publishers: list[InProcessPublisher] = []
        self.subscriptions: list[InProcessSubscription] = []
        self.services: dict[str, list[_Service]] = {}
        self.presences: list[str] = []
        self.watches: list[tuple[str, OnChange]] = []
        self.sources = count(1)

    def medium(self) -> InProcessMedium:
        """One more process's part."""
        return InProcessMedium(self)

    def changed(self, name: str, present: bool) -> None:
        """Notify the watches; the caller holds the lock."""
        for prefix, on_change in list(self.watches):
            if name.startswith(prefix):
                on_change(name, present)


class InProcessMedium:
    """See `medium.Medium`. `lose` makes the others lose it without a farewell."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._open: list[_Token] = []

    def publisher(self, topic: Topic, qos: Qos) -> InProcessPublisher:
        check_name(topic.name)
        end = InProcessPublisher(self._network, topic, qos)
        self._open.append(end)
        return end

    def subscribe(
        self, topic: Topic, qos: Qos, on_sample: OnSample
    ) -> InProcessSubscription:
        check_name(topic.name)
        subscription = InProcessSubscription(self._network, topic, qos, on_sample)
        self._open.append(subscription)
        return subscription

    def serve(
        self, service: str, types: Sequence[ServiceTypes], on_request: OnRequest
    ) -> _Token:
        server = _Service(self._network, check_name(service), on_request)
        self._open.append(server)
        return server

    def client(self, service: str, types: ServiceTypes) -> InProcessClient:
        end = InProcessClient(self._network, check_name(service))
        self._open.append(end)
        return end

    def announce(self, name: str) -> _Token:
        network = self._network
        with network.lock:
            network.presences.append(check_name(name))
            if network.presences.count(name) == 1:
                network.changed(name, True)

        def end() -> None:
            network.presences.remove(name)
            if name not in network.presences:
                network.changed(name, False)

        return self._token(end)

    def watch(self, prefix: str, on_change: OnChange) -> _Token:
        network = self._network
        entry = prefix, on_change
        with network.lock:
            for name in dict.fromkeys(network.presences):
                if name.startswith(prefix):
                    on_change(name, True)
            network.watches.append(entry)
        return self._token(lambda: network.watches.remove(entry))

    def close(self) -> None:
        while self._open:
            self._open.pop().close()

    lose = close

    def _token(self, end: Callable[[], None]) -> _Token:
        token = _Token(self._network, end)
        self._open.append(token)
        return token


class _Token:
    """Ends something once, under the network's lock."""

    def __init__(self, network: Network, end: Callable[[], None]) -> None:
        self._network = network
        self._end: Callable[[], None] | None = end

    def close(self) -> None:
        with self._network.lock:
            end, self._end = self._end, None
            if end is not None:
                end()


class InProcessPublisher(_Token):
    """See `medium.Publisher`."""

    def __init__(self, network: Network, topic: Topic, qos: Qos) -> None:
        super().__init__(network, lambda: network.publishers.remove(self))
        self.topic = topic
        self.qos = qos
        self.source = next(network.sources)
        self._sequence = 0
        self.kept: deque[Sample] = deque(maxlen=qos.depth if qos.durable else 0)
        with network.lock:
            network.publishers.append(self)

    @property
    def matched(self) -> bool:
        return any(s.takes(self) for s in self._network.subscriptions)

    def publish(self, octets: bytes) -> None:
        with self._network.lock:
            if self._end is None:
                raise MediumError(f"the publisher of {self.topic.name} is closed")
            self._sequence += 1
            sample = Sample(octets, self.source, self._sequence)
            self.kept.append(sample)
            for subscription in list(self._network.subscriptions):
                if subscription.takes(self):
                    subscription.on_sample(sample)


class InProcessSubscription(_Token):
    """See `medium.Subscription`."""

    lost = 0

    def __init__(
        self, network: Network, topic: Topic, qos: Qos, on_sample: OnSample
    ) -> None:
        super().__init__(network, self._stop)
        self.topic = topic
        self.qos = qos
        self._on_sample = on_sample
        self._deadline = Deadline(qos.deadline)
        with network.lock:
            network.subscriptions.append(self)
            for publisher in network.publishers if qos.durable else ():
                for sample in publisher.kept if self.takes(publisher) else ():
                    self.on_sample(sample)

    @property
    def missed_deadlines(self) -> int:
        """See `medium.Subscription`."""
        return self._deadline.missed

    def on_sample(self, sample: Sample) -> None:
        """A sample came."""
        self._deadline.met()
        self._on_sample(sample)

    def _stop(self) -> None:
        self._network.subscriptions.remove(self)
        self._deadline.end()

    def takes(self, publisher: InProcessPublisher) -> bool:
        """Whether topic, type and QoS fit."""
        return (
            publisher.topic.name == self.topic.name
            and type_name(publisher.topic.type) == type_name(self.topic.type)
            and publisher.qos.reliable >= self.qos.reliable
            and publisher.qos.durable >= self.qos.durable
        )


class _Service(_Token):
    def __init__(self, network: Network, name: str, on_request: OnRequest) -> None:
        super().__init__(network, self._stop)
        self.name = name
        self.on_request = on_request
        self.waiting: list[Future[bytes]] = []
        with network.lock:
            network.services.setdefault(name, []).append(self)

    def _stop(self) -> None:
        self._network.services[self.name].remove(self)
        for future in list(self.waiting):
            _lose(future)


class InProcessClient(_Token):
    """See `medium.Client`."""

    def __init__(self, network: Network, service: str) -> None:
        super().__init__(network, self.cancel)
        self._service = service
        self._waiting: list[Future[bytes]] = []

    def cancel(self) -> None:
        for future in list(self._waiting):
            _lose(future)

    def call(self, octets: bytes, timeout: float) -> bytes:
        future: Future[bytes] = Future()
        with self._network.lock:
            servers = self._network.services.get(self._service)
            if not servers:
                raise NotServedError(f"nobody serves {self._service}")
            server = servers[0]
            server.waiting.append(future)
            self._waiting.append(future)
        try:
            server.on_request(octets, lambda reply: _answer(future, reply))
            return future.result(timeout)
        except FutureTimeout as error:
            raise ReplyTimeoutError(
                f"no reply of {self._service} in {timeout} s"
            ) from error
        finally:
            server.waiting.remove(future)
            self._waiting.remove(future)

    def send(self, octets: bytes, timeout: float) -> None:
        self.call(octets, timeout)


def _answer(future: Future[Any], reply: bytes) -> None:
    if not future.done():
        future.set_result(reply)


def _lose(future: Future[Any]) -> None:
    if not future.done():
        future.set_exception(PeerLostError("the server was lost"))
