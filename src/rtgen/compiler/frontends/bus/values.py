"""Values that a bus file writes to objects of a device."""

from __future__ import annotations

import re
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds import numbers
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Entry
from rtgen.compiler.frontends.eds.pdos import PdoReader
from rtgen.compiler.model.canopen import (
    INVALID,
    TPDO_COMMUNICATION,
    Device,
    Value,
    Variable,
    resolved,
)
from rtgen.facts.canopen import MAX_SYNC_CYCLIC
from rtgen.facts.cob_ids import configurable, service_of
from rtgen.facts.write_order import OVERFLOW, pdo_of

_NOT_IN_ENTRY = re.compile(r"^\s|\s\Z|[\0\r\n]")
"""Parts of a text that EDS and DCF files cannot have, or that their readers remove."""

_TYPE, _SYNC_START = 2, 6
_FIRST_EVENT = (254, 252)
"""The first transmission types of RPDOs and TPDOs after the cyclic ones."""

NO_ENTRY = (
    "a description cannot have line breaks, NUL, or white space at the ends of a text"
)


class BadValueError(Exception):
    """An invalid value for the object; the message gives the reason."""


def number_of(text: str) -> tuple[int, int]:
    """Parse an object's number `6401:1` or `6040`, in hexadecimal digits."""
    index, _, subindex = text.partition(":")
    return int(index, 16), int(subindex or "0", 16)


def is_entry(text: str) -> bool:
    """Return whether the text can be the value of an entry in an EDS or DCF file."""
    return _NOT_IN_ENTRY.search(text) is None


def _text(value: Any) -> str:
    if not isinstance(value, int):
        return str(value)
    # Python refuses to format very long integers in decimal.
    return str(int(value)) if value.bit_length() <= 64 else f"{value:#x}"


def _refusal(variable: Variable, value: Value | None) -> str:
    """Return why each node refuses a value of an object (CiA 301, 7.5.2); empty if it may not."""
    if not isinstance(value, int | float):
        return ""
    low, high = variable.low, variable.high
    if isinstance(low, int | float) and value < low:
        return f"{value} is below LowLimit {low}"
    if isinstance(high, int | float) and value > high:
        return f"{value} is above HighLimit {high}"
    if not isinstance(value, int):
        return ""
    number = variable.index, variable.subindex
    service = service_of(number)
    if service is not None and not 0 <= value < 1 << 32:
        return f"{value:#x} is no COB-ID"
    if service is not None and not service.fixed:
        is_off = not service.on and value & INVALID
        if not is_off and not configurable(value):
            return f"{value:X}h is no COB-ID that {service.name} can have"
    if number == OVERFLOW and (value == 1 or value > MAX_SYNC_CYCLIC):
        return f"{value} is no SYNC counter: it is 0, or 2 to {MAX_SYNC_CYCLIC}"
    return _pdo_refusal(number, value)


def _pdo_refusal(number: tuple[int, int], value: int) -> str:
    index, subindex = number
    if pdo_of(index) != index:
        return ""
    first = _FIRST_EVENT[index >= TPDO_COMMUNICATION]
    if subindex == _TYPE and MAX_SYNC_CYCLIC < value < first:
        return f"{value} is a reserved transmission type"
    if subindex == _SYNC_START and value > MAX_SYNC_CYCLIC:
        return f"{value} is no SYNC counter: it is up to {MAX_SYNC_CYCLIC}"
    return ""


def configured(
    device: Device, number: tuple[int, int], value: Any, span: Span
) -> tuple[Device, Value]:
    """Return the device with a changed value, and the value converted to the object's data type.

    PDOs are updated for the new values. Raises BadValueError.
    """
    variable = device.find(*number)
    if variable is None:
        raise BadValueError("there is no such object")
    if not variable.access.writable:
        raise BadValueError(f"{variable.name} is {variable.access}")
    text = _text(value)
    findings = Findings()
    entry = Entry(span.file, span.line, span.column, "value", text, span.column)
    declared = numbers.value(entry, variable.data_type, findings)
    if declared is None or findings.diagnostics:
        message = findings.diagnostics[0].message.removeprefix("value: ")
        message = message.removesuffix("; it is ignored")
        raise BadValueError(f"{variable.name}: {message}")
    if isinstance(declared, str) and not is_entry(declared):
        raise BadValueError(f"{variable.name}: {NO_ENTRY}")
    refused = _refusal(variable, resolved(declared, device.node_id or 1))
    if refused:
        raise BadValueError(f"{variable.name}: {refused}")
    written = replace(variable, value=declared, value_span=span)
    objects = tuple(
        (
            replace(
                thing,
                variables=tuple(
                    written if v == variable else v for v in thing.variables
                ),
            )
            if thing.index == number[0]
            else thing
        )
        for thing in device.objects
    )
    pdos = PdoReader(
        objects, device.info, device.dummies, device.node_id, Findings()
    ).read()
    return replace(device, objects=objects, pdos=pdos), declared
