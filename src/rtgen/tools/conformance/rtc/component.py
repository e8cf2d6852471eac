"""The component under test: its objects, and how it was found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from time import monotonic, sleep
from typing import Any, ClassVar

from omniORB import CORBA

from rtgen.facts.openrtm_ports import RUNTIME
from rtgen.runtime.corba.faults import is_timeout
from rtgen.runtime.corba.rt_objects.objects import CallError, Exported
from rtgen.runtime.corba.rt_objects.remote import FAULTS, NilError, RemoteRtc
from rtgen.runtime.corba.rt_objects.wire import NotAvailable, SdoError, texts
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_ERROR,
    RTC_OK,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.tools.conformance.check import SkipError
from rtgen.tools.conformance.rtc.expected import Expected

_POLL_INTERVAL = 0.01
CONNECTOR = "rtgen-conformance-"
"""Prefix of the ids of connectors that checks create."""
UNKNOWN = "rtgen-conformance-unknown"
"""A name that no set, parameter or connector has."""


@dataclass(frozen=True, slots=True)
class Condition:
    """State that checks may change: life cycle, whether the context runs, its rate, sets."""

    state: LifeCycleState
    running: bool
    rate: float
    active: str
    sets: Mapping[str, Mapping[str, str]]


class RtcUnderTest(RemoteRtc):
    """A running component. Methods raise omniORB's exceptions and CallError.

    `timeout` is the time-out for reaching a state, in seconds.
    """

    faults: ClassVar[tuple[type[Exception], ...]] = FAULTS

    def __init__(
        self, expected: Expected, reference: Any, exported: Exported, timeout: float
    ) -> None:
        super().__init__(reference, exported)
        self.expected = expected
        self._timeout = timeout
        self.profile = self.read_profile()
        self.before: Condition | None = None
        """The condition that `restore` restores, set by `keep`."""
        self.pending: tuple[str, LifeCycleState] | None = None
        """A request that was accepted and has not taken effect in time, and its state."""

    def explained(self, fault: Exception) -> str:
        """See `Subject`."""
        if isinstance(fault, SdoError):
            return f"{type(fault).__name__}: {fault.description}"
        if isinstance(fault, CallError | SkipError):
            return str(fault)
        return f"a call has failed: {fault!r}"

    @property
    def context(self) -> Any:
        """The first context that the component owns. Raises SkipError."""
        try:
            return super().context
        except NilError as error:
            raise SkipError(str(error)) from error

    @property
    def is_of_rtgen(self) -> bool:
        """Whether the component is run by rtgen, not by OpenRTM."""
        return RUNTIME in texts(self.profile.properties)

    def active_set(self) -> str:
        """Return the id of the active set; empty if none, as in OpenRTM after setting a value."""
        try:
            return super().active_set()
        except NotAvailable:
            return ""

    # States

    def becomes(self, state: LifeCycleState) -> bool:
        """Return whether the component reaches a state in time."""
        return self._until(lambda: self.state() is state)

    def remains(self, state: LifeCycleState, ticks: int) -> bool:
        """Return whether the component keeps a state for some ticks, within the time-out."""
        rate = self.ask(self.context, "get_rate")
        seconds = ticks / rate if rate > 0 else self._timeout
        return not self._until(
            lambda: self.state() is not state, min(seconds, self._timeout)
        )

    def _until(
        self, condition: Callable[[], bool], seconds: float | None = None
    ) -> bool:
        end = monotonic() + (self._timeout if seconds is None else seconds)
        while not condition():
            if monotonic() > end:
                return False
            sleep(_POLL_INTERVAL)
        return True

    def ends(self) -> bool:
        """Return whether it is gone in time: its reference is invalid, or it is not alive."""
        return self._until(self._is_gone)

    def is_alive(self) -> bool:
        """Return whether it is alive, in its own first context if it has one."""
        return bool(self.call("is_alive", next(iter(self.contexts), None)))

    def _is_gone(self) -> bool:
        try:
            return not self.is_alive()
        except CORBA.SystemException:
            return True

    def is_running(self) -> bool:
        """Return whether its context runs. Raises SkipError."""
        return bool(self.ask(self.context, "is_running"))

    def inactive(self) -> Any:
        """Return the context after making the component INACTIVE. Raises SkipError."""
        context = self.context
        if not self.is_running():
            raise SkipError("its execution context does not run")
        state = self.state()
        if state is ERROR_STATE:
            raise SkipError("it is in ERROR, and stays there")
        if state is ACTIVE_STATE and self.pending is None:
            self.request("deactivate_component", INACTIVE_STATE)
        if self.pending is not None:
            raise SkipError(f"{self.pending[0]} has not taken effect")
        return context

    def request(self, operation: str, state: LifeCycleState) -> ReturnCode_t:
        """Request a state of the context, and wait for it; the request is `pending` until then."""
        try:
            code: ReturnCode_t = self.ask(self.context, operation, self.reference)
        except CORBA.SystemException as error:
            if is_timeout(error):
                self.pending = operation, state
            raise
        if code in (RTC_OK, RTC_ERROR):  # the latter from OpenRTM if it takes long
            ended = self.becomes(state) or self.state() is ERROR_STATE
            self.pending = None if ended else (operation, state)
        return code

    # Restoring

    def keep(self) -> None:
        """Record the state that checks may change."""
        self.before = self._condition()

    def _condition(self) -> Condition:
        context = self.context
        return Condition(
            self.state(),
            bool(self.ask(context, "is_running")),
            self.ask(context, "get_rate"),
            self.active_set(),
            self.sets(),
        )

    def restore(self) -> Iterator[str | None]:
        """Undo the changes of checks; yield the problem of each part, or None."""
        if self.before is None:
            return
        for part in (
            self._restore_connectors,
            self._restore_values,
            self._restore_active_set,
            self._restore_rate,
            self._restore_running,
            self._restore_state,
        ):
            try:
                yield part(self.before)
            except (*FAULTS, SkipError) as fault:
                yield self.explained(fault)

    def _restore_connectors(self, before: Condition) -> str | None:
        """End the remaining connections that checks have made."""
        stands = []
        for port in self.profile.port_profiles:
            for name in self._own_connectors(port):
                self.at_port(port, "disconnect", name)
            stands += self._own_connectors(port)
        return f"connectors remain: {', '.join(stands)}" if stands else None

    def _own_connectors(self, port: Any) -> list[str]:
        """Return the ids of a port's connectors that checks have made."""
        profiles = self.at_port(port, "get_connector_profiles")
        names = [each.connector_id for each in profiles]
        return [name for name in names if name.startswith(CONNECTOR)]

    def _restore_values(self, before: Condition) -> str | None:
        now = self.sets()
        for set_id, values in before.sets.items():
            for name, text in values.items():
                if now.get(set_id, {}).get(name) != text:
                    self.set_value(set_id, name, text)
        now = self.sets()
        same = now == before.sets
        return None if same else f"its values are {now}, they were {before.sets}"

    def _restore_active_set(self, before: Condition) -> str | None:
        if self.active_set() != before.active:
            self.configure("activate_configuration_set", before.active)
        now = self.active_set()
        same = now == before.active
        return None if same else f"its active set is {now}, it was {before.active}"

    def _restore_rate(self, before: Condition) -> str | None:
        if self.ask(self.context, "get_rate") != before.rate:
            self.ask(self.context, "set_rate", before.rate)
        now = self.ask(self.context, "get_rate")
        return None if now == before.rate else f"its rate is {now}, was {before.rate}"

    def _restore_running(self, before: Condition) -> str | None:
        if bool(self.ask(self.context, "is_running")) is not before.running:
            self.ask(self.context, "start" if before.running else "stop")
        now = bool(self.ask(self.context, "is_running"))
        words = {True: "runs", False: "does not run"}
        same = now is before.running
        return None if same else f"its context {words[now]} now"

    def _restore_state(self, before: Condition) -> str | None:
        if self.pending is not None:
            operation, target = self.pending
            if not self.becomes(target):
                now = self.state().name
                return f"it is {now}, and {operation} may take effect later"
            self.pending = None
        state = self.state()
        if state is not before.state:
            if state is ERROR_STATE:
                self.ask(self.context, "reset_component", self.reference)
                self.becomes(INACTIVE_STATE)
            is_active = before.state is ACTIVE_STATE
            change = "activate_component" if is_active else "deactivate_component"
            if self.state() is not before.state:
                self.request(change, before.state)
        state = self.state()
        same = state is before.state
        return None if same else f"it is {state.name}, and was {before.state.name}"
