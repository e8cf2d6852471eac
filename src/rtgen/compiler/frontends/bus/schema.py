"""JSON schema of bus files, and validation against it.

`docs/bus.schema.json` is this schema as a file, for editors; a test keeps them equal.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from rtgen.compiler.frontends.kit.located_toml import Path
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.canopen import BIT_RATES

_OBJECT = "^[0-9A-Fa-f]{4}(:[0-9A-Fa-f]{1,2})?$"
_NAME = "^[A-Za-z_][A-Za-z0-9_]*$"
_PDO = "^[A-Za-z_][A-Za-z0-9_]*\\.(tpdo|rpdo)[1-9][0-9]{0,2}$"


def _table(
    properties: dict[str, Any], *required: str, description: str = ""
) -> dict[str, Any]:
    table = {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
    }
    return table | ({"description": description} if description else {})


def _each(pattern: str, value: dict[str, Any], description: str) -> dict[str, Any]:
    return {
        "type": "object",
        "patternProperties": {pattern: value},
        "additionalProperties": False,
        "description": description,
    }


def _list(items: dict[str, Any], description: str) -> dict[str, Any]:
    return {"type": "array", "items": items, "description": description}


def _number(
    low: int, high: int, description: str = "", kind: str = "integer"
) -> dict[str, Any]:
    number: dict[str, Any] = {"type": kind, "minimum": low, "maximum": high}
    return number | ({"description": description} if description else {})


def _seconds(description: str) -> dict[str, Any]:
    return _number(0, 3600, description, "number")


def _times(description: str) -> dict[str, Any]:
    return _number(0, 1_000_000, description)


def _u32(description: str) -> dict[str, Any]:
    return _number(1, 0xFFFFFFFF, description)


def _flag(description: str) -> dict[str, Any]:
    return {"type": "boolean", "description": description}


def _text(pattern: str, description: str = "") -> dict[str, Any]:
    text = {"type": "string", "pattern": pattern}
    return text | ({"description": description} if description else {})


_VALUES = _each(
    _OBJECT,
    {"type": ["integer", "number", "string", "boolean"]},
    "What is written to objects at start-up: index and sub-index in hexadecimal digits.",
)

_STOPS = _list(
    _text("^-?[0-9A-Fa-fxX]{4}$"),
    "Emergency codes that stop the proxy, with x for any digit; the last one that matches decides, "
    "with - it only reports. Default: xxxx, -8110, -8120, -8140, -82xx.",
)

_BUS = {
    "name": _text(_NAME),
    "bit_rate": {"enum": list(BIT_RATES), "description": "In kbit/s."},
    "manager": _number(1, 127, "The NMT master; default 127."),
    "sync": _seconds("Period of SYNC in seconds."),
    "heartbeat": _seconds("Period of the manager's heartbeat in seconds."),
    "sync_counter": _number(
        2, 240, "SYNC counts from 1 to this number; default: no counter."
    ),
    "dcf": _flag("Whether each node has a DCF; default true."),
    "event": _seconds(
        "Least time between two event-driven PDOs without an inhibit time, in seconds; "
        "default 0.01."
    ),
}

_DEVICE = {
    "eds": {
        "type": "string",
        "description": "EDS, DCF, XDD or XDC, relative to the bus file.",
    },
    "name": _text(_NAME, "The IDL module; default: made from the file's name."),
    "ports": {"enum": ["pdo", "object"]},
    "parameters": _list(
        _text(_OBJECT), "Objects that become configuration parameters."
    ),
    "operations": _list(
        _text(_OBJECT),
        "Objects that have operations of their own in the SDO service: get_<name>, set_<name>.",
    ),
    "factors": _each(
        _OBJECT,
        {"type": ["number", "string"], "pattern": "^cia402$"},
        "Physical value = factor * value; cia402: by 608Fh, 6090h to 6092h and 60A8h to 60AAh of "
        "the drive.",
    ),
    "units": _each(_OBJECT, {"type": "string"}, "Units of the physical values."),
    "values": _VALUES,
    "emergency_stop": _STOPS,
}

_NODE = {
    "device": _text(_NAME),
    "id": _number(1, 127),
    "values": _VALUES,
    "heartbeat_timeout": _seconds(
        "How long the manager waits for a heartbeat, in seconds; default: three periods."
    ),
    "boot_timeout": _seconds(
        "How long a reset may take until the boot-up message, in seconds; default: 1F89h of the "
        "device, else 2."
    ),
    "restarts": _times("How often the manager resets it after an error; default 0."),
    "mandatory": _flag("Whether the network is in error without it; default true."),
    "start": _flag(
        "Whether the manager starts it when it is configured; default true."
    ),
    "lss": _flag(
        "Whether it may have no node-id yet, so that the manager assigns it; default false."
    ),
    "emergency_stop": _STOPS,
    "recoveries": _times(
        "How often in a row its proxy leaves ERROR by itself; default 0."
    ),
    "revision": _u32("Its revision number (1018h:3), to be checked."),
    "serial": _u32(
        "Its serial number (1018h:4), to be checked; selects it among others of its kind in LSS."
    ),
}

_LINK = _table(
    {"from": _text(_PDO), "to": _text(_PDO)},
    *("from", "to"),
    description="An RPDO that receives another node's TPDO: node.tpdo1, node.rpdo2.",
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": "CANopen bus file of rtgen",
} | _table(
    {
        "bus": _table(_BUS, "bit_rate"),
        "device": _each(_NAME, _table(_DEVICE, "eds"), "Kinds of device."),
        "node": _each(_NAME, _table(_NODE, "device", "id"), "Nodes by name."),
        "link": {"type": "array", "items": _LINK},
    },
    *("bus", "device", "node"),
)

_TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
}


def problems(
    value: Any, schema: dict[str, Any] = SCHEMA, path: Path = ()
) -> Iterator[tuple[Path, str]]:
    """Yield the places where a value violates the schema, with the error."""
    wrong = _wrong(value, schema)
    if wrong is not None:
        yield path, wrong
        return
    if isinstance(value, list):
        for number, item in enumerate(value):
            yield from problems(item, schema["items"], (*path, number))
    elif isinstance(value, dict):
        properties = schema.get("properties", {})
        patterns = schema.get("patternProperties", {})
        for key, item in value.items():
            inner = properties.get(key) or next(
                (s for p, s in patterns.items() if re.search(p, key)), None
            )
            if inner is None:
                names = ", ".join(properties)
                known_are = f"known are {names}" if names else "not of its form"
                meant = nearest(str(key), properties)
                if meant is not None:
                    known_are = f"did you mean {meant!r}? {known_are}"
                yield (*path, key), f"unknown key {key!r}; {known_are}"
            else:
                yield from problems(item, inner, (*path, key))
        for key in schema.get("required", ()):
            if key not in value:
                yield path, f"{key!r} is missing"


def _wrong(value: Any, schema: dict[str, Any]) -> str | None:
    """Return the error in the value itself, without its items."""
    if "enum" in schema:
        allowed = schema["enum"]
        fine = not isinstance(value, bool) and value in allowed
        return None if fine else f"must be one of {', '.join(map(str, allowed))}"
    names = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    types = tuple(t for name in names for t in _TYPES[name])
    if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
        kinds = {"object": "a table", "array": "a list"}
        return f"must be {' or '.join(kinds.get(n, f'of type {n}') for n in names)}"
    if isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
        return f"{value[:40]!r} does not have the form {schema['pattern']}"
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and not value >= low:
        return f"must be {low} at least"
    if high is not None and value > high:
        return f"must be {high} at most"
    return None
