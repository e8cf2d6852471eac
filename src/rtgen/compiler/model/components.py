"""Components and systems: ports, configuration, connections."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.declarations import ConstantValue, Declaration, Documented
from rtgen.compiler.model.profile_elements import ProfileElement
from rtgen.compiler.model.spelling import Unspelled
from rtgen.compiler.model.types import ScopedName, Type
from rtgen.facts.activities import kind_of_context
from rtgen.facts.adapter_constants import AdapterConstant

NO_DATE = "1970-01-01T00:00:00+00:00"
"""Default date, since profiles require one and the clock is never read."""
NO_SYSTEM_DATE = "1970-01-01T00:00:00"
"""The default date of systems, without a zone, as in rtsprofile's YAML."""


class PortKind(StrEnum):
    """Kinds of ports; the values are those of `rtgen inspect --json`."""

    INPORT = "inport"
    OUTPORT = "outport"
    PROVIDER = "provider"
    CONSUMER = "consumer"

    @property
    def word(self) -> str:
        """The word in texts for people: `InPort`, `provider`."""
        return {"inport": "InPort", "outport": "OutPort"}.get(self.value, self.value)


class Port(Documented, frozen=True, kw_only=True):
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


class ConfigurationParameter(Documented, frozen=True, kw_only=True):
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


class Component(Declaration, frozen=True, kw_only=True):
    """A component: the CORBA 3 construct read as an RTC. Rate in Hz; dates as xsd:dateTime.

    `ports` and `configuration` include inherited ones, base first. `runtime_base` is the base class
    of its generated base if that is not the runtime's `Component`, and `factory` constructs
    instances if that is not a skeleton for the user to complete; both are written `module:name`,
    where a module with a leading dot is below the generated package. `module` has the generated
    base, if that has no package of its own below `components`. `configuration_base` is the
    runtime's class of parameters that all components of its kind have, if there is one.
    `other_file` contains the IDL definition that a profile of the component replaces. `language` is
    that of its profile.
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
    activity_type: str = ""
    triggers: str = ""
    execution: str = "PeriodicExecutionContext"
    created: str = NO_DATE
    updated: str = NO_DATE
    language: str = "Python"
    runtime_base: str = ""
    configuration_base: str = ""
    factory: str = ""
    module: str = ""
    other_file: str = ""

    @property
    def trigger_ports(self) -> tuple[str, ...]:
        """The InPorts whose samples an EVENTDRIVEN component is executed on; none: all."""
        return tuple(t for text in self.triggers.split(",") if (t := text.strip()))

    @property
    def context_kind(self) -> str:
        """The kind of its own execution context (OMG RTC 1.0, `ExecutionKind`)."""
        return kind_of_context(self.activity)

    @property
    def registered_activity(self) -> str:
        """The text that OpenRTM registers: tools put the component type there."""
        return self.activity_type or self.component_type

    @property
    def is_foreign(self) -> bool:
        """Whether its profile names another language than Python, so that rtgen does not run it."""
        return not self.language.lower().startswith("python")

    @property
    def is_device(self) -> bool:
        """Whether it plays a device, which others reach by its bus: a generated base serves it, and
        the behaviour is the user's.
        """
        return bool(self.runtime_base) and not self.factory

    @property
    def profile_id(self) -> str:
        """The id of the component in profiles of components and systems, written with colons."""
        return ":".join(
            ("RTC", self.vendor, self.category, self.name[-1], self.version)
        )


class Adapter(msgspec.Struct, frozen=True, kw_only=True):
    """Copies members from one struct to another; implemented by the component `name`.

    `copies` are pairs of target member and source member, each as a path of member names.
    Alternatively, `conversion` is a function of `rtgen.runtime.ros2.conversions` that fills the
    target; `stamps`: the target's time is that of the conversion. `constants` are values for
    members of the target.
    """

    name: str
    source: ScopedName
    target: ScopedName
    copies: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
    span: Span
    conversion: str = ""
    stamps: bool = False
    constants: tuple[tuple[tuple[str, ...], AdapterConstant], ...] = ()
    scales: tuple[tuple[tuple[str, ...], float, float], ...] = ()


class SystemComponent(Unspelled, frozen=True, eq=False, kw_only=True):
    """A component of a system. `configuration` maps set id to (parameter, text) pairs.

    Tools store OpenRTM's `__widget__`, `__constraints__` and `__type__` like sets of parameters.
    `conf_files` are the names and texts of its `.conf` files beside the system; `places` has the
    places of its parameters, by set id and parameter. `kind` is that of its execution context,
    which a file only repeats.
    """

    spelling = frozenset({"places", "kind"})

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
    conf_files: tuple[tuple[str, str], ...] = ()
    places: Mapping[tuple[str, str], Span] = msgspec.field(default_factory=dict)
    kind: str = "PERIODIC"

    @property
    def parameter_sets(self) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
        """The configuration without the sets that inform tools: `__widget__`, ..."""
        return tuple(each for each in self.configuration if each[0][:2] != "__")


class PortReference(Unspelled, frozen=True, eq=False, kw_only=True):
    """One end of a connection; `port` without the `<Instance>.` prefix."""

    spelling = frozenset({"span"})

    instance: str
    port: str
    span: Span | None = None

    def __str__(self) -> str:
        return f"{self.instance}.{self.port}"


class Connection(Unspelled, frozen=True, eq=False, kw_only=True):
    """A connection; `properties` by OpenRTM's names (`dataport.subscription_type`, ...).

    `id` is the connector id of an RtsProfile, generated by tools. `places` has the places of its
    properties.
    """

    spelling = frozenset({"places"})

    name: str
    source: PortReference
    target: PortReference
    service: bool
    span: Span
    properties: tuple[tuple[str, str], ...] = ()
    id: str = ""
    places: Mapping[str, Span] = msgspec.field(default_factory=dict)


class Activation(msgspec.Struct, frozen=True, kw_only=True):
    """One step of the start order: `instance`, after `wait_ms` and after those in `after`."""

    instance: str
    sequence: int
    wait_ms: int = 0
    after: tuple[str, ...] = ()


class System(Unspelled, frozen=True, eq=False, kw_only=True):
    """A system of components from an RtsProfile; `activation` in its order.

    `places` has the places of its properties. `created` and `updated` are dates as xsd:dateTime;
    `key` and `sha256` are as in SourceFile, `folder` is the path from the output folder to that of
    the file. `document` is the file's content; elements without a field here are kept when the
    system is saved.
    """

    spelling = frozenset({"places", "document"})

    name: str
    id: str
    file: str
    abstract: str
    components: tuple[SystemComponent, ...]
    connections: tuple[Connection, ...]
    activation: tuple[Activation, ...] = ()
    properties: tuple[tuple[str, str], ...] = ()
    places: Mapping[str, Span] = msgspec.field(default_factory=dict)
    created: str = NO_SYSTEM_DATE
    updated: str = NO_SYSTEM_DATE
    key: str = ""
    sha256: str = ""
    folder: str = ""
    document: ProfileElement | None = None
