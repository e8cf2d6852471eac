"""Names of profiles: components with ports (RTC.xml), instances with connections (RtsProfile)."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Component, Model, PortReference, System
from rtgen.compiler.model.rtc_profile import RtcProfile
from rtgen.tools.lsp.indexing.idl import key_of
from rtgen.tools.lsp.indexing.index import Collector, Kind, path_of
from rtgen.tools.lsp.text import Text

_TYPE_ID = re.compile(r"IDL:([\w/]+):[\d.]+")


def component_key(name: str) -> str:
    """Return the key of a component that a profile defines."""
    return f"component {name}"


def named_type(text: str) -> tuple[str, ...]:
    """Return the scoped name of a type in a profile: `A::B`, or `IDL:A/B:1.0`."""
    match = _TYPE_ID.fullmatch(text.strip())
    parts = match[1].split("/") if match else text.strip().split("::")
    return tuple(part for part in parts if part)


class ProfileNames:
    """Adds the names of profiles of components and systems. `texts` are by displayed path."""

    def __init__(
        self, collector: Collector, model: Model, texts: Mapping[str, Text]
    ) -> None:
        self._collector = collector
        self._texts = texts
        self._components: dict[str, str] = {}
        self._ports: dict[tuple[str, str], str] = {}
        profiles = {profile.name for profile in model.profiles}
        for declaration in model.declarations:
            if isinstance(declaration, Component):
                self._declared(declaration, profiles)
        for profile in model.profiles:
            self._components[profile.name] = component_key(profile.name)

    def _declared(self, component: Component, profiles: set[str]) -> None:
        name = component.name[-1]
        if name in profiles:
            return
        self._components.setdefault(name, key_of(component.name))
        for port in component.ports:
            key = key_of((*component.name, port.identifier))
            self._ports.setdefault((name, port.name), key)
            if port.port:
                self._ports.setdefault((name, port.port), key)

    def add_component(self, profile: RtcProfile) -> None:
        """Add the ports of a component, and the types in it."""
        file = f"file {path_of(profile.file)}"
        key = component_key(profile.name)
        self._collector.define(
            key, profile.name, Kind.COMPONENT, profile.span, container=file
        )
        for port in profile.data_ports:
            own = f"{key}.{port.name}"
            self._ports[profile.name, port.name] = own
            self._collector.define(
                own, port.name, Kind.PORT, port.span, container=key, detail=port.type
            )
            self._type(port.type, port.type_span)
        for service in profile.service_ports:
            for interface in service.interfaces:
                own = f"{key}.{interface.name}"
                self._ports[profile.name, interface.name] = own
                self._ports.setdefault((profile.name, service.name), own)
                self._collector.define(
                    *(own, interface.name, Kind.PORT, interface.span),
                    container=key,
                    detail=interface.type,
                )
                self._type(interface.type, interface.type_span)
        for parameter in profile.parameters:
            own = f"{key}.{parameter.name}"
            self._collector.define(
                *(own, parameter.name, Kind.ATTRIBUTE, parameter.span),
                container=key,
                detail=parameter.type,
            )

    def add_system(self, system: System) -> None:
        """Add the instances of a system, their components and ports, and types."""
        file = path_of(system.file)
        types = {}
        for component in system.components:
            key = f"rts {file}#{component.instance}"
            types[component.instance] = component.type
            self._collector.define(
                *(key, component.instance, Kind.INSTANCE, component.span),
                detail=component.type,
            )
            definition = self._components.get(component.type)
            place = self._inside(component.span, component.type)
            if definition is not None and place is not None:
                self._collector.refer(definition, place)
        for connection in system.connections:
            for end in (connection.source, connection.target):
                self._port(end, types.get(end.instance, ""), str(file))
            for name, value in connection.properties:
                place = connection.places.get(name)
                if name == "dataport.data_type" and place is not None:
                    self._type(value, place)

    def _port(self, end: PortReference, type_: str, file: str) -> None:
        key = self._ports.get((type_, end.port))
        if end.span is None:
            return
        if key is not None:
            self._collector.refer(key, self._inside(end.span, end.port) or end.span)
        place = self._inside(end.span, end.instance)
        if place is not None and place != end.span:
            self._collector.refer(f"rts {file}#{end.instance}", place)

    def _type(self, written: str, span: Span) -> None:
        name = named_type(written)
        if name:
            place = self._inside(span, name[-1], last=True)
            self._collector.refer(key_of(name), place or span)

    def _inside(self, span: Span, word: str, *, last: bool = False) -> Span | None:
        """Return the place of a word on the line of a value, in the value or its tag."""
        text = self._texts.get(span.file)
        if text is None or not word:
            return None
        start, end = text.offsets(span)
        pattern = re.compile(rf"(?<!\w){re.escape(word)}(?!\w)")
        matches = list(pattern.finditer(text.source, start, end))
        if not matches:
            begin = text.source.rfind("<", 0, start) + 1
            stop = text.source.find(">", start)
            matches = list(
                pattern.finditer(
                    text.source, begin, stop if stop > 0 else len(text.source)
                )
            )
        if not matches:
            return None
        return text.span(span.file, *matches[-1 if last else 0].span())
