"""The part of a device's proxy besides its base: the complete component, the codecs of PDOs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rtgen.compiler.backends.canopen.component_module import (
    ComponentModule,
    Values,
    place,
)
from rtgen.compiler.backends.canopen.conversions import is_plain, to_codec, to_object
from rtgen.compiler.backends.canopen.literals import items, literal
from rtgen.compiler.backends.canopen.objects_module import (
    CONFIGURATION,
    REMAPPED,
    is_remapped,
)
from rtgen.compiler.backends.canopen.pdo_codec import Codecs, PdoCodec
from rtgen.compiler.backends.components.locations import base_location
from rtgen.compiler.backends.kit.python_module import PythonModule
from rtgen.compiler.backends.kit.quoting.python import Python, number_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.can_startup import configuration
from rtgen.compiler.lowering.canopen.components import SERVICE_PORT
from rtgen.compiler.lowering.canopen.kinds import service_of
from rtgen.compiler.model import Interface, PortKind
from rtgen.compiler.model.canopen import NodeRelative, PdoDirection
from rtgen.compiler.typemap.canopen.ports import DevicePorts, PdoSample, Quantity
from rtgen.compiler.typemap.canopen.values import kind, object_value, python_type

_SERVICE_TYPES = {
    "aborted": "SdoAbort",
    "gone": "BusGone",
    "typed_value": "ObjectValue",
    "kind": "ValueKind",
}
"""The attributes of a servant, and the types of the module CANopen that they have."""
_ZEROS = {
    "bool": "False",
    "char": '"\\0"',
    "string": '""',
    "wstring": '""',
    "octets": 'b""',
    "r32": "0.0",
    "r64": "0.0",
}


class ProxyModule(ComponentModule):
    """The proxy of a device."""

    SUFFIX = "Proxy"

    @classmethod
    def defined(cls, ports: DevicePorts) -> set[str]:
        """Return the names that the part defines or imports."""
        codecs = {f"{c}_{s.name}" for c in ("decode", "encode") for s in ports.samples}
        name = f"{ports.module}{cls.SUFFIX}"
        return {*super().defined(ports), name, _servant(ports), *codecs}

    def proxy(self) -> PythonModule:
        """Return the part of the module."""
        ports = self.ports
        received, sent = ports.of(PdoDirection.TPDO), ports.of(PdoDirection.RPDO)
        changes = {"pdos": REMAPPED} if is_remapped(ports.kind) else {}
        if configuration(ports.kind):
            changes["configuration"] = CONFIGURATION
        body = render(
            "canopen/proxy.py.j2",
            **self.values,
            base=base_location(self.names.package, self.component),
            changes=changes,
            codecs=Codecs(_codecs(received), _codecs(sent)),
            service_port=self.attributes[PortKind.PROVIDER.value, SERVICE_PORT],
            inlets=[*self._inlets()] if ports.per_object else [],
            sent=[*map(self._send, sent)],
            parameters=[*self._parameters()],
            received=[*map(self._receive, received)],
            servant=self._servant(),
        )
        title = f"The proxy of `{ports.device.key}`, with the codecs of its PDOs."
        return self.module(title, body, self.component.name[-1])

    # To the device.

    def _inlets(self) -> Iterator[Values]:
        """The InPorts of single objects, each with the PDOs that hold the object."""
        for port in self.ports.object_ports:
            if port.direction is PdoDirection.RPDO:
                pdos = items([str(pdo) for pdo, _ in port.places])
                yield {"port": self.port(port.direction, port.name), "pdos": pdos}

    def _send(self, sample: PdoSample) -> Values:
        """A sent PDO, with the arguments of its codec."""
        made = {"number": sample.pdo.number, "name": sample.name}
        if not self.ports.per_object:
            arguments = [*map(to_codec, sample.fields, self.members(sample))]
            port = self.port(PdoDirection.RPDO, sample.name)
            return {**made, "port": port, "arguments": arguments}
        plain = all(map(is_plain, sample.fields))
        values = (f"values[{n}]" for n in range(len(sample.fields)))
        return {
            **made,
            "initial": [
                (self.port(PdoDirection.RPDO, p.name), self._initial(p.quantity))
                for p in self.object_ports(sample)
            ],
            "arguments": (
                [Python("*values")]
                if plain
                else [*map(to_codec, sample.fields, values)]
            ),
        }

    def _initial(self, quantity: Quantity) -> Python:
        """The value of a member before the first sample: that of the object."""
        variable = quantity.variable
        start = variable.start(self.ports.device.node_id)
        value = object_value(variable.data_type, start)
        if isinstance(start, NodeRelative):
            value = None
        if quantity.factor is not None:
            number = value if isinstance(value, int | float) else 0
            return number_literal(float(number * quantity.factor))
        if self.is_time(quantity):
            return Python(f"{self.time}()")
        if value is None:
            return Python(_ZEROS.get(kind(variable.data_type), "0"))
        return literal(value)

    def _parameters(self) -> Iterator[tuple[Python, Python]]:
        for quantity in self.ports.parameters:
            attribute = self.parameters[quantity.name]
            yield place(quantity), to_object(quantity, f"self.config.{attribute}")

    # From the device.

    def _receive(self, sample: PdoSample) -> Values:
        """A received PDO: the variables of its values, those converted, the samples of ports."""
        variables = [f"v{n}" for n in range(len(sample.fields))]
        values = [
            self.decoded(quantity, variable, field.bits)
            for quantity, variable, field in zip(
                sample.fields, variables, sample.layout.fields, strict=True
            )
        ]
        made = {"number": sample.pdo.number, "name": sample.name, "members": []}
        first = f"({variables[0]},)"
        targets = Python(", ".join(variables) if len(variables) > 1 else first)
        if not self.ports.per_object:
            port = self.port(PdoDirection.TPDO, sample.name)
            if values == variables:
                targets, values = Python(""), [Python(f"*decode_{sample.name}(data)")]
            samples = [(port, self.sample(sample, values))]
            return {**made, "targets": targets, "samples": samples}
        # All values are converted before the first is written: a PDO arrives whole or not at all.
        pairs = [*enumerate(zip(variables, values, strict=True))]
        members = [v if v == value else f"m{n}" for n, (v, value) in pairs]
        ports = [*zip(self.object_ports(sample), members, strict=True)]
        return {
            **made,
            "targets": targets,
            "members": [(m, v) for m, v in zip(members, values, strict=True) if m != v],
            "samples": [
                (self.port(PdoDirection.TPDO, p.name), self.object_sample(p, member))
                for p, member in ports
            ],
        }

    # The SDO service.

    def _servant(self) -> Values:
        """The servant, with the operations that the bus file lists."""
        service = self.model.find(service_of(self.ports.kind))
        assert isinstance(service, Interface)
        names = self.names.operations(service)
        return {
            "name": _servant(self.ports),
            "interface": self.types.type_name(service.name),
            "attributes": [
                (attribute, self.types.type_name(("CANopen", name)))
                for attribute, name in _SERVICE_TYPES.items()
            ],
            "objects": [self._object(q, names) for q in self.ports.operations],
        }

    def _object(self, quantity: Quantity, names: Mapping[str, str]) -> Values:
        access, is_time = quantity.variable.access, self.is_time(quantity)
        factor = [] if quantity.factor is None else [number_literal(quantity.factor)]
        return {
            "getter": names[f"get_{quantity.name}"] if access.readable else "",
            "setter": names[f"set_{quantity.name}"] if access.writable else "",
            "type": self._annotation(quantity),
            "is_time": is_time,
            "place": place(quantity),
            "read": [place(quantity), *factor],
            "written": [
                place(quantity),
                to_object(quantity, "value") if is_time else "value",
                *factor,
            ],
        }

    def _annotation(self, quantity: Quantity) -> str:
        if quantity.factor is not None:
            return "float"
        if self.is_time(quantity):
            return self.time
        return python_type(quantity.variable.data_type)


def _servant(ports: DevicePorts) -> str:
    """Return the class of the servant of the SDO port."""
    return f"_{service_of(ports.kind)[-1]}"


def _codecs(samples: Iterable[PdoSample]) -> list[PdoCodec]:
    return [
        PdoCodec(s.name, f"{s.pdo.direction.upper()} {s.pdo.number}", s.layout)
        for s in samples
    ]
