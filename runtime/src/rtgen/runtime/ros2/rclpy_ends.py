"""Ends of topics and services over rclpy, and the threads that wait for them."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from contextlib import contextmanager
from functools import partial
from typing import Any, Protocol

from rclpy.exceptions import (
    NameValidationException,
    NotInitializedException,
    NoTypeSupportImportedException,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.serialization import deserialize_message, serialize_message

from rtgen.runtime.distribution.medium import (
    MediumError,
    NotServedError,
    OnRequest,
    OnSample,
    PeerLostError,
    ReplyTimeoutError,
    Sample,
)
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.rclpy_qos import Gaps, Status

_BATCH = 64
"""Messages taken from an end before others have their turn."""
_DISCOVERY_INTERVAL = 0.005
_LOSS_INTERVAL = 0.25
"""Seconds between looks for a server, before a request and during it."""
_ERRORS = (
    rclpy_implementation.InvalidHandle,
    NameValidationException,
    NotInitializedException,
    NoTypeSupportImportedException,
    RuntimeError,
    TypeError,
    ValueError,
)


@contextmanager
def reported(name: str) -> Iterator[None]:
    """Raise errors of rclpy as MediumError that begin with a name."""
    try:
        yield
    except _ERRORS as error:
        text = " ".join(str(error).split())
        raise MediumError(f"{name}: {text or type(error).__name__}") from error


class End(Protocol):
    """What a `Waiter` waits for: `kind` is one of those of a wait set."""

    @property
    def kind(self) -> str:
        """`subscription`, `service` or `client`."""

    @property
    def handle(self) -> Any:
        """The object of rclpy's C++ part."""

    def take(self) -> None:
        """Process what has arrived, without waiting for more."""


class Waiter:
    """A thread that waits for ends. It is rclpy's executor without its cost for each message."""

    def __init__(self, context: Any, name: str) -> None:
        self._context = context
        self._lock = threading.Lock()
        self._ends: dict[int, End] = {}
        self._entered: dict[int, End] = {}
        self._is_changed = True
        self._closed = False
        self._wake = rclpy_implementation.GuardCondition(context.handle)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def add(self, end: End) -> None:
        """Wait for an end, too."""
        self._change(lambda: self._ends.update({end.handle.pointer: end}))

    def remove(self, end: End) -> None:
        """Wait for it no more; a call of its `take` may be under way."""
        with end.handle:
            pointer = end.handle.pointer
        self._change(lambda: self._ends.pop(pointer, None))

    def _change(self, change: Callable[[], object]) -> None:
        with self._lock:
            change()
            self._is_changed = True
            if not self._closed:
                self._wake.trigger_guard_condition()

    def close(self) -> None:
        """End the thread, after the call that is under way."""

        def end() -> None:
            self._ends.clear()

        self._change(end)
        with self._lock:
            self._closed = True
        self._wake.trigger_guard_condition()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._wake.destroy_when_not_in_use()

    def _run(self) -> None:
        wait_set = None
        try:
            while not self._closed:
                with self._lock:
                    changed, self._is_changed = self._is_changed, False
                    ends = {**self._ends} if changed else {}
                if changed:
                    wait_set = self._renewed(ends)
                assert wait_set is not None
                self._wait(wait_set)
        except _ERRORS as error:
            if not self._closed:
                log.error("ROS 2: messages are received no more: %s", error)
        finally:
            self._renewed({})

    def _renewed(self, ends: dict[int, End]) -> Any:
        """Return a wait set for ends, each of which exists as long as it is waited for."""
        for pointer, end in ends.items():
            if pointer not in self._entered:
                end.handle.__enter__()
        for pointer, end in self._entered.items():
            if pointer not in ends:
                end.handle.__exit__(None, None, None)
        self._entered = ends
        count: defaultdict[str, int] = defaultdict(int)
        for end in ends.values():
            count[end.kind] += 1
        numbers = (count["subscription"], 1, 0, count["client"], count["service"], 0)
        return rclpy_implementation.WaitSet(*numbers, self._context.handle)

    def _wait(self, wait_set: Any) -> None:
        wait_set.clear_entities()
        wait_set.add_guard_condition(self._wake)
        add = {
            "subscription": wait_set.add_subscription,
            "client": wait_set.add_client,
            "service": wait_set.add_service,
        }
        for end in self._entered.values():
            add[end.kind](end.handle)
        wait_set.wait(-1)
        for kind in add:
            for pointer in wait_set.get_ready_entities(kind):
                end = self._entered[pointer]
                try:
                    end.take()
                except Exception as error:
                    log.warning("ROS 2: what has come cannot be read: %s", error)


class _Watched:
    """See `qos.End`."""

    status: Status

    @property
    def missed_deadlines(self) -> int:
        """See `qos.End`."""
        with reported("QoS"):
            return self.status.total("deadline")

    @property
    def lost_liveliness(self) -> int:
        """See `qos.End`."""
        with reported("QoS"):
            return self.status.total("liveliness")

    def look(self) -> None:
        """See `qos.End`."""
        with reported("QoS"):
            self.status.look()


class Publisher(_Watched):
    """See `medium.Publisher`."""

    def __init__(
        self, node: Any, publisher: Any, status: Status, *, is_durable: bool
    ) -> None:
        self._node = node
        self._publisher = publisher
        self.status = status
        self._topic = publisher.topic_name
        self._is_durable = is_durable

    def publish(self, octets: bytes) -> None:
        """See `medium.Publisher`."""
        with reported(self._topic):
            self._publisher.publish(octets)

    @property
    def matched(self) -> bool:
        """See `medium.Publisher`."""
        with reported(self._topic):
            count: int = self._publisher.get_subscription_count()
        return self._is_durable or count > 0

    def close(self) -> None:
        """See `medium.Publisher`."""
        self.status.close()
        self._node.destroy_publisher(self._publisher)


class Subscription(_Watched):
    """See `medium.Subscription`."""

    kind = "subscription"

    def __init__(
        self,
        node: Any,
        subscription: Any,
        on_sample: OnSample,
        waiter: Waiter,
        status: Status,
    ) -> None:
        self.status = status
        name = subscription.topic_name
        self._gaps = Gaps(lambda: int(node.count_publishers(name)))
        self._node = node
        self._subscription = subscription
        self.handle = subscription.handle
        self._type = subscription.msg_type
        self._on_sample = on_sample
        self._waiter = waiter
        self._closed = False
        waiter.add(self)

    def take(self) -> None:
        """See `End`."""
        for _ in range(_BATCH):
            taken = self.handle.take_message(self._type, True)
            if taken is None or self._closed:
                return
            self._gaps.count(taken[1])
            self._on_sample(Sample(taken[0], None))

    @property
    def lost(self) -> int:
        """See `medium.Subscription`."""
        return self._gaps.lost

    def close(self) -> None:
        """See `medium.Subscription`."""
        if not self._closed:
            self._closed = True
            self._waiter.remove(self)
            self.status.close()
            self._node.destroy_subscription(self._subscription)


class Server:
    """The serving end of a service."""

    kind = "service"

    def __init__(
        self, node: Any, service: Any, on_request: OnRequest, waiter: Waiter
    ) -> None:
        self._node = node
        self._service = service
        self.handle = service.handle
        self._types = service.srv_type
        self._on_request = on_request
        self._waiter = waiter
        self._closed = False
        waiter.add(self)

    def take(self) -> None:
        """See `End`."""
        for _ in range(_BATCH):
            request, info = self.handle.service_take_request(self._types.Request)
            if info is None or self._closed:
                return
            octets = serialize_message(request)
            self._on_request(octets, partial(self._respond, info.request_id))

    def _respond(self, request: Any, octets: bytes) -> None:
        if self._closed:
            return
        try:
            response = deserialize_message(octets, self._types.Response)
            self._service.send_response(response, request)
        except _ERRORS as error:
            if not self._closed:
                name = self._service.srv_name
                log.warning("%s: a response cannot be sent: %s", name, error)

    def close(self) -> None:
        """Serve no more."""
        if not self._closed:
            self._closed = True
            self._waiter.remove(self)
            self._node.destroy_service(self._service)


class Client:
    """See `medium.Client`."""

    kind = "client"

    def __init__(self, node: Any, client: Any, service: str, waiter: Waiter) -> None:
        self._node = node
        self._client = client
        self.handle = client.handle
        self._types = client.srv_type
        self._service = service
        self._waiter = waiter
        self._lock = threading.Lock()
        self._waiting: dict[int, Future[bytes]] = {}
        self._times_cancelled = 0
        self._closed = False
        waiter.add(self)

    def take(self) -> None:
        """See `End`."""
        for _ in range(_BATCH):
            info, response = self.handle.take_response(self._types.Response)
            if info is None:
                return
            with self._lock:
                number = info.request_id.sequence_number
                future = self._waiting.pop(number, None)
            if future is not None and future.set_running_or_notify_cancel():
                future.set_result(serialize_message(response))

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`."""
        deadline = time.monotonic() + timeout
        with reported(self._service):
            request = deserialize_message(octets, self._types.Request)
            self._wait_for_server(deadline)
            with self._lock:
                # The response must not be there before the request is known.
                number = self.handle.send_request(request)
                future: Future[bytes] = Future()
                self._waiting[number] = future
            try:
                return self._response(future, deadline)
            except FutureTimeout:
                raise ReplyTimeoutError(
                    f"no response of {self._service} in {timeout} s"
                ) from None
            finally:
                with self._lock:
                    self._waiting.pop(number, None)

    def _wait_for_server(self, deadline: float) -> None:
        before = self._times_cancelled
        while not self.handle.service_server_is_available():
            if self._closed or self._times_cancelled != before:
                raise self._cancelled()
            if time.monotonic() > deadline:
                raise NotServedError(f"nobody serves {self._service}")
            time.sleep(_DISCOVERY_INTERVAL)

    def _response(self, future: Future[bytes], deadline: float) -> bytes:
        """Return the response. Raises FutureTimeout after the deadline, PeerLostError."""
        while True:
            left = deadline - time.monotonic()
            try:
                return future.result(min(max(left, 0.0), _LOSS_INTERVAL))
            except FutureTimeout:
                if left <= _LOSS_INTERVAL:
                    raise
            if not self.handle.service_server_is_available():
                raise PeerLostError(f"the server of {self._service} was lost")

    def send(self, octets: bytes, timeout: float) -> None:
        """See `medium.Client`."""
        self.call(octets, timeout)

    def _cancelled(self) -> PeerLostError:
        return PeerLostError(f"the call of {self._service} was cancelled")

    def cancel(self) -> None:
        """See `medium.Client`."""
        with self._lock:
            self._times_cancelled += 1
            waiting, self._waiting = self._waiting, {}
        for future in waiting.values():
            if future.set_running_or_notify_cancel():
                future.set_exception(self._cancelled())

    def close(self) -> None:
        """See `medium.Client`."""
        if not self._closed:
            self._closed = True
            self.cancel()
            self._waiter.remove(self)
            self._node.destroy_client(self._client)
