"""Base class of components (OMG RTC 1.0): callbacks, ports, configuration, contexts."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar, cast

from rtgen.facts.value_checks import CheckValues
from rtgen.runtime.errors import CheckpointError, DuplicatePortError, EndOfRunError
from rtgen.runtime.failures import Failure, described, ends_run, log, log_failure
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import (
    CREATED_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    ReturnCode_t,
)
from rtgen.runtime.rtc.callbacks import succeeds
from rtgen.runtime.rtc.checkpoints import Checkpoint
from rtgen.runtime.rtc.configuration import ConfigurationSets
from rtgen.runtime.rtc.context_operations import ExecutionContextOperations
from rtgen.runtime.rtc.declarations import Declaration, derived_profile
from rtgen.runtime.rtc.life_cycle import TRANSITIONS, Request
from rtgen.runtime.rtc.logs import logger_of
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import Servant
from rtgen.runtime.timing.clocks import SECOND, Clock, SimulatedClock
from rtgen.runtime.timing.traffic import LogLine

if TYPE_CHECKING:
    from rtgen.runtime.timing.simulated_network import SimulatedNetwork

T = TypeVar("T", bound=DataType)
S = TypeVar("S", bound=Servant)
C = TypeVar("C")
P = TypeVar("P")

FIRST_FOREIGN_HANDLE = 1000
"""First handle of contexts that a component does not own, as in OpenRTM."""


class Time(Protocol):
    """The members of `RTC::Time`."""

    sec: int
    nsec: int


class Timed(Protocol):
    """A sample with a time stamp: any struct with a member `tm` of type `RTC::Time`."""

    @property
    def tm(self) -> Time: ...


class Component:
    """Base class of components (OMG RTC 1.0, 5.2.2.2 and 5.3.1) and of their generated bases.

    Every callback returns a `ReturnCode_t`; any value but RTC_OK, including None, and every
    exception counts as a failure. `docs/life-cycle.md` lists the consequences.
    """

    profile: ClassVar[ComponentProfile] = ComponentProfile("Component")
    _declarations: ClassVar[Mapping[str, Declaration]] = {}
    """The ports and the configuration that the class and its bases declare, by attribute."""

    def __init_subclass__(cls, **facts: Any) -> None:
        """Derive the profile; `facts` are members of `ComponentProfile`."""
        super().__init_subclass__()
        bases = (getattr(base, "_declarations", {}) for base in reversed(cls.__bases__))
        own = {n: v for n, v in vars(cls).items() if isinstance(v, Declaration)}
        declarations = {n: v for each in (*bases, own) for n, v in each.items()}
        if facts or declarations != cls._declarations:
            cls._declarations = declarations
            cls.profile = derived_profile(cls.profile, declarations.values(), facts)

    def __init__(self, instance_name: str | None = None) -> None:
        self.instance_name = instance_name or f"{self.profile.type_name}0"
        self.folder = Path()
        """Base folder of relative file names in parameters: the folder of the system file."""
        self.observables: dict[str, Callable[[], Sequence[float] | float]] = {}
        """Values for reports and tests, by name."""
        self.reason = ""
        """Reason of the last failure, in ERROR that of entering it; empty after a reset."""
        self.in_ports: dict[str, InPort[Any]] = {}
        self.out_ports: dict[str, OutPort[Any]] = {}
        self.providers: dict[tuple[str, str], Provider[Any]] = {}
        """Providers by service port and instance, as `consumers`."""
        self.consumers: dict[tuple[str, str], Consumer[Any]] = {}
        self._check = CheckValues.FIRST
        self._deferred_calls: deque[Callable[[], None]] = deque()
        self.configuration_sets = ConfigurationSets(
            self.instance_name, self._at_end_of_cycle
        )
        self._checkpoint: Checkpoint[Any] | None = None
        self._clock: Clock = SimulatedClock()
        self._alive = False
        self._failing = ""
        self._seen_failures: dict[str, object] = {}
        """The last failure of each callback, so that a repeated one is reported once."""
        self._report: Callable[[Failure], None] = log_failure
        self._interrupt: BaseException | None = None
        """The exception that ends a context not driven by a system."""
        self._last_code = RTC_ERROR
        """Return value of the callback that failed last."""
        self._awaited = ""
        self._condition = ""
        self._active_contexts = 0
        self._contexts: dict[int, ExecutionContextOperations] = {}
        self._event_contexts: tuple[ExecutionContextOperations, ...] = ()
        self._lock = threading.RLock()
        for declaration in self._declarations.values():
            declaration.add_to(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.instance_name}>"

    # Ports and configuration that the class does not declare, added by its constructor

    def add_in_port(self, name: str, type_: type[T]) -> InPort[T]:
        """Add an InPort. Raises DuplicatePortError if the name is used."""
        return self._add(self.in_ports, name, InPort(name, type_, self.instance_name))

    def add_out_port(self, name: str, type_: type[T]) -> OutPort[T]:
        """Add an OutPort; an InPort may have the same name. Raises DuplicatePortError."""
        port = OutPort(name, type_, self.instance_name)
        port.check_values(self._check)
        return self._add(self.out_ports, name, port)

    def add_provider(
        self, port: str, instance: str, interface: Callable[..., S]
    ) -> Provider[S]:
        """Add a provided interface to a service port. Raises DuplicatePortError.

        `interface` is its servant class; declared as a callable, since type checkers accept no
        abstract class for `type[S]`.
        """
        name_of_type = self._type_name(port, instance)
        provider = Provider(
            port, instance, cast("type[S]", interface), self, name_of_type
        )
        provider.check_values(self._check)
        return self._add(self.providers, (port, instance), provider)

    def add_consumer(
        self, port: str, instance: str, interface: Callable[..., S]
    ) -> Consumer[S]:
        """Add a required interface; see `add_provider`. Raises DuplicatePortError."""
        name_of_type = self._type_name(port, instance)
        consumer = Consumer(
            port, instance, cast("type[S]", interface), self.instance_name, name_of_type
        )
        return self._add(self.consumers, (port, instance), consumer)

    def _type_name(self, port: str, instance: str) -> str:
        """Return OpenRTM's name of an interface's type; empty for the scoped name."""
        ports = (
            p for p in self.profile.ports if (p.port, p.instance) == (port, instance)
        )
        return next((each.type_name for each in ports), "")

    def add_configuration(self, values: C) -> C:
        """Bind the fields of `values`, which are the defaults, to the profile's parameters."""
        self.configuration_sets.bind(values, self.profile.configuration)
        return values

    def add_checkpoint(self, type_: type[T]) -> Checkpoint[T]:
        """Declare state that outlives the process (docs/supervision.md), of a generated type.

        For the constructor or `on_initialize`. Raises CheckpointError for a second one.
        """
        if self._checkpoint is not None:
            raise CheckpointError(f"{self.instance_name} has a checkpoint already")
        self._checkpoint = Checkpoint(type_, self.instance_name)
        return self._checkpoint

    def _check_values(self, check: CheckValues) -> None:
        """Set which values of samples and calls are checked: all, the first ones, or none."""
        self._check = check
        for port in self.out_ports.values():
            port.check_values(check)
        for provider in self.providers.values():
            provider.check_values(check)

    def _check_next_values(self) -> None:
        for port in self.out_ports.values():
            port.check_next()
        for provider in self.providers.values():
            provider.check_next()

    def _add(self, ports: dict[Any, P], key: object, port: P) -> P:
        if key in ports:
            raise DuplicatePortError(f"{self.instance_name} has a port {port} already")
        ports[key] = port
        return port

    # Callbacks (ComponentAction and DataFlowComponentAction)

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when the component joins a system; a failure keeps it out."""
        return RTC_OK

    def on_finalize(self) -> ReturnCode_t:
        """Called once, when the component leaves."""
        return RTC_OK

    def on_startup(self, ec_id: int) -> ReturnCode_t:
        """Called when an execution context starts; a failure is logged."""
        return RTC_OK

    def on_shutdown(self, ec_id: int) -> ReturnCode_t:
        """Called when an execution context stops; a failure is logged."""
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Called at the transition from INACTIVE to ACTIVE; a failure leads to ERROR."""
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Called at the transition from ACTIVE to INACTIVE; a failure is logged."""
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Called when ERROR is entered; a failure is logged."""
        return RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Called at every tick in ERROR; a failure is logged."""
        return RTC_OK

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Called at the transition from ERROR to INACTIVE; after a failure it stays in ERROR."""
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Called at every tick while ACTIVE; a failure leads to ERROR."""
        return RTC_OK

    def on_state_update(self, ec_id: int) -> ReturnCode_t:
        """Called at every tick while ACTIVE, after `on_execute`; a failure leads to ERROR."""
        return RTC_OK

    def on_rate_changed(self, ec_id: int) -> ReturnCode_t:
        """Called at the tick after the context's rate was set; a failure leads to ERROR."""
        return RTC_OK

    # For callbacks

    def now(self) -> int:
        """Return the runtime's time in ns: simulated from 0, real as UTC since 1970."""
        return self._clock.now()

    @cached_property
    def logger(self) -> logging.Logger:
        """The component's logger.

        `rtgen run` prints and records its lines from INFO on, those of DEBUG with `-v`; with ROS 2
        they are on `/rosout`, in OpenRTM's manager in its log.
        """
        return logger_of(self.instance_name, self._report_line)

    @property
    def network(self) -> SimulatedNetwork | None:
        """The simulated network in simulated time; None in real time."""
        return self._clock.network

    def stamp(self, sample: Timed) -> None:
        """Set `sample.tm` to `now`."""
        time = sample.tm
        time.sec, time.nsec = divmod(self._clock.now(), SECOND)

    def fail(self, reason: str) -> ReturnCode_t:
        """Set the reason of a failure; return RTC_ERROR, for the callback to return."""
        self._failing = reason
        return RTC_ERROR

    def report(self, condition: str) -> None:
        """Set a condition that impairs the component while it stays ACTIVE; empty to clear it.

        Logged when it changes, and shown at the end of `rtgen run`. Leaving ACTIVE clears it.
        """
        if condition != self._condition:
            self._condition = condition
            if condition:
                log.warning("%s: %s", self.instance_name, condition)

    @property
    def lost(self) -> int:
        """Number of samples lost before they reached the component's InPorts."""
        return sum(port.lost for port in self.in_ports.values())

    @property
    def is_active(self) -> bool:
        """Whether the component is ACTIVE in any context, so that its services respond."""
        return self._active_contexts > 0

    # LightweightRTObject

    def initialize(self) -> ReturnCode_t:
        """Initialize: CREATED to INACTIVE by `on_initialize`.

        PRECONDITION_NOT_MET if already alive.
        """
        if self._alive:
            return PRECONDITION_NOT_MET
        self.configuration_sets.apply()
        row = TRANSITIONS[CREATED_STATE, Request.INITIALIZE]
        self._alive = succeeds(self, row.callback)
        return RTC_OK if self._alive else RTC_ERROR

    def finalize(self) -> ReturnCode_t:
        """Finalize the component by `on_finalize`.

        PRECONDITION_NOT_MET if it is not alive or still participates in a context.
        """
        if not self._alive or self._contexts:
            return PRECONDITION_NOT_MET
        self._alive = False
        row = TRANSITIONS[INACTIVE_STATE, Request.FINALIZE]
        return RTC_OK if succeeds(self, row.callback) else RTC_ERROR

    def exit(self) -> ReturnCode_t:
        """Stop owned contexts, leave all contexts (deactivating if necessary), and finalize.

        PRECONDITION_NOT_MET if it is not alive; RTC_ERROR, without further callbacks, if a
        callback does not return.
        """
        if not self._alive:
            return PRECONDITION_NOT_MET
        contexts = list(self._contexts.values())
        results = [context._expel(self) for context in contexts]
        if not all(results):
            self._alive = False
            return RTC_ERROR
        return self.finalize()

    def is_alive(self, context: ExecutionContextOperations | None = None) -> bool:
        """Return whether the component is initialized and not finalized."""
        return self._alive and (context is None or context in self._contexts.values())

    def attach_context(self, context: ExecutionContextOperations) -> int:
        """Register a context, for `ExecutionContext.add_component`; return its handle, the `ec_id`.

        Handles of owned contexts count from 0, of others from 1000.
        """
        handle = 0 if context.owner is self else FIRST_FOREIGN_HANDLE
        while handle in self._contexts:
            handle += 1
        self._contexts[handle] = context
        return handle

    def detach_context(self, handle: int) -> ReturnCode_t:
        """Unregister a context, for `remove_component`. BAD_PARAMETER if unknown."""
        is_attached = self._contexts.pop(handle, None) is not None
        return RTC_OK if is_attached else ReturnCode_t.BAD_PARAMETER

    def get_context(self, handle: int) -> ExecutionContextOperations | None:
        """Return the context of a handle; None if there is none."""
        return self._contexts.get(handle)

    def get_context_handle(self, context: ExecutionContextOperations) -> int:
        """Return the handle of a context, -1 if the component does not participate in it."""
        handles = (
            handle for handle, attached in self._contexts.items() if attached is context
        )
        return next(handles, -1)

    def get_owned_contexts(self) -> list[ExecutionContextOperations]:
        """Return the contexts owned by the component."""
        return [context for context in self._contexts.values() if context.owner is self]

    def get_participating_contexts(self) -> list[ExecutionContextOperations]:
        """Return the contexts of others in which the component participates."""
        return [
            context for context in self._contexts.values() if context.owner is not self
        ]

    # For the runtime

    def _gate(self, request: Request) -> ReturnCode_t | None:
        """Decide whether activate, deactivate or reset may proceed; None to be called again.

        Called at every tick while the request waits, before its callback; `_awaited` may name what
        it waits for. Any result but RTC_OK and None is a failure: the component enters, or stays
        in, ERROR.
        """
        return RTC_OK

    def _unread(self) -> int:
        """Return the number of samples that have come at the ports that trigger it."""
        return sum(port.unread for port in self._triggers())

    def _triggers(self) -> Sequence[InPort[Any]]:
        """Return the InPorts whose samples an event-driven context executes on."""
        names = self.profile.triggers
        return [p for name, p in self.in_ports.items() if not names or name in names]

    def _sample_came(self) -> None:
        for context in self._event_contexts:
            context.wake()

    def _arrived(self) -> None:
        """Process external input between two ticks, after `ExecutionContext.wake`."""

    def _request_failure(self, reason: str) -> None:
        """Request ERROR in every context, for a reason outside of the callbacks."""
        for context in list(self._contexts.values()):
            context.fail_component(self, reason)

    def _join(self, clock: Clock) -> None:
        self._clock = clock
        self.configuration_sets.traffic = clock.traffic
        for port in self.in_ports.values():
            port._protect(clock.guard())

    def _at_end_of_cycle(self, call: Callable[[], None]) -> None:
        self._deferred_calls.append(call)

    def _put_before(self, callback: str, action: Callable[[], None]) -> None:
        """Call an action before a callback from now on."""
        inside: Callable[[int], ReturnCode_t] = getattr(self, callback)

        def outside(ec_id: int) -> ReturnCode_t:
            action()
            return inside(ec_id)

        setattr(self, callback, outside)

    def _run_deferred_calls(self) -> None:
        calls = self._deferred_calls
        for _ in range(len(calls)):
            calls.popleft()()

    def _failed(
        self, callback: str, what: str, error: BaseException | None = None
    ) -> None:
        """Store the reason of a failure and report it; an interrupt ends the run."""
        stored, self._failing = self._failing, ""
        reason = stored if stored and error is None else what
        if callback not in ("on_aborting", "on_error"):
            self.reason = reason
        self._report_failure(callback, reason, error)
        if error is not None and ends_run(error):
            self._end_run(error)

    def _servant_failed(self, operation: str, error: BaseException) -> None:
        """Report an exception of a servant, which does not affect the component's state."""
        self._report_failure(operation, described(error), error)

    def _function_failed(self, name: str, error: BaseException) -> None:
        """Report an exception of a user's function that is no callback; an interrupt ends the run.

        One that the end of the run has cut short has not failed.
        """
        if not isinstance(error, EndOfRunError):
            self._report_failure(name, described(error), error)
        if ends_run(error):
            self._end_run(error)

    def _report_failure(
        self, callback: str, reason: str, error: BaseException | None
    ) -> None:
        kind = reason if error is None else _kind(error)
        repeated = self._seen_failures.get(callback) == kind
        self._seen_failures[callback] = kind
        self._report(
            Failure(
                self.instance_name,
                callback,
                self._clock.elapsed(),
                reason,
                error,
                repeated,
            )
        )

    def _report_line(self, line: LogLine) -> None:
        traffic = self._clock.traffic
        if traffic.watchers:
            traffic.report(line)

    def _end_run(self, error: BaseException) -> None:
        """Raise an interrupt in the component's driver. Replaced by the system."""
        self._interrupt = error


def _kind(error: BaseException) -> object:
    """Return the identity of a failure, to detect repetitions: exception type and place."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return type(error), str(error)
    return type(error), trace.tb_frame.f_code, trace.tb_lineno
