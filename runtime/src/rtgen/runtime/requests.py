"""Requests from outside during a run: a queue for each client, served in turn within a budget.

The budget is a part of the time, which the requests of all clients share, so that they cannot take
the time of the run. Clients that come first, such as an operator, are served before the others and
are not limited by it.
"""

from __future__ import annotations

import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable
from functools import partial
from typing import Final

import msgspec

Request = Callable[[], object]
"""Is executed by the thread of the run; must not raise."""

BURST: Final = 0.05
"""Time that can be saved up for requests [s]."""
_SHORTEST, _LONGEST = 0.001, 0.05
"""Times for which a thread waits before it looks again [s]."""
_QUIET: Final = 1.0
"""Time after which a client is not refused because of others [s]."""
MAX_AT_ONCE: Final = 100
"""Maximum number of requests that are executed one after the other."""
_MAX_CLIENTS: Final = 256
"""Maximum number of clients that are known by their names."""


class Client(msgspec.Struct, eq=False):
    """The queue of a client; `put` and `charge` may be called from any thread."""

    _requests: Requests
    _limit: int | None
    _ready: Callable[[], bool]
    first: bool
    _waiting: deque[Request] = msgspec.field(default_factory=deque)
    running: int = 0
    """Number of requests that are being executed."""

    spent: float = 0.0
    """Time of the client's requests, by which clients are served in turn [s]."""

    def put(self, request: Request) -> bool:
        """Add a request; return False if the queue is full, or the client has left."""
        return self._requests.put(self, request)

    def charge(self, seconds: float) -> None:
        """Count time that the client has taken elsewhere as time of its requests."""
        self._requests._charge(self, seconds)

    @property
    def is_full(self) -> bool:
        """Whether `put` would refuse a request."""
        return self._limit is not None and len(self._waiting) >= self._limit

    @property
    def is_idle(self) -> bool:
        """Whether no request waits or is being executed."""
        return not self._waiting and not self.running

    def _has_next(self) -> bool:
        return bool(self._waiting) and self._ready()


class Requests:
    """The queues of all clients.

    `share` is the part of the time for clients that do not come first, in [0, 1]; what they do not
    use is saved up to `burst` [s]. Requests are executed by the threads that call `carry_out` or
    `carry_out_one`; `conversion` is the time that each takes elsewhere [s].
    """

    def __init__(
        self,
        share: float,
        burst: float = BURST,
        clock: Callable[[], float] = time.perf_counter,
        conversion: float = 0.0,
    ) -> None:
        self._conversion = conversion
        self._share = share
        self._burst = self._credit = burst
        self._clock = clock
        self._last = clock()
        self._clients: list[Client] = []
        self._reached = {True: 0.0, False: 0.0}
        """The time of the client that was served last, by whether it comes first."""
        self._changed = threading.Condition()

    def join(
        self,
        limit: int | None,
        *,
        first: bool = False,
        ready: Callable[[], bool] = lambda: True,
    ) -> Client:
        """Return the queue of a new client, of at most `limit` requests.

        Its requests are only executed while `ready` holds; `wake` reports that this may have
        changed.
        """
        client = Client(self, limit, ready, first=first)
        with self._changed:
            self._clients.append(client)
        return client

    def leave(self, client: Client) -> None:
        """Forget a client and its requests."""
        with self._changed:
            if client in self._clients:
                self._clients.remove(client)

    def empty(self) -> bool:
        """Return whether no request waits."""
        with self._changed:
            return not any(client._waiting for client in self._clients)

    def wake(self) -> None:
        """End a `wait`."""
        with self._changed:
            self._changed.notify_all()

    def wait(self, timeout: float, *, limited: bool = True) -> None:
        """Wait for a request that can be executed, at most some time [s]."""
        with self._changed:
            if self._next(limited=limited) is not None:
                return
            if limited and self._share and any(c._has_next() for c in self._clients):
                timeout = min(timeout, -self._credit / self._share)
            self._changed.wait(max(timeout, 0.0))

    def carry_out(self, longest: float, *, limited: bool = True) -> None:
        """Execute requests, until none waits or for a time [s]; without budget if not `limited`.

        At most MAX_AT_ONCE are executed. A request that is being executed is not ended.
        """
        end = self._clock() + longest
        for _ in range(MAX_AT_ONCE):
            if not self.carry_out_one(limited=limited) or self._clock() >= end:
                return

    def carry_out_one(self, *, limited: bool = True) -> bool:
        """Execute the request whose turn it is; return whether there was one."""
        with self._changed:
            client = self._next(limited=limited)
            if client is None:
                return False
            request = client._waiting.popleft()
            self._reached[client.first] = client.spent
            client.running += 1
        begun = self._clock()
        try:
            request()
        finally:
            self._charge(client, self._clock() - begun + self._conversion)
            client.running -= 1
        return True

    def put(self, client: Client, request: Request) -> bool:
        """Add a request of a client; see `Client.put`."""
        with self._changed:
            if client.is_full or client not in self._clients:
                return False
            if not client._waiting:
                # A client does not save up its turns.
                client.spent = max(client.spent, self._reached[client.first])
            client._waiting.append(request)
            self._changed.notify_all()
        return True

    def _charge(self, client: Client, seconds: float) -> None:
        with self._changed:
            client.spent += seconds
            if not client.first:
                self._credit -= seconds

    def _next(self, *, limited: bool) -> Client | None:
        """Return the client whose turn it is; None if there is none within the budget."""
        now = self._clock()
        earned = self._credit + (now - self._last) * self._share
        self._credit, self._last = min(earned, self._burst), now
        waiting = [each for each in self._clients if each._has_next()]
        if limited and self._credit <= 0.0:
            waiting = [each for each in waiting if each.first]
        return min(waiting, key=lambda c: (not c.first, c.spent), default=None)


class Queues(msgspec.Struct, eq=False):
    """The queues of clients by their names; those of clients without requests are forgotten."""

    _requests: Requests
    _limit: int
    _busy: int
    _clients: OrderedDict[Hashable, Client] = msgspec.field(default_factory=OrderedDict)
    _lock: threading.Lock = msgspec.field(default_factory=threading.Lock)

    def put(
        self, name: Hashable, request: Callable[[], object], *, first: bool = False
    ) -> bool:
        """Add a request of a client; return False if too many wait."""
        with self._lock:
            client = self._client(name, first=first)
            return client is not None and client.put(request)

    def _client(self, name: Hashable, *, first: bool) -> Client | None:
        key = name, first
        client = self._clients.get(key)
        if client is not None:
            self._clients.move_to_end(key)
            return client
        if len(self._clients) >= _MAX_CLIENTS:
            idle = next((k for k, c in self._clients.items() if c.is_idle), None)
            if idle is None:
                return None
            self._requests.leave(self._clients.pop(idle))
        clients: list[Client] = []
        ready = partial(self._is_ready, clients)
        clients.append(self._requests.join(self._limit, first=first, ready=ready))
        self._clients[key] = clients[0]
        return clients[0]

    def _is_ready(self, client: list[Client]) -> bool:
        return client[0].running < self._busy


class Allowance(msgspec.Struct, eq=False):
    """The part of the time that clients may take whose requests cannot wait, but be refused.

    `share` is that of all clients, and of each one half of it. A client that has taken nothing for
    a second is not refused, whatever the others take.
    """

    _share: float
    _burst: float = BURST
    _clock: Callable[[], float] = time.perf_counter
    _lock: threading.Lock = msgspec.field(default_factory=threading.Lock)
    _credits: OrderedDict[Hashable, tuple[float, float]] = msgspec.field(
        default_factory=OrderedDict
    )
    """Credit of each client, and of all of them (None), at a time [s]."""

    def allows(self, client: Hashable) -> bool:
        """Return whether a request of a client is executed now."""
        with self._lock:
            if client not in self._credits:
                return True
            own, then = self._credit(client), self._credits[client][1]
            if own > 0.0 and self._clock() - then >= _QUIET:
                return True
            return own > 0.0 and self._credit(None) > 0.0

    def charge(self, client: Hashable, seconds: float) -> None:
        """Count the time of a request [s]."""
        with self._lock:
            now = self._clock()
            for each in (client, None):
                self._credits[each] = self._credit(each) - seconds, now
                self._credits.move_to_end(each)
            if len(self._credits) > _MAX_CLIENTS:
                self._credits.popitem(last=False)

    def _credit(self, client: Hashable) -> float:
        credit, then = self._credits.get(client, (self._burst, 0.0))
        share = self._share if client is None else self._share / 2
        return min(credit + (self._clock() - then) * share, self._burst)


class Overruns:
    """Whether components of this process have left out ticks recently."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last: float | None = None

    def report(self) -> None:
        """Take note of a tick that was left out."""
        self._last = self._clock()

    def recent(self) -> bool:
        """Return whether one was reported within the last second."""
        return self._last is not None and self._clock() - self._last < _QUIET


class Pace:
    """The part of the time that requests may take whose threads can wait.

    Threads wait only while `applies` holds, after a long request at most `burst / share` [s].
    """

    def __init__(
        self,
        share: float,
        burst: float = BURST,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
        applies: Callable[[], bool] = lambda: True,
    ) -> None:
        self._share = share
        self._burst = self._credit = burst
        self._clock = clock
        self._sleep = sleep
        self._applies = applies
        self._last = clock()
        self._lock = threading.Lock()
        self._turn = threading.Lock()

    def wait(self) -> None:
        """Wait until a request may be executed."""
        if not self._applies():
            return
        with self._turn:  # One thread looks at the clock, the others wait for it.
            while self._applies() and (debt := -self._earned()) >= 0.0:
                self._sleep(min(max(debt / self._share, _SHORTEST), _LONGEST))

    def charge(self, seconds: float) -> None:
        """Count the time of a request [s]."""
        with self._lock:
            self._credit = max(self._credit - seconds, -self._burst)

    def _earned(self) -> float:
        with self._lock:
            now = self._clock()
            earned = self._credit + (now - self._last) * self._share
            self._credit, self._last = min(earned, self._burst), now
            return self._credit


overruns: Final = Overruns()
"""Those of the components of this process that run in real time."""
calls: Final = Pace(0.25, applies=overruns.recent)
"""The part of the time for calls of other processes while components leave out ticks.

Calls are part of the work of a system, so nothing limits them before.
"""


def await_turn() -> float | None:
    """Wait until a call of another process may be executed; return the time of the thread [s].

    Return None for one that is not limited.
    """
    if not overruns.recent():
        return None
    calls.wait()
    return time.thread_time()


def charge(begun: float | None, conversion: float = 0.0) -> None:
    """Count the time of a call since `await_turn`, and that of its conversion [s]."""
    if begun is not None:
        calls.charge(time.thread_time() - begun + conversion)


class Rates(msgspec.Struct, eq=False):
    """The rate at which messages of clients are read that can be made to wait.

    Each client may send `rate` messages in a second, after a pause `burst` at once; those that have
    sent more share `total`.
    """

    _rate: float
    _total: float
    _burst: float
    _clock: Callable[[], float] = time.monotonic
    _credits: dict[Hashable, tuple[float, float]] = {}
    """The messages that each client may send, at a time [s]."""

    def delay(self, client: Hashable, messages: float) -> float:
        """Count messages of a client; return the time until the next is read [s]."""
        now = self._clock()
        others = sum(
            credit < 0.0
            for each, (credit, _) in self._credits.items()
            if each != client
        )
        rate = min(self._rate, self._total / (1 + others))
        credit, then = self._credits.get(client, (self._burst, now))
        credit = min(credit + (now - then) * rate, self._burst) - messages
        self._credits[client] = credit, now
        return max(-credit / rate, 0.0)

    def leave(self, client: Hashable) -> None:
        """Forget a client."""
        self._credits.pop(client, None)
