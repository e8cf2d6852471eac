"""Output of `rtgen inspect` for a CANopen network: JSON (`rtgen-inspect/1`) and text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from rtgen.compiler.inspection.devices import value_of
from rtgen.compiler.inspection.facts import FIELDS, Json, facts
from rtgen.compiler.layouts.can_messages import identifier_of, messages
from rtgen.compiler.layouts.can_timing import Timing, load, response_times
from rtgen.compiler.model.can_bus import Bus, BusNode, DeviceKind, PdoLink
from rtgen.compiler.model.canopen import Value

_Numbered: TypeAlias = Sequence[tuple[tuple[int, int], Any]]


FIELDS.update(
    {
        Bus: "kind name file line bit_rate manager sync heartbeat devices nodes links load"
        " messages doc annotations",
        DeviceKind: "name module file=device.file ports parameters operations factors units",
        BusNode: "name id device values pdos",
    }
)


def declaration(bus: Bus) -> Json:
    """Return the network as JSON; times in seconds, `response` is null if unbounded."""
    sent = messages(bus)
    return facts(
        bus,
        kind="bus",
        line=1,
        devices=[*map(_kind, bus.kinds)],
        nodes=[*map(_node, bus.nodes)],
        links=[
            dict(zip(("from", "to"), _ends(each), strict=True)) for each in bus.links
        ],
        load=round(load(sent, bus.bit_rate), 6),
        messages=[*map(_message, response_times(sent, bus.bit_rate))],
        doc="",
        annotations=[],
    )


def _kind(kind: DeviceKind) -> Json:
    return facts(
        kind,
        parameters=[*map(_written, kind.parameters)],
        operations=[*map(_written, kind.operations)],
        factors=_by_object(kind.factors),
        units=_by_object(kind.units),
    )


def _node(node: BusNode) -> Json:
    values = ((number, value_of(value, node.id)) for number, value in node.values)
    pdos: list[Json] = [
        {
            "direction": pdo.direction.value,
            "number": pdo.number,
            "identifier": identifier_of(pdo, node),
        }
        for pdo in node.device.pdos
    ]
    device = node.kind.name
    return facts(node, device=device, values=_by_object(tuple(values)), pdos=pdos)


def _ends(link: PdoLink) -> tuple[str, str]:
    (sender, tpdo), (receiver, rpdo) = link.source, link.target
    return f"{sender}.tpdo{tpdo}", f"{receiver}.rpdo{rpdo}"


def _message(timing: Timing) -> Json:
    message, response = timing.message, timing.response
    return {
        "name": message.name,
        "identifier": message.identifier,
        "octets": message.octets,
        "period": message.period / 1e9,
        "response": None if response is None else response / 1e9,
    }


def _by_object(numbered: _Numbered) -> Mapping[str, Any]:
    return {_written(number): value for number, value in numbered}


def _written(number: tuple[int, int]) -> str:
    """Return an object as in bus files: `6040`, `6401:1`."""
    index, subindex = number
    return f"{index:04X}:{subindex:X}" if subindex else f"{index:04X}"


def lines(bus: Bus) -> Iterator[str]:
    """Yield the network as text: its nodes with their configuration, and its messages."""
    yield f"bus {bus.name}: {bus.bit_rate} kbit/s, manager {bus.manager}"
    for node in bus.nodes:
        yield f"  node {node.id} {node.name}: {node.kind.module}"
        for number, value in node.values:
            yield f"    {_written(number)} = {_shown(value, node.id)}"
    for link in bus.links:
        yield "  {} -> {}".format(*_ends(link))
    sent = messages(bus)
    yield f"  load {load(sent, bus.bit_rate):.1%}"
    for timing in response_times(sent, bus.bit_rate):
        message, response = timing.message, timing.response
        worst = "no bound" if response is None else f"{response / 1e6:.3f} ms"
        yield (
            f"  {message.identifier:03X}h {message.name}: {message.octets} octets "
            f"every {message.period / 1e6:g} ms, there within {worst}"
        )


def _shown(value: Value, node_id: int) -> str:
    number = value_of(value, node_id)
    return (
        f"0x{number:X}" if isinstance(number, int) and number >= 0x100 else str(number)
    )
