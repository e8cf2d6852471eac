"""A component in an execution context: its state, and its part in each tick (OMG RTC 1.0)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from rtgen.runtime.errors import EndOfRunError
from rtgen.runtime.failures import encodable, log
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_OK,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.callbacks import is_ok, note_answer, note_exception, succeeds
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.context_operations import ExecutionContextOperations
from rtgen.runtime.rtc.life_cycle import GATED, TRANSITIONS, Request


class ParticipantContext(ExecutionContextOperations, Protocol):
    """The members of a context that a participant and its observers use."""

    overruns: int

    def _notify(
        self, participant: Any, before: LifeCycleState, now: LifeCycleState
    ) -> None: ...


_GOALS = {Request.ACTIVATE: ACTIVE_STATE, Request.DEACTIVATE: INACTIVE_STATE}


def _nobody() -> str:
    return ""


class Participant:
    """A component in a context: its state there, and the requests for the next tick."""

    __slots__ = (
        "_deferred_calls",
        "_failure",
        "_requests",
        "_updates",
        "activating",
        "component",
        "context",
        "handle",
        "provider_awaited",
        "state",
        "ticks",
    )

    def __init__(self, component: Component, context: ParticipantContext) -> None:
        self.component = component
        self.context = context
        self.handle = component.attach_context(context)
        self.state = INACTIVE_STATE
        self.ticks = 0
        """Number of calls of `on_execute`."""
        self.activating = False
        """Whether ACTIVATE was requested and is still pending."""
        self.provider_awaited: Callable[[], str] = _nobody
        """The component that must be activated before this one; empty if none."""
        self._requests: deque[Request] = deque()
        self._failure = ""
        self._deferred_calls = component._deferred_calls
        own = getattr(component.on_state_update, "__func__", None)
        self._updates = own is not Component.on_state_update

    def request(self, request: Request) -> ReturnCode_t:
        """Queue a legal request for the next tick; PRECONDITION_NOT_MET for an illegal one."""
        if (self.state, request) not in TRANSITIONS:
            return PRECONDITION_NOT_MET
        if request not in self._requests:
            self._requests.append(request)
        if request is Request.ACTIVATE:
            self.activating = True
        return RTC_OK

    def fail(self, reason: str) -> ReturnCode_t:
        """Queue FAIL for the next tick with its reason; the first reason is kept."""
        if (self.state, Request.FAIL) not in TRANSITIONS:
            return PRECONDITION_NOT_MET
        if Request.FAIL not in self._requests:
            self._failure = encodable(reason)
        return self.request(Request.FAIL)

    def cycle(self) -> None:
        """Execute a complete tick of a context with a single participant."""
        if not (self._requests and self.carry_out_requests()):
            if self.state is ACTIVE_STATE:
                self.ticks += 1
                try:
                    code = self.component.on_execute(self.handle)
                except EndOfRunError:
                    return
                except BaseException as error:
                    note_exception(self.component, "on_execute", error)
                    self.enter(ERROR_STATE)
                else:
                    if code is not RTC_OK and not is_ok(code):
                        note_answer(self.component, "on_execute", code)
                        self.enter(ERROR_STATE)
                    elif self._updates:
                        self.update()
            elif self.state is ERROR_STATE:
                succeeds(self.component, "on_error", self.handle)
        if self._deferred_calls:
            self.component._run_deferred_calls()

    def carry_out_requests(self) -> bool:
        """Execute the first phase of a tick; return True if it led to ERROR, which ends the
        tick.
        """
        before = self.state
        for _ in range(len(self._requests)):
            request = self._requests.popleft()
            if request is Request.ACTIVATE and (awaited := self.provider_awaited()):
                self.component._awaited = f"{awaited} to be activated"
                self._requests.append(request)
            elif request not in GATED or self._passes(request):
                self.carry_out(request)
        return self.state is ERROR_STATE and before is not ERROR_STATE

    def execute(self) -> None:
        """Execute the second phase of a tick."""
        if self.state is ACTIVE_STATE:
            self.ticks += 1
        row = TRANSITIONS.get((self.state, Request.EXECUTE))
        if row is not None and not succeeds(self.component, row.callback, self.handle):
            self.enter(row.failure)

    def update(self) -> None:
        """Execute the third phase of a tick."""
        row = TRANSITIONS.get((self.state, Request.STATE_UPDATE))
        if row is not None and not succeeds(self.component, row.callback, self.handle):
            self.enter(row.failure)

    def arrive(self) -> None:
        """Process external input since the last tick, if the component is ACTIVE."""
        if self.state is not ACTIVE_STATE:
            return
        try:
            self.component._arrived()
        except EndOfRunError:
            return
        except BaseException as error:
            note_exception(self.component, "on_execute", error)
            self.enter(ERROR_STATE)
        self.finish()

    def take_samples(self) -> bool:
        """Execute for samples that have come; return whether to be called again for others.

        It is not if the component has read none of them.
        """
        before = self.component._unread()
        if self.state is not ACTIVE_STATE or not before:
            return False
        self.execute()
        self.update()
        self.finish()
        return 0 < self.component._unread() < before

    def finish(self) -> None:
        """End a tick: deliver deferred samples, apply configuration changes."""
        if self._deferred_calls:
            self.component._run_deferred_calls()

    def carry_out(self, request: Request) -> None:
        """Carry out a legal request; ignore one that has become illegal."""
        row = TRANSITIONS.get((self.state, request))
        if row is None:
            if self.state is _GOALS.get(request):
                return
            name, state = self.component.instance_name, self.state.name
            ignored = "%s: %s is ignored: the state is already %s"
            log.warning(ignored, name, request, state.removesuffix("_STATE"))
            return
        if request is Request.FAIL:
            self.component.reason = self._failure
            log.warning("%s: %s", self.component.instance_name, self._failure)
        done = not row.callback or succeeds(self.component, row.callback, self.handle)
        self.enter(row.success if done else row.failure)
        if request is Request.ACTIVATE:
            self.activating = False

    def enter(self, state: LifeCycleState) -> None:
        """Change the state; call `on_aborting` when entering ERROR."""
        before = self.state
        if state is before:
            return
        self.state = state
        self.component._active_contexts += (state is ACTIVE_STATE) - (
            before is ACTIVE_STATE
        )
        if before is ERROR_STATE:
            self.component.reason = ""
        self.component._awaited = self.component._condition = ""
        self.context._notify(self, before, state)
        if state is ERROR_STATE:
            succeeds(self.component, "on_aborting", self.handle)

    def _passes(self, request: Request) -> bool:
        """Return whether to carry out a gated request now; a waiting one is queued again."""
        if (self.state, request) not in TRANSITIONS:
            return True
        component = self.component
        component._awaited = ""
        if request is Request.ACTIVATE:
            component.configuration_sets.apply()
        try:
            code = component._gate(request)
        except BaseException as error:
            note_exception(component, request, error)
        else:
            if code is None:
                self._requests.append(request)
                return False
            if is_ok(code):
                return True
            note_answer(component, request, code)
        self.enter(ERROR_STATE)
        self.activating = False
        return False
