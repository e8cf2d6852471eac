"""Describes CAN buses for pages of `rtgen ui`, as `rtgen can monitor` does for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rtgen.compiler.layouts.can_messages import messages
from rtgen.compiler.layouts.can_timing import load
from rtgen.runtime.canopen.values import ObjectValueError, encode
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.can.decoding.decoder import Decoder
from rtgen.tools.can.decoding.node_index import NodeIndex, read_node_index
from rtgen.tools.can.decoding.object_values import Field, sdo_value
from rtgen.tools.can.parsing.values import parsed_value
from rtgen.tools.kit.exits import Refusal
from rtgen.ui.errors import BAD_VALUE, UNKNOWN, CommandError
from rtgen.ui.protocol import ui


class BusDescriber:
    """The description of a bus; decodes its frames in the order of arrival.

    Without a file the nodes have no objects.
    """

    def __init__(self, file: Path | None) -> None:
        """Read the file. Raises InputError."""
        empty = NodeIndex(nodes={})
        self._node_index = empty if file is None else read_node_index(file, ())
        self._decoder = Decoder(self._node_index)

    @property
    def network(self) -> str:
        """The name of the network; empty without a file."""
        return "" if self._node_index.bus is None else self._node_index.bus.name

    def bus(self, name: str) -> ui.Bus:
        """Return the bus and its described nodes, whose states are unknown."""
        bus = self._node_index.bus
        rate = 0 if bus is None else 1000 * bus.bit_rate
        computed = -1.0
        if bus is not None and bus.bit_rate:
            computed = load(messages(bus, None), bus.bit_rate)
        nodes = [
            ui.BusNode(node_id=n.id, name=n.name, device=n.device.name)
            for n in sorted(self._node_index.nodes.values(), key=lambda n: n.id)
        ]
        if bus is not None:
            manager = self._node_index.manager
            nodes.append(
                ui.BusNode(node_id=manager, name=self._node_index.name(manager))
            )
        return ui.Bus(name=name, bit_rate=rate, computed_load=computed, nodes=nodes)

    def frame(self, frame: Frame) -> ui.Frame:
        """Return a decoded frame with its values, without time and bus."""
        decoded = self._decoder.decode(frame)
        return ui.Frame(
            can_id=frame.can_id,
            extended=frame.extended,
            remote=frame.remote,
            data=frame.data,
            kind=decoded.kind,
            node_id=-1 if decoded.node is None else decoded.node,
            text=decoded.text,
            fields=[_field(each) for each in decoded.fields],
        )

    def objects(self, node_id: int) -> Sequence[ui.ObjectEntry]:
        """Return the objects of a node by number; none without a description."""
        node = self._node_index.nodes.get(node_id)
        if node is None:
            return ()
        return [
            ui.ObjectEntry(
                index=number[0],
                subindex=number[1],
                name=thing.name,
                type=str(thing.kind),
                access=thing.access.value,
                unit=thing.unit,
            )
            for number, thing in sorted(node.objects.items())
        ]

    def octets(self, node_id: int, number: tuple[int, int], text: str) -> bytes:
        """Return the octets of a value of an object. Raises CommandError."""
        node = self._node_index.nodes.get(node_id)
        thing = None if node is None else node.objects.get(number)
        if thing is None:
            raise CommandError(UNKNOWN, f"node {node_id} has no such object described")
        try:
            return encode(thing.kind, parsed_value(thing, text))
        except (Refusal, ObjectValueError, ValueError) as error:
            message = str(error)
            raise CommandError(BAD_VALUE, message) from error

    def text(self, node_id: int, number: tuple[int, int], octets: bytes) -> str:
        """Return the value of an object with its unit; octets if it is not described."""
        node = self._node_index.nodes.get(node_id)
        thing = None if node is None else node.objects.get(number)
        if node is None or thing is None:
            return octets.hex(" ")
        return Field(node.name, thing, sdo_value(thing, octets)).text


def _field(field: Field) -> ui.FrameField:
    value = field.physical
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return ui.FrameField(
        name=f"{field.node}.{field.name}" if field.node else field.name,
        text=field.text,
        unit=field.thing.unit,
        numeric=is_number,
        number=float(value) if isinstance(value, int | float) else 0.0,
    )
