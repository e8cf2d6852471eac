"""Polls naming services (CORBA) and their components in a thread of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, Final
from uuid import uuid4

import msgspec

from rtgen.facts.openrtm_ports import KIND
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.corba.naming import Bound, Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.activation import Activations
from rtgen.runtime.corba.rt_objects.component import RtObject
from rtgen.runtime.corba.rt_objects.data import DATA_DEFAULTS
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.publishing import RtObjects
from rtgen.runtime.corba.rt_objects.remote import FAULTS
from rtgen.runtime.corba.rt_objects.wire import (
    ConnectorProfile,
    PortProfile,
    texts,
    values,
)
from rtgen.runtime.errors import TransportError
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.return_codes import RTC_OK
from rtgen.runtime.services.servants import Servant
from rtgen.ui.calls import carried_out
from rtgen.ui.edits import Edit
from rtgen.ui.errors import CALL_FAILED, IMPOSSIBLE, NO_FIT, UNKNOWN, CommandError
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import BindingKind, CommandKind
from rtgen.ui.remote_component import (
    DATA_TYPE,
    RemoteComponent,
    described,
    explained,
)
from rtgen.ui.remote_connections import RemoteConnections
from rtgen.ui.remote_state import RemoteState, obstacle, restored
from rtgen.ui.request_thread import RequestThread
from rtgen.ui.watching import Key, Take, Use

PERIOD: Final = 1.0
"""Polling interval [s]."""
TIMEOUT: Final = 1.0
"""Time-out of a call [s]."""
_End = tuple[bool, ui.PortAddress]
"""One end of a connection, and whether the page draws it as the source."""
_Ports = dict[bytes, list[tuple[Any, _End]]]
"""Ports with their references, by the object keys of the references."""


class _Service:
    """A naming service, as of its last answer."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.silent = "not queried yet"
        self.names: list[Bound] = []
        self._naming: Naming | None = None

    def query(self, orb: Any) -> None:
        try:
            if self._naming is None:
                self._naming = Naming(orb, self.address)
                self.address = self._naming.address
            self.names = self._naming.tree()
            self.silent = ""
        except TransportError as error:
            self.silent = str(error)
            self._naming = None

    @property
    def components(self) -> Iterable[tuple[str, Any]]:
        """The components of the service: name on the page and object reference."""
        for bound in self.names:
            if bound.reference is not None and bound.path[-1][1] == KIND:
                yield self.name_of(bound), bound.reference

    def name_of(self, bound: Bound) -> str:
        return f"{self.address}/{bound.text}".removesuffix(f".{KIND}")


class NamingWatcher:
    """Polls the components of other processes, and executes commands for them.

    Commands (`submit`) run between two queries, so each waits for one time-out at most. `publish`
    is called with each new state, and again if it returned False. `report` is called with a
    component's name and an error, which may be empty. Components that do not answer are queried
    again, for one time-out per round altogether. `own` has the components of this process, which
    are left out. Raises TransportError if omniORB cannot start.
    """

    def __init__(
        self,
        addresses: Sequence[str],
        publish: Callable[[RemoteState], bool],
        report: Callable[[str, str], None],
        own: RtObjects | None = None,
        period: float = PERIOD,
    ) -> None:
        self._publish = publish
        self._report = report
        self._own = own
        self._orb = Orb(timeout=TIMEOUT)
        self._exported = Exported(self._orb)
        self._activations = Activations(self._exported)
        self._taps = RemoteConnections(self._orb, self._exported)
        self._takers: Mapping[Key, Take] = {}
        self._listened: Mapping[Key, Take] = self._takers
        """The watched OutPorts at the time when connections were last made."""
        self._refused: dict[Key, Any] = {}
        """Ports that refused a connection of pages, by key."""
        self._services = [_Service(each) for each in addresses]
        self._components: dict[str, RemoteComponent] = {}
        self._aliases: dict[str, str] = {}
        """The name on the page by each name of a component, which may have several."""
        self._ids: dict[str, tuple[ui.PortAddress, ui.PortAddress, str]] = {}
        """The ends and connector ids of connections."""
        self._published = RemoteState()
        self._thread = RequestThread("rtgen-ui-names", period, self._poll, self._settle)
        self.submit = self._thread.submit
        self._thread.start()

    @property
    def time(self) -> None:
        """None: each component has a time of its own."""

    access = None

    def follow(self, take: object) -> None:
        """Do nothing: components are watched, and no run."""

    def close(self) -> None:
        """Stop polling; waits for a call in progress.

        Components that were activated here are deactivated.
        """
        self._thread.close()
        self._activations.release_all()
        with suppress(*FAULTS):
            self._taps.close(2 * TIMEOUT)
        self._orb.close()

    # Polling.

    def _settle(self) -> None:
        """Receive what pages watch, and publish the state, after a request."""
        if self._takers is not self._listened:
            self._listen()
        self._publish_changes()

    def _poll(self) -> None:
        for service in self._services:
            service.query(self._orb.orb)
            if self._thread.is_closing:
                return
        self._update_components()
        everybody = sorted(self._components.values(), key=lambda each: each.asked)
        silent = [each for each in everybody if each.component.silent]
        for each in everybody:
            if not each.component.silent:
                self._query(each)
        deadline = time.monotonic() + TIMEOUT
        for each in silent:
            if time.monotonic() > deadline:
                break
            self._query(each)
        self._publish_changes()
        self._listen()

    def _query(self, component: RemoteComponent) -> None:
        """Execute the waiting actions, then query a component."""
        self._thread.carry_out_waiting()
        if not self._thread.is_closing and not component.query():
            self._publish_changes()

    def _update_components(self) -> None:
        """Update the components from the bindings of the naming services."""
        components: dict[str, RemoteComponent] = {}
        self._aliases = {}
        by_key: dict[bytes, list[RemoteComponent]] = {}
        for service in self._services:
            for name, reference in service.components:
                mine = None if self._own is None else self._own.own(reference)
                if isinstance(mine, RtObject):
                    self._aliases[name] = mine.component.instance_name
                    continue
                same = by_key.setdefault(self._exported.key(reference), [])
                other = next((each for each in same if each.is_at(reference)), None)
                if other is None:
                    before = self._components.get(name)
                    if before is None or not before.is_at(reference):
                        before = RemoteComponent(name, reference, self._exported)
                    components[name] = other = before
                    same.append(other)
                self._aliases[name] = other.component.instance
        self._components = components

    def _publish_changes(self) -> None:
        """Publish the state if it has changed."""
        now = RemoteState(
            tuple(self._service(each) for each in self._services),
            {
                n: each.component
                for n, each in self._components.items()
                if each.answered
            },
            self._connections(),
        )
        if now != self._published and self._publish(now):
            self._published = now

    def _service(self, service: _Service) -> ui.NamingService:
        bindings = []
        for bound in service.names:
            instance, kind = "", BindingKind.BINDING_OBJECT
            if bound.reference is None:
                kind = BindingKind.BINDING_CONTEXT
            elif bound.path[-1][1] == KIND:
                instance, kind = self._component(service.name_of(bound))
            bindings.append(ui.Binding(path=bound.text, kind=kind, instance=instance))
        return ui.NamingService(
            address=service.address, silent=service.silent, bindings=bindings
        )

    def _component(self, name: str) -> tuple[str, BindingKind]:
        """Return the instance of a component's name, and whether it answers."""
        instance = self._aliases[name]
        component = self._components.get(instance)
        if component is None:
            return instance, BindingKind.BINDING_COMPONENT
        dead = bool(component.component.silent) and component.asked > 0.0
        kind = BindingKind.BINDING_DEAD if dead else BindingKind.BINDING_COMPONENT
        return instance if component.answered else "", kind

    def _connections(self) -> dict[str, ui.Connection]:
        """Return the connections whose ends are both known."""
        ports: _Ports = {}
        for instance, each in self._components.items():
            for port in each.component.ports:
                reference = each.ports[port.name].port_ref
                address = ui.PortAddress(instance=instance, port=port.name)
                if reference is not None:
                    same = ports.setdefault(self._exported.key(reference), [])
                    same.append((reference, (_is_first(port), address)))
        connections: dict[str, ui.Connection] = {}
        self._ids = {}
        for component in self._components.values():
            for connector in component.connectors:
                ends = [
                    end
                    for port_ref in connector.ports
                    if port_ref is not None
                    for end in (
                        *self._end_of(ports, port_ref),
                        *self._own_end(port_ref),
                    )
                ]
                ends.sort(key=lambda end: not end[0])
                for _, target in ends[1:]:
                    source = ends[0][1]
                    name = (
                        f"{source.instance}.{source.port}_{target.instance}."
                        f"{target.port} {connector.connector_id}"
                    )
                    properties = texts(connector.properties)
                    self._ids[name] = source, target, connector.connector_id
                    connections[name] = ui.Connection(
                        name=name,
                        source=source,
                        target=target,
                        properties=[ui.Value(k, v) for k, v in properties.items()],
                    )
        return connections

    def _end_of(self, ports: _Ports, port: Any) -> Iterator[_End]:
        """Return the port that a reference denotes."""
        for reference, end in ports.get(self._exported.key(port), ()):
            if reference._is_equivalent(port):
                yield end

    def _own_end(self, reference: Any) -> Iterator[_End]:
        """Return the port of this process that a reference denotes; None for another object."""
        port = None if self._own is None else self._own.own(reference)
        if isinstance(port, PortService):
            profile = described(port.end.port, port.get_port_profile())
            address = ui.PortAddress(instance=port.instance, port=port.end.port)
            yield _is_first(profile), address

    # Samples.

    def watch(self, takers: Mapping[Key, Take]) -> None:
        """Receive the samples of only these OutPorts from now on; from any thread."""
        self._takers = takers
        self.submit(lambda: None)

    def _listen(self) -> None:
        """Make the connections that pages need, and end the unused ones."""
        self._listened = self._takers
        self._taps.tidy(self._takers, self._port_state)
        failed: set[str] = set()
        for key, take in self._takers.items():
            self._thread.carry_out_waiting()
            port, _ = self._port_state(key.instance, key.port)
            if port is None or self._components[key.instance].component.silent:
                self._refused.pop(key, None)
                continue
            refused = self._refused.get(key)
            is_refused = refused is not None and refused._is_equivalent(port.port_ref)
            if is_refused or key.instance in failed or self._thread.is_closing:
                continue
            try:
                self._taps.listen(key, port, take)
            except (*FAULTS, CommandError) as error:
                failed.add(key.instance)
                self._refused[key] = port.port_ref
                self._report(key.instance, f"{key.port} gives no samples: {error}")

    def _port_state(self, instance: str, port: str) -> tuple[PortProfile | None, float]:
        """Return the last known state of a port, and its time."""
        component = self._components.get(instance)
        return (
            (None, 0.0)
            if component is None
            else (component.ports.get(port), component.asked)
        )

    # Commands.

    def carry_out(self, command: ui.Command) -> Edit | None:
        """Execute a command for components of other processes; by `submit` only.

        Returns the change, if it can be reverted. Raises CommandError.
        """
        value: Any = command.value
        match command.discriminator:
            case (
                CommandKind.COMMAND_ACTIVATE
                | CommandKind.COMMAND_DEACTIVATE
                | CommandKind.COMMAND_RESET
            ) as kind:
                for instance in value:
                    self._request(kind, instance)
                self._query_again(value)
                return None
            case CommandKind.COMMAND_SET:
                return _redone(self._setting(value))
            case CommandKind.COMMAND_ACTIVATE_SET:
                return _redone(self._use(value))
            case CommandKind.COMMAND_CONNECT:
                return _redone(self._wire(value))
            case CommandKind.COMMAND_CUT:
                return _redone(self._cut(value))
            case CommandKind.COMMAND_INJECT:
                raise CommandError(
                    IMPOSSIBLE,
                    "only InPorts of other processes take samples",
                )
        raise CommandError(IMPOSSIBLE, "not possible for components of other processes")

    def _request(self, kind: CommandKind, instance: str) -> None:
        """Request a state of a component. Raises CommandError."""
        component = self._at(instance)
        request = partial(component.request, kind)
        if kind is not CommandKind.COMMAND_ACTIVATE:
            request()
            self._activations.forget(instance)
            return
        try:
            self._activations.activate(instance, component.rtc, request)
        except FAULTS as error:
            raise CommandError(
                CALL_FAILED, f"{instance}: {explained(error)}"
            ) from error

    def give(self, address: ui.PortAddress, value: DataType) -> None:
        """Send a sample to an InPort; by `submit` only. Raises CommandError."""
        port = self._profile(address)
        key = Key(Use.GIVE, address.instance, address.port)
        try:
            self._taps.give(key, port, value)
        except (*FAULTS, CdrError) as error:
            raise CommandError(CALL_FAILED, str(error)) from error

    def call(self, command: ui.Call, interface: type[Servant], type_name: str) -> bytes:
        """Call an operation of a service; by `submit` only. Raises CommandError."""
        address = command.port
        port = self._profile(address)
        key = Key(Use.CALL, address.instance, address.port, command.interface_name)
        try:
            invoke = self._taps.caller(key, port, interface, type_name)
        except FAULTS as error:
            raise CommandError(CALL_FAILED, explained(error)) from error
        return carried_out(interface, invoke, command)

    def _setting(self, command: ui.SetParameter) -> Edit:
        component = self._at(command.instance).component
        set_id = command.set or component.active_set
        sets = {each.name: each.values for each in component.configuration_sets}
        texts = {each.name: each.text for each in sets.get(set_id, ())}

        def put(text: str) -> None:
            self._at(command.instance).set(set_id, command.parameter, text)
            self._query_again([command.instance])

        def undo() -> None:
            if set_id not in sets:
                self._at(command.instance).remove_set(set_id)
                self._query_again([command.instance])
            else:
                put(texts.get(command.parameter, ""))

        label = f"{command.instance}.{command.parameter} = {command.text}"[:200]
        return Edit(label, partial(put, command.text), undo, remote=True)

    def _use(self, command: ui.ActiveSet) -> Edit:
        before = self._at(command.instance).component.active_set

        def put(set_id: str) -> None:
            self._at(command.instance).use(set_id)
            self._query_again([command.instance])

        label = f"{command.instance}: set {command.set}"[:200]
        redo, undo = partial(put, command.set), partial(put, before)
        return Edit(label, redo, undo, remote=True)

    def _at(self, instance: str) -> RemoteComponent:
        """Return a component that answers. Raises CommandError."""
        component = self._components.get(instance)
        if component is None:
            raise CommandError(
                UNKNOWN,
                f"no naming service has {instance}",
                "components of the page's own system are not reached over CORBA",
            )
        if component.component.silent:
            message = f"{instance}: {component.component.silent}"
            raise CommandError(CALL_FAILED, message, "it is queried again and again")
        return component

    def _query_again(self, instances: Iterable[str]) -> None:
        for instance in instances:
            if instance in self._components:
                self._components[instance].query()
        self._publish_changes()

    def _wire(self, command: ui.Connect) -> Edit:
        wire = _Wire(self, command)
        label = f"connect {command.source.port} with {command.target.port}"
        return Edit(label, wire.make, wire.cut, remote=True)

    def make(self, command: ui.Connect) -> str:
        """Make a connection; return its id. Raises CommandError."""
        ends = command.source, command.target
        far = ends[0] if ends[0].instance in self._components else ends[1]
        reached = self._at(far.instance)
        profiles = [
            self._own_profile(end, self._profile(far)) or self._profile(end)
            for end in ends
        ]
        why = obstacle(*(described("", each) for each in profiles))
        if why:
            raise CommandError(NO_FIT, why)
        stated = {each.name: each.text for each in command.properties}
        type_ = texts(profiles[0].properties).get(DATA_TYPE)
        if type_ is not None:
            stated = DATA_DEFAULTS | {DATA_TYPE: type_} | stated
        name = command.name or "_".join(each.name for each in profiles)
        ports = [each.port_ref for each in profiles]
        profile = ConnectorProfile(name, str(uuid4()), ports, values(stated))
        reached.connect(far.port, profile)
        self._query_again([end.instance for end in ends])
        return profile.connector_id

    def _profile(self, address: ui.PortAddress) -> PortProfile:
        """Return the profile of a port of a component that answers. Raises CommandError."""
        profile = self._at(address.instance).ports.get(address.port)
        if profile is None:
            message = f"{address.instance} has no port {address.port}"
            raise CommandError(UNKNOWN, message)
        return profile

    def _own_profile(
        self, address: ui.PortAddress, other: PortProfile
    ) -> PortProfile | None:
        """Return the profile of a port of this process; of two with the name, the one that fits."""
        if self._own is None or address.instance in self._components:
            return None
        profiles = [
            port.get_port_profile()
            for port in self._own.ports_at(address.instance, address.port)
        ]
        there = described("", other)
        fitting = (
            each for each in profiles if not obstacle(described("", each), there)
        )
        return next(fitting, next(iter(profiles), None))

    def _cut(self, name: str) -> Edit:
        if name not in self._ids:
            raise CommandError(UNKNOWN, f"there is no connection {name}")
        source, target, connector_id = self._ids[name]
        properties = self._published.connections[name].properties
        command = ui.Connect(source, target, "", restored(properties))
        wire = _Wire(self, command, connector_id)
        label = f"cut {source.port} from {target.port}"
        return Edit(label, wire.cut, wire.make, remote=True)

    def end(self, command: ui.Connect, connector_id: str) -> None:
        """End a connection. Raises CommandError."""
        source, target = command.source, command.target
        if not self._end_here(command, connector_id):
            # At a component of rtgen, which makes a connection again that the other end ends.
            components = [
                self._components.get(each.instance) for each in (source, target)
            ]
            ends = [
                end
                for end, binding in zip((source, target), components, strict=True)
                if binding is not None and not binding.component.silent
            ]
            ends.sort(key=lambda end: not self._components[end.instance].is_of_rtgen)
            end = ends[0] if ends else source
            self._at(end.instance).disconnect(end.port, connector_id)
        self._query_again([source.instance, target.instance])

    def _end_here(self, command: ui.Connect, connector_id: str) -> bool:
        """End a connection at a port of this process; return whether it is connected there."""
        for end in (command.source, command.target):
            if self._own is not None and end.instance not in self._components:
                for port in self._own.ports_at(end.instance, end.port):
                    if port.is_linked(connector_id):
                        return port.disconnect(connector_id) is RTC_OK
        return False


class _Wire(msgspec.Struct, eq=False):
    """A connection that can be made and cut repeatedly, with a new id each time."""

    _neighbours: NamingWatcher
    _takers: ui.Connect
    _id: str = ""

    def make(self) -> None:
        self._id = self._neighbours.make(self._takers)

    def cut(self) -> None:
        self._neighbours.end(self._takers, self._id)


def _redone(edit: Edit) -> Edit:
    edit.redo()
    return edit


def _is_first(port: ui.Port) -> bool:
    """Return whether the page draws a port as the source, whatever its place in the connector."""
    if port.kind is ui.PortKind.PORT_SERVICE:
        return any(not each.provided for each in port.interfaces)
    return port.kind is ui.PortKind.PORT_OUT
