"""A component as described by an RtcProfile: texts, before types are resolved.

`facts` are properties of rtgen's profiles beyond the schema: see `typemap.profiles.facts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.facts.constraints import Constraint

_ANY_TYPES = ("Any", "any", "CORBA::Any", "IDL:omg.org/CORBA/Any:1.0")
"""Types with which tools and OpenRTM state that a port takes the data of any event."""
EVENT_PORT, EVENT = "event_port", "event"
"""Annotations of a port for events, and of each of its events."""

EVENT_ARGUMENTS = ("name", "source", "target", "condition", "type")
"""Attributes of an event: name, states before and after, time, data type."""


class ProfileParameter(msgspec.Struct, frozen=True, kw_only=True):
    """A parameter of the set `default`. `type` is a word of C++, `default` its text."""

    name: str
    type: str
    default: str
    span: Span
    type_span: Span
    default_span: Span
    variable: str = ""
    unit: str = ""
    doc: str = ""
    widget: str = ""
    constraint: Constraint | None = None
    facts: Mapping[str, Any] = msgspec.field(default_factory=dict)


class ProfileDataPort(msgspec.Struct, frozen=True, kw_only=True):
    """A data port. `type` is a scoped name of IDL, `idl_file` a base name or empty.

    An input for the events of a state machine is `for_events`; `events` has the attributes of
    each event by name.
    """

    name: str
    output: bool
    type: str
    span: Span
    type_span: Span
    idl_file: str = ""
    variable: str = ""
    unit: str = ""
    doc: str = ""
    facts: Mapping[str, Any] = msgspec.field(default_factory=dict)
    for_events: bool = False
    events: tuple[tuple[tuple[str, str], ...], ...] = ()

    @property
    def data_type(self) -> str:
        """The type of its data: that of its events, where the port states that it takes any.

        Empty if they have none, or several.
        """
        if not self.for_events or self.type.strip() not in _ANY_TYPES:
            return self.type
        types = {text for event in self.events for key, text in event if key == "type"}
        types.discard("")
        return types.pop() if len(types) == 1 else ""


class ProfileInterface(msgspec.Struct, frozen=True, kw_only=True):
    """An interface of a service port."""

    name: str
    provided: bool
    type: str
    span: Span
    type_span: Span
    idl_file: str = ""
    variable: str = ""
    instance: str = ""
    doc: str = ""
    facts: Mapping[str, Any] = msgspec.field(default_factory=dict)


class ProfileServicePort(msgspec.Struct, frozen=True, kw_only=True):
    """A service port with its interfaces."""

    name: str
    interfaces: tuple[ProfileInterface, ...]
    doc: str = ""


class RtcProfile(msgspec.Struct, frozen=True, kw_only=True):
    """Content of `rtc:RtcProfile`; `version` is that of the component.

    `rate` is in Hz, None if not given. `implements`: the profile replaces the component of this
    name in the definitions.
    """

    file: str
    span: Span
    name: str
    vendor: str
    category: str
    version: str
    description: str
    doc: str
    component_type: str
    activity: str
    kind: str
    execution: str
    rate: float | None
    max_instances: int
    created: str
    updated: str
    parameters: tuple[ProfileParameter, ...]
    data_ports: tuple[ProfileDataPort, ...]
    service_ports: tuple[ProfileServicePort, ...]
    facts: Mapping[str, Any] = msgspec.field(default_factory=dict)
    implements: bool = False
    language: str = "Python"
    activity_type: str = ""
    triggers: str = ""
