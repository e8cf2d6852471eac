"""Execution contexts (OMG RTC 1.0, 5.2.2.6): ticks, and operations on participants."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from rtgen.runtime.errors import RateError
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    UNSUPPORTED,
    ExecutionKind,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.life_cycle import Request
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.timing.clocks import period_of

_Around = Callable[[Callable[[], None]], Callable[[], None]]


class Driver(Protocol):
    """The scheduler of a context: calls `cycle` and is notified of changes."""

    def started(self, context: ExecutionContext) -> None: ...

    def stopped(self, context: ExecutionContext) -> bool:
        """Wait until no tick is in progress (unless called from the tick itself).

        False if a tick does not end in time; no further callback of its components is called
        then.
        """

    def rate_changed(self, context: ExecutionContext) -> None: ...

    def cycle_changed(self, context: ExecutionContext) -> None: ...

    def woken(self, context: ExecutionContext) -> None:
        """Request a call of `between_ticks` soon, in the thread of the ticks."""


class Undriven:
    """A scheduler without effect: `ExecutionContext.tick` is called explicitly."""

    def started(self, context: ExecutionContext) -> None:
        return None

    def stopped(self, context: ExecutionContext) -> bool:
        return True

    def rate_changed(self, context: ExecutionContext) -> None:
        return None

    def cycle_changed(self, context: ExecutionContext) -> None:
        return None

    def woken(self, context: ExecutionContext) -> None:
        return None


StateListener = Callable[[Participant, LifeCycleState, LifeCycleState], None]
"""Called with a participant, its former state and its state."""


class ExecutionContext:
    """An execution context (OMG RTC 1.0, 5.2.2.6), of PERIODIC kind by default.

    One of EVENT_DRIVEN kind calls `on_execute` when samples come at the ports that trigger its
    participants, not in its ticks: these serve requests, configuration and `on_error`.

    Activation, deactivation, reset and rate change are requests: they return immediately and are
    executed at the next tick, so that callbacks only run within ticks. Each phase of a tick
    runs for all participants before the next: requests, `on_execute` (or `on_error`),
    `on_state_update`, and deferred work at the end of the cycle.
    """

    def __init__(
        self,
        rate_hz: float = 1000.0,
        *,
        owner: Component | None = None,
        kind: ExecutionKind = ExecutionKind.PERIODIC,
        driver: Driver | None = None,
        listener: StateListener | None = None,
        has_own_thread: bool = False,
    ) -> None:
        self.owner = owner
        self.overruns = 0
        """Times (real time) without a tick because the previous one was still running."""
        self.longest = 0
        """The longest tick so far in ns, updated at an overrun."""
        self.causes: dict[str, int] = {}
        """Overruns by the context whose tick took the time; empty: the machine, `*`: all."""
        self.has_own_thread = has_own_thread
        """Whether it ticks (real time) in a thread of its own, from its next start on."""
        self.cycle: Callable[[], None] = self._cycle_of_all
        """One tick, whether or not the context is running; called by the scheduler."""
        self._rate = _checked_rate(rate_hz)
        self._kind = kind
        self._running = False
        self._driver: Driver = driver or Undriven()
        self._listener = listener
        self._participants: tuple[Participant, ...] = ()
        self._around: tuple[_Around, ...] = ()

    @property
    def period(self) -> int:
        """The period in whole nanoseconds."""
        return period_of(self._rate)

    @property
    def participants(self) -> tuple[Participant, ...]:
        """The participants, in the order in which they were added."""
        return self._participants

    def tick(self) -> ReturnCode_t:
        """Execute one tick in a context without a scheduler. PRECONDITION_NOT_MET if stopped.

        Re-raises a KeyboardInterrupt of a callback after the tick.
        """
        if not self._running:
            return PRECONDITION_NOT_MET
        self.cycle()
        for participant in self._participants:
            component = participant.component
            error, component._interrupt = component._interrupt, None
            if error is not None:
                raise error
        return RTC_OK

    def put_around_ticks(self, around: _Around) -> Callable[[], None]:
        """Let a function wrap what is called for each tick, until the result is called."""
        self._around = (*self._around, around)
        self._choose_cycle()

        def remove() -> None:
            self._around = tuple(each for each in self._around if each is not around)
            self._choose_cycle()

        return remove

    def wake(self) -> None:
        """Let the participants process external input, without waiting for a tick.

        Callable from any thread. Without a scheduler this happens at the next tick.
        """
        if self._running:
            self._driver.woken(self)

    def between_ticks(self) -> None:
        """Do the work requested by `wake`; called by the scheduler, never during a tick."""
        again = False
        for participant in self._participants:
            with participant.component._lock:
                participant.arrive()
                if self.is_event_driven and participant.take_samples():
                    again = True
        if again:
            self.wake()

    @property
    def is_event_driven(self) -> bool:
        """Whether samples execute the participants."""
        return self._kind is ExecutionKind.EVENT_DRIVEN

    def is_running(self) -> bool:
        """Return whether the context is started."""
        return self._running

    def start(self) -> ReturnCode_t:
        """Start: call every `on_startup`, then start ticks. PRECONDITION_NOT_MET if running."""
        if self._running:
            return PRECONDITION_NOT_MET
        for participant in self._participants:
            participant.carry_out(Request.STARTUP)
        self._running = True
        self._driver.started(self)
        return RTC_OK

    def stop(self) -> ReturnCode_t:
        """Stop: end the ticks, then call every `on_shutdown`; states are kept.

        PRECONDITION_NOT_MET if stopped; RTC_ERROR, without `on_shutdown`, if a tick does not end.
        """
        if not self._running:
            return PRECONDITION_NOT_MET
        self._running = False
        if not self._driver.stopped(self):
            return RTC_ERROR
        for participant in self._participants:
            participant.carry_out(Request.SHUTDOWN)
        return RTC_OK

    def get_rate(self) -> float:
        """Return the rate in Hz."""
        return self._rate

    def set_rate(self, rate: float) -> ReturnCode_t:
        """Set the rate in Hz; `on_rate_changed` follows at the next tick.

        The next tick is one new period after the last, or now if that has passed. BAD_PARAMETER for
        a rate that is not above 0, UNSUPPORTED for a context that is not of PERIODIC kind.
        """
        if self._kind is not ExecutionKind.PERIODIC:
            return UNSUPPORTED
        if not _is_rate(rate):
            return BAD_PARAMETER
        self._rate = float(rate)
        for participant in self._participants:
            participant.request(Request.RATE_CHANGE)
        self._driver.rate_changed(self)
        return RTC_OK

    def get_kind(self) -> ExecutionKind:
        """Return the kind."""
        return self._kind

    def add_component(self, component: Component) -> ReturnCode_t:
        """Add an INACTIVE participant; `on_startup` follows if the context is running.

        PRECONDITION_NOT_MET if it is not initialized, or already participates.
        """
        if not component.is_alive() or self._find(component) is not None:
            return PRECONDITION_NOT_MET
        participant = Participant(component, self)
        if self._running:
            participant.carry_out(Request.STARTUP)
        self._set_participants((*self._participants, participant))
        return RTC_OK

    def remove_component(self, component: Component) -> ReturnCode_t:
        """Remove a participant, after `on_shutdown` if the context is running.

        BAD_PARAMETER if it does not participate, PRECONDITION_NOT_MET while it is ACTIVE.
        """
        participant = self._find(component)
        if participant is None:
            return BAD_PARAMETER
        if participant.state is ACTIVE_STATE:
            return PRECONDITION_NOT_MET
        self._set_participants(
            tuple(p for p in self._participants if p is not participant)
        )
        if self._running:
            participant.carry_out(Request.SHUTDOWN)
        return component.detach_context(participant.handle)

    def activate_component(self, component: Component) -> ReturnCode_t:
        """Request ACTIVE. BAD_PARAMETER: no participant; PRECONDITION_NOT_MET: not INACTIVE."""
        return self._request(component, Request.ACTIVATE)

    def deactivate_component(self, component: Component) -> ReturnCode_t:
        """Request INACTIVE. BAD_PARAMETER: no participant; PRECONDITION_NOT_MET: not ACTIVE."""
        return self._request(component, Request.DEACTIVATE)

    def reset_component(self, component: Component) -> ReturnCode_t:
        """Request INACTIVE. BAD_PARAMETER: no participant; PRECONDITION_NOT_MET: not in ERROR."""
        return self._request(component, Request.RESET)

    def fail_component(self, component: Component, reason: str) -> ReturnCode_t:
        """Request ERROR, for a reason outside of the callbacks.

        BAD_PARAMETER: no participant; PRECONDITION_NOT_MET: already in ERROR.
        """
        participant = self._find(component)
        return BAD_PARAMETER if participant is None else participant.fail(reason)

    def get_component_state(self, component: Component) -> LifeCycleState:
        """Return the component's state here; CREATED if it does not participate."""
        participant = self._find(component)
        return CREATED_STATE if participant is None else participant.state

    def _request(self, component: Component, request: Request) -> ReturnCode_t:
        participant = self._find(component)
        return BAD_PARAMETER if participant is None else participant.request(request)

    def _find(self, component: Component) -> Participant | None:
        participants = (p for p in self._participants if p.component is component)
        return next(participants, None)

    def _expel(self, component: Component) -> bool:
        """Remove a participant in any state, for a component that exits.

        A context that the component owns stops for all. False if a tick of the context does not
        end: no further callback is called then.
        """
        participant = self._find(component)
        if participant is None:
            return True
        leaving: tuple[Participant, ...] = (participant,)
        if was_running := self._running and component is self.owner:
            leaving = self._participants
            self._running = False
            if not self._driver.stopped(self):
                return False
        with component._lock:
            if participant.state is ACTIVE_STATE:
                participant.carry_out(Request.DEACTIVATE)
            if was_running or self._running:
                for one in leaving:
                    one.carry_out(Request.SHUTDOWN)
            self._set_participants(
                tuple(p for p in self._participants if p is not participant)
            )
            component.detach_context(participant.handle)
        return True

    def _notify(
        self, participant: Participant, before: LifeCycleState, now: LifeCycleState
    ) -> None:
        if self._listener is not None:
            self._listener(participant, before, now)

    def _set_participants(self, participants: tuple[Participant, ...]) -> None:
        for participant in {*self._participants, *participants}:
            if self.is_event_driven:
                self._listen(participant.component, participant in participants)
        self._participants = participants
        contexts = {
            id(context): context
            for participant in participants
            for context in participant.component._contexts.values()
        }
        for context in [self, *contexts.values()]:
            if isinstance(context, ExecutionContext):
                context._choose_cycle()

    def _listen(self, component: Component, listens: bool) -> None:
        others = tuple(c for c in component._event_contexts if c is not self)
        component._event_contexts = (*others, self) if listens else others
        if component._event_contexts:
            for port in component._triggers():
                port.call_on_arrival(component._sample_came)

    def _choose_cycle(self) -> None:
        sole = self._participants[0] if len(self._participants) == 1 else None
        if self.is_event_driven:
            self.cycle = self._cycle_between_samples
        elif sole is not None and len(sole.component._contexts) == 1:
            self.cycle = sole.cycle
        else:
            self.cycle = self._cycle_of_all
        for around in self._around:
            self.cycle = around(self.cycle)
        self._driver.cycle_changed(self)

    def _cycle_between_samples(self) -> None:
        for participant in self._participants:
            with participant.component._lock:
                before = participant.state
                if not participant.carry_out_requests():
                    if participant.state is ERROR_STATE:
                        participant.execute()
                    elif participant.state is not before and participant.take_samples():
                        self.wake()
                participant.finish()

    def _cycle_of_all(self) -> None:
        going_on = []
        for participant in self._participants:
            with participant.component._lock:
                if not participant.carry_out_requests():
                    going_on.append(participant)
        for phase in (Participant.execute, Participant.update):
            for participant in going_on:
                with participant.component._lock:
                    phase(participant)
        for participant in self._participants:
            with participant.component._lock:
                participant.finish()


def _is_rate(rate: float) -> bool:
    return math.isfinite(rate) and rate > 0.0


def _checked_rate(rate: float) -> float:
    if not _is_rate(rate):
        raise RateError(f"the rate {rate!r} must be a number of Hz above 0")
    return float(rate)
