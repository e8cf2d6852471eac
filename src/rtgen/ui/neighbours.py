"""Watches naming services and the components that they have, in a thread that nothing waits for."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from typing import Any, Final

from rtgen.facts.openrtm_ports import KIND
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
from rtgen.ui.errors import CALL_FAILED, IMPOSSIBLE, UNKNOWN, CommandError
from rtgen.ui.neighbourhood import Neighbourhood, obstacle
from rtgen.ui.outside import DATA_TYPE, Outside, described
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import BindingKind, CommandKind

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

    `tell` is called with each new state of things; False if it has to be told again. A component
    that does not answer is asked again, but all of these together take a round no longer than
    one time-out. `own`: the components of this process, of which the system tells. Raises
    TransportError if omniORB cannot start.
    """

    def __init__(
        self,
        addresses: Sequence[str],
        tell: Callable[[Neighbourhood], bool],
        own: RtObjects | None = None,
        period: float = PERIOD,
        timeout: float = TIMEOUT,
    ) -> None:
        self._tell = tell
        self._own = own
        self._period = period
        self._timeout = timeout
        self._orb = Orb(timeout=timeout)
        self._exported = Exported(self._orb)
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

    def _look(self, component: Outside) -> None:
        """Carry out what waits, then ask a component."""
        with suppress(queue.Empty):
            while not self._closing.is_set():
                self._requests.get_nowait()()
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

    # Commands.

    def carry_out(self, command: ui.Command) -> None:
        """Carry out a command that concerns components of the neighbourhood; by `submit` only.

        Raises CommandError.
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
            case CommandKind.COMMAND_SET:
                found = self._at(value.instance)
                found.set(value.set, value.parameter, value.text)
                self._look_again([value.instance])
            case CommandKind.COMMAND_ACTIVATE_SET:
                self._at(value.instance).use(value.set)
                self._look_again([value.instance])
            case CommandKind.COMMAND_CONNECT:
                self._connect(value)
            case CommandKind.COMMAND_CUT:
                self._cut(value)
            case _:
                raise CommandError(
                    IMPOSSIBLE, "that cannot be done to components of other processes"
                )

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

    def _connect(self, wanted: ui.Connect) -> None:
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
        profile = ConnectorProfile(name, "", ports, values(stated))
        reached.connect(far.port, profile)
        self._look_again([end.instance for end in ends])

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

    def _cut(self, name: str) -> None:
        if name not in self._ids:
            raise CommandError(UNKNOWN, f"there is no connection {name}")
        source, target, connector_id = self._ids[name]
        known = self._found.get(source.instance)
        end = target if known is None or known.component.silent else source
        self._at(end.instance).disconnect(end.port, connector_id)
        self._look_again([source.instance, target.instance])


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
