"""The part of a device's component besides its base: its slave, without ports and configuration."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends.canopen.component_module import (
    ComponentModule,
    Values,
    place,
)
from rtgen.compiler.backends.canopen.conversions import to_object
from rtgen.compiler.backends.kit.python_module import PythonModule
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model.canopen import PdoDirection
from rtgen.compiler.typemap.canopen.ports import PdoSample


class DeviceModule(ComponentModule):
    """The slave of a device."""

    SUFFIX = "Device"

    def device(self) -> PythonModule:
        """Return the part of the module."""
        slave = f"{self.ports.module}Slave"
        sent = self._outgoing_by_object if self.ports.per_object else self._outgoing
        body = render(
            "canopen/device.py.j2",
            **self.values,
            slave=slave,
            received=[*map(self._incoming, self.ports.of(PdoDirection.RPDO))],
            sent=[*sent()],
        )
        title = f"The device of `{self.ports.device.key}` as a component."
        return self.module(title, body, slave)

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
            values = map(to_object, sample.fields, self.members(sample))
            places = map(place, sample.fields)
            yield {"name": sample.name, "fields": [*zip(places, values, strict=True)]}

    def _outgoing_by_object(self) -> Iterator[Values]:
        for port in self.ports.object_ports:
            if port.direction is PdoDirection.TPDO:
                field = (place(port.quantity), to_object(port.quantity, "sample.data"))
                yield {"name": port.name, "fields": [field]}
