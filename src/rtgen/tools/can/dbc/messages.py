"""The messages of a bus for a DBC file, with the names that `rtgen can monitor` shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from rtgen.compiler.backends.canopen.rules import NOT_IN_DBC
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.layouts import can_messages
from rtgen.compiler.layouts.can_services import emergency_cob_id, uses_sync
from rtgen.compiler.layouts.can_supervision import heartbeat
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import PdoDirection
from rtgen.facts.canopen import EXTENDED, INVALID, can_id_of
from rtgen.facts.cob_ids import COB_ID_TIME, SDO_SERVERS
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import ErrorRegister, known_codes
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MAX_DATA,
    NMT,
    SDO_REQUEST,
    SDO_RESPONSE,
    CobId,
)
from rtgen.tools.can.dbc.database import (
    ENCODING,
    Message,
    Names,
    Signal,
    dbc_text,
    has_characters,
)
from rtgen.tools.can.dbc.objects import (
    is_number,
    object_names,
    object_signals,
    sdo_signal,
)
from rtgen.tools.can.decoding.decoder import COMMAND_TEXTS, STATE_TEXTS
from rtgen.tools.can.decoding.node_index import DescribedNode, NodeIndex
from rtgen.tools.can.decoding.pdo_fields import Route, routes

_MILLISECOND = 1_000_000
_BITS = 8 * MAX_DATA
_OBJECT, _VALUE = 8, 32
"""The first bits of an object's number and of its value in SDO and multiplexed PDOs."""
_NUMBER_BITS = 24


def bus_dbc(bus: Bus, index: NodeIndex) -> tuple[bytes, list[Diagnostic]]:
    """Return the DBC file of a bus, and what it does not say of the bus."""
    described = _BusMessages(bus, index)
    text = dbc_text(
        described.messages(),
        described.comments,
        comment=f"CANopen network {bus.name}",
        bit_rate=1000 * bus.bit_rate,
    )
    return text.encode(ENCODING), described.diagnostics


class _BusMessages:
    """The messages of a bus, and the names of its nodes."""

    def __init__(self, bus: Bus, index: NodeIndex) -> None:
        self.bus, self.index = bus, index
        self.diagnostics: list[Diagnostic] = []
        self.comments: dict[str, str] = {}
        names = Names()
        self.names: dict[int, str] = {}
        for node in index.nodes.values():
            self._add(names, node.id, node.device.info.product_name)
        if bus.manager not in self.names:
            self._add(names, bus.manager, "manager")
        self.manager = self.names[bus.manager]

    def _add(self, names: Names, node_id: int, what: str) -> None:
        name = self.names[node_id] = names.add(self.index.name(node_id))
        self.comments[name] = f"node-id {node_id} {what}".rstrip()

    def messages(self) -> list[Message]:
        """Return the messages, by identifier; each identifier once."""
        names = Names()
        result: dict[tuple[bool, int], Message] = {}
        for message in (*self._pdos(), *self._services()):
            result.setdefault((message.extended, message.can_id), message)
        in_order = [result[key] for key in sorted(result)]
        return [replace(message, name=names.add(message.name)) for message in in_order]

    def _left_out(self, node: BusNode, message: str) -> None:
        self.diagnostics.append(NOT_IN_DBC.at(node.span, message))

    # PDOs

    def _pdos(self) -> Iterator[Message]:
        sharing: dict[tuple[int, bool], list[Route]] = {}
        for node in self.index.nodes.values():
            for key, route in routes(node, node.parameters):
                sharing.setdefault(key, []).append(route)
        self._cycles = self._pdo_cycles()
        self._bus_nodes = {node.id: node for node in self.bus.nodes}
        for (can_id, extended), found in sharing.items():
            found.sort(key=lambda route: route.direction is PdoDirection.RPDO)
            yield self._pdo(can_id, extended, found)

    def _pdo(self, can_id: int, extended: bool, sharing: list[Route]) -> Message:
        route = sharing[0]
        node = self.names[route.node.id]
        sent = route.direction is PdoDirection.TPDO
        takers = sharing[1:] if sent else sharing
        receivers = [self.names[taker.node.id] for taker in takers]
        if sent and self.manager not in receivers:
            receivers.append(self.manager)
        also = "".join(f" -> {r.node.name}.{r.pdo}" for r in sharing[1:])
        return Message(
            f"{node}_{route.pdo}",
            can_id,
            min(route.octets, MAX_DATA),
            node if sent else self.manager,
            self._pdo_signals(route),
            extended,
            list(dict.fromkeys(receivers)),
            self._cycles.get((route.node.name, route.pdo), 0),
            f"{route.node.name}.{route.pdo}{also}",
        )

    def _pdo_signals(self, route: Route) -> list[Signal]:
        names, node = Names(), route.node
        if route.multiplexed:
            return [
                Signal(names.add("address"), 0, 8),
                *_selected_objects(node, names, names.add("object")),
            ]
        result = []
        for entry in route.mapped:
            thing, where = entry.thing, f"{node.name}.{route.pdo}: {entry.thing}"
            bus_node = self._bus_nodes[node.id]
            if entry.first + entry.bits > _BITS:
                self._left_out(bus_node, f"{where} is not in the DBC: it is cut off")
                continue
            if not is_number(thing, entry.bits) and thing.factor is not None:
                message = f"{where} is in the DBC as {entry.bits} bits without a factor"
                self._left_out(bus_node, message)
            if not has_characters(thing.unit):
                message = f"{where}: a DBC has no characters for the unit {thing.unit}"
                self._left_out(bus_node, message)
            for signal in object_signals(node, thing, entry.first, entry.bits):
                result.append(replace(signal, name=names.add(signal.name)))
        return result

    def _pdo_cycles(self) -> dict[tuple[str, str], int]:
        """Return the periods of the periodic PDOs, in ms by the names of node and PDO."""
        traffic = {m.name: m for m in can_messages.messages(self.bus)}
        result = {}
        for node in self.bus.nodes:
            for pdo in node.device.pdos:
                name = f"{pdo.direction}{pdo.number}"
                message = traffic.get(f"{node.name}.{name}")
                sent = pdo.direction is PdoDirection.TPDO
                if message is None or (sent and pdo.transmission_type == 0):
                    continue
                if message.trigger:
                    result[node.name, name] = _milliseconds(message.period)
                elif sent and pdo.event_timer:
                    result[node.name, name] = pdo.event_timer
        return result

    # Other services

    def _services(self) -> Iterator[Message]:
        nodes, manager = list(self.index.nodes.values()), self.manager
        others = [name for name in self.names.values() if name != manager]
        yield Message("nmt", NMT, 2, manager, self._command(), receivers=others)
        for node in self.bus.nodes:
            yield from self._emergency(node, self.names[node.id])
        if self.bus.sync or any(map(uses_sync, self.bus.nodes)):
            yield self._sync(others)
        for described in nodes:
            yield from self._times(described, others)
            yield from self._sdo_servers(described, self.names[described.id])
        for node in self.bus.nodes:
            yield self._heartbeat(node.id, heartbeat(node))
        if self.bus.heartbeat:
            period = round(self.bus.heartbeat * 1000)
            yield self._heartbeat(self.bus.manager, period)

    def _command(self) -> list[Signal]:
        names = {n: name for n, name in self.names.items() if name != self.manager}
        return [
            Signal(
                "command",
                0,
                8,
                values={int(c): text for c, text in COMMAND_TEXTS.items()},
            ),
            Signal("node", 8, 8, values={0: "all nodes", **names}),
        ]

    def _sync(self, receivers: list[str]) -> Message:
        cob_id = CobId(self.bus.sync_cob_id)
        counter = bool(self.bus.sync_counter)
        return Message(
            "sync",
            cob_id.can_id,
            1 if counter else 0,
            self.manager,
            [Signal("counter", 0, 8)] if counter else [],
            cob_id.extended,
            receivers,
            round(self.bus.sync * 1000),
        )

    def _times(self, node: DescribedNode, receivers: list[str]) -> Iterator[Message]:
        """Yield TIME, if the node consumes or produces it."""
        cob_id = CobId(node.parameters.get(COB_ID_TIME, 0) & 0xFFFFFFFF)
        if not (cob_id.bit30 or cob_id.bit31):
            return
        signals = [
            Signal("ms", 0, 28, unit="ms", comment="since midnight"),
            Signal("days", 32, 16, unit="d", comment="since 1984-01-01"),
        ]
        name = self.names[node.id] if cob_id.bit30 else self.manager
        taken = [r for r in receivers if r != name]
        yield Message("time", cob_id.can_id, 6, name, signals, cob_id.extended, taken)

    def _emergency(self, node: BusNode, name: str) -> Iterator[Message]:
        cob_id = emergency_cob_id(node)
        if cob_id & INVALID:
            return
        register = [
            Signal((bit.name or "").lower(), 16 + bit.bit_length() - 1, 1)
            for bit in ErrorRegister
        ]
        signals = [
            Signal("code", 0, 16, values=known_codes()),
            *register,
            Signal("additional", 24, 40),
        ]
        yield Message(
            f"{name}_emcy",
            can_id_of(cob_id),
            MAX_DATA,
            name,
            signals,
            bool(cob_id & EXTENDED),
            [self.manager],
        )

    def _heartbeat(self, node_id: int, period: int) -> Message:
        name = self.names[node_id]
        return Message(
            f"{name}_heartbeat",
            ERROR_CONTROL + node_id,
            1,
            name,
            [
                Signal(
                    "state",
                    0,
                    7,
                    values={int(s): text for s, text in STATE_TEXTS.items()},
                ),
                Signal("toggle", 7, 1, comment="of node guarding"),
            ],
            receivers=[other for other in self.names.values() if other != name],
            cycle=period,
        )

    def _sdo_servers(self, node: DescribedNode, name: str) -> Iterator[Message]:
        yield from self._sdo_pair(
            node,
            f"{name}_sdo",
            CobId(SDO_REQUEST + node.id),
            CobId(SDO_RESPONSE + node.id),
        )
        parameters = node.parameters
        for place, server in enumerate(SDO_SERVERS[1:], 2):
            words = [parameters.get((server, sub), INVALID) for sub in (1, 2)]
            request, answer = (CobId(word & 0xFFFFFFFF) for word in words)
            if request.valid and answer.valid:
                yield from self._sdo_pair(node, f"{name}_sdo{place}", request, answer)

    def _sdo_pair(
        self, node: DescribedNode, name: str, request: CobId, answer: CobId
    ) -> Iterator[Message]:
        server = self.names[node.id]
        for what, cob_id, sender, receiver in (
            ("request", request, self.manager, server),
            ("answer", answer, server, self.manager),
        ):
            yield Message(
                f"{name}_{what}",
                cob_id.can_id,
                MAX_DATA,
                sender,
                _sdo_signals(node, request=what == "request"),
                cob_id.extended,
                [receiver],
            )


def _sdo_signals(node: DescribedNode, *, request: bool) -> list[Signal]:
    """Return the signals of SDO: the command octet selects what follows.

    An expedited message has an object's value; others its number, and the rest, seven octets.
    """
    start = sdo.DOWNLOAD if request else sdo.UPLOAD
    values = [c for c in range(start, start + 0x20) if c & sdo.WITH_SIZE]
    sizes = [start | sdo.SIZE_INDICATED]
    block = sdo.BLOCK_DOWNLOAD if request else sdo.BLOCK_UPLOAD_ANSWER
    sizes += [block | sdo.WITH_SIZE, block | sdo.WITH_SIZE | sdo.WITH_CRC]
    numbered = [start, sdo.ABORT, *sizes, block, block | sdo.WITH_CRC]
    if request:
        numbered += [sdo.UPLOAD, sdo.BLOCK_UPLOAD, sdo.BLOCK_UPLOAD | sdo.WITH_CRC]
    else:
        numbered += [sdo.DOWNLOAD_DONE]
        numbered += [
            sdo.BLOCK_DOWNLOAD_ANSWER,
            sdo.BLOCK_DOWNLOAD_ANSWER | sdo.WITH_CRC,
        ]
    others = [c for c in range(256) if c not in values and c not in numbered]
    names = Names()
    fixed = [
        Signal("command", 0, 8, values=_command_names(request=request)),
        Signal("target", _OBJECT, _NUMBER_BITS, values=object_names(node)),
        Signal("size", _VALUE, 32, unit="octets"),
        Signal("abort_code", _VALUE, 32, values=sdo.ABORT_TEXTS),
        Signal("data", 8, 56),
    ]
    commands = [[], numbered, sizes, [sdo.ABORT], others]
    result = [
        replace(
            signal,
            name=names.add(signal.name),
            selector="command" if when else "",
            when=_ranges(when),
        )
        for signal, when in zip(fixed, commands, strict=True)
    ]
    selected = _selected_objects(node, names, names.add("object"))
    objects = replace(next(selected), selector="command", when=_ranges(values))
    return [*result, objects, *selected]


def _selected_objects(
    node: DescribedNode, names: Names, selector: str
) -> Iterator[Signal]:
    """Yield the number of an object, and for each object its value."""
    yield Signal(selector, _OBJECT, _NUMBER_BITS, values=object_names(node))
    for thing in node.objects.values():
        signal = sdo_signal(node, thing, _VALUE, selector)
        yield replace(signal, name=names.add(signal.name))


def _command_names(*, request: bool) -> Mapping[int, str]:
    """Return the names of the commands that begin or end a transfer."""
    start, verb = (
        (sdo.DOWNLOAD, "write request") if request else (sdo.UPLOAD, "read answer")
    )
    names = dict.fromkeys(range(start, start + 16), verb)
    names[sdo.ABORT] = "abort"
    if request:
        names[sdo.UPLOAD] = "read request"
    else:
        names[sdo.DOWNLOAD_DONE] = "write done"
    return dict(sorted(names.items()))


def _ranges(numbers: list[int]) -> tuple[range, ...]:
    """Return ascending ranges of the numbers."""
    result: list[range] = []
    for number in sorted(numbers):
        if result and result[-1].stop == number:
            result[-1] = range(result[-1].start, number + 1)
        else:
            result.append(range(number, number + 1))
    return tuple(result)


def _milliseconds(period: int) -> int:
    return round(period / _MILLISECOND)
