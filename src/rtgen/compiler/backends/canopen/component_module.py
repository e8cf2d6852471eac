"""Common parts of the proxy and the slave of a device: names of types, ports, members; imports."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any, TypeAlias

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
from rtgen.compiler.model import Component, Model, NamedType, ScopedName, Struct
from rtgen.compiler.model.canopen import PdoDirection
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
    """A module under construction."""

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        component: Component,
        ports: DevicePorts,
        options: Options,
        taken: Collection[str],
    ) -> None:
        self._options = options
        self.ports = ports
        self.component = component
        self.names = names
        self.types = component_imports(model, names, component, taken)
        self.attributes = {
            (port.kind.value, port.name): name
            for port, name in attributes_of(component).ports
        }
        self.parameters = {
            parameter.name: name
            for parameter, name in attributes_of(component).configuration
        }
        self.model = model

    # Names.

    @property
    def time(self) -> str:
        """The class of `RTC::Time`."""
        return self.types.type_name(TIME)

    def port(self, direction: PdoDirection, name: str) -> str:
        """The attribute for a port."""
        kind = "outport" if direction is PdoDirection.TPDO else "inport"
        return self.attributes[kind, name]

    def struct(self, sample: PdoSample) -> ScopedName:
        """The type of a PDO's port."""
        return (self.ports.module, sample.struct)

    def member(self, struct: ScopedName, name: str) -> str:
        """A member as an attribute in Python."""
        declaration = self.model.find(struct)
        assert isinstance(declaration, Struct)
        return self.names.members(declaration)[name]

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
        type_ = self.types.type_name(self.struct(sample))
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

    @property
    def device_package(self) -> str:
        """The package of the device's types and tables."""
        return f"{self.names.package}.{package_of(self.ports.kind)}"

    def module(self, title: str, body: str, *, defines: Iterable[str]) -> PythonModule:
        """Return the part of the module."""
        used = [Import("rtgen.runtime.canopen", "pdo", "_pdo")] * ("_pdo." in body)
        return python_module(
            module_path(self.names.package, self.component),
            self._options.package,
            self._options.version,
            [self.ports.device.key],
            title,
            imports=[*used, *self.types.imports()],
            body=body,
            defines=defines,
        )


def place(quantity: Quantity) -> Python:
    """Return index and sub-index of the object of a value."""
    return number(quantity.variable.index, quantity.variable.subindex)
