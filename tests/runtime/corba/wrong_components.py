"""Violations of RTC 1.0 and of OpenRTM's conventions, each of one operation of a component."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace
from omniORB import any as anys

from rtgen.facts.connector_properties import STRICTNESS
from rtgen.runtime import RTC_OK
from rtgen.runtime.corba.rt_objects.component import ContextService, RtObject
from rtgen.runtime.corba.rt_objects.configuration import Configuration
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import texts, values
from rtgen.runtime.return_codes import (
    PRECONDITION_NOT_MET,
    ExecutionKind,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.configuration import ConfigurationSets
from rtgen.runtime.rtc.execution_context import ExecutionContext

Breaking = Callable[[Callable[..., Any]], Callable[..., Any]]
"""A change of a method."""
Mutant = tuple[type, str, Breaking]
"""A class, and how one of its methods is changed."""
PROFILE = "get_component_profile"


def instead(
    answer: Callable[..., Any], when: Callable[..., bool] = lambda *given: True
) -> Breaking:
    """Return a method that does something else for some arguments."""

    def broken(right: Callable[..., Any]) -> Callable[..., Any]:
        def wrong(self: Any, *given: Any) -> Any:
            return (answer if when(self, *given) else right)(self, *given)

        return wrong

    return broken


def otherwise(change: Callable[[Any], Any]) -> Breaking:
    """Return a method with another answer."""
    return lambda right: lambda self, *given: change(right(self, *given))


def always(answer: Any) -> Breaking:
    return otherwise(lambda _: answer)


def changing(**changes: Any) -> Breaking:
    """Return a method with other fields of its answer."""
    return otherwise(lambda found: replace(found, **changes))


def install(mutant: Mutant, patch: pytest.MonkeyPatch) -> None:
    """Replace the method of a mutant."""
    class_, operation, breaking = mutant
    patch.setattr(class_, operation, breaking(getattr(class_, operation)))


def profile(change: Callable[[Any], Any]) -> Mutant:
    """Return a component with another profile."""
    return RtObject, PROFILE, otherwise(change)


def storing_nothing(when: Callable[..., bool]) -> Mutant:
    """Return a component that accepts some values, and does not store them."""
    return Configuration, "set_configuration_set_values", instead(pretend, when)


def accepting(key: str, text: str) -> Mutant:
    """Return a component that accepts a connector property, and does not connect."""
    return PortService, "connect", instead(taken, has(key, text))


def in_port(name: str, **changed: Any) -> Callable[[Any], Any]:
    """Return a component profile in which one port is changed."""
    return changed_port(name, lambda port: replace(port, **changed))


def changed_port(name: str, change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a component profile with another profile of a port."""

    def changed(profile: Any) -> Any:
        ports = [
            change(port) if port.name.endswith(f".{name}") else port
            for port in profile.port_profiles
        ]
        return replace(profile, port_profiles=ports)

    return changed


def typed(kind: str, type_: str) -> list[Any]:
    return values({"port.port_type": kind, "dataport.data_type": type_})


def state(self: ContextService) -> LifeCycleState:
    return self.context.get_component_state(self._owner.component)


def is_known(self: ContextService, reference: Any) -> bool:
    return isinstance(self._exported.local(reference), RtObject)


def is_state(name: str) -> Callable[..., bool]:
    return lambda self, given: is_known(self, given) and state(self).name == name


def pairs(given: Any) -> dict[str, str]:
    return {each.name: each.value.value() for each in given.configuration_data}


def is_value(name: str, *texts: str) -> Callable[..., bool]:
    return lambda self, given: pairs(given).get(name) in texts


def is_unknown_text(self: Any, given: Any) -> bool:
    return pairs(given).get("count") == "no value"


def pretend(self: Any, *given: Any) -> bool:
    return True


def taken(self: Any, profile: Any) -> Any:
    return RTC_OK, profile


def has(key: str, text: str) -> Callable[..., bool]:
    return lambda self, profile: (
        text in [each.value.value() for each in profile.properties if each.name == key]
    )


def ok(self: Any, *given: Any) -> Any:
    return RTC_OK


def with_property(key: str, text: str) -> Callable[[Any], Any]:
    """Return a change of an answer: another value of a property that its profile has."""

    def change(found: Any) -> Any:
        if isinstance(found, tuple):
            return found[0], change(found[1])
        stated = texts(found.properties)
        if key not in stated:
            return found
        return replace(found, properties=values({**stated, key: text}))

    return change


def but(operation: str) -> Callable[..., Any]:
    """Return a method of a context that refuses a request, and carries out another one."""

    def answer(self: ContextService, _reference: Any) -> ReturnCode_t:
        getattr(self.context, operation)(self._owner.component)
        return PRECONDITION_NOT_MET

    return answer


def set_two(self: Configuration, given: Any) -> bool:
    self._sets.set("label", f"beside {pairs(given)}", "default")
    return self.add_configuration_set(given)


LEVEL = "IDL:Bench/Level:1.0"
MUTANTS: dict[str, Mutant] = {
    "profile": (RtObject, PROFILE, changing(version="2.1.1")),
    "profile.properties": profile(
        lambda p: replace(p, properties=values({"max_instance": "7"}))
    ),
    "profile.identity": (RtObject, "get_sdo_id", always("Gauge1")),
    "ports.directions": profile(
        in_port("shown", properties=typed("DataInPort", LEVEL))
    ),
    "ports.types": profile(
        in_port("shown", properties=typed("DataOutPort", "IDL:Other:1.0"))
    ),
    "ports.interfaces": profile(in_port("valves", interfaces=[])),
    "ports.references": (RtObject, "get_ports", otherwise(lambda ports: ports[1:])),
    "ports.unknown": (PortService, "disconnect", always(RTC_OK)),
    "configuration.active": (
        Configuration,
        "get_active_configuration_set",
        changing(id="other"),
    ),
    "configuration.unknown": (
        Configuration,
        "get_configuration_set",
        instead(lambda self, name: self.get_active_configuration_set()),
    ),
    "configuration.unknown-parameters": (
        Configuration,
        "get_configuration_parameter_value",
        instead(lambda self, name: anys.to_any("0"), lambda self, name: "-" in name),
    ),
    "contexts.profile": (
        ContextService,
        "get_profile",
        otherwise(lambda found: replace(found, rate=found.rate + 1)),
    ),
    "contexts.handles": (RtObject, "get_context", always(None)),
    "contexts.kind": (ExecutionContext, "get_kind", always(ExecutionKind.EVENT_DRIVEN)),
    "contexts.state": (
        ContextService,
        "get_component_state",
        always(LifeCycleState.CREATED_STATE),
    ),
    "configuration.values": (
        ConfigurationSets,
        "texts",
        otherwise(lambda found: {**found, "count": "-5"}),
    ),
    "life-cycle.activation": (
        ContextService,
        "activate_component",
        instead(but("activate_component"), is_state("INACTIVE_STATE")),
    ),
    "life-cycle.inactive": (
        ContextService,
        "reset_component",
        instead(ok, is_state("INACTIVE_STATE")),
    ),
    "life-cycle.active": (
        ContextService,
        "activate_component",
        instead(ok, is_state("ACTIVE_STATE")),
    ),
    "life-cycle.initialization": (RtObject, "finalize", always(RTC_OK)),
    "contexts.strangers": (
        ContextService,
        "activate_component",
        instead(ok, lambda self, reference: not is_known(self, reference)),
    ),
    "contexts.running": (
        ContextService,
        "start",
        instead(ok, lambda self: self.context.is_running()),
    ),
    "contexts.rate": (
        ContextService,
        "set_rate",
        instead(ok, lambda self, rate: rate <= 0),
    ),
    "configuration.set": storing_nothing(is_value("mode", "FAST")),
    "configuration.limits": storing_nothing(is_value("count", "0", "-1")),
    "configuration.types": storing_nothing(is_unknown_text),
    "connections": (PortService, "get_connector_profile", changing(name="other")),
    "connections.types": accepting(
        "dataport.data_type", "IDL:rtgen/Conformance/NoType:1.0"
    ),
    "connections.interfaces": accepting(
        "dataport.interface_type", "rtgen-conformance-none"
    ),
    "configuration.sets": (
        Configuration,
        "activate_configuration_set",
        instead(pretend, lambda self, name: name not in self._sets.ids),
    ),
    "configuration.defaults": (
        ConfigurationSets,
        "texts",
        otherwise(lambda found: {**found, "count": "4"}),
    ),
    "connections.services": accepting(STRICTNESS, "strict"),
    "exit": (RtObject, "exit", instead(ok)),
    "configuration.reads": (
        Configuration,
        "get_configuration_parameter_value",
        always(anys.to_any("17")),
    ),
    "configuration.parameters": (
        Configuration,
        "set_configuration_parameter",
        instead(pretend),
    ),
    "configuration.added": (
        Configuration,
        "add_configuration_set",
        instead(pretend, lambda self, given: given.id not in self._sets.ids),
    ),
    "contexts.defaults": (
        ExecutionContext,
        "get_rate",
        otherwise(lambda rate: rate / 2),
    ),
    "connections.all": (PortService, "disconnect_all", instead(ok)),
}
WITHOUT_MUTANT = {"ports.names", "configuration.names", "life-cycle.error", "left"}
"""Checks that have tests of their own."""
FURTHER: dict[str, Mutant] = {
    "ports.names: a port twice": profile(
        lambda p: replace(p, port_profiles=[*p.port_profiles, *p.port_profiles])
    ),
    "ports.interfaces: an interface twice": profile(
        changed_port("valves", lambda p: replace(p, interfaces=2 * p.interfaces))
    ),
    "ports.unknown: a profile of an unknown connector": (
        PortService,
        "get_connector_profile",
        otherwise(lambda p: replace(p, connector_id=p.connector_id or "other")),
    ),
    "contexts.profile: a participant twice": (
        ContextService,
        "get_profile",
        otherwise(lambda p: replace(p, participants=[p.owner, p.owner])),
    ),
    "contexts.handles: a context twice": (
        RtObject,
        "get_owned_contexts",
        otherwise(lambda found: 2 * found),
    ),
    "contexts.handles: a context of an unknown handle": (
        RtObject,
        "get_context",
        instead(lambda self, _: self.get_owned_contexts()[0]),
    ),
    "life-cycle.inactive: a refused deactivation that activates": (
        ContextService,
        "deactivate_component",
        instead(but("activate_component"), is_state("INACTIVE_STATE")),
    ),
    "life-cycle.active: a refused reset that deactivates": (
        ContextService,
        "reset_component",
        instead(but("deactivate_component"), is_state("ACTIVE_STATE")),
    ),
    "configuration.set: another parameter is set, too": (
        Configuration,
        "set_configuration_set_values",
        instead(set_two, is_value("mode", "FAST")),
    ),
    **{
        f"connections: {operation} with another {key}": (
            PortService,
            operation,
            otherwise(with_property(key, text)),
        )
        for operation, key, text in (
            ("connect", "dataport.interface_type", "data_service"),
            ("connect", "dataport.dataflow_type", "pull"),
            ("connect", "dataport.corba_cdr.inport_ior", "IOR:00"),
            ("get_connector_profile", "dataport.interface_type", "data_service"),
        )
    },
    "connections: a port profile without connectors": (
        PortService,
        "get_port_profile",
        changing(connector_profiles=[]),
    ),
}
"""Further violations, by the check that fails and what is wrong."""
