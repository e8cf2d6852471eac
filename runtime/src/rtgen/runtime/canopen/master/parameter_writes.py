"""Writes of a proxy's parameters to its node, in the order of `facts.write_order`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rtgen.facts import write_order
from rtgen.facts.canopen import INVALID, NO_RTR
from rtgen.facts.cob_ids import in_force, service_of
from rtgen.facts.write_order import How, Step
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectNumber,
    ObjectValue,
    Write,
)


class ParameterWriter:
    """The `Target` of the writes of parameters.

    The node has the values of its description, `configuration`, and `written`, the later ones
    first. Where the configuration is unknown (None), only parameters are written.
    """

    def __init__(
        self,
        description: DeviceDescription,
        node_id: int,
        configuration: Sequence[Write] | None,
        written: Mapping[ObjectNumber, ObjectValue],
        values: Mapping[ObjectNumber, ObjectValue],
    ) -> None:
        self._description = description
        self._node_id = node_id
        self._is_known = configuration is not None
        self._configured = {(w.index, w.subindex): w for w in configuration or ()}
        self._mapped = {
            (pdo.mapping_index, 0): len(pdo.mapping) for pdo in description.pdos
        }
        self._written = written
        self._values = values

    def writes(self) -> Iterator[tuple[ObjectNumber, bytes]]:
        """Yield the writes of the wanted values.

        Raises ObjectValueError for a value that its object cannot have.
        """
        objects = self._description.by_number
        for step in write_order.steps(self._values.keys(), self):
            number = step.number
            yield number, values.encode(objects[number].kind, self._value(step))

    def before(self, number: ObjectNumber) -> int | None:
        """See `Target`."""
        return self._number(number, self._present(number))

    def after(self, number: ObjectNumber) -> int | None:
        """See `Target`."""
        return self._number(number, self._final(number))

    def states(self, number: ObjectNumber) -> bool:
        """See `Target`."""
        if number in self._written or number in self._configured:
            return True
        described = self._description.by_number.get(number)
        return described is None or described.states(self._node_id)

    def configured(self, number: ObjectNumber) -> int | None:
        """See `Target`: the configuration has been written."""
        return None

    def moves(self, number: ObjectNumber) -> bool:
        """See `Target`."""
        flags = INVALID | NO_RTR
        before, after = self.before(number) or 0, self.after(number) or 0
        return before & ~flags != after & ~flags

    def writable(self, number: ObjectNumber) -> bool:
        """See `Target`."""
        described = self._description.by_number.get(number)
        is_writable = described is not None and described.writable
        return is_writable and (self._is_known or number in self._values)

    def _value(self, step: Step) -> ObjectValue:
        if step.how is How.ZERO:
            return 0
        before = step.how is How.OFF_BEFORE
        value = self._present(step.number) if before else self._final(step.number)
        if step.how is not How.VALUE:
            service = service_of(step.number)
            assert service is not None
            assert isinstance(value, int)
            return service.switched_off(value)
        assert value is not None
        return value

    def _number(self, number: ObjectNumber, value: ObjectValue | None) -> int | None:
        if number not in self._description.by_number:
            return None
        return value if isinstance(value, int) else 0

    def _final(self, number: ObjectNumber) -> ObjectValue | None:
        """Return the value afterwards; a COB-ID of 0 stands for the predefined one."""
        value = self._values.get(number)
        if value is None:
            return self._present(number)
        if service_of(number) is not None and isinstance(value, int):
            return in_force(number, value, self._node_id, chosen=True)
        return value

    def _present(self, number: ObjectNumber) -> ObjectValue | None:
        if number in self._written:
            return self._written[number]
        described = self._description.by_number.get(number)
        if described is None:
            return None
        write = self._configured.get(number)
        if write is None:
            mapped = self._mapped.get(number)
            return described.initial(self._node_id) if mapped is None else mapped
        return values.decode(described.kind, write.octets(self._node_id))
