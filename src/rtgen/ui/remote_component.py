"""Queries and controls a component of another process (rtgen or OpenRTM) over CORBA."""

from __future__ import annotations

from collections.abc import Mapping
from time import monotonic
from typing import Any, Final, NoReturn

from msgspec.structs import replace
from omniORB import CORBA

from rtgen.facts.openrtm_ports import RUNTIME, known_name
from rtgen.facts.port_fitting import IN_PORT, OUT_PORT, scoped
from rtgen.runtime.corba.faults import is_silent
from rtgen.runtime.corba.rt_objects.objects import CallError, Exported
from rtgen.runtime.corba.rt_objects.remote import (
    CONSTRAINTS,
    FAULTS,
    TYPES,
    WIDGETS,
    RemoteRtc,
)
from rtgen.runtime.corba.rt_objects.wire import (
    ComponentProfile,
    ConnectorProfile,
    PortInterfacePolarity,
    PortProfile,
    SdoError,
    texts,
)
from rtgen.runtime.return_codes import RTC_OK
from rtgen.runtime.rtc.stated_values import problem
from rtgen.ui.description import STATES
from rtgen.ui.errors import BAD_VALUE, CALL_FAILED, NO_FIT, WRONG_STATE, CommandError
from rtgen.ui.protocol import ui
from rtgen.ui.type_table import NO_TYPE

DATA_TYPE: Final = "dataport.data_type"
_PORT_KINDS: Final = {
    IN_PORT: ui.PortKind.PORT_IN,
    OUT_PORT: ui.PortKind.PORT_OUT,
}
_REQUESTS: Final = {
    ui.CommandKind.COMMAND_ACTIVATE: "activate_component",
    ui.CommandKind.COMMAND_DEACTIVATE: "deactivate_component",
    ui.CommandKind.COMMAND_RESET: "reset_component",
}


class RemoteComponent:
    """A component found by a naming service. Its calls are bounded by the ORB's time-out."""

    def __init__(self, name: str, reference: Any, exported: Exported) -> None:
        self.rtc = RemoteRtc(reference, exported)
        self.component = ui.Component(
            instance=name, place=name.rpartition("/")[0], silent="not queried yet"
        )
        """The last known state; `silent` is the reason why the component does not answer now."""
        self.answered = False
        """Whether the component has ever answered."""
        self.asked = 0.0
        """End of the last `query`, by `time.monotonic` [s]."""
        self.ports: dict[str, PortProfile] = {}
        self._profile: ComponentProfile | None = None
        """The profile of the component since it answers; ports are read each time."""

    def is_at(self, reference: Any) -> bool:
        """Return whether a reference denotes this component."""
        return bool(self.rtc.reference._is_equivalent(reference))

    def query(self) -> bool:
        """Update the state from the component; return False if it does not answer."""
        try:
            component = self._described()
        except Exception as error:  # the page shows any error on the component's box
            component = replace(self.component, silent=explained(error))
            self._profile = None
        if component != self.component:
            self.component = component
        self.answered = self.answered or not component.silent
        self.asked = monotonic()
        return not component.silent

    def _described(self) -> ui.Component:
        rtc = self.rtc
        if self._profile is None:
            self._profile = rtc.read_profile()
        profile = self._profile
        contexts = rtc.contexts or rtc.call("get_participating_contexts")
        current = ui.State.STATE_CREATED
        if contexts:
            state = rtc.ask(contexts[0], "get_component_state", rtc.reference)
            current = STATES[state]
        sets = rtc.all_sets()
        values = {name: v for name, v in sets.items() if not name.startswith("__")}
        ports = {known_name(each.name): each for each in rtc.ports()}
        component = ui.Component(
            instance=self.component.instance,
            type=profile.type_name,
            category=profile.category,
            vendor=profile.vendor,
            version=profile.version,
            doc=profile.description,
            place=self.component.place,
            current=current,
            contexts=[self._context(each) for each in contexts],
            ports=[described(name, each) for name, each in ports.items()],
            parameters=_parameters(sets, values),
            configuration_sets=[
                ui.ConfigurationSet(name=each, values=_values(pairs))
                for each, pairs in values.items()
            ],
            active_set=rtc.active_set(),
        )
        self.ports = ports
        return component

    def _context(self, reference: Any) -> ui.ExecutionContext:
        profile = self.rtc.ask(reference, "get_profile")
        return ui.ExecutionContext(
            handle=self.rtc.call("get_context_handle", reference),
            rate=profile.rate,
            kind=profile.kind.name,
            running=bool(self.rtc.ask(reference, "is_running")),
        )

    @property
    def is_of_rtgen(self) -> bool:
        """Whether the component is run by rtgen."""
        return self._profile is not None and RUNTIME in texts(self._profile.properties)

    @property
    def connectors(self) -> list[ConnectorProfile]:
        """The connectors of all ports."""
        return [
            each for port in self.ports.values() for each in port.connector_profiles
        ]

    # Commands. They raise CommandError.

    def request(self, kind: ui.CommandKind) -> None:
        """Request a state from the component's own context."""
        try:
            code = self.rtc.ask(self.rtc.context, _REQUESTS[kind], self.rtc.reference)
        except FAULTS as error:
            raise self._failed(error) from error
        if code is not RTC_OK:
            raise CommandError(WRONG_STATE, f"{self.component.instance}: {code.name}")

    def set(self, set_id: str, parameter: str, text: str) -> None:
        """Set a parameter. Values of the active set take effect, as by OpenRTM's tools."""
        declared = next(
            (p for p in self.component.parameters if p.name == parameter), None
        )
        if declared is not None:
            why = problem(parameter, text, declared.type, declared.constraint)
            if why:
                raise CommandError(BAD_VALUE, f"{self.component.instance}: {why}")
        try:
            active = self.rtc.active_set()
            add = set_id not in ("", *self.rtc.sets())
            taken = self.rtc.set_value(set_id or active, parameter, text, add=add)
            if taken and set_id in ("", active):
                taken = self.rtc.configure("activate_configuration_set", active)
        except SdoError as error:
            self._refuse(f"{parameter} = {text}", error)
        except FAULTS as error:
            raise self._failed(error) from error
        if not taken:
            self._refuse(f"{parameter} = {text}")

    def remove_set(self, set_id: str) -> None:
        """Remove a set."""
        try:
            taken = self.rtc.configure("remove_configuration_set", set_id)
        except FAULTS as error:
            raise self._failed(error) from error
        if not taken:
            self._refuse(f"to remove the set {set_id}")

    def use(self, set_id: str) -> None:
        """Make a set the active one."""
        try:
            taken = self.rtc.configure("activate_configuration_set", set_id)
        except SdoError as error:
            self._refuse(f"the set {set_id}", error)
        except FAULTS as error:
            raise self._failed(error) from error
        if not taken:
            self._refuse(f"the set {set_id}")

    def connect(self, port: str, profile: ConnectorProfile) -> None:
        """Make a connection by a port."""
        try:
            code, _ = self.rtc.at_port(self.ports[port], "connect", profile)
        except FAULTS as error:
            raise self._failed(error) from error
        if code is not RTC_OK:
            message = f"{self.component.instance}.{port} refuses: {code.name}"
            raise CommandError(NO_FIT, message)

    def disconnect(self, port: str, connector_id: str) -> None:
        """End a connection by a port."""
        try:
            code = self.rtc.at_port(self.ports[port], "disconnect", connector_id)
        except FAULTS as error:
            raise self._failed(error) from error
        if code is not RTC_OK:
            message = f"{self.component.instance}.{port}: {code.name}"
            raise CommandError(WRONG_STATE, message)

    def _refuse(self, what: str, error: SdoError | None = None) -> NoReturn:
        why = f": {error.description}" if error is not None else ""
        message = f"{self.component.instance} refuses {what}{why}"
        raise CommandError(BAD_VALUE, message) from error

    def _failed(self, error: Exception) -> CommandError:
        """Return the error of a command whose call failed."""
        message = f"{self.component.instance}: {explained(error)}"
        return CommandError(CALL_FAILED, message)


def explained(error: Exception) -> str:
    """Return the reason of a failed call."""
    if isinstance(error, SdoError):
        return error.description or type(error).__name__
    if isinstance(error, CORBA.SystemException) and is_silent(error):
        return f"it does not answer ({type(error).__name__})"
    return str(error) if isinstance(error, CallError) else f"a call has failed: {error}"


def described(name: str, profile: PortProfile) -> ui.Port:
    """Describe a port by its profile."""
    properties = texts(profile.properties)
    kind = _PORT_KINDS.get(properties.get("port.port_type", ""))
    return ui.Port(
        name=name,
        kind=ui.PortKind.PORT_SERVICE if kind is None else kind,
        type="" if kind is None else scoped(properties.get(DATA_TYPE, "")),
        type_number=NO_TYPE,
        interfaces=[
            ui.ServiceInterface(
                name=each.instance_name,
                type=scoped(each.type_name),
                provided=each.polarity == PortInterfacePolarity.PROVIDED,
            )
            for each in profile.interfaces
        ],
    )


def _parameters(
    sets: Mapping[str, Mapping[str, str]], values: Mapping[str, Mapping[str, str]]
) -> list[ui.Parameter]:
    """Return the parameters of all sets, with their types, constraints and widgets."""
    names = dict.fromkeys(name for pairs in values.values() for name in pairs)

    def stated(what: str, name: str) -> str:
        return sets.get(what, {}).get(name, "")

    return [
        ui.Parameter(
            name=name,
            type=stated(TYPES, name),
            constraint=stated(CONSTRAINTS, name),
            widget=stated(WIDGETS, name),
        )
        for name in names
        if not name.startswith("__")
    ]


def _values(pairs: Mapping[str, str]) -> list[ui.Value]:
    return [ui.Value(name=name, text=text) for name, text in pairs.items()]
