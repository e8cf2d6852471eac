"""Profiles of components: the runtime form of their definitions."""

from __future__ import annotations

import msgspec

from rtgen.facts.activities import kind_of_context
from rtgen.runtime.return_codes import ExecutionKind


class ParameterProfile(msgspec.Struct, frozen=True, gc=False):
    """A configuration parameter.

    `name` is the outside name, `python_name` the field of the configuration class, `type` the
    canonical IDL spelling (`double`, `sequence<long>`, a scoped name), `default` a text as in a
    `.conf` file, `constraint` a text as in RTC.xml (`0.0<x<=2.0`).
    """

    name: str
    python_name: str
    type: str
    default: str = ""
    minimum: float | int | None = None
    maximum: float | int | None = None
    unit: str = ""
    constraint: str = ""
    widget: str = ""
    description: str = ""


class PortProfile(msgspec.Struct, frozen=True, gc=False):
    """A data port, or one interface of a service port.

    `kind` is `inport`, `outport`, `provider` or `consumer`; `port` and `instance` name the service
    port and the interface's instance in it; both are empty for a data port. `type_name` is
    OpenRTM's name of the interface's type, empty for `type`.
    """

    name: str
    python_name: str
    kind: str
    type: str
    repository_id: str
    port: str = ""
    instance: str = ""
    unit: str = ""
    description: str = ""
    type_name: str = ""


class ComponentProfile(msgspec.Struct, frozen=True, gc=False):
    """A component type; `rate` in Hz is the default of systems and `.conf` files.

    `activity_type` is what others see instead of `activity`, if it is given. `triggers` are the
    InPorts whose samples an EVENTDRIVEN component is executed on; none: all of them.
    """

    type_name: str
    kind: str = "DataFlowComponent"
    category: str = ""
    vendor: str = ""
    version: str = "1.0.0"
    description: str = ""
    rate: float = 1000.0
    max_instances: int = 1
    activity: str = "PERIODIC"
    activity_type: str = ""
    triggers: tuple[str, ...] = ()
    execution: str = "PeriodicExecutionContext"
    ports: tuple[PortProfile, ...] = ()
    configuration: tuple[ParameterProfile, ...] = ()

    @property
    def kind_of_context(self) -> ExecutionKind:
        """The kind of a component's own context."""
        return ExecutionKind[kind_of_context(self.activity)]
