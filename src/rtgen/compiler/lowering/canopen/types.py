"""The types of a device's ports, and the interface of its SDO service."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.lowering.canopen.kinds import (
    OBJECT_ACCESS,
    OBJECT_DICTIONARY,
    file_name,
)
from rtgen.compiler.model import (
    VOID,
    Declaration,
    Direction,
    Interface,
    Member,
    NamedType,
    Operation,
    Parameter,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    default_id,
)
from rtgen.compiler.typemap.canopen.labels import object_line
from rtgen.compiler.typemap.canopen.ports import STAMP, DevicePorts, PdoSample

_OCTETS = NamedType(("CANopen", "Octets"))
TIME = NamedType(("RTC", "Time"))
_RAISED: tuple[ScopedName, ...] = (("CANopen", "SdoAbort"), ("CANopen", "BusGone"))


def declarations(ports: DevicePorts) -> Iterator[Declaration]:
    """Yield the structs of the ports, and the interface with the operations of the bus file."""
    if ports.per_object:
        yield from _timed(ports)
    else:
        yield from (_struct(ports, sample) for sample in ports.samples)
    if ports.operations:
        yield _service(ports)


def _common(ports: DevicePorts, name: str, span: Span, doc: str) -> dict[str, Any]:
    return {
        "name": (ports.kind.module, name),
        "repository_id": default_id((ports.kind.module, name)),
        "file": file_name(ports),
        "span": span,
        "doc": doc,
    }


def _stamp(span: Span, what: str) -> Member:
    return Member(name=STAMP, type=TIME, span=span, doc=what)


def _struct(ports: DevicePorts, sample: PdoSample) -> Struct:
    pdo = sample.pdo
    way = "transmits" if pdo.direction == "tpdo" else "receives"
    doc = f"{pdo.direction.upper()} {pdo.number}, which the device {way}."
    members = (
        Member(
            name=q.name, type=_type(q.type), span=q.variable.span, doc=object_line(q)
        )
        for q in sample.fields
    )
    return Struct(
        **_common(ports, sample.struct, pdo.span, doc),
        members=(_stamp(pdo.span, "When it was sent or received."), *members),
    )


def _timed(ports: DevicePorts) -> Iterator[Struct]:
    """Yield the types of ports without a counterpart in the module RTC."""
    names: set[ScopedName] = set()
    for port in ports.object_ports:
        name = port.quantity.timed(ports.kind.module)
        if name[0] != ports.kind.module or name in names:
            continue
        names.add(name)
        span = port.quantity.variable.span
        doc = f"Time-stamped value of type {port.quantity.type}, for which RTC has no type."
        data = Member(name="data", type=port.quantity.type, span=span)
        yield Struct(
            **_common(ports, name[1], span, doc),
            members=(_stamp(span, "When it was sent or received."), data),
        )


def _service(ports: DevicePorts) -> Interface:
    operations: list[Operation] = []
    for quantity in ports.operations:
        variable = quantity.variable
        common: dict[str, Any] = {
            "raises": _RAISED,
            "span": variable.span,
            "doc": object_line(quantity),
        }
        type_ = _type(quantity.type)
        if variable.access.readable:
            name = f"get_{quantity.name}"
            operations.append(
                Operation(
                    name=name,
                    repository_id=default_id((ports.kind.module, OBJECT_ACCESS, name)),
                    returns=type_,
                    **common,
                )
            )
        if variable.access.writable:
            name = f"set_{quantity.name}"
            value = Parameter(
                direction=Direction.IN, name="value", type=type_, span=variable.span
            )
            operations.append(
                Operation(
                    name=name,
                    repository_id=default_id((ports.kind.module, OBJECT_ACCESS, name)),
                    returns=VOID,
                    parameters=(value,),
                    **common,
                )
            )
    doc = (
        "Access to single objects of the device by name, and to all objects by number."
    )
    return Interface(
        **_common(ports, OBJECT_ACCESS, ports.device.span, doc),
        bases=(OBJECT_DICTIONARY,),
        operations=tuple(operations),
    )


def _type(type_: Type) -> Type:
    """Return the type of a parameter, with a typedef for a sequence."""
    return _OCTETS if isinstance(type_, SequenceType) else type_
