"""A system: components driven by one clock, their connections, and requests to them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from rtgen.facts.threads import Threads
from rtgen.facts.value_checks import PERIOD, CheckValues
from rtgen.runtime.closable import Closable
from rtgen.runtime.errors import (
    CheckpointError,
    ConnectError,
    DuplicateConnectionError,
    DuplicateInstanceError,
    InitializationError,
    ObservableError,
    UnknownComponentError,
    UnknownConnectionError,
    UnknownObservableError,
)
from rtgen.runtime.failures import Failure, described, ends_run, log_failure
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.return_codes import (
    CREATED_STATE,
    INACTIVE_STATE,
    RTC_OK,
    ExecutionKind,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.checkpoints import CheckpointFolder
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.configuration import DEFAULT_SET
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.services.transports import ControlTransport, Transport
from rtgen.runtime.system.closing import Closing
from rtgen.runtime.system.dependencies import Dependencies
from rtgen.runtime.system.flow import Flow
from rtgen.runtime.system.joining import (
    Connector,
    Joining,
    PortAddress,
    instances_of,
)
from rtgen.runtime.system.latency import Latencies, Latency
from rtgen.runtime.system.observation import Observation, connection_change
from rtgen.runtime.system.port_names import unknown_port
from rtgen.runtime.system.real_time import RealTimeScheduler
from rtgen.runtime.system.records import (
    Listener,
    StateRecord,
    Statistics,
)
from rtgen.runtime.system.scheduling import Scheduler
from rtgen.runtime.system.simulated_time import SimulatedScheduler
from rtgen.runtime.system.watchdog import calling
from rtgen.runtime.timing.clocks import SECOND, Clock, RealClock, SimulatedClock


class System(Closable):
    """Components, each with an execution context of its own, on a simulated or a real clock.

    In simulated time everything is executed in `run`, in one thread, in order of time; at the same
    time the timeline comes first, then periodic connections, then components in the order in which
    they were added, those of equal rate in the order of the flow of their data. In real time they
    tick from the first `run` on, in one thread, except those that block: they have threads of their
    own from then on; with `threads` "own" all have.

    Requests (activation and so on) return immediately and are executed at the component's next
    tick. A system is a context manager, which closes it.

    With a transport, service calls use it, and service ports of other processes can be connected.
    With `checkpoints` the declared state of components is stored there, and components start from
    the stored state.

    Values of samples and calls within the process are checked against their types: with
    `check_values` "always", "first" (the first values of each port and operation, then one each
    100 ms), or "never". A wrong one raises CdrError in `write` or in the call.

    A failure of a component's code is reported to `on_failure`, by default to the logger
    `rtgen.runtime` with its traceback, and not raised by `run`, except exceptions that end the run:
    see `docs/runtime.md`, Failures.
    """

    def __init__(
        self,
        clock: Clock | None = None,
        transport: Transport | None = None,
        checkpoints: CheckpointFolder | None = None,
        check_values: CheckValues | str = CheckValues.FIRST,
        threads: Threads | str = Threads.SHARED,
    ) -> None:
        self.clock: Clock = clock or SimulatedClock()
        self._transport = transport
        self._checkpoints = checkpoints
        self._scheduler = _scheduler(self.clock)
        self._participants: dict[str, Participant] = {}
        self._connectors: dict[str, Connector] = {}
        self._of_instance: dict[str, dict[str, Connector]] = {}
        self._connecting = threading.RLock()
        self.closing = Closing()
        """Further actions at the end of the system."""
        self._joining = Joining(
            self._participants, self.component, self.clock.guard, transport
        )
        self._dependencies = Dependencies(self._participants, self._of_instance)
        self._flow = Flow(self._participants, self._connectors)
        self._latencies: Iterable[Latency] = ()
        self._observation = Observation(self.clock.elapsed, self.end_run)
        self._check = CheckValues(check_values)
        self._threads = Threads(threads)
        if self._check is CheckValues.FIRST:
            self._scheduler.between_instants(PERIOD, self._check_next_values)
        self.on_failure: Callable[[Failure], None] = log_failure
        """Called with each failure of a component's code; in real time from its thread."""
        if isinstance(transport, ControlTransport):
            transport.allow_control(self)

    # Components.

    def add(
        self,
        component: Component,
        rate_hz: float | None = None,
        threads: Threads | str | None = None,
        kind: ExecutionKind | None = None,
    ) -> ExecutionContext:
        """Initialize a component and give it a running context of its own.

        The rate is `rate_hz`, else that of its `.conf` file, else that of its profile; the thread
        is that of `threads`, else of the `.conf` file, else of the system; the kind is `kind`, else
        EVENT_DRIVEN for a profile with activity EVENTDRIVEN, else PERIODIC. Raises
        DuplicateInstanceError, RateError, CheckpointError, or InitializationError if
        `on_initialize` failed; its cause is the exception, which is not reported otherwise.
        """
        name = component.instance_name
        if name in self._participants:
            raise DuplicateInstanceError(f"the system has a component {name!r} already")
        rates = (rate_hz, component.configuration_sets.rate, component.profile.rate)
        rate = next(rate for rate in rates if rate is not None)
        threads = threads or component.configuration_sets.threads or self._threads
        context = ExecutionContext(
            rate,
            owner=component,
            kind=kind if kind is not None else component.profile.kind_of_context,
            driver=self._scheduler,
            listener=self._state_changed,
            has_own_thread=Threads(threads) is Threads.OWN,
        )
        component._join(self.clock)
        component._check_values(self._check)
        failures: list[Failure] = []
        component._report = failures.append
        if component.initialize() is not RTC_OK:
            why = component.reason or "it is initialized already"
            cause = failures[0].error if failures else None
            if cause is not None and ends_run(cause):
                raise cause
            raise InitializationError(f"{name} cannot be initialized: {why}") from cause
        if self._checkpoints is not None and component._checkpoint is not None:
            try:
                component._checkpoint.open(self._checkpoints.file(name))
            except CheckpointError:
                component.finalize()
                raise
        component._report = self._failed
        component._end_run = self.end_run  # type: ignore[method-assign]
        context.add_component(component)
        participant = self._participants[name] = context.participants[0]
        participant.provider_awaited = partial(self._dependencies.awaited, name)
        if self._transport is not None:
            self._transport.serve(component)
        self._observation.observe(component)
        self._state_changed(context.participants[0], CREATED_STATE, INACTIVE_STATE)
        context.start()
        return context

    def add_context(
        self, rate_hz: float, *, kind: ExecutionKind = ExecutionKind.PERIODIC
    ) -> ExecutionContext:
        """Return a further context without owner, in which components can participate.

        It is stopped initially, and ticks by the system's clock from its `start` on. Raises
        RateError.
        """
        return ExecutionContext(
            rate_hz,
            kind=kind,
            driver=self._scheduler,
            listener=self._state_changed,
            has_own_thread=self._threads is Threads.OWN,
        )

    def remove(self, instance: str) -> None:
        """Let a component exit, then remove its connections. Raises UnknownComponentError."""
        component = self.component(instance)
        participant = self._participants[instance]
        try:
            component.exit()
        finally:
            if component._checkpoint is not None:
                component._checkpoint.close()
            for connector in list(self._of_instance.get(instance, {}).values()):
                # A connection that a transport has made for this one ends with it.
                if connector.name in self._connectors:
                    self.disconnect(connector)
        if self._transport is not None:
            self._transport.withdraw(component)
        self._state_changed(participant, participant.state, CREATED_STATE)
        del self._participants[instance]

    @property
    def instances(self) -> tuple[str, ...]:
        """The instance names, in the order in which the components were added."""
        return tuple(self._participants)

    def component(self, instance: str) -> Component:
        """Return the component of an instance name. Raises UnknownComponentError."""
        return self._participant(instance).component

    def context(self, instance: str) -> ExecutionContext:
        """Return a component's own execution context. Raises UnknownComponentError."""
        context = self._participant(instance).context
        assert isinstance(context, ExecutionContext)  # made by `add`
        return context

    def state(self, instance: str) -> LifeCycleState:
        """Return a component's state in its own context. Raises UnknownComponentError."""
        return self._participant(instance).state

    def statistics(self, instance: str) -> Statistics:
        """Return the statistics of a component so far. Raises UnknownComponentError."""
        participant = self._participant(instance)
        component = participant.component
        return Statistics(
            participant.state,
            participant.ticks,
            participant.context.overruns,
            component.lost,
            component.reason,
            component._awaited,
            component._condition,
        )

    def observable(self, name: str) -> tuple[float, ...]:
        """Return the values of the observable `<instance>.<observable>`; a number as one value.

        Raises UnknownComponentError, UnknownObservableError, or ObservableError.
        """
        instance, _, what = name.rpartition(".")
        observables = self.component(instance).observables
        if what not in observables:
            names = ", ".join(observables) or "none"
            raise UnknownObservableError(
                f"{instance} has no observable {what!r}; known: {names}"
            )
        try:
            value: Any = calling(instance, what, observables[what])
            return tuple(
                map(float, [value] if isinstance(value, int | float) else value)
            )
        except Exception as error:
            raise ObservableError(
                f"the observable {name} at {self.time / SECOND:.3f} s: {described(error)}"
            ) from error

    # Requests.

    def activate(self, instance: str) -> ReturnCode_t:
        """Request ACTIVE; PRECONDITION_NOT_MET unless INACTIVE. Raises UnknownComponentError.

        The component waits for the providers of its services, if they are being activated, too.
        """
        component = self.component(instance)
        return self.context(instance).activate_component(component)

    def activation_order(self, instances: Sequence[str]) -> list[str]:
        """Return the instances, each after the providers of its consumers.

        Instances in a cycle, or without dependencies, keep their order.
        """
        return self._dependencies.order(instances)

    def deactivate(self, instance: str) -> ReturnCode_t:
        """Request INACTIVE; PRECONDITION_NOT_MET unless ACTIVE. Raises UnknownComponentError."""
        component = self.component(instance)
        return self.context(instance).deactivate_component(component)

    def reset(self, instance: str) -> ReturnCode_t:
        """Request INACTIVE; PRECONDITION_NOT_MET unless ERROR. Raises UnknownComponentError."""
        component = self.component(instance)
        return self.context(instance).reset_component(component)

    def configure(
        self, instance: str, parameter: str, text: str, set_id: str = DEFAULT_SET
    ) -> None:
        """Set a parameter in a configuration set; it takes effect between two cycles.

        Raises UnknownComponentError, UnknownParameterError or ParameterValueError.
        """
        self.component(instance).configuration_sets.set(parameter, text, set_id)

    def activate_set(self, instance: str, set_id: str) -> None:
        """Activate a configuration set; it takes effect between two cycles.

        Raises UnknownComponentError or UnknownConfigurationSetError.
        """
        self.component(instance).configuration_sets.activate(set_id)

    # Connections.

    @property
    def connectors(self) -> tuple[Connector, ...]:
        """The connections, oldest first."""
        return tuple(self._connectors.values())

    def connector(self, name: str) -> Connector:
        """Return the connection of a name. Raises UnknownConnectionError."""
        if name not in self._connectors:
            names = ", ".join(self._connectors) or "none"
            raise UnknownConnectionError(
                f"there is no connection {name!r}; known: {names}"
            )
        return self._connectors[name]

    def connect(
        self,
        source: PortAddress,
        target: PortAddress,
        properties: Mapping[str, str] | None = None,
        name: str = "",
    ) -> Connector:
        """Connect two ports, each given as (instance, port): data ports or service ports.

        With a transport, one of two service ports can be in another process.

        Allowed at any time, also from a callback. Data ports can be given in either order. The
        default name of the connection is `<instance>.<port>_<instance>.<port>`. Raises
        UnknownComponentError, or the ConnectError with the reason why the ports are incompatible.
        """
        name = name or f"{'.'.join(source)}_{'.'.join(target)}"
        connector = self._joining.made(source, target, properties or {}, name)
        self.establish(connector)
        return connector

    def establish(self, connector: Connector) -> None:
        """Establish a connection that a transport has made, as `connect` does.

        Raises DuplicateConnectionError for a name that is used.
        """
        if connector.name in self._connectors:
            raise DuplicateConnectionError(
                f"there is a connection {connector.name!r} already"
            )
        connector.attach()
        self._connectors[connector.name] = connector
        for instance in instances_of(connector):
            self._of_instance.setdefault(instance, {})[connector.name] = connector
        self._report_connection(connector, connected=True)
        if isinstance(connector, DataConnector) and connector.publisher is not None:
            # The writer of a connection from another process is not here.
            ends = connector.source.owner, connector.target.owner
            driver = next(self.component(e) for e in ends if e in self._participants)
            connector.end_publishing = self._scheduler.drive(
                connector.publisher, driver
            )

    def obstacle(self, source: PortAddress, target: PortAddress) -> str:
        """Return why two ports cannot be connected; else empty. Raises UnknownComponentError."""
        try:
            self._joining.made(source, target, {}, "")
        except ConnectError as error:
            return str(error)
        return ""

    def disconnect(self, connection: Connector | str) -> None:
        """Remove a connection. Unread samples are dropped and counted as lost.

        Allowed at any time, also from a callback. Raises UnknownConnectionError.
        """
        name = connection if isinstance(connection, str) else connection.name
        with self._connecting:
            connector = self.connector(name)
            if not isinstance(connection, str) and connection is not connector:
                raise UnknownConnectionError(f"{connection!r} is cut already")
            del self._connectors[name]
            for instance in set(instances_of(connector)):
                del self._of_instance[instance][name]
            connector.detach()
        self._report_connection(connector, connected=False)

    def _report_connection(self, connector: Connector, *, connected: bool) -> None:
        traffic = self.clock.traffic
        if traffic.watchers:
            traffic.report(connection_change(connector, connected=connected))

    # Time.

    @property
    def time(self) -> int:
        """Nanoseconds since the start."""
        return self.clock.elapsed()

    def at(self, instant: int, action: Callable[[], None]) -> None:
        """Call an action at a time [ns since the start], before the ticks at that time.

        Immediately if it has passed. In real time the action runs in the thread of `run`.
        """
        self._scheduler.at(instant, action)

    def every(self, period: int, action: Callable[[], None]) -> Callable[[], None]:
        """Call an action now and every period [ns], after the ticks at that time."""
        return self._scheduler.every(period, action)

    def run(
        self,
        until_ns: int | None = None,
        until: Callable[[System], bool] | None = None,
    ) -> bool:
        """Run until a condition holds (True), or until a time [ns since the start] (False).

        The end time is exclusive: one second of a 1000 Hz component is 1000 ticks. The condition is
        evaluated after all ticks at a time; in real time after each change of state, and every few
        milliseconds. `run` can be called again to continue; in real time components also run
        between two calls. Raises ValueError if neither is given, exceptions of listeners,
        conditions and actions of `at` and `every`, and KeyboardInterrupt and the debugger's quit
        from a callback.
        """
        if until_ns is None and until is None:
            raise ValueError("run needs an end: until_ns, until, or both")
        self._flow.fix(self._scheduler)
        condition = None if until is None else lambda: until(self)
        return self._scheduler.run(until_ns, condition)

    def follow(self, flow: Iterable[tuple[str, str]]) -> None:
        """Let components of equal rate tick as if there were further connections.

        Each is a pair of instances. Only before the first `run`.
        """
        self._flow.further += flow

    def measure_latencies(self) -> None:
        """Measure from now on the latencies of the chains of connections that there are now."""
        components = {name: self.component(name) for name in self.instances}
        self._latencies = Latencies(components, self.connectors, self.clock.elapsed)

    @property
    def latencies(self) -> tuple[Latency, ...]:
        """Latencies of samples along chains of connections, the longest chains first."""
        return tuple(self._latencies)

    def end_run(self, error: BaseException) -> None:
        """Make `run` raise the error after the current step. Can be called from any thread.

        If `run` is not active, its next call raises the error.
        """
        self._scheduler.end_run(error)

    @property
    def is_ending(self) -> bool:
        """Whether `run` raises an error of `end_run` after the current step."""
        return self._scheduler.is_ending

    def close(self) -> None:
        """Let every component exit (deactivate, shut down, finalize) once all ticks have ended.

        Consumers of services exit before their providers; otherwise the last added is first. A
        KeyboardInterrupt abandons the running component, and is raised at the end. In real time
        components whose callbacks do not return are abandoned after two seconds.
        """
        self.closing.run(
            reversed(self.activation_order(self.instances)),
            halt=self._scheduler.halt,
            let_exit=self._exit,
            close=self._scheduler.close,
        )

    def _exit(self, instance: str) -> None:
        try:
            self.remove(instance)
        except KeyboardInterrupt:
            self._participants.pop(instance, None)
            raise

    # Listeners.

    def add_listener(self, listener: Listener) -> None:
        """Add a listener for changes of state and samples, which otherwise cost nothing."""
        self._observation.add(listener, self._components())

    def remove_listener(self, listener: Listener) -> None:
        """Remove a listener; an unknown one is ignored."""
        self._observation.remove(listener, self._components())

    def watch_states(self, action: Callable[[StateRecord], None]) -> None:
        """Call an action with each change of state; samples are not affected."""
        self._observation.watch_states(action)

    def watch_port(
        self, instance: str, port: str, action: Callable[[Any], None]
    ) -> None:
        """Call an action with each sample that an OutPort writes; it remains the writer's.

        In real time it is called from the component's thread. Raises UnknownComponentError or
        UnknownPortError.
        """
        component = self.component(instance)
        if port not in component.out_ports:
            raise unknown_port(component, port)
        self._observation.watch(component.out_ports[port], action)

    def _state_changed(
        self, participant: Participant, before: LifeCycleState, after: LifeCycleState
    ) -> None:
        self._observation.state_changed(participant, before, after)
        self._scheduler.changed()

    def _components(self) -> list[Component]:
        return [self.component(instance) for instance in self.instances]

    def _check_next_values(self) -> None:
        for participant in self._participants.values():
            participant.component._check_next_values()

    def _failed(self, failure: Failure) -> None:
        self.on_failure(failure)

    def _participant(self, instance: str) -> Participant:
        if instance not in self._participants:
            names = ", ".join(self._participants) or "none"
            raise UnknownComponentError(
                f"there is no component {instance!r}; known: {names}"
            )
        return self._participants[instance]


def _scheduler(clock: Clock) -> Scheduler:
    if isinstance(clock, SimulatedClock):
        return SimulatedScheduler(clock)
    if isinstance(clock, RealClock):
        return RealTimeScheduler(clock)
    raise TypeError(f"a system needs a SimulatedClock or a RealClock, not {clock!r}")
