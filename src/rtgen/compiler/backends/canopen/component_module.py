"""Common parts of the proxy and the slave of a device: names of types, ports, members; imports."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, TypeAlias

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.conversions import from_codec, from_object, stamp
from rtgen.compiler.backends.canopen.literals import call, number
from rtgen.compiler.backends.components.base_module import component_imports
from rtgen.compiler.backends.components.locations import module_path
from rtgen.compiler.backends.components.members import attributes_of
from rtgen.compiler.backends.kit.python_module import (
    Import,
    PythonModule,
    python_module,
)
from rtgen.compiler.backends.kit.quoting.python import Python
from rtgen.compiler.lowering.canopen.kinds import package_of
from rtgen.compiler.model import Component, Model, NamedType, Struct
from rtgen.compiler.model.canopen import PdoDirection
from rtgen.compiler.typemap.canopen.names import table_class
from rtgen.compiler.typemap.canopen.ports import (
    DevicePorts,
    ObjectPort,
    PdoSample,
    Quantity,
)
from rtgen.compiler.typemap.python.idl_names import PythonNames

TIME = ("RTC", "Time")

Values: TypeAlias = dict[str, Any]
"""The values of a part of a template."""


class ComponentModule:
    """The part of a component's module besides its base.

    `networks` is the package of the networks, empty if there is none.
    """

    SUFFIX: ClassVar[str]
    """What the component's name adds to that of the device."""

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        ports: DevicePorts,
        options: Options,
        networks: str,
    ) -> None:
        component = model.find((f"{ports.module}{self.SUFFIX}",))
        assert isinstance(component, Component)
        self._options = options
        self.model = model
        self.names = names
        self.ports = ports
        self.component = component
        self.types = component_imports(model, names, component, self.defined(ports))
        attributes = attributes_of(component)
        self.attributes = {(p.kind.value, p.name): n for p, n in attributes.ports}
        self.parameters = {p.name: name for p, name in attributes.configuration}
        self.values: Values = {
            "name": component.name[-1],
            "device": f"{names.package}.{package_of(ports.kind)}",
            "objects": table_class(ports.module),
            "networks": networks,
            "per_object": ports.per_object,
        }
        """The values of both templates."""

    @classmethod
    def defined(cls, ports: DevicePorts) -> set[str]:
        """Return the names that the part defines or imports."""
        return {table_class(ports.module)}

    # Names.

    @property
    def time(self) -> str:
        """The class of `RTC::Time`."""
        return self.types.type_name(TIME)

    def port(self, direction: PdoDirection, name: str) -> str:
        """The attribute for a port."""
        kind = "outport" if direction is PdoDirection.TPDO else "inport"
        return self.attributes[kind, name]

    def members(self, sample: PdoSample) -> list[str]:
        """The members of a PDO's sample, as expressions."""
        struct = self.model.find((self.ports.module, sample.struct))
        assert isinstance(struct, Struct)
        names = self.names.members(struct)
        return [f"sample.{names[quantity.name]}" for quantity in sample.fields]

    def object_ports(self, sample: PdoSample) -> list[ObjectPort]:
        """The ports of a PDO's objects, in the order of its fields; for ports by object."""
        places = {
            place: port
            for port in self.ports.object_ports
            if port.direction is sample.pdo.direction
            for number, place in port.places
            if number == sample.pdo.number
        }
        return [places[place] for place in range(len(sample.fields))]

    # Samples.

    def sample(self, sample: PdoSample, values: Iterable[str]) -> Python:
        """The sample of a PDO; `values` are those of its fields as members."""
        type_ = self.types.type_name((self.ports.module, sample.struct))
        return call(type_, stamp(self.time), *values)

    def object_sample(self, port: ObjectPort, value: str) -> Python:
        """The sample of a port of one object."""
        type_ = self.types.type_name(port.quantity.timed(self.ports.module))
        return call(type_, stamp(self.time), value)

    def decoded(self, quantity: Quantity, value: str, bits: int) -> Python:
        """A codec's field of `bits` bits, converted to a member."""
        time = self.time if self.is_time(quantity) else ""
        return from_codec(quantity, value, bits, time)

    def of_object(self, quantity: Quantity, value: str) -> Python:
        """A value of the object dictionary, converted to a member."""
        time = self.time if self.is_time(quantity) else ""
        return from_object(quantity, value, time)

    def is_time(self, quantity: Quantity) -> bool:
        """Whether members represent the type as `RTC::Time`."""
        return quantity.type == NamedType(TIME)

    # Text.

    def module(self, title: str, body: str, defines: str) -> PythonModule:
        """Return the part of the module."""
        used = [Import("rtgen.runtime.canopen", "pdo", "_pdo")] * ("_pdo." in body)
        return python_module(
            module_path(self.names.package, self.component),
            self._options,
            [self.ports.device.key],
            title,
            imports=[*used, *self.types.imports()],
            body=body,
            defines=[defines],
        )


def place(quantity: Quantity) -> Python:
    """Return index and sub-index of the object of a value."""
    return number(quantity.variable.index, quantity.variable.subindex)
