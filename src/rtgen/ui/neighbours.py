"""Watches naming services and the components that they have, in a thread that nothing waits for."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, Final
from uuid import uuid4

from rtgen.facts.openrtm_ports import KIND
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.corba.naming import Bound, Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.component import RtObject
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.peers import DATA_DEFAULTS
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.publishing import RtObjects
from rtgen.runtime.corba.rt_objects.wire import (
    ConnectorProfile,
    PortProfile,
    texts,
    values,
)
from rtgen.runtime.errors import TransportError
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.services.servants import Servant
from rtgen.ui.calls import carried_out
from rtgen.ui.edits import Edit
from rtgen.ui.errors import CALL_FAILED, IMPOSSIBLE, UNKNOWN, CommandError
from rtgen.ui.neighbourhood import Neighbourhood, obstacle, restored
from rtgen.ui.outside import DATA_TYPE, FAULTS, Outside, described, explained
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import BindingKind, CommandKind
from rtgen.ui.taps import Key, Take, Taps, Use

PERIOD: Final = 1.0
"""How often everything is asked [s]."""
TIMEOUT: Final = 1.0
"""The longest time of a call [s]."""
_End = tuple[bool, ui.PortAddress]
"""An end of a connection, and whether the connection begins there on the page."""
_Ports = dict[int, list[tuple[Any, _End]]]
"""Ports with their references, by the hashes of these."""
MOST_WAITING: Final = 256
"""Commands that wait."""
_HASHES: Final = 0x7FFFFFFF


class _Service:
    """A naming service, as it was when it answered last."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.silent = "not asked yet"
        self.names: list[Bound] = []
        self._naming: Naming | None = None

    def look(self, orb: Any) -> None:
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
        """The names of components on the page, and what they are bound to."""
        for bound in self.names:
            if bound.reference is not None and bound.path[-1][1] == KIND:
                yield self.name_of(bound), bound.reference

    def name_of(self, bound: Bound) -> str:
        return f"{self.address}/{bound.text}".removesuffix(f".{KIND}")


class Neighbours:
    """The components of other processes. Commands, which `submit` takes, are carried out between
    two looks at components, so each waits for a time-out of a call at most.

    `tell` is called with each new state; False: it must be called again. `report` gets
    what has gone wrong with a component, which may be empty. A component
    that does not answer is asked again, but all of these together take a round no longer than
    one time-out. `own`: the components of this process, of which the system tells. Raises
    TransportError if omniORB cannot start.
    """

    def __init__(
        self,
        addresses: Sequence[str],
        tell: Callable[[Neighbourhood], bool],
        report: Callable[[str, str], None],
        own: RtObjects | None = None,
        period: float = PERIOD,
        timeout: float = TIMEOUT,
    ) -> None:
        self._tell = tell
        self._report = report
        self._own = own
        self._period = period
        self._timeout = timeout
        self._orb = Orb(timeout=timeout)
        self._exported = Exported(self._orb)
        self._taps = Taps(self._orb, self._exported)
        self._wanted: Mapping[Key, Take] = {}
        self._listened: Mapping[Key, Take] = self._wanted
        """The watched OutPorts when connections were last made."""
        self._refused: dict[Key, Any] = {}
        """Ports that have rejected a connection of pages, by their keys."""
        self._services = [_Service(each) for each in addresses]
        self._found: dict[str, Outside] = {}
        self._also: dict[str, str] = {}
        """The names on the page of components that have several, by each of their names."""
        self._ids: dict[str, tuple[ui.PortAddress, ui.PortAddress, str]] = {}
        """The ends and the connector ids of connections."""
        self._told = Neighbourhood()
        self._requests: queue.Queue[Callable[[], None]] = queue.Queue(MOST_WAITING)
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._run, name="rtgen-ui-names", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """End the looking around; waits for a call in progress."""
        self._closing.set()
        with suppress(queue.Full):
            self._requests.put_nowait(lambda: None)
        self._thread.join()
        with suppress(*FAULTS):
            self._taps.close(2 * self._timeout)
        self._orb.close()

    def submit(self, request: Callable[[], None]) -> bool:
        """Have a request carried out; False if too many wait. It must not raise."""
        try:
            self._requests.put_nowait(request)
        except queue.Full:
            return False
        return True

    # Looking around.

    def _run(self) -> None:
        while not self._closing.is_set():
            next_round = time.monotonic() + self._period
            self._look_around()
            while (left := next_round - time.monotonic()) > 0:
                try:
                    self._requests.get(timeout=left)()
                except queue.Empty:
                    break
                if self._closing.is_set():
                    return
                if self._wanted is not self._listened:
                    self._listen()
                self._publish()

    def _look_around(self) -> None:
        for service in self._services:
            service.look(self._orb.orb)
            if self._closing.is_set():
                return
        self._take_over()
        everybody = sorted(self._found.values(), key=lambda each: each.asked)
        silent = [each for each in everybody if each.component.silent]
        for each in everybody:
            if not each.component.silent:
                self._look(each)
        deadline = time.monotonic() + self._timeout
        for each in silent:
            if time.monotonic() > deadline:
                break
            self._look(each)
        self._publish()
        self._listen()

    def _carry_out_waiting(self) -> None:
        with suppress(queue.Empty):
            while not self._closing.is_set():
                self._requests.get_nowait()()

    def _look(self, component: Outside) -> None:
        """Execute the waiting actions, then query a component."""
        self._carry_out_waiting()
        if not self._closing.is_set() and not component.look():
            self._publish()

    def _take_over(self) -> None:
        """Take over what the naming services have now."""
        found: dict[str, Outside] = {}
        self._also = {}
        known: dict[int, list[Outside]] = {}
        for service in self._services:
            for name, reference in service.components:
                mine = None if self._own is None else self._own.own(reference)
                if isinstance(mine, RtObject):
                    self._also[name] = mine.component.instance_name
                    continue
                same = known.setdefault(reference._hash(_HASHES), [])
                other = next((each for each in same if each.is_at(reference)), None)
                if other is None:
                    before = self._found.get(name)
                    if before is None or not before.is_at(reference):
                        before = Outside(name, reference, self._exported)
                    found[name] = other = before
                    same.append(other)
                self._also[name] = other.component.instance
        self._found = found

    def _publish(self) -> None:
        """Tell what is known, if it is not what was told last."""
        now = Neighbourhood(
            tuple(self._service(each) for each in self._services),
            {n: each.component for n, each in self._found.items() if each.answered},
            self._connections(),
        )
        if now != self._told and self._tell(now):
            self._told = now

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
        """The instance of a name of a component, and whether it answers."""
        instance = self._also[name]
        found = self._found.get(instance)
        if found is None:
            return instance, BindingKind.BINDING_COMPONENT
        dead = bool(found.component.silent) and found.asked > 0.0
        kind = BindingKind.BINDING_DEAD if dead else BindingKind.BINDING_COMPONENT
        return instance if found.answered else "", kind

    def _connections(self) -> dict[str, ui.Connection]:
        """The connections of which both ends are known."""
        ports: _Ports = {}
        for instance, each in self._found.items():
            for port in each.component.ports:
                reference = each.ports[port.name].port_ref
                address = ui.PortAddress(instance=instance, port=port.name)
                if reference is not None:
                    same = ports.setdefault(reference._hash(_HASHES), [])
                    same.append((reference, (_is_first(port), address)))
        found: dict[str, ui.Connection] = {}
        self._ids = {}
        for outside in self._found.values():
            for connector in outside.connectors:
                ends = [
                    end
                    for wanted in connector.ports
                    if wanted is not None
                    for end in (*_at(ports, wanted), *self._own_end(wanted))
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
                    found[name] = ui.Connection(
                        name=name,
                        source=source,
                        target=target,
                        properties=[ui.Value(k, v) for k, v in properties.items()],
                    )
        return found

    def _own_end(self, reference: Any) -> Iterator[_End]:
        """The port of this process to which a reference leads, if there is one."""
        port = None if self._own is None else self._own.own(reference)
        if isinstance(port, PortService):
            profile = described(port.end.port, port.get_port_profile())
            address = ui.PortAddress(instance=port.instance, port=port.end.port)
            yield _is_first(profile), address

    # Samples.

    def watch(self, wanted: Mapping[Key, Take]) -> None:
        """Receive the samples of only these OutPorts from now on; from any thread."""
        self._wanted = wanted
        self.submit(lambda: None)

    def _listen(self) -> None:
        """Make and end the connections of pages, by what they need and what there is."""
        self._listened = self._wanted
        self._taps.tidy(self._wanted, self._seen)
        failed: set[str] = set()
        for key, take in self._wanted.items():
            self._carry_out_waiting()
            port, _ = self._seen(key.instance, key.port)
            if port is None or self._found[key.instance].component.silent:
                self._refused.pop(key, None)
                continue
            refused = self._refused.get(key)
            is_refused = refused is not None and refused._is_equivalent(port.port_ref)
            if is_refused or key.instance in failed or self._closing.is_set():
                continue
            try:
                self._taps.listen(key, port, take)
            except (*FAULTS, CommandError) as error:
                failed.add(key.instance)
                self._refused[key] = port.port_ref
                self._report(key.instance, f"{key.port} gives no samples: {error}")

    def _seen(self, instance: str, port: str) -> tuple[PortProfile | None, float]:
        """Return the last known state of a port, and its time."""
        found = self._found.get(instance)
        return (None, 0.0) if found is None else (found.ports.get(port), found.asked)

    # Commands.

    def carry_out(self, command: ui.Command) -> Edit | None:
        """Carry out a command that concerns components of the neighbourhood; by `submit` only.

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
                    self._at(instance).request(kind)
                self._look_again(value)
                return None
            case CommandKind.COMMAND_SET:
                return _made(self._setting(value))
            case CommandKind.COMMAND_ACTIVATE_SET:
                return _made(self._use(value))
            case CommandKind.COMMAND_CONNECT:
                return _made(self._wire(value))
            case CommandKind.COMMAND_CUT:
                return _made(self._cut(value))
            case CommandKind.COMMAND_INJECT:
                raise CommandError(
                    IMPOSSIBLE,
                    "samples are given to InPorts of other processes alone",
                )
        raise CommandError(
            IMPOSSIBLE, "that cannot be done to components of other processes"
        )

    def give(self, address: ui.PortAddress, value: DataType) -> None:
        """Send a sample to an InPort; by `submit` only. Raises CommandError."""
        port = self._profile(address)
        key = Key(Use.GIVE, address.instance, address.port)
        try:
            self._taps.give(key, port, value)
        except (*FAULTS, CdrError) as error:
            raise CommandError(CALL_FAILED, str(error)) from error

    def call(self, wanted: ui.Call, interface: type[Servant], type_name: str) -> bytes:
        """Call an operation of a service; by `submit` only. Raises CommandError."""
        address = wanted.port
        port = self._profile(address)
        key = Key(Use.CALL, address.instance, address.port, wanted.interface_name)
        try:
            invoke = self._taps.caller(key, port, interface, type_name)
        except FAULTS as error:
            raise CommandError(CALL_FAILED, explained(error)) from error
        return carried_out(interface, invoke, wanted)

    def _setting(self, wanted: ui.SetParameter) -> Edit:
        component = self._at(wanted.instance).component
        set_id = wanted.set or component.active_set
        sets = {each.name: each.values for each in component.configuration_sets}
        texts = {each.name: each.text for each in sets.get(set_id, ())}

        def put(text: str) -> None:
            self._at(wanted.instance).set(set_id, wanted.parameter, text)
            self._look_again([wanted.instance])

        def undo() -> None:
            if set_id not in sets:
                self._at(wanted.instance).remove_set(set_id)
                self._look_again([wanted.instance])
            else:
                put(texts.get(wanted.parameter, ""))

        label = f"{wanted.instance}.{wanted.parameter} = {wanted.text}"[:200]
        return Edit(label, partial(put, wanted.text), undo, outside=True)

    def _use(self, wanted: ui.ActiveSet) -> Edit:
        before = self._at(wanted.instance).component.active_set

        def put(set_id: str) -> None:
            self._at(wanted.instance).use(set_id)
            self._look_again([wanted.instance])

        label = f"{wanted.instance}: set {wanted.set}"[:200]
        redo, undo = partial(put, wanted.set), partial(put, before)
        return Edit(label, redo, undo, outside=True)

    def _at(self, instance: str) -> Outside:
        """A component that answers. Raises CommandError."""
        found = self._found.get(instance)
        if found is None:
            raise CommandError(
                UNKNOWN,
                f"no naming service has {instance}",
                "components of the page's own system are not reached over CORBA",
            )
        if found.component.silent:
            message = f"{instance}: {found.component.silent}"
            raise CommandError(CALL_FAILED, message, "it is asked again and again")
        return found

    def _look_again(self, instances: Iterable[str]) -> None:
        for instance in instances:
            if instance in self._found:
                self._found[instance].look()
        self._publish()

    def _wire(self, wanted: ui.Connect) -> Edit:
        wire = _Wire(self, wanted)
        label = f"connect {wanted.source.port} with {wanted.target.port}"
        return Edit(label, wire.make, wire.cut, outside=True)

    def make(self, wanted: ui.Connect) -> str:
        """Make a connection; returns its id. Raises CommandError."""
        ends = wanted.source, wanted.target
        far = ends[0] if ends[0].instance in self._found else ends[1]
        reached = self._at(far.instance)
        profiles = [
            self._own_profile(end, self._profile(far)) or self._profile(end)
            for end in ends
        ]
        stated = {each.name: each.text for each in wanted.properties}
        type_ = texts(profiles[0].properties).get(DATA_TYPE)
        if type_ is not None:
            stated = DATA_DEFAULTS | {DATA_TYPE: type_} | stated
        name = wanted.name or "_".join(each.name for each in profiles)
        ports = [each.port_ref for each in profiles]
        profile = ConnectorProfile(name, str(uuid4()), ports, values(stated))
        reached.connect(far.port, profile)
        self._look_again([end.instance for end in ends])
        return profile.connector_id

    def _profile(self, address: ui.PortAddress) -> PortProfile:
        """The profile of a port of a component that answers. Raises CommandError."""
        found = self._at(address.instance).ports.get(address.port)
        if found is None:
            message = f"{address.instance} has no port {address.port}"
            raise CommandError(UNKNOWN, message)
        return found

    def _own_profile(
        self, address: ui.PortAddress, other: PortProfile
    ) -> PortProfile | None:
        """The profile of a port of this process, that which fits if several have the name."""
        if self._own is None or address.instance in self._found:
            return None
        found = [
            port.get_port_profile()
            for port in self._own.ports_at(address.instance, address.port)
        ]
        there = described("", other)
        fitting = (each for each in found if not obstacle(described("", each), there))
        return next(fitting, next(iter(found), None))

    def _cut(self, name: str) -> Edit:
        if name not in self._ids:
            raise CommandError(UNKNOWN, f"there is no connection {name}")
        source, target, connector_id = self._ids[name]
        properties = self._told.connections[name].properties
        wanted = ui.Connect(source, target, "", restored(properties))
        wire = _Wire(self, wanted, connector_id)
        label = f"cut {source.port} from {target.port}"
        return Edit(label, wire.cut, wire.make, outside=True)

    def end(self, wanted: ui.Connect, connector_id: str) -> None:
        """End a connection. Raises CommandError."""
        source, target = wanted.source, wanted.target
        known = self._found.get(source.instance)
        end = target if known is None or known.component.silent else source
        self._at(end.instance).disconnect(end.port, connector_id)
        self._look_again([source.instance, target.instance])


class _Wire:
    """A connection that can be made and cut; it has a new id each time."""

    def __init__(
        self, neighbours: Neighbours, wanted: ui.Connect, connector_id: str = ""
    ) -> None:
        self._neighbours = neighbours
        self._wanted = wanted
        self._id = connector_id

    def make(self) -> None:
        self._id = self._neighbours.make(self._wanted)

    def cut(self) -> None:
        self._neighbours.end(self._wanted, self._id)


def _made(edit: Edit) -> Edit:
    edit.redo()
    return edit


def _at(ports: _Ports, wanted: Any) -> Iterator[_End]:
    """The port to which a reference leads."""
    for reference, end in ports.get(wanted._hash(_HASHES), ()):
        if reference._is_equivalent(wanted):
            yield end


def _is_first(port: ui.Port) -> bool:
    """Whether a connection begins at a port on the page, wherever its connector has it."""
    if port.kind is ui.PortKind.PORT_SERVICE:
        return any(not each.provided for each in port.interfaces)
    return port.kind is ui.PortKind.PORT_OUT
