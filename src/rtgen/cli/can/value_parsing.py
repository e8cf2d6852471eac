"""Values of objects as they are written on the command line and in sequences."""

from __future__ import annotations

from datetime import UTC, datetime

from rtgen.cli.can.known import KnownObject
from rtgen.cli.common import Refusal
from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.frames import SECOND
from rtgen.runtime.canopen.values import ObjectValueError, limits

_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}


def parsed_value(thing: KnownObject, text: str) -> ObjectValue:
    """The value of a text, for an object; physical where it has a factor. Raises Refusal."""
    factor = thing.factor
    try:
        value = _number(text, factor) if factor else _parsed(thing.kind, text)
        if factor and limits(thing.kind) is not None:
            return round(value)  # type: ignore[arg-type]
        return value
    except (ValueError, OverflowError) as error:
        if isinstance(error, ObjectValueError):
            raise Refusal(f"{thing}: {error}") from error
        hint = "" if thing.name else ", or tell its --type"
        told = f"{text!r} is no {_called(thing.kind)}{hint}"
        raise Refusal(f"{thing}: {told}") from error


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
            told = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
            return round(told.timestamp() * 1000) * (SECOND // 1000)
        case "time_difference":
            return round(float(text) * 1000) * (SECOND // 1000)
    return text


def _integer(text: str) -> int:
    """The number, also with zeros before it."""
    try:
        return int(text, 0)
    except ValueError:
        return int(text)


def _called(kind: Kind) -> str:
    """What a value of a kind is called in a message."""
    if limits(kind) is not None:
        return f"integer ({kind})"
    return {
        "bool": "boolean: true or false",
        "r32": "number",
        "r64": "number",
        "octets": "row of octets: write them in hex",
        "time_of_day": "time: write it as 2026-01-31T12:00:00",
        "time_difference": "time: write it in seconds",
    }.get(kind, kind)
