"""Names of device descriptions and bus files: objects by index, nodes, kinds of device, PDOs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit.located_toml import Path, Toml
from rtgen.compiler.kit.toml_text import TomlError
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import Device, Variable
from rtgen.facts.canopen import RPDO_COMMUNICATION, TPDO_COMMUNICATION
from rtgen.tools.indexing.index import Collector, Kind, path_of
from rtgen.tools.indexing.text import Text

_MAPPINGS = (range(0x1600, 0x1800), range(0x1A00, 0x1C00))
_OBJECT = re.compile(r"([0-9A-Fa-f]{4})(?::([0-9A-Fa-f]{1,2}))?")
_END = re.compile(r"(\w+)\.(tpdo|rpdo)(\d{1,3})")
_FIRST_OF_PDOS = {"tpdo": TPDO_COMMUNICATION, "rpdo": RPDO_COMMUNICATION}


def object_key(file: str, index: int, subindex: int | None = None) -> str:
    """Return the key of an object or sub-object of a device description."""
    sub = "" if subindex is None else f":{subindex:X}"
    return f"eds {path_of(file)}#{index:04X}{sub}"


def add_device(collector: Collector, device: Device) -> None:
    """Add the objects of a device description, and those mapped by its PDOs."""
    device_key = f"file {path_of(device.file)}"
    for entry in device.objects:
        key = object_key(device.file, entry.index)
        name = f"{entry.index:04X} {entry.name}"
        collector.define(key, name, Kind.OBJECT, entry.span, container=device_key)
        for variable in entry.variables:
            own = object_key(device.file, entry.index, variable.subindex)
            if variable.span == entry.span:
                continue
            name = f"{variable.index:04X}:{variable.subindex:X} {variable.name}"
            collector.define(own, name, Kind.MEMBER, variable.span, container=key)
    for variable in device.variables:
        mapped = _mapped(variable)
        if mapped is not None and variable.value_span != variable.span:
            target = _key(device, *mapped)
            if target is not None:
                collector.refer(target, variable.value_span)


def _mapped(variable: Variable) -> tuple[int, int] | None:
    """Return the object of an entry of a PDO mapping."""
    value = variable.current
    if (
        not variable.subindex
        or not isinstance(value, int)
        or not any(variable.index in indexes for indexes in _MAPPINGS)
    ):
        return None
    return value >> 16, value >> 8 & 0xFF


def _key(device: Device, index: int, subindex: int | None) -> str | None:
    """Return the key of the device's object; for a plain variable, without sub-index."""
    for entry in device.objects:
        if entry.index == index:
            alone = subindex is None or len(entry.variables) == 1
            return object_key(device.file, index, None if alone else subindex)
    return None


_HEADER = re.compile(
    r"""^[ \t]*\[\s*(device|node)\s*\.\s*["']?([\w-]+)["']?\s*[.\]]""", re.M
)
"""The header of a table of a device or a node, or of one in it."""


class BusNames:
    """Adds the names of a bus file."""

    def __init__(self, collector: Collector, bus: Bus, text: Text) -> None:
        self._collector = collector
        self._bus = bus
        self._text = text
        self._file = path_of(bus.file)

    def add(self) -> None:
        """Add definitions of nodes and kinds, and uses of nodes, kinds, objects and files."""
        try:
            self._toml = Toml(self._text.normal, self._bus.file)
        except TomlError:
            return  # reported by the front end
        content = self._toml.content
        devices = {kind.name: kind.device for kind in self._bus.kinds}
        for name, table in _tables(content, "device"):
            span = self._last(("device", name), name)
            self._collector.define(f"bus {self._file}#{name}", name, Kind.DEVICE, span)
            device = devices.get(name)
            if device is not None:
                self._use(
                    ("device", name, "eds"), f"file {path_of(device.file)}", table
                )
                self._objects(("device", name), table, device)
        for name, table in _tables(content, "node"):
            span = self._last(("node", name), name)
            kind = table.get("device")
            key = f"bus {self._file}#node {name}"
            self._collector.define(key, name, Kind.NODE, span, detail=str(kind))
            self._use(("node", name, "device"), f"bus {self._file}#{kind}", table)
            if isinstance(kind, str) and kind in devices:
                self._objects(("node", name), table, devices[kind])
        for match in _HEADER.finditer(self._text.source):
            space = "node " if match[1] == "node" else ""
            span = self._text.span(self._bus.file, *match.span(2))
            self._collector.refer(f"bus {self._file}#{space}{match[2]}", span)
        nodes = {node.name: node.device for node in self._bus.nodes}
        for number, link in enumerate(content.get("link", ())):
            for end in ("from", "to"):
                self._end(("link", number, end), link, nodes)

    def _last(self, path: Path, name: str) -> Span:
        """Return the place of the last part of a table's name in its header."""
        span = self._toml.span(path)
        return self._inside(span, name) or span

    def _inside(self, span: Span, text: str, after: str = "") -> Span | None:
        """Return the place of a text in the lines of a key and its value."""
        start, _ = self._text.offsets(span)
        start_of_text = self._text.source.find(after, start)
        if start_of_text < 0:
            return None
        pattern = rf"(?<![\w:]){re.escape(text)}(?![\w:])"
        match = re.compile(pattern).search(
            self._text.source, start_of_text + len(after)
        )
        if (
            match is None
            or _next_key(self._text.source, start_of_text) <= match.start()
        ):
            return None
        return self._text.span(span.file, *match.span())

    def _use(self, path: Path, key: str, table: Mapping[str, Any]) -> None:
        value = table.get(str(path[-1]))
        if isinstance(value, str):
            span = self._inside(self._toml.span(path), value, "=")
            if span is not None:
                self._collector.refer(key, span)

    def _objects(self, path: Path, table: Mapping[str, Any], device: Device) -> None:
        for name in ("parameters", "operations"):
            for text in table.get(name, ()):
                span = self._inside(self._toml.span((*path, name)), text, "=")
                self._object(text, span, device)
        for name in ("factors", "units", "values"):
            inner = table.get(name, {})
            for text in inner if isinstance(inner, dict) else ():
                span = self._toml.span((*path, name, text))
                self._object(text, self._inside(span, text) or span, device)

    def _object(self, text: str, span: Span | None, device: Device) -> None:
        match = _OBJECT.fullmatch(text) if isinstance(text, str) else None
        if match is None or span is None:
            return
        subindex = None if match[2] is None else int(match[2], 16)
        key = _key(device, int(match[1], 16), subindex)
        if key is not None:
            self._collector.refer(key, span)

    def _end(
        self, path: Path, link: Mapping[str, Any], nodes: Mapping[str, Device]
    ) -> None:
        text = link.get(str(path[-1])) if isinstance(link, dict) else None
        match = _END.fullmatch(text) if isinstance(text, str) else None
        if match is None or text is None:
            return
        span = self._inside(self._toml.span(path), text, "=")
        if span is None:
            return
        start, _ = self._text.offsets(span)
        middle = start + len(match[1])
        node = self._text.span(span.file, start, middle)
        self._collector.refer(f"bus {self._file}#node {match[1]}", node)
        device = nodes.get(match[1])
        index = _FIRST_OF_PDOS[match[2]] + int(match[3]) - 1
        key = None if device is None else _key(device, index, None)
        if key is not None:
            pdo = self._text.span(span.file, middle + 1, start + len(text))
            self._collector.refer(key, pdo)


def _tables(content: Mapping[str, Any], name: str) -> Iterator[tuple[str, Any]]:
    tables = content.get(name, {})
    if isinstance(tables, dict):
        yield from (
            (key, value) for key, value in tables.items() if isinstance(value, dict)
        )


def _next_key(text: str, offset: int) -> int:
    """Return the start of the next table header, or the end of the text."""
    match = re.compile(r"^\s*\[", re.MULTILINE).search(text, offset)
    return len(text) if match is None else match.start()


def object_of(key: str) -> tuple[str, int, int | None]:
    """Return the file, index and sub-index in an object's key."""
    file, _, number = key.removeprefix("eds ").rpartition("#")
    index, _, sub = number.partition(":")
    return file, int(index, 16), int(sub, 16) if sub else None
