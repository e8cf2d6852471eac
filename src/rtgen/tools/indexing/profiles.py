"""Names of profiles of components: RTC.xml."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.rtc_profile import RtcProfile
from rtgen.tools.indexing.components import component_key
from rtgen.tools.indexing.idl import key_of
from rtgen.tools.indexing.index import Collector, Kind, path_of
from rtgen.tools.indexing.text import Text

_TYPE_ID = re.compile(r"IDL:([\w/]+):[\d.]+")


def named_type(text: str) -> tuple[str, ...]:
    """Return the scoped name of a type in a profile: `A::B`, or `IDL:A/B:1.0`."""
    match = _TYPE_ID.fullmatch(text.strip())
    parts = match[1].split("/") if match else text.strip().split("::")
    return tuple(part for part in parts if part)


class ProfileNames:
    """Adds the names of profiles of components. `texts` are by displayed path."""

    def __init__(self, collector: Collector, texts: Mapping[str, Text]) -> None:
        self._collector = collector
        self._texts = texts

    def add_component(self, profile: RtcProfile) -> None:
        """Add the ports of a component, and the types in it."""
        file = f"file {path_of(profile.file)}"
        key = component_key(profile.name)
        self._collector.define(
            key, profile.name, Kind.COMPONENT, profile.span, container=file
        )
        self._id(profile, key)
        for port in profile.data_ports:
            own = f"{key}.{port.name}"
            self._collector.define(
                own, port.name, Kind.PORT, port.span, container=key, detail=port.type
            )
            self._type(port.type, port.type_span)
        for service in profile.service_ports:
            for interface in service.interfaces:
                own = f"{key}.{interface.name}"
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

    def _id(self, profile: RtcProfile, key: str) -> None:
        """Add the name in the id of the profile: `RTC:vendor:category:name:version`."""
        text = self._texts.get(profile.file)
        if text is not None:
            pattern = rf"RTC:[^:\"'<>]*:[^:\"'<>]*:({re.escape(profile.name)}):"
            if (match := re.search(pattern, text.source)) is not None:
                self._collector.refer(key, text.span(profile.file, *match.span(1)))

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
