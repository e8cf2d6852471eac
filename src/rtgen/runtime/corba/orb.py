"""The ORB of this process."""

from __future__ import annotations

import itertools
import threading
from typing import Any

import omniORB
from omniORB import CORBA, PortableServer

from rtgen.runtime.errors import TransportError

LOOPBACK = "127.0.0.1"
_numbers = itertools.count()


class Orb:
    """omniORB with an object adapter of its own; `timeout` [s] bounds every call.

    It listens at `host` (by default at the loopback interface only) on a port that the system
    chooses. omniORB has one ORB for each process: one that runs already is used as it is. Raises
    TransportError.
    """

    def __init__(self, host: str = LOOPBACK, timeout: float = 2.0) -> None:
        self._owned = omniORB.orb is None
        milliseconds = str(max(1, round(timeout * 1000)))
        options = {
            "-ORBnativeCharCodeSet": "UTF-8",
            "-ORBendPoint": f"giop:tcp:{host}:",
            "-ORBclientCallTimeOutPeriod": milliseconds,
            "-ORBclientConnectTimeOutPeriod": milliseconds,
            "-ORBverifyObjectExistsAndType": "0",
            "-ORBtraceLevel": "0",
        }
        words = ["rtgen", *(word for pair in options.items() for word in pair)]
        self._timeout = timeout
        try:
            self.orb: Any = CORBA.ORB_init(words, CORBA.ORB_ID)
            root = self.orb.resolve_initial_references("RootPOA")
            self.poa: Any = root.create_POA(f"rtgen-{next(_numbers)}", None, [])
            self.poa._get_the_POAManager().activate()
        except (CORBA.Exception, PortableServer.POA.AdapterAlreadyExists) as error:
            raise TransportError(f"omniORB cannot listen at {host}: {error}") from error

    def close(self) -> None:
        """Ends all objects, and the ORB if it began here; waits for calls, but not for ever."""
        self.poa.destroy(False, False)
        if self._owned:
            # A servant that never returns would hold destroy() for ever.
            ending = threading.Thread(target=self.orb.destroy, daemon=True)
            ending.start()
            ending.join(self._timeout)
