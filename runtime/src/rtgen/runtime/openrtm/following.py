"""Complements OpenRTM: ticks for INACTIVE components, and state changes by a behaviour."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from rtgen.runtime.failures import described, log
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    LifeCycleState,
)
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.participant import Participant

_PERIOD = 0.005
_END_TIMEOUT = 2.0
_STEPS = {
    (INACTIVE_STATE, ACTIVE_STATE): "activate_component",
    (INACTIVE_STATE, ERROR_STATE): "activate_component",
    (ACTIVE_STATE, INACTIVE_STATE): "deactivate_component",
    (ERROR_STATE, INACTIVE_STATE): "reset_component",
    (ERROR_STATE, ACTIVE_STATE): "reset_component",
}
"""Requests to OpenRTM's context, by its state of the component and the behaviour's state.

A behaviour in ERROR rejects activation, which leads to ERROR there as well.
"""


class Follower(msgspec.Struct, eq=False):
    """A thread that runs while there is work, started by `wake`.

    It executes ticks of a component that is INACTIVE in OpenRTM if something depends on them
    (requests, the end of a cycle), and requests OpenRTM to follow the behaviour's state.
    """

    _behaviour: Component
    _participants: Mapping[int, Participant]
    _context: Callable[[int], Any]
    _rtc: Any
    states: dict[int, LifeCycleState] = {}
    """The component's state in each context of OpenRTM."""

    _lock: threading.Lock = msgspec.field(default_factory=threading.Lock)
    _again: bool = False
    _reported: str = ""
    _ended: threading.Event = msgspec.field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def look(self, ec_id: int) -> None:
        """Start working if a context needs it."""
        participant = self._participants.get(ec_id)
        if participant is not None and self._has_work(ec_id, participant):
            self.wake()

    def wake(self) -> None:
        """Start working."""
        with self._lock:
            self._again = True
            if self._thread is None and not self._ended.is_set():
                self._thread = threading.Thread(
                    target=self._run,
                    name=f"rtgen {self._behaviour.instance_name}",
                    daemon=True,
                )
                self._thread.start()

    def end(self) -> None:
        """End the thread, after its current work."""
        with self._lock:
            self._ended.set()
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(_END_TIMEOUT)

    def _run(self) -> None:
        while not self._ended.wait(_PERIOD):
            with self._lock:
                self._again = False
            work = False
            for ec_id, participant in tuple(self._participants.items()):
                try:
                    self._work(ec_id, participant)
                except Exception as error:  # Either OpenRTM's or the behaviour's own.
                    self._log_once(described(error))
                work |= self._has_work(ec_id, participant)
            with self._lock:
                if not work and not self._again:
                    self._thread = None
                    return

    def _log_once(self, failure: str) -> None:
        # Failing work is repeated; its error is logged once.
        if failure != self._reported:
            log.warning("%s: %s", self._behaviour.instance_name, failure)
        self._reported = failure

    def _work(self, ec_id: int, participant: Participant) -> None:
        with self._behaviour._lock:
            if self._state(ec_id) is INACTIVE_STATE:
                participant.carry_out_requests()
                participant.finish()
            step = self._step(ec_id, participant)
        if step is not None:
            # Outside the behaviour's lock, because OpenRTM's callback acquires it.
            getattr(self._context(ec_id), step)(self._rtc.getObjRef())

    def _state(self, ec_id: int) -> LifeCycleState:
        return self.states.get(ec_id, INACTIVE_STATE)

    def _step(self, ec_id: int, participant: Participant) -> str | None:
        """Return the request for OpenRTM's context; None during a request of the behaviour."""
        if participant._requests:
            return None
        return _STEPS.get((self._state(ec_id), participant.state))

    def _has_work(self, ec_id: int, participant: Participant) -> bool:
        if self._state(ec_id) is INACTIVE_STATE and (
            participant._requests or participant._deferred_calls
        ):
            return True
        return self._step(ec_id, participant) is not None
