"""Generates systems for OpenRTM: scripts to start and stop, RtsProfile, conf files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

from msgspec.structs import replace

from rtgen.compiler.backends import Artifact
from rtgen.compiler.backends.kit.python_text import (
    fit,
    header,
    header_comment,
    tuple_of,
)
from rtgen.compiler.backends.kit.quoting.code import HashComment
from rtgen.compiler.backends.kit.quoting.properties import (
    Conf,
    is_conf_key,
    is_conf_value,
)
from rtgen.compiler.backends.kit.quoting.python import number_literal, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.profiles.rts_profile import InstancePorts, system_text
from rtgen.compiler.diagnostics import Diagnostic, Span, has_errors
from rtgen.compiler.model import (
    Activation,
    Connection,
    Port,
    PortKind,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.system_links import (
    Known,
    Pair,
    interface_key,
    interfaces,
    service_pairs,
)
from rtgen.compiler.systems.conditions import PER_CYCLE
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.openrtm_ports import key_of, names_of
from rtgen.facts.connector_properties import (
    OVERRIDE,
    OWN_PORT,
    STRICTNESS,
    own_properties,
)
from rtgen.facts.openrtm_ports import SERVICE, foreign_instances, known_name
from rtgen.openrtm.backend import system_rules as rules
from rtgen.openrtm.backend.plan import ROOT, ComponentPlan
from rtgen.openrtm.backend.rules import CONF_TEXT

_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "corba_cdr",
    "dataport.subscription_type": "flush",
    "dataport.publisher.push_policy": "new",
    "dataport.serializer.cdr.endian": "little,big",
    "dataport.buffer.length": "8",
    "dataport.buffer.write.full_policy": "overwrite",
    "dataport.buffer.write.timeout": "1.0",
    "dataport.buffer.read.empty_policy": "readback",
    "dataport.buffer.read.timeout": "1.0",
}
"""Properties given explicitly: OpenRTM would reuse those of a port's earlier connections."""

_STEM = re.compile(r"[^/\\:\x00-\x1f]+")

_LINE_END = re.compile(r"\r\n|\r|\n")
"""Line ends of OpenRTM; a comment may contain other line ends of Unicode."""

_CONF_LINE = re.compile(
    r"\s*conf\.(?P<set>[^.\s]+)\.(?P<name>[^:=\s]+)\s*[:=](?P<text>.*)"
)


@dataclass(frozen=True, slots=True)
class _Instance:
    """A component of a system with its plan; `per_cycle` are values by parameter."""

    component: SystemComponent
    plan: ComponentPlan
    per_cycle: Mapping[str, float]

    @property
    def rate(self) -> float:
        return self.component.rate or self.plan.component.rate


def system_artifacts(
    systems: Sequence[System], plans: Iterable[ComponentPlan], version: str
) -> tuple[list[Artifact], list[Diagnostic]]:
    """Return the folders of all systems, with diagnostics specific to OpenRTM.

    The systems have no errors: their components, ports and types exist.
    """
    by_type = {plan.name: plan for plan in plans}
    folders = {
        plan.name.casefold(): f"component {plan.name}" for plan in by_type.values()
    }
    artifacts: list[Artifact] = []
    findings: list[Diagnostic] = []
    for system in systems:
        name = folder_name(system)
        taken = folders.setdefault(name.casefold(), f"system {system.file}")
        if taken != f"system {system.file}":
            message = f"the {taken} has the folder `{ROOT}/{name}` already"
            span = Span(system.file, 1, 1, 1, 2)
            findings.append(
                rules.SYSTEM_FOLDER.at(span, message, hint="rename the file")
            )
            continue
        writer = _Writer(system, name, by_type, version)
        findings += writer.findings
        if not has_errors(writer.findings):
            artifacts += writer.artifacts()
    return artifacts, findings


def folder_name(system: System) -> str:
    """Return the folder of a system: the stem of its file, or its folder for `system.xml`."""
    parts = system.key.split("/")
    stem = parts[-1].rpartition(".")[0]
    if stem == "system" and len(parts) > 1:
        stem = parts[-2]
    return stem if _STEM.fullmatch(stem) else "system"


class _Writer:
    """Generates the files of one system."""

    def __init__(
        self,
        system: System,
        name: str,
        plans: Mapping[str, ComponentPlan],
        version: str,
    ) -> None:
        self.findings: list[Diagnostic] = []
        self._name = name
        self._folder = f"{ROOT}/{name}"
        self._version = version
        self._plans = {c.instance: plans[c.type] for c in system.components}
        self._ends = {
            instance: Known(plan.component, plan.unit.model)
            for instance, plan in self._plans.items()
        }
        self._foreign = foreign_instances(system.properties) + [
            instance for instance, plan in self._plans.items() if plan.is_foreign
        ]
        self._pairs: dict[int, list[Pair]] = {}
        self._connections = [
            self._connection(c) for c in system.connections if self._is_possible(c)
        ]
        for c in system.components:
            if not (_STEM.fullmatch(c.instance) and is_conf_key(c.instance)):
                message = f"an instance cannot be called {c.instance!r} on OpenRTM"
                self.findings.append(rules.INSTANCE_NAME.at(c.span, message))
            if not is_conf_value(c.active_set):
                message = f"the set {c.active_set!r} of {c.instance!r} cannot be active"
                self.findings.append(CONF_TEXT.at(c.span, message))
        if not is_conf_value(system.folder):
            message = f"the folder of the system, {system.folder!r}, cannot be written"
            self.findings.append(CONF_TEXT.at(Span(system.file, 1, 1, 1, 2), message))
        self._system = replace(
            system,
            connections=tuple(self._connections),
            activation=self._activation(system),
        )
        per_cycle = self._per_cycle(plans)
        self._instances = {
            c.instance: _Instance(c, plans[c.type], per_cycle.get(c.instance, {}))
            for c in system.components
        }

    def artifacts(self) -> Iterator[Artifact]:
        """Yield all files."""
        yield self._artifact("start.sh", self._script("start.sh.j2"))
        yield self._artifact("connect.py", self._connect_script())
        yield self._artifact("stop.sh", self._script("stop.sh.j2"))
        yield self._artifact(f"{self._name}.xml", self._profile())
        for name, instance in self._instances.items():
            if name in self._foreign:
                continue
            yield self._artifact(
                f"{instance.component.instance}.conf", self._conf(instance)
            )

    def _artifact(self, name: str, text: str) -> Artifact:
        return Artifact(f"{self._folder}/{name}", text, (self._system.key,))

    def _header(self) -> tuple[str, ...]:
        return header(self._version, [self._system.key])

    def _header_comment(self) -> HashComment:
        return header_comment(self._version, [self._system.key])

    # Connections.

    def _is_possible(self, connection: Connection) -> bool:
        own = dict(connection.properties).get(OWN_PORT)
        if own is not None:
            message = (
                f"the connector is left out: {own} is a port of the behaviour's own"
            )
            self.findings.append(rules.OWN_PORT.at(connection.span, message))
        return own is None

    def _connection(self, connection: Connection) -> Connection:
        """Return the connection with OpenRTM's names of ports, and all properties."""
        source: PortKind | None = None
        target: PortKind | None = None
        stated = own_properties(connection.properties)
        if connection.service:
            pairs, lonely = service_pairs(connection, self._ends)
            for end, consumer in lonely:
                message = (
                    f"{end}: its consumer of {consumer.type} would find no provider"
                )
                diagnostic = rules.LONELY_CONSUMER.at(
                    end.span or connection.span, message
                )
                self.findings.append(diagnostic)
            self._pairs[id(connection)] = pairs
            properties = {
                STRICTNESS: "best_effort" if lonely else "strict",
                **{
                    self._interface_key(p.consumer_end, p.consumer): (
                        self._interface_key(p.provider_end, p.provider)
                    )
                    for p in pairs
                },
            }
        else:
            own = {
                key.removeprefix(OVERRIDE): text
                for key, text in connection.properties
                if key.startswith(OVERRIDE)
            }
            properties = {**_DEFAULTS, **stated, **own}
            properties["dataport.data_type"] = self._data_type(connection.source)
            source, target = PortKind.OUTPORT, PortKind.INPORT
        return replace(
            connection,
            source=self._renamed(connection.source, source),
            target=self._renamed(connection.target, target),
            properties=tuple(properties.items()),
        )

    def _renamed(self, end: PortReference, kind: PortKind | None) -> PortReference:
        """Return one end with OpenRTM's port name; `kind` None for a service port."""
        component = self._ends[end.instance].component
        ports = (
            interfaces(end, self._ends)
            if kind is None
            else [p for p in component.ports if p.kind is kind and p.name == end.port]
        )
        registered = names_of(component)[key_of(ports[0])]
        return replace(end, port=known_name(registered))

    def _interface_key(self, end: PortReference, port: Port) -> str:
        """Return OpenRTM's name of an interface in the properties of a connector."""
        [interface] = [
            interface
            for service in self._plans[end.instance].service_ports
            for interface in service.interfaces
            if interface.port == port
        ]
        registered = replace(port, type_name=interface.type_name)
        return interface_key(self._renamed(end, None), registered)

    def _data_type(self, end: PortReference) -> str:
        ports = self._plans[end.instance].out_ports
        return next(p.type.repository_id for p in ports if p.port.name == end.port)

    # Order and rates.

    def _activation(self, system: System) -> tuple[Activation, ...]:
        """Return the order of the system, with providers before their callers."""
        needs: dict[str, set[str]] = {c.instance: set() for c in system.components}
        for pairs in self._pairs.values():
            for pair in pairs:
                needs[pair.consumer_end.instance].add(pair.provider_end.instance)
        by_instance = {step.instance: step for step in system.activation}
        waiting = list(by_instance)
        ordered: list[Activation] = []
        while waiting:
            pending = set(waiting)
            # Components that call each other in a cycle are in the system's order.
            ready = next(
                (i for i in waiting if not needs[i] & (pending - {i})), waiting[0]
            )
            waiting.remove(ready)
            step = by_instance[ready]
            before = {step.instance for step in ordered}
            after = (*step.after, *sorted(needs[ready] - {ready}))
            ordered.append(
                replace(
                    step,
                    sequence=len(ordered) + 1,
                    after=tuple(i for i in dict.fromkeys(after) if i in before),
                )
            )
        return tuple(ordered)

    def _per_cycle(
        self, plans: Mapping[str, ComponentPlan]
    ) -> dict[str, dict[str, float]]:
        """Return the parameters listed by the system, with their values in it."""
        listed = dict(self._system.properties).get(PER_CYCLE, "")
        components = {c.instance: c for c in self._system.components}
        rates: dict[str, dict[str, float]] = {}
        for entry in filter(None, map(str.strip, listed.split(","))):
            instance, _, name = entry.partition(".")
            c = components.get(instance)
            value = None if c is None else _value(c, plans[c.type], name)
            if value is None:
                message = f"`{PER_CYCLE}`: {entry} is not a parameter with a number"
                span = Span(self._system.file, 1, 1, 1, 2)
                self.findings.append(rules.PER_CYCLE.at(span, message))
            else:
                rates.setdefault(instance, {})[name] = value
        return rates

    # Files.

    def _profile(self) -> str:
        ports = {}
        for instance, ends in self._ends.items():
            names = names_of(ends.component)
            data = [known_name(names[key]) for key in names if key[0] != SERVICE]
            service = [known_name(names[key]) for key in names if key[0] == SERVICE]
            ports[instance] = InstancePorts(tuple(data), tuple(service))
        components = [
            replace(
                i.component,
                id=i.plan.component.profile_id,
                rate=i.rate,
                kind=i.plan.component.context_kind,
                path_uri=(
                    i.component.path_uri
                    if name in self._foreign
                    else f"localhost/{name}.rtc"
                ),
            )
            for name, i in self._instances.items()
        ]
        system = replace(self._system, components=tuple(components))
        return system_text(system, ports, self._header())

    def _conf(self, instance: _Instance) -> str:
        c = instance.component
        return render(
            "openrtm/instance.conf.j2",
            header=self._header_comment(),
            instance=c.instance,
            rate=number_literal(instance.rate),
            # modules are started in their own folders
            folder=f"../../{self._system.folder}" if self._system.folder else "",
            beside=[
                Conf(line)
                for _, text in c.conf_files
                for line in _LINE_END.split(text.strip())
                if text.strip()
            ],
            sets=[
                (set_id, name, text)
                for set_id, values in c.parameter_sets
                for name, text in values
                if is_conf_key(set_id) and is_conf_key(name) and is_conf_value(text)
            ],
            active=c.active_set,
        )

    def _script(self, template: str) -> str:
        started = [step.instance for step in self._system.activation]
        order = [name for name in started if name not in self._foreign]
        return render(
            f"openrtm/{template}",
            header=self._header_comment(),
            name=self._name,
            instances=[
                {
                    "name": name,
                    "type": self._instances[name].plan.name,
                    "option": f"{self._instances[name].plan.component.category}.{name}"
                    f".config_file:../{self._name}/{name}.conf",
                    "log": f"../{self._name}/run/{name}.log",
                    "stubs": bool(self._instances[name].plan.own_idl_files),
                }
                for name in order
            ],
        )

    def _connect_script(self) -> str:
        steps = {step.instance: step for step in self._system.activation}
        instances = [
            _instance_text(
                self._instances[name], step.wait_ms, foreign=name in self._foreign
            )
            for name, step in steps.items()
        ]
        connections = [_connection_text(c) for c in self._connections]
        system = (
            f"SYSTEM = System(name={string_literal(self._name)}, "
            f"instances={tuple_of(instances).flat}, "
            f"connections={tuple_of(connections).flat})"
        )
        has_data = any(not c.service for c in self._connections)
        return render(
            "openrtm/connect.py.j2",
            header=self._header_comment(),
            name=self._name,
            data=fit(f"DATA = {_mapping(_DEFAULTS)}") if has_data else "",
            system=fit(system),
        )


def _value(c: SystemComponent, plan: ComponentPlan, name: str) -> float | None:
    """Return the number of a parameter: from the system, a conf file, or the definition."""
    parameter = next((p for p in plan.component.configuration if p.name == name), None)
    if parameter is None:
        return None
    texts = [Parameters(plan.unit.model).default_text(parameter)]
    for line in "\n".join(text for _, text in c.conf_files).splitlines():
        match = _CONF_LINE.fullmatch(line)
        if match and (match["set"], match["name"]) == (c.active_set, name):
            texts.append(match["text"].strip())
    for set_id, values in c.parameter_sets:
        texts += [t for n, t in values if (set_id, n) == (c.active_set, name)]
    try:
        value = float(texts[-1])
    except ValueError:
        return None
    return value if isfinite(value) else None


def _instance_text(instance: _Instance, wait_ms: int, *, foreign: bool) -> str:
    c = instance.component
    parts = [string_literal(c.instance), f"rate={number_literal(instance.rate)}"]
    if c.configuration:
        sets = (
            f"{string_literal(set_id)}: {_mapping(dict(values))}"
            for set_id, values in c.parameter_sets
        )
        parts.append(f"configuration={{{', '.join(sets)}}}")
    if c.active_set != "default":
        parts.append(f"active_set={string_literal(c.active_set)}")
    if instance.per_cycle:
        pairs = (
            f"{string_literal(n)}: {number_literal(v)}"
            for n, v in instance.per_cycle.items()
        )
        parts.append(f"per_cycle={{{', '.join(pairs)}}}")
    if wait_ms:
        parts.append(f"wait={number_literal(wait_ms / 1000)}")
    if foreign:
        parts.append(
            f"foreign={string_literal(c.path_uri or f'localhost/{c.instance}.rtc')}"
        )
    return f"Instance({', '.join(parts)})"


def _connection_text(connection: Connection) -> str:
    texts = (connection.name, str(connection.source), str(connection.target))
    properties = dict(connection.properties)
    if connection.service:
        mapping = _mapping(properties)
    else:
        own = {k: v for k, v in properties.items() if _DEFAULTS.get(k) != v}
        mapping = _mapping(own, "**DATA")
    arguments = [*map(string_literal, texts), mapping]
    if connection.id not in ("", connection.name):
        arguments.append(f"id={string_literal(connection.id)}")
    return f"Connection({', '.join(arguments)})"


def _mapping(pairs: Mapping[str, str], *first: str) -> str:
    items = (f"{string_literal(k)}: {string_literal(v)}" for k, v in pairs.items())
    return f"{{{', '.join((*first, *items))}}}"
