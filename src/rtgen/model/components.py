"""Components and systems: ports, configuration, connections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from rtgen.diagnostics import Span
from rtgen.model.declarations import ConstantValue, Declaration, Documented
from rtgen.model.types import ScopedName, Type

NO_DATE = "1970-01-01T00:00:00+00:00"
"""Default date, since profiles require one and the clock is never read."""


class PortKind(StrEnum):
    """Kinds of ports; the values are those of `rtgen inspect --json`."""

    INPORT = "inport"
    OUTPORT = "outport"
    PROVIDER = "provider"
    CONSUMER = "consumer"


@dataclass(frozen=True, slots=True, kw_only=True)
class Port(Documented):
    """A data port, or one interface of a service port.

    `name` is the outside name (`@name`, else the identifier), `identifier` the IDL identifier.
    For an interface `port` is the service port it belongs to (`@port`, else `name`) and
    `instance` its instance name there (`@instance`, else the unscoped interface name). `type_name`
    is the name that OpenRTM knows the interface's type by (`@type_name`), empty for the scoped one.
    """

    kind: PortKind
    name: str
    identifier: str
    type: Type
    port: str = ""
    instance: str = ""
    unit: str = ""
    type_name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConfigurationParameter(Documented):
    """A configuration parameter; `default`, `minimum`, `maximum` are of its type."""

    name: str
    identifier: str
    type: Type
    default: ConstantValue | None = None
    minimum: ConstantValue | None = None
    maximum: ConstantValue | None = None
    unit: str = ""
    constraint: str = ""
    widget: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Component(Declaration):
    """A component: the CORBA 3 construct read as an RTC. Rate in Hz; dates as xsd:dateTime.

    `ports` and `configuration` include inherited ones, base first. `runtime_base` is the base
    class of its generated base if that is not the runtime's `Component`, and `factory` constructs
    instances if that is not a skeleton for the user to complete; both are written `module:name`,
    where a module with a leading dot is below the generated package. `other_file` contains the
    IDL definition that a profile of the component replaces.
    """

    ports: tuple[Port, ...] = ()
    configuration: tuple[ConfigurationParameter, ...] = ()
    base: ScopedName | None = None
    supports: tuple[ScopedName, ...] = ()
    kind: str = "DataFlowComponent"
    category: str = ""
    vendor: str = ""
    version: str = "1.0.0"
    description: str = ""
    rate: float = 1000.0
    max_instances: int = 1
    activity: str = "PERIODIC"
    component_type: str = "STATIC"
    execution: str = "PeriodicExecutionContext"
    created: str = NO_DATE
    updated: str = NO_DATE
    runtime_base: str = ""
    factory: str = ""
    other_file: str = ""

    @property
    def profile_id(self) -> str:
        """The id of the component in profiles of components and systems, written with colons."""
        return ":".join(
            ("RTC", self.vendor, self.category, self.name[-1], self.version)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Adapter:
    """Copies members from one struct to another; implemented by the component `name`.

    `copies` are pairs of target member and source member, each as a path of member names.
    """

    name: str
    source: ScopedName
    target: ScopedName
    copies: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
    span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemComponent:
    """A component of a system. `configuration` maps set id to (parameter, text) pairs.

    Tools store OpenRTM's `__widget__`, `__constraints__` and `__type__` like sets of parameters.
    `conf` is the text of the component's `.conf` files beside the system; `places` has the places
    of its parameters, by set id and parameter.
    """

    instance: str
    type: str
    id: str
    path_uri: str
    span: Span
    rate: float | None = None
    active_set: str = "default"
    configuration: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()
    location: tuple[int, int, int, int] | None = None
    required: bool = True
    conf: str = ""
    places: Mapping[tuple[str, str], Span] = field(
        default_factory=dict, compare=False, repr=False
    )

    @property
    def parameter_sets(self) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
        """The configuration without the sets that inform tools: `__widget__`, ..."""
        return tuple(each for each in self.configuration if each[0][:2] != "__")


@dataclass(frozen=True, slots=True, kw_only=True)
class PortReference:
    """One end of a connection; `port` without the `<Instance>.` prefix."""

    instance: str
    port: str
    span: Span | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.instance}.{self.port}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """A connection; `properties` by OpenRTM's names (`dataport.subscription_type`, ...).

    `id` is the connector id of an RtsProfile, generated by tools. `places` has the places of its
    properties.
    """

    name: str
    source: PortReference
    target: PortReference
    service: bool
    span: Span
    properties: tuple[tuple[str, str], ...] = ()
    id: str = ""
    places: Mapping[str, Span] = field(default_factory=dict, compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Activation:
    """One step of the start order: `instance`, after `wait_ms` and after those in `after`."""

    instance: str
    sequence: int
    wait_ms: int = 0
    after: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class System:
    """A system of components from an RtsProfile; `activation` in its order.

    `places` has the places of its properties. `created` and `updated` are dates as xsd:dateTime;
    `key` and `sha256` are as in SourceFile, `folder` is the path from the output folder to that
    of the file.
    """

    name: str
    id: str
    file: str
    abstract: str
    components: tuple[SystemComponent, ...]
    connections: tuple[Connection, ...]
    activation: tuple[Activation, ...] = ()
    properties: tuple[tuple[str, str], ...] = ()
    places: Mapping[str, Span] = field(default_factory=dict, compare=False, repr=False)
    created: str = NO_DATE
    updated: str = NO_DATE
    key: str = ""
    sha256: str = ""
    folder: str = ""
