"""The part of a device's component besides its base: its slave, without ports and configuration."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.component_module import (
    ComponentModule,
    Values,
    place,
)
from rtgen.compiler.backends.canopen.conversions import to_object
from rtgen.compiler.backends.kit.python_module import PythonModule
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model import Component, Model
from rtgen.compiler.model.canopen import PdoDirection
from rtgen.compiler.typemap.canopen.names import table_class
from rtgen.compiler.typemap.canopen.ports import DevicePorts, PdoSample
from rtgen.compiler.typemap.python.idl_names import PythonNames


def device_module(
    model: Model,
    names: PythonNames,
    component: Component,
    ports: DevicePorts,
    options: Options,
    networks: str,
) -> PythonModule:
    """The module. `networks` is the package of the networks, empty if there is none."""
    return _DeviceModule(model, names, component, ports, options).device(networks)


class _DeviceModule(ComponentModule):
    def __init__(
        self,
        model: Model,
        names: PythonNames,
        component: Component,
        ports: DevicePorts,
        options: Options,
    ) -> None:
        self._objects = table_class(ports.module)
        super().__init__(model, names, component, ports, options, {self._objects})

    def device(self, networks: str) -> PythonModule:
        """The whole module."""
        name = f"{self.ports.module}Slave"
        sent = self._outgoing_by_object if self.ports.per_object else self._outgoing
        body = render(
            "canopen/device.py.j2",
            name=name,
            component=self.component.name[-1],
            device=self.device_package,
            objects=self._objects,
            networks=networks,
            received=[*map(self._incoming, self.ports.of(PdoDirection.RPDO))],
            sent=[*sent()],
        )
        title = f"The device of `{self.ports.device.key}` as a component."
        return self.module(title, body, defines=[name])

    def _incoming(self, sample: PdoSample) -> Values:
        """A received PDO, with the samples of its ports."""
        values = [self.of_object(q, f"get(({place(q)}))") for q in sample.fields]
        if self.ports.per_object:
            samples = [
                (port.name, self.object_sample(port, value))
                for port, value in zip(self.object_ports(sample), values, strict=True)
            ]
        else:
            samples = [(sample.name, self.sample(sample, values))]
        return {"number": sample.pdo.number, "name": sample.name, "samples": samples}

    def _outgoing(self) -> Iterator[Values]:
        """The OutPorts, each with the objects of its samples and their values."""
        for sample in self.ports.of(PdoDirection.TPDO):
            struct = self.struct(sample)
            fields = [
                (place(q), to_object(q, f"sample.{self.member(struct, q.name)}"))
                for q in sample.fields
            ]
            yield {"name": sample.name, "fields": fields}

    def _outgoing_by_object(self) -> Iterator[Values]:
        for port in self.ports.object_ports:
            if port.direction is PdoDirection.TPDO:
                field = (place(port.quantity), to_object(port.quantity, "sample.data"))
                yield {"name": port.name, "fields": [field]}
