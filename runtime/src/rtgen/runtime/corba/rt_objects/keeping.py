"""Monitors components of other processes: reports losses, and reconnects."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import partial
from typing import TypeVar

from rtgen.runtime.corba.naming import is_alive
from rtgen.runtime.corba.rt_objects.foreign import Directory, Foreign
from rtgen.runtime.corba.rt_objects.peers import PeerConnection, ServicePeer
from rtgen.runtime.errors import RtcError
from rtgen.runtime.failures import NOTE, log
from rtgen.runtime.return_codes import ERROR_STATE

_PERIOD = 0.25

Peer = PeerConnection | ServicePeer
T = TypeVar("T")


class Keeper:
    """A thread that monitors foreign components and connections until `close`.

    A connection is re-established after the other process was restarted; a foreign component is
    configured, and activated if it should be ACTIVE.
    """

    def __init__(
        self, directory: Directory, peers: Callable[[], Iterable[Peer]]
    ) -> None:
        self._directory = directory
        self._peers = peers
        self._lost: set[str] = set()
        self._failed: set[str] = set()
        self._reported: dict[str, str] = {}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread, after its current calls."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._ended.wait(_PERIOD):
            for foreign in self._directory.foreign.values():
                self._look(foreign)
            missing: set[str] = set()
            for peer in self._peers():
                if not self._ended.is_set() and peer.there.instance not in missing:
                    found = self._tried(peer.name, partial(peer.renew, self._directory))
                    if found is False:
                        # Each further attempt would wait for it again.
                        missing.add(peer.there.instance)
            for instance in sorted(self._lost):
                foreign = self._directory.foreign[instance]
                if is_alive(foreign.reference):
                    self._tried(instance, partial(self._resume, foreign))

    def _look(self, foreign: Foreign) -> None:
        instance = foreign.instance
        if not is_alive(foreign.reference):
            foreign.last_state = None
            if instance not in self._lost:
                self._lost.add(instance)
                log.warning(
                    "%s is lost: its process does not respond; searching for it again",
                    instance,
                )
            self._tried(instance, partial(self._directory.find, instance))
            return
        foreign.look()
        failed = foreign.wanted and foreign.last_state is ERROR_STATE
        if failed and instance not in self._failed:
            log.warning("%s, which rtgen does not run, is in ERROR", instance)
        (self._failed.add if failed else self._failed.discard)(instance)

    def _resume(self, foreign: Foreign) -> None:
        """Restore the former state of a component that is back."""
        foreign.configure()
        if foreign.wanted:
            foreign.activate(self._directory.activations)
        self._lost.discard(foreign.instance)
        log.log(NOTE, "%s is there again", foreign.instance)

    def _tried(self, what: str, action: Callable[[], T]) -> T | None:
        """Return the result of an action; None after a failure, which is reported once."""
        try:
            result = action()
        except RtcError as error:
            if self._reported.get(what) != str(error):
                self._reported[what] = str(error)
                log.warning("%s", error)
            return None
        self._reported.pop(what, None)
        return result
