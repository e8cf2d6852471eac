"""Foreign components, run by other programs: found by their paths, configured, activated, watched.

`INSTANCE.rtc` of another rtgen process is also found here; it configures and activates itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from omniORB import CORBA
from omniORB import any as anys

from rtgen.facts.openrtm_ports import KIND
from rtgen.runtime.corba.naming import Naming, is_alive
from rtgen.runtime.corba.rt_objects.activation import Activations
from rtgen.runtime.corba.rt_objects.objects import CallError, Exported
from rtgen.runtime.corba.rt_objects.remote import CONSTRAINTS, FAULTS, TYPES, RemoteRtc
from rtgen.runtime.corba.rt_objects.wire import (
    CONFIGURATION,
    RT_OBJECT,
    ConfigurationSet,
    NameValue,
    SdoError,
    texts,
)
from rtgen.runtime.errors import ConfigurationError, TransportError
from rtgen.runtime.return_codes import LifeCycleState
from rtgen.runtime.rtc.stated_values import problem
from rtgen.runtime.services.transports import ForeignComponent

_ADDRESSES = ("corbaname:", "corbaloc:", "IOR:")
_DEFAULT_SET = "default"

Opened = Callable[[str], Naming]
"""Function that returns a client of the naming service at `HOST[:PORT]`. Raises TransportError."""


class Foreign:
    """A component that rtgen does not run. Calls are bounded by the time-out of the ORB."""

    def __init__(self, plan: ForeignComponent, exported: Exported) -> None:
        self.plan = plan
        self.reference: Any = None
        """The component found last."""
        self.wanted = False
        """Whether it should be ACTIVE."""
        self.last_state: LifeCycleState | None = None
        """The state when it was asked last; None if it did not respond."""
        self._exported = exported

    @property
    def instance(self) -> str:
        """The instance name."""
        return self.plan.instance

    def configure(self) -> None:
        """Set the configuration given by the system. Raises ConfigurationError, TransportError."""
        if not self.plan.configuration:
            return
        try:
            sets = self._call(self.reference, RT_OBJECT, "get_configuration")
            for set_id, pairs in self.plan.configuration.items():
                self._set(sets, set_id, pairs)
            chosen = self.plan.active_set
            self._call(sets, CONFIGURATION, "activate_configuration_set", chosen)
        except SdoError as error:
            raise ConfigurationError(
                f"{self.instance} refuses its configuration: {error.description}"
            ) from error
        except CallError as error:
            raise ConfigurationError(f"{self.instance}: {error}") from error
        except CORBA.SystemException as error:
            raise self._lost(error) from error

    def _set(self, sets: Any, set_id: str, given: Mapping[str, str]) -> None:
        known = self._call(sets, CONFIGURATION, "get_configuration_sets")
        found = next((each for each in known if each.id == set_id), None)
        default = next((each for each in known if each.id == _DEFAULT_SET), None)
        parameters = (
            {item.name for item in default.configuration_data} if default else ()
        )
        unknown = sorted(given.keys() - set(parameters))
        if unknown:
            raise ConfigurationError(
                f"{self.instance} has no parameter {', '.join(unknown)}; "
                f"it has: {', '.join(sorted(parameters)) or 'none'}"
            )
        types, limits = (_described(known, each) for each in (TYPES, CONSTRAINTS))
        for name, text in given.items():
            why = problem(name, text, types.get(name, ""), limits.get(name, ""))
            if why:
                raise ConfigurationError(f"{self.instance}: {why}")
        data = (
            {item.name: item.value for item in found.configuration_data}
            if found
            else {}
        )
        data |= {name: anys.to_any(text) for name, text in given.items()}
        items = [NameValue(name, value) for name, value in data.items()]
        made = ConfigurationSet(set_id, found.description if found else "", items)
        change = "set_configuration_set_values" if found else "add_configuration_set"
        self._call(sets, CONFIGURATION, change, made)

    def activate(self, activations: Activations) -> None:
        """Request ACTIVE in its own context. Raises TransportError."""
        self.wanted = True
        try:
            activations.activate(self.instance, self.rtc)
        except TransportError as error:
            raise TransportError(f"{self.instance}: {error}") from error
        except FAULTS as error:
            raise self._lost(error) from error
        self.look()

    @property
    def rtc(self) -> RemoteRtc:
        """The component found last, to call."""
        return RemoteRtc(self.reference, self._exported)

    def look(self) -> None:
        """Update `last_state`."""
        self.last_state = self.state

    @property
    def state(self) -> LifeCycleState | None:
        """Its state in its own context; None if it does not respond."""
        try:
            return self.rtc.state()
        except FAULTS:
            return None

    def _call(self, reference: Any, *what: Any) -> Any:
        return self._exported.call(reference, *what)

    def _lost(self, error: Any) -> TransportError:
        return TransportError(f"{self.instance} does not answer: {error}")


def _described(sets: Iterable[ConfigurationSet], set_id: str) -> dict[str, str]:
    """Return what a set that informs tools says of the parameters."""
    found = next((each for each in sets if each.id == set_id), None)
    return {} if found is None else texts(found.configuration_data)


class Directory:
    """Finds components of other processes. Methods raise TransportError.

    `activated` is the file that lists those activated by this process.
    """

    def __init__(
        self,
        naming: Naming,
        exported: Exported,
        opened: Opened,
        activated: Path | None = None,
    ) -> None:
        self.naming = naming
        self.foreign: dict[str, Foreign] = {}
        self._exported = exported
        self._opened = opened
        self.activations = Activations(exported, activated)
        self._services: dict[str, Naming] = {}

    def add(self, plan: ForeignComponent) -> None:
        """Look for a component by the path in its plan from now on."""
        self.foreign[plan.instance] = Foreign(plan, self._exported)

    def find(self, instance: str) -> Any:
        """Return a component that responds; None if there is none."""
        foreign = self.foreign.get(instance)
        if foreign is None:
            found = self.naming.component(instance, KIND)
            return found if is_alive(found) else None
        if foreign.reference is None or not is_alive(foreign.reference):
            foreign.reference = self._find(foreign.plan)
        return foreign.reference

    def where(self, instance: str) -> str:
        """Return the places searched for a component, for messages."""
        path = self.foreign[instance].plan.path if instance in self.foreign else ""
        if path.startswith(_ADDRESSES):
            return f"nothing answers at {path}"
        also = f", nor is anything at {path}," if "/" in path else ""
        service = f"the naming service {self.naming.address}"
        return f"{service} has no {instance}.{KIND}{also} that answers"

    def _find(self, plan: ForeignComponent) -> Any:
        if plan.path.startswith(_ADDRESSES):
            found = self._exported.reference(plan.path)
            return found if is_alive(found) else None
        address, *names = plan.path.split("/")
        path = [_id_and_kind(name) for name in names]
        candidates: list[Callable[[], Any]] = []
        if path:
            candidates.append(lambda: self.naming.at(path))
        candidates.append(lambda: self.naming.component(plan.instance, KIND))
        if path and address:
            candidates.append(lambda: self._elsewhere(address, path))
        return next((found for each in candidates if is_alive(found := each())), None)

    def _elsewhere(self, address: str, path: list[tuple[str, str]]) -> Any:
        """Return the object of a path's naming service; None if the service does not respond."""
        try:
            if address not in self._services:
                self._services[address] = self._opened(address)
            return self._services[address].at(path)
        except TransportError:
            self._services.pop(address, None)
            return None


def _id_and_kind(name: str) -> tuple[str, str]:
    """Split a name such as `rh3.host_cxt` into id and kind."""
    identity, dot, kind = name.rpartition(".")
    return (identity, kind) if dot else (name, "")


def is_place(path: str) -> bool:
    """Return whether a text is a place: an address of CORBA, or `HOST[:PORT]/...`."""
    host, _, names = path.partition("/")
    return path.startswith(_ADDRESSES) or bool(host and names)


def located(path: str, exported: Exported, opened: Opened) -> Any:
    """Return the object at a place; None if there is none. Raises TransportError."""
    if path.startswith(_ADDRESSES):
        return exported.reference(path)
    address, *names = path.split("/")
    return opened(address).at([_id_and_kind(name) for name in names])
