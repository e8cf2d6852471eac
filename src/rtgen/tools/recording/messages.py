"""Types of recorded channels other than ports, in the IDL module `rtgen`."""

from __future__ import annotations

from typing import Any, ClassVar

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, field


class Component(Aggregated):
    """A component of the run; the order is that of ticking; `rate` in Hz."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Component", instance=idl.STRING, type=idl.STRING, rate=idl.DOUBLE
    )

    instance: str = ""
    type: str = ""
    rate: float = 0.0


class State(Aggregated):
    """A change of state in a context, with the reason of an ERROR."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::State",
        instance=idl.STRING,
        before=idl.member(idl.STRING, name="from"),
        after=idl.member(idl.STRING, name="to"),
        context=idl.LONG,
        reason=idl.STRING,
    )

    instance: str = ""
    before: str = ""
    after: str = ""
    context: int = 0
    reason: str = ""


class Parameter(Aggregated):
    """A parameter that has taken effect with a value."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Parameter",
        instance=idl.STRING,
        parameter=idl.STRING,
        value=idl.STRING,
    )

    instance: str = ""
    parameter: str = ""
    value: str = ""


class Property(Aggregated):
    """A property of a connection."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Property", name=idl.STRING, value=idl.STRING
    )

    name: str = ""
    value: str = ""


class Connection(Aggregated):
    """Two ports, `INSTANCE.PORT`, that were connected or disconnected."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Connection",
        name=idl.STRING,
        source=idl.STRING,
        target=idl.STRING,
        properties=idl.sequence(Property),
        connected=idl.BOOLEAN,
    )

    name: str = ""
    source: str = ""
    target: str = ""
    properties: list[Property] = field(default_factory=list)
    connected: bool = False


class CanFrame(Aggregated):
    """A CAN frame on a bus."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::CanFrame",
        id=idl.UNSIGNED_LONG,
        extended=idl.BOOLEAN,
        remote=idl.BOOLEAN,
        data=idl.sequence(idl.OCTET, 8),
    )

    id: int = 0
    extended: bool = False
    remote: bool = False
    data: bytes = b""


class BoardCall(Aggregated):
    """An OpaqueRPC call: the octets of request and reply, and the error, if any."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::BoardCall",
        request=idl.sequence(idl.OCTET),
        reply=idl.sequence(idl.OCTET),
        error=idl.STRING,
    )

    request: bytes = b""
    reply: bytes = b""
    error: str = ""


class LogLine(Aggregated):
    """A line of a component's log, with a level of Python's `logging`, and its place."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::LogLine",
        instance=idl.STRING,
        level=idl.LONG,
        text=idl.STRING,
        file=idl.STRING,
        function=idl.STRING,
        line=idl.LONG,
    )

    instance: str = ""
    level: int = 0
    text: str = ""
    file: str = ""
    function: str = ""
    line: int = 0


class Run(Aggregated):
    """An event of the run itself: `end`, before or after the actions due at that time."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Run", what=idl.STRING, through=idl.BOOLEAN
    )

    what: str = ""
    through: bool = False


class Topic:
    """Topics of these channels."""

    RUN = "/rtgen/run"
    COMPONENTS = "/rtgen/components"
    STATES = "/rtgen/states"
    PARAMETERS = "/rtgen/parameters"
    CONNECTIONS = "/rtgen/connections"
    LOGS = "/rtgen/logs"
    CAN = "/rtgen/can/"
    CALLS = "/rtgen/calls/"


TYPES: dict[str, Any] = {
    type_._descriptor_.name: type_
    for type_ in (
        Component,
        State,
        Parameter,
        Connection,
        CanFrame,
        BoardCall,
        LogLine,
        Run,
    )
}
"""The types of channels by their scoped names."""
