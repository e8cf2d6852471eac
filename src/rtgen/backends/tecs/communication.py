"""What a project with TECS boards has once: the communication RTC and its interface."""

from __future__ import annotations

from typing import Any

from rtgen.backends import Artifact, Options
from rtgen.backends.components.members import attributes_of
from rtgen.backends.idl_text import idl_text
from rtgen.backends.python_text import header_comment
from rtgen.backends.rendering import render
from rtgen.backends.tecs.options import FIRST_PORT, RtcOptions
from rtgen.backends.tecs.rtc_components import COMMUNICATION
from rtgen.diagnostics import Span
from rtgen.model import (
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
)

COMPONENT = "OpaqueRpcCommunication"
FILE = "OpaqueRpc.idl"
PORT = "service"
"""The service port of the communication RTC."""

_NOWHERE = Span(FILE, 1, 1, 1, 1)
_OCTETS = NamedType((*COMMUNICATION, "Octets"))
_FAILED = (*COMMUNICATION, "Failed")
_UNSIGNED_LONG = PrimitiveType(Primitive.UNSIGNED_LONG)
_USUAL = RtcOptions()
_PARAMETERS: tuple[tuple[str, str | float, str, str], ...] = (
    ("type", "TCP", "", "`TCP`, or `SERIA` (`SERIAL`) for a serial line."),
    ("ipaddr", _USUAL.address, "", "TCP: the board's address."),
    ("port", str(FIRST_PORT), "", "TCP: the board's port; serial line: its device."),
    ("baudrate", "none", "", "Serial line: its speed in bit/s."),
    ("tap", "none", "", "TCP: the local address or network interface to use."),
    ("timeout", _USUAL.timeout, "s", "How long a call may take."),
)


def communication_model(sources: tuple[SourceFile, ...]) -> Model:
    """The interface `OpaqueRpc` and the component that provides it.

    `sources` are the CDL files of the project.
    """
    first = sources[0]
    file = SourceFile(name=FILE, key=first.key, sha256=first.sha256, main=True)
    return Model(files=(file,), declarations=(*_interface(), _component()))


def _named(name: tuple[str, ...], doc: str = "") -> dict[str, Any]:
    return {
        "name": name,
        "repository_id": f"IDL:{'/'.join(name)}:1.0",
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
    doc = "Carries requests of any signature to a TECS board."
    return Component(
        **_named((COMPONENT,), doc),
        ports=(
            Port(
                kind=PortKind.PROVIDER,
                name=PORT,
                identifier=PORT,
                type=NamedType(COMMUNICATION),
                port=PORT,
                instance="communication",
                span=_NOWHERE,
                doc="The channel, for one marshaller.",
            ),
        ),
        configuration=tuple(
            ConfigurationParameter(
                name=name,
                identifier=name,
                type=StringType() if isinstance(default, str) else _DOUBLE,
                default=default,
                unit=unit,
                constraint="" if isinstance(default, str) else "x>0.0",
                span=_NOWHERE,
                doc=doc,
            )
            for name, default, unit, doc in _PARAMETERS
        ),
        category="TECS",
        vendor="rtgen",
        description=doc.rstrip("."),
        rate=10.0,
        max_instances=0,
    )


_DOUBLE = PrimitiveType(Primitive.DOUBLE)


def communication_artifacts(
    model: Model, options: Options, sources: tuple[SourceFile, ...]
) -> tuple[Artifact, ...]:
    """`OpaqueRpc.idl` and `opaque_rpc_communication.py`, in the package of the options."""
    origin = tuple(source.key for source in sources)
    header = header_comment(options.version, origin)
    component = model.find((COMPONENT,))
    assert isinstance(component, Component)
    attributes = attributes_of(component)
    text = render(
        "tecs/opaque_rpc_communication.py.j2",
        header=header,
        provider=attributes.ports[0][1],
        fields={parameter.name: name for parameter, name in attributes.configuration},
    )
    comment = header.replace("# ", "// ")
    idl = f"{comment}\n{idl_text(model, model.declarations)}"
    return (
        Artifact(f"{options.folder}/{FILE}", idl, origin),
        Artifact(f"{options.folder}/opaque_rpc_communication.py", text, origin),
    )
