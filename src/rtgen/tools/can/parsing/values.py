"""Parses values of objects on the command line and in sequences."""

from __future__ import annotations

from datetime import UTC, datetime

from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.values import ObjectValueError, limits
from rtgen.runtime.canopen.wire.frames import SECOND
from rtgen.tools.can.decoding.node_index import DescribedObject
from rtgen.tools.kit.exits import Refusal

_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}


def parsed_value(thing: DescribedObject, text: str) -> ObjectValue:
    """Parse a value of an object, physical if it has a factor. Raises Refusal."""
    factor = thing.factor
    try:
        value = _number(text, factor) if factor else _parsed(thing.kind, text)
        if factor and limits(thing.kind) is not None:
            return round(value)  # type: ignore[arg-type]
        return value
    except (ValueError, OverflowError) as error:
        if isinstance(error, ObjectValueError):
            raise Refusal(f"{thing}: {error}") from error
        hint = "" if thing.name else ", or set its --type"
        problem = f"{text!r} is not {_called(thing.kind)}{hint}"
        raise Refusal(f"{thing}: {problem}") from error


def _number(text: str, factor: float) -> float:
    return float(text) / factor


def _parsed(kind: Kind, text: str) -> ObjectValue:
    if limits(kind) is not None:
        return _integer(text)
    match kind:
        case "bool":
            if text.lower() not in _BOOLEANS:
                raise ValueError(text)
            return _BOOLEANS[text.lower()]
        case "r32" | "r64":
            return float(text)
        case "octets":
            return bytes.fromhex(text)
        case "time_of_day":
            moment = datetime.fromisoformat(text)
            moment_in_utc = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
            return round(moment_in_utc.timestamp() * 1000) * (SECOND // 1000)
        case "time_difference":
            return round(float(text) * 1000) * (SECOND // 1000)
    return text


def _integer(text: str) -> int:
    """Parse an integer; leading zeros are allowed."""
    try:
        return int(text, 0)
    except ValueError:
        return int(text)


def _called(kind: Kind) -> str:
    """Return the name of a kind of values for messages."""
    if limits(kind) is not None:
        return f"an integer ({kind})"
    return {
        "bool": "a boolean: true or false",
        "r32": "a number",
        "r64": "a number",
        "octets": "octets: write them in hex",
        "time_of_day": "a time: write it as 2026-01-31T12:00:00",
        "time_difference": "a time: write it in seconds",
    }.get(kind, kind)
