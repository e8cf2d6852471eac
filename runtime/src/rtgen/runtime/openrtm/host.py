"""Runs a behaviour as an OpenRTM component: OpenRTM's callbacks drive the runtime's life cycle."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from rtgen.runtime.errors import ConfigurationError
from rtgen.runtime.failures import log
from rtgen.runtime.openrtm.contexts import HostContext, MachineClock
from rtgen.runtime.openrtm.following import Follower
from rtgen.runtime.openrtm.ports import Inflow, Outflow
from rtgen.runtime.openrtm.starting import log_to_manager
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_ERROR,
    RTC_OK,
    ExecutionKind,
    LifeCycleState,
)
from rtgen.runtime.rtc.component import FIRST_FOREIGN_HANDLE, Component
from rtgen.runtime.rtc.life_cycle import Request
from rtgen.runtime.rtc.participant import Participant

_T = TypeVar("_T")

_TRANSITION_TIMEOUT = 0.3
"""Time-out of a callback that waits for a transition [s]; OpenRTM's is 0.5 s."""

FOLDER = "rtgen.folder"
"""Component property: the folder against which relative file names are resolved."""


class Host:
    """Runs a behaviour in an OpenRTM component.

    The life cycle is that of the embedded runtime (`docs/life-cycle.md`), in the order of OMG RTC
    1.0: OpenRTM's calls of `onDeactivated` on the way to ERROR, and of `onAborting`, which was
    already called, are not forwarded. A long transition continues after OpenRTM has completed it;
    state changes by the behaviour itself are requested from OpenRTM.
    """

    def __init__(self, rtc: Any, factory: Callable[[str], Component]) -> None:
        """Initialize with OpenRTM's component; `factory` makes a behaviour for an instance name."""
        self._rtc = rtc
        self._factory = factory
        self._codes = import_module("RTC")
        self._wire: Any = import_module("rtgen.runtime.openrtm.wire")
        self._behaviour: Component | None = None
        self._participants: dict[int, Participant] = {}
        self._unapplied = False
        self._has_executed = True
        """Whether the tick in progress has executed the behaviour."""
        self._follower: Follower | None = None
        self._consumers: dict[tuple[str, str], Callable[[], Any]] = {}

    # Construction, in the component's onInitialize

    def begin(self) -> Host:
        """Construct the behaviour, once the component has its instance name."""
        log_to_manager()
        component = self._factory(self._rtc.getInstanceName())
        component._join(MachineClock())
        folder = self._rtc.getProperties().getProperty(FOLDER)
        if folder:
            component.folder = Path(folder)
        self._behaviour = component
        self._follower = Follower(
            component, self._participants, self._context, self._rtc
        )
        return self

    @property
    def behaviour(self) -> Component:
        """The behaviour. Raises RuntimeError before `begin`."""
        if self._behaviour is None:
            raise RuntimeError("the component is not initialized")
        return self._behaviour

    def parameter(self, name: str) -> Callable[[Any, str], tuple[bool, Any]]:
        """Return the converter of a parameter for `bindParameter`.

        An invalid text leaves the old value unchanged, and is logged. The behaviour gets the new
        value in its next callback.
        """
        sets = self.behaviour.configuration_sets

        def convert(old: _T, text: str) -> tuple[bool, _T]:
            try:
                value: _T = sets.value(name, text)
                sets.set(name, text)
            except ConfigurationError as error:
                log.warning("%s: %s", self.behaviour.instance_name, error)
                return True, old
            self._unapplied = True
            return True, value

        return convert

    def in_port(self, name: str, port: Any, datum: Any) -> None:
        """Connect an InPort of the behaviour; `datum` is a wire object of its type."""
        target = self.behaviour.in_ports[name]
        Inflow(target, port, datum, self._wire.conversions_of(target.type._descriptor_))

    def out_port(self, name: str, port: Any, datum: Any) -> None:
        """Connect an OutPort of the behaviour.

        Its samples are sent as `datum`, filled with them, or as new wire objects.
        """
        source = self.behaviour.out_ports[name]
        Outflow(
            source, port, datum, self._wire.conversions_of(source.type._descriptor_)
        )

    def servant(self, port: str, instance: str) -> Any:
        """Return an invoker that calls the behaviour's provider, while it is ACTIVE."""
        return self._wire.invoker_of_provider(self.behaviour.providers[port, instance])

    def consumer(self, port: str, instance: str, consumer: Any) -> None:
        """Connect a consumer of the behaviour to OpenRTM's; see `RemoteProvider`."""
        inner = self.behaviour.consumers[port, instance]

        def reference() -> Any:
            return consumer._ptr(True)

        inner._provider = self._wire.RemoteProvider(inner, reference)
        self._consumers[port, instance] = reference

    def service_port(self, name: str, port: Any) -> None:
        """Log a warning for each consumer that a connection of the port leaves unconnected.

        OpenRTM returns RTC_OK for such a connection, for instance if type names differ by a scope.
        """

        def connected(profile: Any) -> None:
            empty = [
                consumer
                for key, consumer in self.behaviour.consumers.items()
                if key[0] == name and self._consumers[key]() is None
            ]
            for consumer in empty:
                offered = [
                    each.name.partition(".provided.")[2]
                    for each in profile.properties
                    if ".provided." in each.name
                ]
                log.warning(
                    "%s: the connection %r has no provider for it; it offers %s",
                    consumer,
                    profile.name,
                    ", ".join(offered) or "none",
                )

        port.setOnConnected(connected)

    # OpenRTM's callbacks

    def on_initialize(self) -> Any:
        """`onInitialize`, after all ports and parameters are bound: CREATED to INACTIVE."""
        behaviour = self.behaviour
        behaviour._run_deferred_calls()
        behaviour._last_code = RTC_OK
        return self._code(behaviour.initialize() is not RTC_OK)

    def on_finalize(self) -> Any:
        """`onFinalize`: leave all contexts, deactivating if necessary, and finalize."""
        if self._follower is not None:
            self._follower.end()
        behaviour = self._behaviour
        if behaviour is None or not behaviour.is_alive():
            return self._codes.RTC_OK
        with behaviour._lock:
            behaviour._last_code = RTC_OK
            return self._code(behaviour.exit() is not RTC_OK)

    def on_startup(self, ec_id: int) -> Any:
        """`onStartup`."""
        return self._started(ec_id, True, Request.STARTUP)

    def on_shutdown(self, ec_id: int) -> Any:
        """`onShutdown`; a component that has ended was notified before."""
        return self._started(ec_id, False, Request.SHUTDOWN)

    def on_activated(self, ec_id: int) -> Any:
        """`onActivated`; RTC_OK also if the transition takes longer, and may fail later."""
        return self._requested(ec_id, Request.ACTIVATE, ACTIVE_STATE)

    def on_deactivated(self, ec_id: int) -> Any:
        """`onDeactivated`; ignored on the way to ERROR. Ends the wait for an activation."""
        return self._requested(ec_id, Request.DEACTIVATE, INACTIVE_STATE)

    def on_reset(self, ec_id: int) -> Any:
        """`onReset`; the component stays in ERROR unless the result is RTC_OK."""
        return self._requested(ec_id, Request.RESET, INACTIVE_STATE)

    def on_aborting(self, ec_id: int) -> Any:
        """`onAborting`; the behaviour's callback was called at the transition."""
        self._started_follower.states[ec_id] = ERROR_STATE
        return self._codes.RTC_OK

    def on_execute(self, ec_id: int) -> Any:
        """`onExecute`."""
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            self._apply()
            if participant.state is not ERROR_STATE:
                if not participant.carry_out_requests() and self._is_due():
                    participant.execute()
                if participant.state is not ERROR_STATE:
                    return self._codes.RTC_OK
            participant.finish()
            return self._code(True)

    def on_state_update(self, ec_id: int) -> Any:
        """`onStateUpdate`, and the end of the tick."""
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            if self._has_executed:
                participant.update()
            return self._ended(ec_id, participant)

    def _is_due(self) -> bool:
        """Return whether to execute the behaviour: an event-driven one needs a sample."""
        behaviour = self.behaviour
        kind = behaviour.profile.kind_of_context
        self._has_executed = kind is not ExecutionKind.EVENT_DRIVEN or any(
            port.is_new() for port in behaviour._triggers()
        )
        return self._has_executed

    def on_error(self, ec_id: int) -> Any:
        """`onError`."""
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            self._apply()
            participant.carry_out_requests()
            if participant.state is ERROR_STATE:
                participant.execute()
            participant.finish()
            self._started_follower.look(ec_id)
            return self._code(self.behaviour._last_code is not RTC_OK)

    def on_rate_changed(self, ec_id: int) -> Any:
        """`onRateChanged`; forwarded at the next tick if there is one, else immediately."""
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            participant.request(Request.RATE_CHANGE)
            if participant.state is not INACTIVE_STATE:
                return self._codes.RTC_OK
            participant.carry_out_requests()
            return self._ended(ec_id, participant)

    # Life cycle

    def _participant(self, ec_id: int) -> Participant:
        """Return the behaviour's participant in a context of OpenRTM."""
        member = self._participants.get(ec_id)
        if member is not None:
            return member
        behaviour = self.behaviour
        context = HostContext(
            lambda: self._context(ec_id),
            behaviour if ec_id < FIRST_FOREIGN_HANDLE else None,
            self._started_follower.wake,
        )
        if context.add_component(behaviour) is not RTC_OK:
            raise RuntimeError(f"{behaviour.instance_name} is not alive")
        participant = context.participants[0]
        # Handles are OpenRTM's, in any order of its contexts.
        behaviour._contexts[ec_id] = behaviour._contexts.pop(participant.handle)
        participant.handle = ec_id
        self._participants[ec_id] = participant
        return participant

    @contextmanager
    def _turn(self, ec_id: int) -> Iterator[Participant | None]:
        """Acquire the behaviour's lock; yields its participant, without a failed callback.

        None for a behaviour that has ended: OpenRTM stops the context of a component later.
        """
        behaviour = self.behaviour
        with behaviour._lock:
            behaviour._last_code = RTC_OK
            yield self._participant(ec_id) if behaviour.is_alive() else None

    @property
    def _started_follower(self) -> Follower:
        if self._follower is None:
            raise RuntimeError("the component is not initialized")
        return self._follower

    def _context(self, ec_id: int) -> Any:
        return self._rtc.get_context(ec_id)

    def _started(self, ec_id: int, running: bool, request: Request) -> Any:
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            assert isinstance(participant.context, HostContext)
            participant.context.set_running(running)
            participant.carry_out(request)
            self._started_follower.look(ec_id)
            return self._code(self.behaviour._last_code is not RTC_OK)

    def _requested(self, ec_id: int, request: Request, goal: LifeCycleState) -> Any:
        """Execute a transition made by OpenRTM; waits for a while if it takes time."""
        follower = self._started_follower
        with self._turn(ec_id) as participant:
            if participant is None:
                return self._codes.RTC_OK
            if (
                request is Request.DEACTIVATE
                and Request.ACTIVATE in participant._requests
            ):
                participant._requests.remove(Request.ACTIVATE)
            self._apply()
            follower.states[ec_id] = goal
            participant.request(request)
            participant.carry_out_requests()
            end = time.monotonic() + _TRANSITION_TIMEOUT
            while participant._requests and time.monotonic() < end:
                time.sleep(0.001)
                participant.carry_out_requests()
            code = self._ended(ec_id, participant)
            if request is Request.RESET and code != self._codes.RTC_OK:
                follower.states[ec_id] = ERROR_STATE
        return code

    def _ended(self, ec_id: int, participant: Participant) -> Any:
        """End a tick: RTC_OK unless the behaviour is, and remains, in ERROR."""
        participant.finish()
        self._started_follower.look(ec_id)
        return self._code(
            participant.state is ERROR_STATE
            and Request.RESET not in participant._requests
        )

    def _apply(self) -> None:
        """Copy parameters set by OpenRTM to the configuration object."""
        if self._unapplied:
            self._unapplied = False
            self.behaviour.configuration_sets.apply()

    def _code(self, failed: bool) -> Any:
        """Return OpenRTM's return code; after a failure, the behaviour's, if it returned one."""
        if not failed:
            return self._codes.RTC_OK
        code = self.behaviour._last_code
        return getattr(self._codes, (RTC_ERROR if code is RTC_OK else code).name)
