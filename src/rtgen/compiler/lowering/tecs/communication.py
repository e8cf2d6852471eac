"""The communication RTC and its interface, shared by all TECS boards of a project."""

from __future__ import annotations

from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.lowering.tecs.rtc_components import COMMUNICATION
from rtgen.compiler.model import (
    VOID,
    Component,
    ConfigurationParameter,
    Declaration,
    Direction,
    ExceptionDecl,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    SequenceType,
    SourceFile,
    StringType,
    Type,
    Typedef,
    default_id,
)
from rtgen.facts import opaque_rpc as facts

FILE = "OpaqueRpc.idl"
"""The IDL file of the interface, which is part of the runtime."""

RUNTIME = "rtgen.runtime.opaque_rpc"
"""The Python package of the interface."""

FACTORY = f"{RUNTIME}.communication:{facts.COMPONENT}"
"""The factory of the component."""

_NOWHERE = Span(FILE, 1, 1, 1, 1)
_OCTETS = NamedType((*COMMUNICATION, "Octets"))
_FAILED = (*COMMUNICATION, "Failed")
_UNSIGNED_LONG = PrimitiveType(Primitive.UNSIGNED_LONG)


def communication_model(sources: tuple[SourceFile, ...]) -> Model:
    """The interface `OpaqueRpc` and the component that provides it.

    `sources` are the CDL files of the project.
    """
    first = sources[0]
    file = SourceFile(
        name=FILE,
        key=first.key,
        sha256=first.sha256,
        main=True,
        package=RUNTIME,
        exported=False,
    )
    return Model(files=(file,), declarations=(*_interface(), _component()))


def _named(name: tuple[str, ...], doc: str = "") -> dict[str, Any]:
    return {
        "name": name,
        "repository_id": default_id(name),
        "file": FILE,
        "span": _NOWHERE,
        "doc": doc,
    }


def _interface() -> tuple[Declaration, ...]:
    def operation(
        name: str, returns: Type, doc: str, *parameters: tuple[str, Type]
    ) -> Operation:
        return Operation(
            name=name,
            returns=returns,
            parameters=tuple(
                Parameter(direction=Direction.IN, name=n, type=t, span=_NOWHERE)
                for n, t in parameters
            ),
            raises=(_FAILED,) if parameters else (),
            span=_NOWHERE,
            doc=doc,
        )

    octets = Typedef(**_named(_OCTETS.name), type=SequenceType(_octet()))
    failed = ExceptionDecl(
        **_named(_FAILED, "The channel failed; `code` is the kernel's, as `E_TMOUT`."),
        members=(
            Member(name="code", type=PrimitiveType(Primitive.LONG), span=_NOWHERE),
            Member(name="reason", type=StringType(), span=_NOWHERE),
        ),
    )
    interface = Interface(
        **_named(COMMUNICATION, "A channel to a TECS board, for one call at a time."),
        operations=(
            operation(
                "begin",
                _OCTETS,
                "Takes the channel and sends a request; the leading octets of its reply.\n\n"
                "The channel is free again if it fails.",
                ("request", _OCTETS),
                ("first", _UNSIGNED_LONG),
            ),
            operation(
                "more",
                _OCTETS,
                "The next octets of the reply.",
                ("count", _UNSIGNED_LONG),
            ),
            operation("end", VOID, "The reply was read: frees the channel."),
            operation(
                "reset", VOID, "The call failed: forgets its reply, frees the channel."
            ),
        ),
    )
    return octets, failed, interface


def _octet() -> PrimitiveType:
    return PrimitiveType(Primitive.OCTET)


def _component() -> Component:
    return Component(
        **_named((facts.COMPONENT,), f"{facts.DESCRIPTION}."),
        ports=(
            Port(
                kind=PortKind.PROVIDER,
                name=facts.PORT,
                identifier=facts.PORT,
                type=NamedType(COMMUNICATION),
                port=facts.PORT,
                instance=facts.INSTANCE,
                span=_NOWHERE,
                doc=facts.PORT_DESCRIPTION,
            ),
        ),
        configuration=tuple(
            ConfigurationParameter(
                name=parameter.name,
                identifier=parameter.name,
                type=StringType() if isinstance(parameter.default, str) else _DOUBLE,
                default=parameter.default,
                unit=parameter.unit,
                constraint=parameter.constraint,
                span=_NOWHERE,
                doc=parameter.description,
            )
            for parameter in facts.PARAMETERS
        ),
        category=facts.CATEGORY,
        vendor=facts.VENDOR,
        description=facts.DESCRIPTION,
        rate=facts.RATE,
        max_instances=0,
        factory=FACTORY,
    )


_DOUBLE = PrimitiveType(Primitive.DOUBLE)
