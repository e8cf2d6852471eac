"""Execution contexts and the life cycle of their participants."""

from __future__ import annotations

import threading
import time
from typing import Any

import OpenRTM__POA
import RTC
import RTC__POA

from . import orb
from .NVUtil import list_of
from .properties import Properties
from .values import toBool

FOREIGN = 1000
"""First handle of contexts of other components."""


class Participant:
    """A component in a context: its state, requested transitions, and the callbacks of a cycle."""

    def __init__(self, component: Any, handle: int) -> None:
        self.component = component
        self.handle = handle
        self.state = RTC.INACTIVE_STATE
        self._next = RTC.INACTIVE_STATE
        self._asked: Any = None
        # A component of the process is called directly, another one over CORBA.
        self.actions = orb.local(component) or component

    def ask(self, state: Any) -> None:
        """Request a transition, which the next cycle executes."""
        self._asked = state

    def before(self) -> None:
        """Execute transitions: exit action of the old state, then entry action of the new."""
        if self._asked is not None and self._next == self.state:
            self._next = self._asked
        self._asked = None
        if self._next == self.state:
            return
        if self.state == RTC.ACTIVE_STATE:
            self.actions.on_deactivated(self.handle)
        elif self.state == RTC.ERROR_STATE and not self._reset():
            return
        # The old state is reported until the entry action of the new one has returned.
        state = self._next
        if state == RTC.ACTIVE_STATE:
            self._check(self.actions.on_activated(self.handle))
        elif state == RTC.ERROR_STATE:
            self.actions.on_aborting(self.handle)
        self.state = state

    def _reset(self) -> bool:
        """Reset the component; return whether it succeeded, otherwise it stays in ERROR."""
        if self.actions.on_reset(self.handle) == RTC.RTC_OK:
            return True
        self._next = RTC.ERROR_STATE
        return False

    def execute(self) -> None:
        if self.state == RTC.ERROR_STATE:
            self.actions.on_error(self.handle)
        elif self.state == RTC.ACTIVE_STATE and self._next != RTC.ERROR_STATE:
            self._check(self.actions.on_execute(self.handle))

    def after(self) -> None:
        if self.state == RTC.ACTIVE_STATE and self._next != RTC.ERROR_STATE:
            self._check(self.actions.on_state_update(self.handle))

    def rate_changed(self) -> Any:
        code = self.actions.on_rate_changed(self.handle)
        self._check(code)
        return code

    def _check(self, code: Any) -> None:
        if code != RTC.RTC_OK:
            self._next = RTC.ERROR_STATE


class ExecutionContextBase:
    """Common base of contexts; `_cycle_soon` schedules a cycle."""

    def __init__(self, properties: Properties) -> None:
        """Initialize; `properties` is the node `exec_cxt` of the component."""
        self._rate = float(properties.getProperty("periodic.rate", "1000"))
        self._properties = properties
        self._participants: list[Participant] = []
        self._running = False
        self._owner: Any = None
        self._lock = threading.RLock()
        self._cycling = threading.RLock()
        self._objref = self._this()

    def getObjRef(self) -> Any:
        return self._objref

    def bindComponent(self, component: Any, reference: Any, handle: int) -> None:
        """Make a component the owner and first participant."""
        self._owner = reference
        self._participants.append(Participant(reference, handle))

    def cycle(self) -> None:
        """Run one cycle: each phase over all participants before the next."""
        with self._cycling:
            participants = list(self._participants)
            for each in participants:
                each.before()
            for each in participants:
                each.execute()
            for each in participants:
                each.after()

    def is_running(self) -> bool:
        return self._running

    def start(self) -> Any:
        if self._running:
            return RTC.PRECONDITION_NOT_MET
        self._running = True
        for each in list(self._participants):
            each.actions.on_startup(each.handle)
        self._started()
        return RTC.RTC_OK

    def stop(self) -> Any:
        if not self._running:
            return RTC.PRECONDITION_NOT_MET
        self._running = False
        self._stopped()
        for each in list(self._participants):
            each.actions.on_shutdown(each.handle)
        return RTC.RTC_OK

    def _started(self) -> None:
        """Start the cycles."""

    def _stopped(self) -> None:
        """Stop the cycles."""

    def _cycle_soon(self) -> None:
        """Schedule a cycle for a requested transition."""

    def get_rate(self) -> float:
        return self._rate

    def set_rate(self, rate: float) -> Any:
        if rate <= 0:
            return RTC.BAD_PARAMETER
        before, self._rate = self._rate, rate
        for each in list(self._participants):
            if each.rate_changed() != RTC.RTC_OK:
                self._rate = before
                return RTC.RTC_ERROR
        return RTC.RTC_OK

    def add_component(self, component: Any) -> Any:
        if component is None:
            return RTC.BAD_PARAMETER
        handle = component.attach_context(self._objref)
        with self._cycling:
            self._participants.append(Participant(component, handle))
        return RTC.RTC_OK

    def remove_component(self, component: Any) -> Any:
        found = self._find(component)
        if found is None:
            return RTC.BAD_PARAMETER
        with self._cycling:
            self._participants.remove(found)
        component.detach_context(found.handle)
        return RTC.RTC_OK

    def _find(self, component: Any) -> Participant | None:
        if component is None:
            return None
        for each in list(self._participants):
            if each.component._is_equivalent(component):
                return each
        return None

    def activate_component(self, component: Any) -> Any:
        return self._transition(
            component, RTC.INACTIVE_STATE, RTC.ACTIVE_STATE, "activation"
        )

    def deactivate_component(self, component: Any) -> Any:
        return self._transition(
            component, RTC.ACTIVE_STATE, RTC.INACTIVE_STATE, "deactivation"
        )

    def reset_component(self, component: Any) -> Any:
        return self._transition(component, RTC.ERROR_STATE, RTC.INACTIVE_STATE, "reset")

    def _transition(self, component: Any, old: Any, new: Any, kind: str) -> Any:
        found = self._find(component)
        if found is None:
            return RTC.BAD_PARAMETER
        if found.state != old:
            return RTC.PRECONDITION_NOT_MET
        found.ask(new)
        if not toBool(self._setting("sync", "transition", kind), "YES", "NO", True):
            return RTC.RTC_OK
        self._cycle_soon()
        limit = float(self._setting("transition", "timeout", kind) or "0.5")
        end = time.monotonic() + limit
        while found.state == old and time.monotonic() < end:
            time.sleep(1.0 / self._rate)
        if found.state == old:
            return RTC.RTC_ERROR
        # The transition may have failed, and the next cycle have passed, meanwhile.
        failed = found.state == RTC.ERROR_STATE
        return RTC.PRECONDITION_NOT_MET if failed else RTC.RTC_OK

    def _setting(self, first: str, second: str, kind: str) -> str:
        """Return a setting such as `transition_timeout`, by the kind of transition if it is set."""
        own = f"sync_{kind}" if first == "sync" else f"{kind}_timeout"
        return self._properties.getProperty(own) or self._properties.getProperty(
            f"{first}_{second}"
        )

    def get_component_state(self, component: Any) -> Any:
        found = self._find(component)
        return RTC.CREATED_STATE if found is None else found.state

    def get_kind(self) -> Any:
        return RTC.PERIODIC

    def get_profile(self) -> Any:
        return RTC.ExecutionContextProfile(
            RTC.PERIODIC,
            self._rate,
            self._owner,
            [
                each.component._narrow(RTC.RTObject)
                for each in self._participants
                if not self._owner._is_equivalent(each.component)
            ],
            list_of(self._properties),
        )

    def exit(self) -> None:
        """Deactivate all active participants, then end the context."""
        with self._cycling:
            for each in self._participants:
                if each.state == RTC.ACTIVE_STATE:
                    each.actions.on_deactivated(each.handle)
                each.state = RTC.INACTIVE_STATE

    def close(self) -> None:
        if self._running:
            self.stop()
        orb.poa().deactivate_object(orb.poa().servant_to_id(self))


class PeriodicExecutionContext(ExecutionContextBase, RTC__POA.ExecutionContextService):
    """A thread; after each cycle it sleeps for the rest of the period."""

    def __init__(self, properties: Properties) -> None:
        super().__init__(properties)
        self._thread: threading.Thread | None = None

    def _started(self) -> None:
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while self._running:
            begun = time.monotonic()
            self.cycle()
            rest = begun + 1.0 / self._rate - time.monotonic()
            if rest > 0:
                time.sleep(rest)

    def _stopped(self) -> None:
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()


class ExtTrigExecutionContext(
    ExecutionContextBase, OpenRTM__POA.ExtTrigExecutionContextService
):
    """A cycle for each `tick`, and for each requested transition.

    OpenRTM's has a thread that is woken by `tick`; here the cycle is over when `tick` returns.
    """

    def tick(self) -> None:
        if self._running:
            self.cycle()

    def _cycle_soon(self) -> None:
        self.tick()


CONTEXTS = {
    "PeriodicExecutionContext": PeriodicExecutionContext,
    "ExtTrigExecutionContext": ExtTrigExecutionContext,
}
