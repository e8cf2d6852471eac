"""The RTCs of a service: marshaller and client."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.lowering.tecs.plan import Service
from rtgen.compiler.model import Component, Interface, NamedType, Port, PortKind
from rtgen.compiler.typemap.python.names import identifier

COMMUNICATION = ("OpaqueRpc",)
"""The interface of the communication RTC."""

MARSHALLER = "Marshaller"
CLIENT = "Client"
RTCS = (MARSHALLER, CLIENT)
"""The suffixes of the names of a service's RTCs."""


def consumer_name(service: Service) -> str:
    """The marshaller's port to the communication RTC."""
    return "communication" if service.module != "communication" else "opaque_rpc"


def marshaller_module(service: Service) -> str:
    """Return the module of a service, with its interface, bases of RTCs, and marshaller."""
    return f"{service.module}_marshaller"


def components_of(
    service: Service, interface: Interface, file: str
) -> Iterator[Component]:
    """The marshaller RTC, and the client RTC that the user completes.

    `file` is the IDL file of the interface.
    """
    span = service.signature.span
    offered = NamedType(interface.name)
    scoped = service.signature.scoped

    def port(kind: PortKind, name: str, type_: NamedType, doc: str) -> Port:
        return Port(
            kind=kind,
            name=name,
            identifier=name,
            type=type_,
            port=name,
            instance=name,
            span=span,
            doc=doc,
        )

    def component(
        name: str, ports: tuple[Port, ...], doc: str, factory: str = ""
    ) -> Component:
        return Component(
            name=(name,),
            repository_id=f"IDL:{name}:1.0",
            file=file,
            span=span,
            doc=doc,
            ports=ports,
            category="TECS",
            vendor="rtgen",
            description=doc.rstrip("."),
            rate=10.0,
            max_instances=0,
            factory=factory,
            module=marshaller_module(service),
        )

    yield component(
        f"{service.name}{MARSHALLER}",
        (
            port(PortKind.PROVIDER, service.module, offered, f"What {scoped} offers."),
            port(
                PortKind.CONSUMER,
                consumer_name(service),
                NamedType(COMMUNICATION),
                "The board's channel.",
            ),
        ),
        f"Carries calls of {scoped} to a TECS board.",
        f".{marshaller_module(service)}:{identifier(f'{service.name}{MARSHALLER}')}",
    )
    yield component(
        f"{service.name}{CLIENT}",
        (port(PortKind.CONSUMER, service.module, offered, f"What {scoped} offers."),),
        f"Calls {scoped} of a TECS board.",
    )
