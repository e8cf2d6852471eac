"""The ports of a device's PDOs and the members of their samples.

The common source for IDL, codecs and conversions of a device.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

import msgspec
from msgspec.structs import replace

from rtgen.compiler.layouts.pdo import Mapped, PdoLayout, PdoLayoutError, layout
from rtgen.compiler.model import NamedType, Primitive, PrimitiveType, ScopedName, Type
from rtgen.compiler.model.can_bus import DeviceKind, kind_of
from rtgen.compiler.model.canopen import (
    SIGNED,
    UNSIGNED,
    DataType,
    Device,
    Pdo,
    PdoDirection,
    Variable,
)
from rtgen.compiler.typemap.canopen.idl import row
from rtgen.compiler.typemap.canopen.names import field_names, numbered

STAMP = "tm"
"""The first member of every sample, an `RTC::Time`: the time of measurement or arrival."""

_DOUBLE = PrimitiveType(Primitive.DOUBLE)
OWN_PARAMETERS = (
    *("interface", "channel", "bitrate", "options", "node_id", "network"),
    *("master", "heartbeat_timeout", "boot_timeout", "emergency_stop", "recoveries"),
    "sdo_in_error",
)
"""Configuration parameters of every proxy; devices have those up to `network` and `merged_stop`."""

NUMERIC = frozenset((*SIGNED, *UNSIGNED, DataType.REAL32, DataType.REAL64))
"""Numeric kinds."""
_PLAIN_PARAMETERS = (
    DataType.BOOLEAN,
    DataType.VISIBLE_STRING,
    DataType.UNICODE_STRING,
)
_OWN_TIMED = {
    PrimitiveType(Primitive.LONG_LONG): "TimedLongLong",
    PrimitiveType(Primitive.UNSIGNED_LONG_LONG): "TimedULongLong",
    NamedType(("RTC", "Time")): "TimedTime",
}


class Quantity(msgspec.Struct, frozen=True):
    """A variable as shown by components: with a factor it is a physical value, a `double`.

    Physical value = `factor` * value; None if the raw value is shown.
    """

    name: str
    variable: Variable
    factor: float | None = None
    unit: str = ""

    @property
    def type(self) -> Type:
        """The IDL type."""
        return row(self.variable.data_type).type if self.factor is None else _DOUBLE

    def timed(self, module: str) -> ScopedName:
        """Return the type of a port with this variable only; RTC's, or one of `module`."""
        if self.factor is not None:
            return ("RTC", "TimedDouble")
        port_type = row(self.variable.data_type).timed
        return (
            (module, _OWN_TIMED[self.type]) if port_type is None else ("RTC", port_type)
        )


def _usable(factor: float | None, variable: Variable) -> float | None:
    """Return the factor if it changes the value, else None."""
    fine = factor is not None and isfinite(factor) and factor not in (0, 1)
    return factor if fine and variable.data_type in NUMERIC else None


def can_be_parameter(quantity: Quantity) -> bool:
    """Return whether an object can be a configuration parameter: a writable number or text."""
    code = quantity.variable.data_type
    return quantity.variable.access.writable and (
        code in NUMERIC or code in _PLAIN_PARAMETERS
    )


class PdoSample(msgspec.Struct, frozen=True):
    """A PDO with a port: `fields` are the members of its struct after the time stamp.

    `layout` has the same fields, under the same names.
    """

    pdo: Pdo
    fields: tuple[Quantity, ...]
    layout: PdoLayout

    @property
    def name(self) -> str:
        """The name of its port: `tpdo1`."""
        return f"{self.pdo.direction}{self.pdo.number}"

    @property
    def struct(self) -> str:
        """The name of its struct: `Tpdo1`."""
        return self.name.capitalize()


class ObjectPort(msgspec.Struct, frozen=True):
    """A mapped object with a separate port.

    `places` are the PDOs that map it, as (PDO number, index among the PDO's fields).
    """

    name: str
    direction: PdoDirection
    quantity: Quantity
    places: tuple[tuple[int, int], ...]


class DevicePorts:
    """The ports and parameters of a device's components, from the settings of its kind.

    `module` is the IDL module; `per_object`: one port for each object instead of each PDO.
    `names` are the fields of all variables by index and sub-index. `samples` are the PDOs that
    map an object, in order of the device. `refused` are PDOs without a port, with the reason.
    """

    def __init__(self, device: Device, kind: DeviceKind | None = None) -> None:
        self.device = device
        self.kind = kind or kind_of(device)
        self.module = self.kind.module
        self.per_object = self.kind.ports == "object"
        self.names = field_names(device.variables)
        self._factors: Mapping[tuple[int, int], float] = dict(self.kind.factors)
        self._units: Mapping[tuple[int, int], str] = dict(self.kind.units)
        self.refused: list[tuple[Pdo, str]] = []
        self.samples = tuple(self._samples())

    def quantity(self, variable: Variable) -> Quantity:
        """Return a variable with the factor and the unit of the bus file."""
        number = variable.index, variable.subindex
        factor = _usable(self._factors.get(number), variable)
        plain = factor is None and _usable(variable.factor, variable) is not None
        unit = self._units.get(number, "" if plain else variable.unit)
        return Quantity(self.names[number], variable, factor, unit)

    @property
    def parameters(self) -> tuple[Quantity, ...]:
        """The objects that become configuration parameters, in order of the bus file.

        The number is appended to a name that every proxy uses.
        """
        quantities = []
        for number in self.kind.parameters:
            variable = self.device.find(*number)
            if variable is not None:
                quantity = self.quantity(variable)
                if quantity.name.lower() in OWN_PARAMETERS:
                    quantity = replace(quantity, name=numbered(quantity.name, number))
                quantities.append(quantity)
        return tuple(quantities)

    @property
    def operations(self) -> tuple[Quantity, ...]:
        """The objects for which the SDO service has operations, in order of the bus file."""
        variables = (self.device.find(*number) for number in self.kind.operations)
        return tuple(self.quantity(v) for v in variables if v is not None)

    def of(self, direction: PdoDirection) -> tuple[PdoSample, ...]:
        """Return the PDOs of a direction."""
        return tuple(s for s in self.samples if s.pdo.direction is direction)

    @property
    def object_ports(self) -> tuple[ObjectPort, ...]:
        """A port for each mapped object, named `_in` and `_out` if there are both directions."""
        pdos: dict[tuple[PdoDirection, tuple[int, int]], list[tuple[int, int]]] = {}
        quantities: dict[tuple[int, int], Quantity] = {}
        for sample in self.samples:
            for place, field in enumerate(sample.fields):
                number = field.variable.index, field.variable.subindex
                quantities[number] = self.quantity(field.variable)
                key = sample.pdo.direction, number
                pdos.setdefault(key, []).append((sample.pdo.number, place))
        ports = []
        for (direction, number), places in pdos.items():
            quantity = quantities[number]
            name = quantity.name
            other = next(d for d in PdoDirection if d is not direction)
            if (other, number) in pdos:
                name += "_out" if direction is PdoDirection.TPDO else "_in"
            ports.append(ObjectPort(name, direction, quantity, tuple(places)))
        return tuple(ports)

    def _samples(self) -> Iterator[PdoSample]:
        for pdo in self.device.pdos:
            fields: list[Quantity] = []
            mapped: list[Mapped] = []
            struct = f"{pdo.direction}{pdo.number}"
            for entry in pdo.entries:
                variable = self.device.find(entry.index, entry.subindex)
                if variable is None or entry.dummy:
                    mapped.append(Mapped(None, 0, entry.bits))
                    continue
                quantity = self._member(variable, fields, struct)
                fields.append(quantity)
                mapped.append(Mapped(quantity.name, variable.data_type, entry.bits))
            if not fields:
                continue
            try:
                laid_out = layout(mapped)
            except PdoLayoutError as error:
                self.refused.append((pdo, str(error)))
            else:
                yield PdoSample(pdo, tuple(fields), laid_out)

    def _member(
        self, variable: Variable, quantities: Sequence[Quantity], struct: str
    ) -> Quantity:
        """Return a variable as a member of a struct.

        The object's number is appended to a name equal to that of the struct, the time stamp or the
        module of its type; repeated variables are numbered.
        """
        quantity = self.quantity(variable)
        first = quantity.name
        if first.lower() in (STAMP, struct, "rtc"):
            first = numbered(first, variable.number)
        taken = {q.name.lower() for q in quantities}
        name, place = first, 1
        while name.lower() in taken:
            place += 1
            name = f"{first}_{place}"
        return Quantity(name, variable, quantity.factor, quantity.unit)
