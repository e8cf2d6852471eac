"""Keys of bus files and of rtgen.toml, and the table at an offset."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rtgen.compiler.frontends.bus.schema import SCHEMA as BUS
from rtgen.compiler.project.file import SCHEMA as PROJECT
from rtgen.tools.indexing.text import Text

_HEADER = re.compile(r"^[ \t]*(\[\[?)[ \t]*([^\]\n]*?)[ \t]*\]", re.MULTILINE)
_KEY = re.compile(r"[ \t]*([\w-]+)[ \t]*=")
_PART = re.compile(r"[\w-]+|\"[^\"]*\"|'[^']*'")


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a table: its place, and its schema."""

    name: str
    start: int
    end: int
    description: str


def table_at(source: str, offset: int) -> tuple[str, ...]:
    """Return the names of the table at an offset."""
    table: tuple[str, ...] = ()
    for match in _HEADER.finditer(source, 0, offset):
        table = tuple(part.strip("\"'") for part in _PART.findall(match[2]))
    return table


def bus_table(path: tuple[str, ...]) -> Mapping[str, Any]:
    """Return the schema of a table of a bus file; empty for an unknown one."""
    schema: Any = BUS
    for name in path:
        schema = _below(schema, name)
        if schema.get("type") == "array":
            schema = schema.get("items", {})
    table: Mapping[str, Any] = schema
    return table


def _below(schema: Mapping[str, Any], name: str) -> Any:
    properties = schema.get("properties", {})
    if name in properties:
        return properties[name]
    patterns = schema.get("patternProperties", {})
    return next((value for value in patterns.values()), {})


def bus_keys(path: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield the keys of a table of a bus file with their descriptions."""
    for name, schema in bus_table(path).get("properties", {}).items():
        yield name, schema.get("description", "")


def project_keys(path: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield the sections of rtgen.toml, or the keys of one of them."""
    if not path:
        yield from ((name, "") for name in PROJECT)
        return
    section = PROJECT.get(path[0])
    if isinstance(section, dict) and len(path) == 1:
        yield from ((name, "") for name in section)
    elif path[0] == "adapter":
        yield from ((name, "") for name in ("from", "to", "map", "set"))


def key_at(text: Text, offset: int) -> Key | None:
    """Return the key of a bus file at an offset."""
    source = text.source
    line = source.rfind("\n", 0, offset) + 1
    match = _KEY.match(source, line)
    if match is None or not match.start(1) <= offset <= match.end(1):
        return None
    table = bus_table(table_at(source, offset))
    description = _below(table, match[1]).get("description", "") if table else ""
    return Key(match[1], match.start(1), match.end(1), description)
