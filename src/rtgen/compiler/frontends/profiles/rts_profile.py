"""Reads systems: RtsProfile 0.2, the files of RT System Editor and rtshell, in XML or YAML.

Names are resolved by namespace; unknown elements are ignored; what real files omit is optional.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.profiles import profile_tree
from rtgen.compiler.frontends.profiles.rules import (
    CYCLE,
    ID,
    MISSING,
    NO_END,
    NOT_A_SYSTEM,
    NUMBER,
    OTHER_ID,
    SAME_INSTANCE,
    UNKNOWN_INSTANCE,
)
from rtgen.compiler.model import (
    Activation,
    Connection,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.components import NO_SYSTEM_DATE
from rtgen.compiler.model.profile_elements import RTS, RTS_EXT, ProfileElement
from rtgen.facts.connector_properties import PROFILE_ATTRIBUTES

_DROPPED = frozenset(
    f"dataport.corba_cdr.{end}_{form}"
    for end in ("inport", "outport")
    for form in ("ior", "ref")
)


class SystemResult(NamedTuple):
    """Result of `load`: no system if there are errors; `sources` maps displayed path to text."""

    system: System | None
    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[str, str]


def load(
    path: Path, *, display: str | None = None, encoding: str = "auto"
) -> SystemResult:
    """Read a system. All errors of the input are among the diagnostics.

    `display` is the path in diagnostics, by default `path`; `encoding` that of YAML that is not
    UTF-8.
    """
    file = display if display is not None else path.as_posix()
    findings = profile_tree.sink()
    data = profile_tree.read(path, file, findings.report)
    if data is None:
        return SystemResult(None, findings.diagnostics, {})
    return load_bytes(data, file, encoding)


def load_bytes(data: bytes, file: str, encoding: str = "auto") -> SystemResult:
    """Read a system from the bytes of a file; `file` is the path in diagnostics."""
    findings = profile_tree.sink()
    root, text = profile_tree.parse(data, file, findings.report, encoding)
    system = None if root is None else _Reader(file, findings).system(root)
    return SystemResult(
        None if findings.errors else system, findings.diagnostics, {file: text}
    )


class _Reader:
    """Builds the model from the tree; reports to `findings`."""

    def __init__(self, file: str, findings: Findings) -> None:
        self._findings = findings
        self._file = file
        self._components: dict[str, SystemComponent] = {}

    def system(self, root: Element) -> System | None:
        if root.name != (RTS, "RtsProfile"):
            message = f"the root element is `{root.name[1]}`, not `RtsProfile` of {RTS}"
            self._findings.add(NOT_A_SYSTEM, root.span, message)
            return None
        for element in root.all(RTS, "Components"):
            self._add_component(element)
        id_ = root.get(RTS, "id")
        return System(
            name=_part_of_id(id_, "RTSystem", 1) or Path(self._file).stem,
            id=id_,
            file=self._file,
            abstract=root.get(RTS, "abstract"),
            components=tuple(self._components.values()),
            connections=tuple(self._connections(root)),
            activation=self._activation(root.first(RTS, "Activation")),
            properties=tuple(_properties(root).items()),
            places={
                item.get(RTS_EXT, "name"): item.place("value")
                for item in root.all(RTS_EXT, "Properties")
            },
            created=root.get(RTS, "creationDate") or NO_SYSTEM_DATE,
            updated=root.get(RTS, "updateDate") or NO_SYSTEM_DATE,
            document=_document(root),
        )

    def _required(self, element: Element, name: str) -> str | None:
        value = element.get(RTS, name)
        if value:
            return value
        span = element.place(name)
        if name in {local for _, local in element.attributes} and value == "":
            message = f"`rts:{name}` of `{element.name[1]}` is empty or not qualified by `rts:`"
        else:
            message = f"`{element.name[1]}` has no `rts:{name}`"
        self._findings.add(MISSING, span, message)
        return None

    def _add_component(self, element: Element) -> None:
        instance = self._required(element, "instanceName")
        id_ = self._required(element, "id")
        if instance is None or id_ is None:
            return
        type_ = _part_of_id(id_, "RTC", 2)
        if not type_:
            message = f"id {id_!r} of {instance!r} names no component type"
            hint = "RTC:vendor:category:type:version"
            self._findings.add(ID, element.place("id"), message, hint=hint)
            return
        span = element.place("instanceName")
        earlier = self._components.get(instance)
        if earlier is not None:
            related = [Related(earlier.span, "the other component")]
            message = f"two components are called {instance!r}"
            self._findings.report(SAME_INSTANCE.at(span, message, related=related))
            return
        places: dict[tuple[str, str], Span] = {}
        self._components[instance] = SystemComponent(
            instance=instance,
            type=type_,
            id=id_,
            path_uri=element.get(RTS, "pathUri"),
            span=span,
            rate=self._rate(element),
            active_set=element.get(RTS, "activeConfigurationSet") or "default",
            configuration=tuple(self._configuration(element, places)),
            location=self._location(element),
            required=element.get(RTS, "isRequired", "true").lower() in ("true", "1"),
            places=places,
        )

    def _rate(self, element: Element) -> float | None:
        context = element.first(RTS, "ExecutionContexts")
        text = context.get(RTS, "rate") if context is not None else ""
        if context is None or not text:
            return None
        try:
            rate = float(text)
        except ValueError:
            rate = -1.0
        if isfinite(rate) and rate >= 0:
            # rtsprofile writes zero for a context without a rate.
            return rate or None
        self._findings.add(
            NUMBER,
            context.place("rate"),
            f"rate {text!r} is not a frequency above 0 Hz",
        )
        return None

    def _configuration(
        self, element: Element, places: dict[tuple[str, str], Span]
    ) -> Iterator[tuple[str, tuple[tuple[str, str], ...]]]:
        """Yield the configuration sets; records the places of their values in `places`."""
        for values in element.all(RTS, "ConfigurationSets"):
            set_id = self._required(values, "id")
            pairs = []
            for item in values.all(RTS, "ConfigurationData"):
                name = self._required(item, "name")
                if name is not None:
                    pairs.append((name, item.get(RTS, "data")))
                    places[set_id or "", name] = item.place("name")
            if set_id is not None:
                yield set_id, tuple(pairs)

    def _location(self, element: Element) -> tuple[int, int, int, int] | None:
        location = element.first(RTS_EXT, "Location")
        if location is None:
            return None
        parts = [
            self._integer(location, RTS_EXT, name, 0 if name in "xy" else -1)
            for name in ("x", "y", "width", "height")
        ]
        return (parts[0], parts[1], parts[2], parts[3])

    def _integer(
        self, element: Element, namespace: str, name: str, default: int
    ) -> int:
        text = element.get(namespace, name)
        if not text.strip():
            return default
        try:
            return int(text)
        except ValueError:
            message = f"`{name}` of `{element.name[1]}` is {text!r}, no whole number"
            self._findings.add(NUMBER, element.place(name), message)
            return default

    def _instance(self, element: Element) -> str | None:
        """Return the instance that an element refers to; None, after a diagnostic, without one."""
        instance = self._required(element, "instanceName")
        if instance is None:
            return None
        component = self._components.get(instance)
        if component is None:
            hint = f"the system has {', '.join(self._components) or 'no components'}"
            message = f"no component is called {instance!r}"
            self._findings.add(
                UNKNOWN_INSTANCE, element.place("instanceName"), message, hint=hint
            )
            return None
        id_ = element.get(RTS, "componentId")
        if id_ and id_ != component.id:
            message = f"{instance!r} has the id {component.id!r}, not {id_!r}"
            self._findings.add(OTHER_ID, element.place("componentId"), message)
        return instance

    def _connections(self, root: Element) -> Iterator[Connection]:
        for element in root.children:
            if element.name == (RTS, "DataPortConnectors"):
                service = False
            elif element.name == (RTS, "ServicePortConnectors"):
                service = True
            else:
                continue
            connection = self._connection(element, service)
            if connection is not None:
                yield connection

    def _connection(self, element: Element, service: bool) -> Connection | None:
        kind = "Service" if service else "Data"
        source = self._end(element, f"source{kind}Port")
        target = self._end(element, f"target{kind}Port")
        if source is None or target is None:
            return None
        properties: dict[str, str] = {}
        places: dict[str, Span] = {}
        if not service:
            for key, attribute in PROFILE_ATTRIBUTES.items():
                value = element.get(RTS, attribute)
                if value:
                    properties[key] = value
                    places[key] = element.place(attribute)
        for item in element.all(RTS_EXT, "Properties"):
            key, value = item.get(RTS_EXT, "name"), item.get(RTS_EXT, "value")
            # Object references saved by an editor are invalid in another run.
            if key and key not in _DROPPED and not value.startswith("IOR:"):
                properties[key] = value
                places[key] = item.place("name")
        identity = element.get(RTS, "connectorId") or ""
        name = element.get(RTS, "name") or identity
        return Connection(
            id=identity,
            name=name or f"{source}_{target}",
            source=source,
            target=target,
            service=service,
            span=element.span,
            properties=tuple(properties.items()),
            places=places,
        )

    def _end(self, element: Element, name: str) -> PortReference | None:
        ends = list(element.all(RTS, name))
        if len(ends) != 1:
            message = (
                f"a connector has one `rts:{name}`; this one has {len(ends) or 'none'}"
            )
            self._findings.add(NO_END, element.span, message)
            return None
        instance = self._instance(ends[0])
        port = self._required(ends[0], "portName")
        if instance is None or port is None:
            return None
        return PortReference(
            instance=instance,
            port=port.removeprefix(f"{instance}."),
            span=ends[0].place("portName"),
        )

    def _activation(self, element: Element | None) -> tuple[Activation, ...]:
        if element is None:
            required = [c for c in self._components.values() if c.required]
            others = [c for c in self._components.values() if not c.required]
            return tuple(
                Activation(instance=component.instance, sequence=number)
                for number, component in enumerate(required + others, 1)
            )
        steps = [self._step(target) for target in element.all(RTS, "targets")]
        ordered = sorted(
            (step for step in steps if step is not None), key=lambda s: s.sequence
        )
        return self._resolved(ordered, element.span)

    def _step(self, target: Element) -> Activation | None:
        component = target.first(RTS, "TargetComponent")
        if component is None:
            self._findings.add(
                MISSING, target.span, "`targets` has no `rts:TargetComponent`"
            )
            return None
        instance = self._instance(component)
        sequence = self._integer(target, RTS, "sequence", 0)
        wait = target.first(RTS, "WaitTime")
        wait_ms = self._integer(wait, RTS, "waitTime", 0) if wait is not None else 0
        if wait is not None and wait_ms < 0:
            self._findings.add(
                NUMBER,
                wait.place("waitTime"),
                f"waiting time {wait_ms} ms is below zero",
            )
        after = [
            self._instance(preceding)
            for condition in target.all(RTS, "Preceding")
            for preceding in condition.all(RTS, "PrecedingComponents")
        ]
        if instance is None or None in after:
            return None
        return Activation(
            instance=instance,
            sequence=sequence,
            wait_ms=wait_ms,
            after=tuple(name for name in after if name is not None),
        )

    def _resolved(self, steps: list[Activation], span: Span) -> tuple[Activation, ...]:
        """Return the steps in their sequence, each after those that it waits for."""
        started: list[Activation] = []
        waiting = steps
        while waiting:
            pending = {step.instance for step in waiting}
            ready = next(
                (s for s in waiting if not pending.intersection(s.after)), None
            )
            if ready is None:
                names = ", ".join(step.instance for step in waiting)
                self._findings.add(CYCLE, span, f"{names} wait for each other")
                return ()
            started.append(ready)
            waiting = [step for step in waiting if step is not ready]
        return tuple(started)


def _document(element: Element) -> ProfileElement:
    return ProfileElement(
        name=element.name,
        attributes=element.attributes,
        children=tuple(map(_document, element.children)),
        text=element.text.strip() if element.children else element.text,
    )


def _part_of_id(id_: str, prefix: str, index: int) -> str:
    """Return a part of a profile's id, `prefix:part0:part1...:version`, or with dots."""
    head, _, rest = id_.partition(":")
    body, _, _ = rest.rpartition(":")
    parts = body.split(":") if ":" in body else body.split(".")
    if head != prefix or len(parts) <= index:
        return ""
    return ":".join(parts[index:]) if ":" in body else parts[-1]


def _properties(element: Element) -> dict[str, str]:
    return {
        name: item.get(RTS_EXT, "value")
        for item in element.all(RTS_EXT, "Properties")
        if (name := item.get(RTS_EXT, "name"))
    }
