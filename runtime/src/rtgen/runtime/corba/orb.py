"""The ORB (omniORB) of this process."""

from __future__ import annotations

import itertools
import threading
import time
from typing import Any

import omniORB
from omniORB import CORBA, PortableServer

from rtgen.runtime.errors import TransportError
from rtgen.runtime.freed_memory import keep_freed_memory

_POLL_INTERVAL = 0.005
_RELEASE_TIME = 0.05
"""Seconds in which a thread that has left the list releases the interpreter's lock."""
LOOPBACK = "127.0.0.1"
MAX_MESSAGE = 64 << 20
"""Maximum size of a message in octets, in either direction."""
_numbers = itertools.count()


class Orb:
    """omniORB with a separate object adapter; `timeout` [s] bounds every call.

    It listens at `host` (default: the loopback interface only) on a free port. omniORB allows one
    ORB per process, so an existing ORB is used unchanged. Raises TransportError.
    """

    def __init__(self, host: str = LOOPBACK, timeout: float = 2.0) -> None:
        keep_freed_memory()
        self._owned = omniORB.orb is None
        self._milliseconds = max(1, round(timeout * 1000))
        milliseconds = str(self._milliseconds)
        options = {
            "-ORBnativeCharCodeSet": "UTF-8",
            "-ORBendPoint": f"giop:tcp:{host}:",
            "-ORBclientCallTimeOutPeriod": milliseconds,
            "-ORBclientConnectTimeOutPeriod": milliseconds,
            "-ORBgiopMaxMsgSize": str(MAX_MESSAGE),
            "-ORBverifyObjectExistsAndType": "0",
            "-ORBtraceLevel": "0",
        }
        words = ["rtgen", *(word for pair in options.items() for word in pair)]
        self._timeout = timeout
        self.busy: list[None] = []
        """An item for each call in progress."""
        self.orb: Any = None
        try:
            self.orb = CORBA.ORB_init(words, CORBA.ORB_ID)
            root = self.orb.resolve_initial_references("RootPOA")
            self.poa: Any = root.create_POA(f"rtgen-{next(_numbers)}", None, [])
            self.poa._get_the_POAManager().activate()
        except (CORBA.Exception, PortableServer.POA.AdapterAlreadyExists) as error:
            if self._owned and self.orb is not None:
                self.orb.destroy()
            raise TransportError(f"omniORB cannot listen at {host}: {error}") from error

    def activate(self, servant: Any) -> Any:
        """Return a reference to the object of a servant."""
        return self.poa.id_to_reference(self.poa.activate_object(servant))

    def deactivate(self, reference: Any) -> None:
        """Remove an object created by `activate`."""
        self.poa.deactivate_object(self.poa.reference_to_id(reference))

    def limit(self, reference: Any) -> None:
        """Bound the calls of a reference, since an existing ORB may have other options."""
        omniORB.setClientCallTimeout(reference, self._milliseconds)

    @property
    def limit_in_seconds(self) -> float:
        """The time-out of calls [s]."""
        return self._milliseconds / 1000

    def hasten(self, seconds: float) -> None:
        """Bound the calls made from now on by a shorter time-out, too."""
        self._milliseconds = min(self._milliseconds, max(1, round(seconds * 1000)))

    def close(self) -> None:
        """Remove all objects, and shut down the ORB if it was started here.

        Waits for calls in progress up to the time-out; an ORB with a servant that never returns
        is left running.
        """
        self.poa.destroy(False, False)
        deadline = time.monotonic() + self._timeout
        while self.busy and time.monotonic() < deadline:
            time.sleep(_POLL_INTERVAL)
        # In this thread: another one might still be running at interpreter exit.
        if self._owned and not self.busy:
            self.orb.destroy()
            await_workers(deadline)


def await_workers(deadline: float) -> None:
    """Wait for the threads of a destroyed ORB, which end on their own.

    `deadline` is a value of `time.monotonic`.

    Each acquires the interpreter's lock once more to free its state. A thread that requests it
    during interpreter exit is unwound through omniORB's destructors, which aborts the process.
    """

    def remain() -> bool:
        return any(isinstance(t, omniORB.WorkerThread) for t in threading.enumerate())

    while remain() and time.monotonic() < deadline:
        time.sleep(_POLL_INTERVAL)
    time.sleep(_RELEASE_TIME)
