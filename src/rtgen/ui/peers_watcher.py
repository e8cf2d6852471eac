"""Follows and controls the components of a system that other processes run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace as replace_fields
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Protocol

from msgspec.structs import replace

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.control import Asker, ControlError
from rtgen.runtime.distribution.descriptions import Description
from rtgen.runtime.distribution.medium import MediumError, Subscription
from rtgen.runtime.marshalling.comparison import definition, text_difference
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.system.json_calls import (
    RESULT,
    CallError,
    Outcome,
    members_of,
    request_of,
    values_of,
)
from rtgen.runtime.system.json_printers import plain
from rtgen.tools.recording.channels import cdr_encoder
from rtgen.ui.calls import carried_out
from rtgen.ui.description import STATES_BY_NAME, parameter, service_ports
from rtgen.ui.edits import Edit
from rtgen.ui.errors import CALL_FAILED, IMPOSSIBLE, UNKNOWN, CommandError
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind, PortKind
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.request_thread import RequestThread
from rtgen.ui.watching import Key, Take, Use

if TYPE_CHECKING:
    from rtgen.runtime.distribution.local_runs import Event
    from rtgen.runtime.marshalling.descriptors import DataType
    from rtgen.runtime.services.servants import Servant
    from rtgen.ui.buses import Access
    from rtgen.ui.peers_recorder import PeersRecorder

_PERIOD: Final = 0.5
"""The time between two queries of all components [s]."""
_REQUESTS: Final = {
    CommandKind.COMMAND_ACTIVATE: "activate",
    CommandKind.COMMAND_DEACTIVATE: "deactivate",
    CommandKind.COMMAND_RESET: "reset",
}


class Link(Protocol):
    """The way to the processes that run a system; methods raise MediumError."""

    @property
    def instances(self) -> Sequence[str]:
        """The components that are present."""

    @property
    def time(self) -> float | None:
        """The time of the run [s]; None if the processes have no common one."""

    @property
    def access(self) -> Access | None:
        """See `Watcher`."""

    def follow(self, take: Callable[[Event], None]) -> None:
        """See `Watcher`."""

    def state(self, instance: str) -> tuple[str, str] | None:
        """Return the state of a component, and its reason, as told last; None if never."""

    def look(self) -> RemoteState:
        """Return the connections, with their flows, and the run, if these are known."""

    def asker(self, instance: str) -> Asker:
        """Return the control service of a component."""

    def listen(
        self, there: RemotePort, type_: type[Any], take: Callable[[Any], None]
    ) -> Subscription:
        """Take the values of an OutPort."""

    def give(self, there: RemotePort, type_: type[Any], value: Any) -> None:
        """Give a sample to an InPort."""

    def close(self) -> None:
        """Leave the processes as they are."""


class PeersWatcher:
    """Queries the components of a system, and carries out commands for them.

    `place` says where they are. `publish` is called with each new state, and again if it returned
    False. `report` is called with a component's name and an error. A `recorder` gets all of it, and
    the samples of all OutPorts.
    """

    def __init__(
        self,
        link: Link,
        place: str,
        data_type: Callable[[str], type[DataType] | None],
        publish: Callable[[RemoteState], bool],
        report: Callable[[str, str], None],
        period: float = _PERIOD,
        recorder: PeersRecorder | None = None,
    ) -> None:
        self._link = link
        self._place = place
        self._data_type = data_type
        self._publish = publish
        self._report = report
        self._recorder = recorder
        self._components: dict[str, ui.Component] = {}
        self._statistics: dict[str, ui.Statistics] = {}
        self._descriptions: dict[str, Description] = {}
        self._state = RemoteState()
        """What the link has said last."""
        self._published = self._state
        self._takers: Mapping[Key, Take] = {}
        self._listened: Mapping[Key, Take] = self._takers
        self._refused: set[Key] = set()
        """OutPorts that give no samples."""
        self._taps: dict[Key, Subscription] = {}
        self._thread = RequestThread("rtgen-ui-peers", period, self._poll, self._settle)
        self.submit = self._thread.submit
        self._thread.start()

    @property
    def time(self) -> float | None:
        """See `Watcher`."""
        return self._link.time

    @property
    def access(self) -> Access | None:
        """See `Watcher`."""
        return self._link.access

    def follow(self, take: Callable[[Event], None]) -> None:
        """See `Watcher`."""
        self._link.follow(take)

    def close(self) -> None:
        """Stop watching; waits for a call in progress. States stay as they are."""
        self._thread.close()
        for tap in self._taps.values():
            tap.close()
        self._link.close()
        if self._recorder is not None:
            self._recorder.close()

    def watch(self, takers: Mapping[Key, Take]) -> None:
        """Receive the samples of only these OutPorts from now on; from any thread."""
        self._takers = takers
        self.submit(lambda: None)

    # Queries.

    def _poll(self) -> None:
        before, self._state = self._state, self._link.look()
        if self._state.run.number != before.run.number:
            # Another run, of which nothing is known.
            self._components.clear()
            self._statistics.clear()
            self._descriptions.clear()
            self._taps.clear()
            self._refused.clear()
        present = self._link.instances
        for instance in [*self._components]:
            if instance not in present:
                self._lose(instance)
        for instance in present:
            self._thread.carry_out_waiting()
            if self._thread.is_closing:
                return
            self._query(instance)
        self._settle()

    def _lose(self, instance: str) -> None:
        ended = "the run has ended" if self._state.run.ended else ""
        silent = ended or "its process has ended, or cannot be reached"
        self._components[instance] = replace(self._components[instance], silent=silent)
        self._descriptions.pop(instance, None)

    def _query(self, instance: str) -> None:
        try:
            asker = self._link.asker(instance)
            known = self._descriptions.get(instance) or asker.describe()
            self._descriptions[instance] = known
            state, sets = asker.state(), asker.parameters()
        except (ControlError, MediumError) as error:
            before = self._components.get(instance)
            if before is not None:
                self._components[instance] = replace(before, silent=str(error))
            return
        self._statistics[instance] = ui.Statistics(
            instance=instance, ticks=state.ticks, overruns=state.overruns
        )
        told = self._link.state(instance) or (state.state, state.reason)
        rate = known.rate
        self._components[instance] = ui.Component(
            instance=instance,
            type=known.type,
            doc=known.doc,
            current=STATES_BY_NAME.get(told[0], ui.State.STATE_CREATED),
            reason=told[1],
            contexts=(
                []
                if rate is None
                else [ui.ExecutionContext(rate=rate, kind=known.kind, running=True)]
            ),
            ports=[*_ports(known)],
            parameters=[*map(parameter, known.parameters)]
            or [ui.Parameter(name=name) for name in sets.sets.get(sets.active, {})],
            configuration_sets=[
                ui.ConfigurationSet(name, [ui.Value(*pair) for pair in values.items()])
                for name, values in sets.sets.items()
            ],
            active_set=sets.active,
            place=self._place,
        )

    def _settle(self) -> None:
        """Publish the state if it has changed, and receive what pages watch."""
        here = self._components
        now = replace_fields(
            self._state,
            components=dict(here),
            statistics=dict(self._statistics),
            connections={
                name: each
                for name, each in self._state.connections.items()
                if each.source.instance in here and each.target.instance in here
            },
        )
        if self._recorder is not None:
            self._recorder.follow(now)
        if now != self._published and self._publish(now):
            self._published = now
        wanted: dict[Key, Take] = {}
        if self._recorder is not None:
            wanted = dict.fromkeys(self._out_ports(), _ignore)
        wanted.update(self._takers)
        self._listened = wanted
        for key in [*self._taps]:
            if key not in wanted:
                self._taps.pop(key).close()
        self._refused.intersection_update(wanted)
        for key in wanted:
            if key not in self._taps and key not in self._refused:
                self._listen(key)

    def _out_ports(self) -> Iterable[Key]:
        """Return all OutPorts that are known."""
        return (
            Key(Use.LISTEN, instance, port)
            for instance, described in self._descriptions.items()
            for port in described.out_ports
        )

    def _listen(self, key: Key) -> None:
        described = self._descriptions.get(key.instance)
        port = None if described is None else described.out_ports.get(key.port)
        if port is None:
            return
        type_ = self._data_type(port.type)
        if type_ is None:
            self._refuse(key, f"the project does not define {port.type}")
            return
        if text_difference(definition(type_._descriptor_), port.definition):
            self._refuse(key, f"the project defines {port.type} in another way")
            return
        encode = cdr_encoder(type_)
        if encode is None:
            self._refuse(key, f"{port.type} has no encoding by CDR")
            return
        recorder = self._recorder
        record: Take = _ignore
        if recorder is not None:
            record = recorder.taker(key.instance, key.port, type_, port.unit)

        def on_value(value: Any) -> None:
            try:
                data = encode(value)
            except CdrError as error:
                if recorder is not None:
                    recorder.missing.add(f"{key.instance}.{key.port}", error)
                return
            record(data)
            self._listened.get(key, _ignore)(data)

        there = RemotePort(key.instance, key.port)
        try:
            self._taps[key] = self._link.listen(there, type_, on_value)
        except MediumError as error:
            self._refuse(key, str(error))

    def _refuse(self, key: Key, reason: str) -> None:
        self._refused.add(key)
        if self._recorder is not None:
            self._recorder.missing.refuse(f"{key.instance}.{key.port}", reason)
        self._report(key.instance, f"{key.port} gives no samples: {reason}")

    # Commands.

    def carry_out(self, command: ui.Command) -> Edit | None:
        """Carry out a command; by `submit` only. Raises CommandError."""
        value: Any = command.value
        kind = command.discriminator
        if kind in _REQUESTS:
            for instance in value:
                self._ask(instance, _REQUESTS[kind])
            self._query_again(value)
            return None
        if kind is CommandKind.COMMAND_SET:
            return self._setting(value)
        if kind is CommandKind.COMMAND_ACTIVATE_SET:
            return self._use(value)
        message = "not possible for components of processes that are only watched"
        raise CommandError(IMPOSSIBLE, message, "their system's file has the wiring")

    def call(self, command: ui.Call, interface: type[Servant], type_name: str) -> bytes:
        """Call an operation of a service; by `submit` only. Raises CommandError."""
        there, calls = command.port, calls_of(interface)
        port = f"{there.port}.{command.interface_name}"

        def invoke(operation: str, arguments: tuple[object, ...]) -> object:
            names = members_of(calls[operation].request)
            values = [*zip(names, map(plain, arguments), strict=True)]
            try:
                asker = self._link.asker(there.instance)
                outcome = asker.call(port, operation, values)
            except (ControlError, MediumError) as error:
                raise CommandError(CALL_FAILED, str(error)) from error
            if outcome.refused or outcome.exception:
                texts = (outcome.exception, outcome.message, outcome.refused)
                raise CommandError(CALL_FAILED, ": ".join(filter(None, texts)))
            return _results(operation, calls[operation].reply, outcome)

        return carried_out(interface, invoke, command)

    def give(self, address: ui.PortAddress, value: DataType) -> None:
        """Send a sample to an InPort; by `submit` only. Raises CommandError."""
        there = RemotePort(address.instance, address.port)
        try:
            self._link.give(there, type(value), value)
        except (MediumError, CdrError) as error:
            raise CommandError(CALL_FAILED, str(error)) from error

    def _ask(self, instance: str, method: str, *arguments: str) -> None:
        """Make a request of a component. Raises CommandError."""
        if instance not in self._components:
            raise CommandError(UNKNOWN, f"no process has {instance}")
        try:
            result = getattr(self._link.asker(instance), method)(*arguments)
        except (ControlError, MediumError) as error:
            raise CommandError(CALL_FAILED, str(error)) from error
        if result not in (None, "RTC_OK"):
            raise CommandError(CALL_FAILED, f"{instance}: {method}: {result}")

    def _query_again(self, instances: Iterable[str]) -> None:
        for instance in instances:
            self._query(instance)
        self._settle()

    def _setting(self, command: ui.SetParameter) -> Edit:
        instance, parameter = command.instance, command.parameter
        component = self._components.get(instance, ui.Component())
        set_id = command.set or component.active_set
        sets = {each.name: each.values for each in component.configuration_sets}
        texts = {each.name: each.text for each in sets.get(set_id, ())}

        def put(text: str) -> None:
            self._ask(instance, "set", parameter, text, set_id)
            self._query_again([instance])

        put(command.text)
        label = f"{instance}.{parameter} = {command.text}"[:200]
        undo = partial(put, texts.get(parameter, ""))
        return Edit(label, partial(put, command.text), undo, remote=True)

    def _use(self, command: ui.ActiveSet) -> Edit:
        instance = command.instance
        before = self._components.get(instance, ui.Component()).active_set

        def put(set_id: str) -> None:
            self._ask(instance, "activate_set", set_id)
            self._query_again([instance])

        put(command.set)
        label = f"{instance}: set {command.set}"[:200]
        return Edit(label, partial(put, command.set), partial(put, before), remote=True)


def _ignore(data: bytes) -> None:
    """Take a sample that nobody watches."""


def _results(operation: str, type_: Any, outcome: Outcome) -> object:
    """Return the results of a call as its operation returns them. Raises CommandError."""
    names = members_of(type_)
    values = {RESULT: outcome.result, **outcome.out}
    try:
        reply = request_of(operation, type_, [(each, values[each]) for each in names])
    except (CallError, KeyError) as error:
        raise CommandError(CALL_FAILED, f"the reply is wrong: {error}") from error
    if reply is None:
        return None
    results = values_of(reply)
    return results[0] if len(results) == 1 else results


def _ports(described: Description) -> Iterable[ui.Port]:
    for kind, ports in (
        (PortKind.PORT_IN, described.in_ports),
        (PortKind.PORT_OUT, described.out_ports),
    ):
        for name, port in ports.items():
            yield ui.Port(
                name=name,
                kind=kind,
                type=port.type,
                type_number=-1,
                unit=port.unit,
                doc=port.doc,
            )
    yield from service_ports(
        (each.port, ui.ServiceInterface(each.instance, each.name, provided))
        for provided, interfaces in (
            (True, described.providers),
            (False, described.consumers),
        )
        for each in interfaces
    )
