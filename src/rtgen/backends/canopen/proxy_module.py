"""The part of a device's proxy besides its base: the complete component, the codecs of PDOs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.backends import Options
from rtgen.backends.canopen.component_module import ComponentModule
from rtgen.backends.canopen.conversions import is_plain, to_codec, to_object
from rtgen.backends.canopen.literals import call, items, literal, number
from rtgen.backends.canopen.objects_module import (
    CONFIGURATION,
    REMAPPED,
    is_remapped,
)
from rtgen.backends.canopen.pdo_codec import IMPORTS, PdoCodec, codecs_text
from rtgen.backends.components.locations import base_location
from rtgen.backends.kit.python_module import PythonModule
from rtgen.backends.kit.quoting.python import docstring, number_literal, string_literal
from rtgen.layouts.can_startup import configuration
from rtgen.lowering.canopen.components import SERVICE_PORT
from rtgen.lowering.canopen.kinds import service_of
from rtgen.model import Component, Interface, Model, PortKind
from rtgen.model.canopen import NodeRelative, PdoDirection
from rtgen.typemap.canopen.names import table_class
from rtgen.typemap.canopen.ports import DevicePorts, ObjectPort, PdoSample, Quantity
from rtgen.typemap.canopen.values import kind, object_value, python_type
from rtgen.typemap.python.idl_names import PythonNames

_HOOKS = "rtgen.runtime.canopen.hooks"
_SAMPLES = "rtgen.runtime.canopen.port_samples"
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


def proxy_module(
    model: Model,
    names: PythonNames,
    component: Component,
    ports: DevicePorts,
    options: Options,
    networks: str,
) -> PythonModule:
    """The module. `networks` is the package of the networks, empty if there is none."""
    return _ProxyModule(model, names, component, ports, options).proxy(networks)


class _ProxyModule(ComponentModule):
    def __init__(
        self,
        model: Model,
        names: PythonNames,
        component: Component,
        ports: DevicePorts,
        options: Options,
    ) -> None:
        name = component.name[-1]
        codecs = {f"{c}_{s.name}" for c in ("decode", "encode") for s in ports.samples}
        self._objects = table_class(ports.module)
        self._servant_name = f"_{service_of(ports.kind)[-1]}"
        taken = {name, self._servant_name, self._objects, *codecs}
        super().__init__(model, names, component, ports, options, taken)
        self._name = name
        self._received = ports.of(PdoDirection.TPDO)
        self._sent = ports.of(PdoDirection.RPDO)
        self._changes: dict[str, str] = {}
        if is_remapped(ports.kind):
            self._changes["pdos"] = REMAPPED
        if configuration(ports.kind):
            self._changes["configuration"] = CONFIGURATION

    def proxy(self, networks: str) -> PythonModule:
        """The whole module."""
        body = [
            f"class {self._name}({self._name}Base):",
            docstring(self.component.doc, 4).rstrip("\n"),
            "",
            f"    description = {self._description()}",
            *([f"    networks = {string_literal(networks)}"] if networks else []),
            *self._constructor(),
            *self._table("_receivers", "Receiver", "_receive", self._received),
            *self._table("_senders", "Sender", "_send", self._sent),
            *self._parameters(),
        ]
        for sample in self._received:
            body += self._receive(sample)
        for sample in self._sent:
            body += self._send(sample)
        body += self._servant()
        tables = ["DESCRIPTION", self._objects, *self._changes.values()]
        self.use(base_location(self.names.package, self.component), f"{self._name}Base")
        title = f"The proxy of `{self.ports.device.key}`, with the codecs of its PDOs."
        text = "\n".join([*self._codecs(), *body])
        return self.module(title, text, tables=tables, defines=[self._name])

    def _codecs(self) -> list[str]:
        """The functions from octets to values for TPDOs, from values to octets for RPDOs."""
        if not self.ports.samples:
            return []
        for module, name, local in IMPORTS:
            self.use(module, name, local)
        return [codecs_text(_codecs(self._received), _codecs(self._sent)), "", ""]

    # The class.

    def _description(self) -> str:
        """The description of the device for the codecs, also without a network."""
        if not self._changes:
            return "DESCRIPTION"
        replace = self.use("msgspec.structs", "replace")
        return call(replace, "DESCRIPTION", **self._changes)

    def _constructor(self) -> Iterator[str]:
        self.use("rtgen.runtime.canopen.objects", "over_sdo")
        yield ""
        yield "    def __init__(self, instance_name: str | None = None) -> None:"
        yield "        super().__init__(instance_name)"
        yield f"        self.objects = over_sdo({self._objects}, self)"
        yield '        """The objects of the device by their names, read and written by SDO."""'
        yield f"        self.{self._service_port()}.set_servant({self._servant_name}(self))"
        if not self.ports.per_object:
            return
        for port in self._in_ports():
            self.use(_SAMPLES, "Inlet")
            attribute = self.port(PdoDirection.RPDO, port.name)
            pdos = items([str(pdo) for pdo, _ in port.places])
            yield f"        _{attribute} = Inlet(self.{attribute}, {pdos})"
        for sample in self._sent:
            self.use(_SAMPLES, "Gathering")
            fields = [
                f"(_{self.port(PdoDirection.RPDO, p.name)}, {self._initial(p.quantity)})"
                for p in self.object_ports(sample)
            ]
            values = call("Gathering", str(sample.pdo.number), *fields)
            yield f"        self._{sample.name} = {values}"

    def _service_port(self) -> str:
        return self.attributes[PortKind.PROVIDER.value, SERVICE_PORT]

    def _in_ports(self) -> list[ObjectPort]:
        return [
            port
            for port in self.ports.object_ports
            if port.direction is PdoDirection.RPDO
        ]

    def _initial(self, quantity: Quantity) -> str:
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
            return f"{self.time}()"
        if value is None:
            return _ZEROS.get(kind(variable.data_type), "0")
        return literal(value)

    def _table(
        self, name: str, type_: str, prefix: str, samples: tuple[PdoSample, ...]
    ) -> Iterator[str]:
        self.use("collections.abc", "Mapping")
        self.use(_HOOKS, type_)
        entries = (f"{s.pdo.number}: self.{prefix}_{s.name}" for s in samples)
        yield ""
        yield f"    def {name}(self) -> Mapping[int, {type_}]:"
        yield f"        return {{{', '.join(entries)}}}"

    def _parameters(self) -> Iterator[str]:
        self.use("rtgen.runtime.canopen.description", "ObjectNumber")
        self.use("rtgen.runtime.canopen.description", "ObjectValue")
        entries = []
        for quantity in self.ports.parameters:
            attribute = self.parameters[quantity.name]
            variable = quantity.variable
            value = to_object(quantity, f"self.config.{attribute}")
            place = number(variable.index, variable.subindex)
            entries.append(f"({place}): {value}")
        yield ""
        yield "    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:"
        yield f"        return {{{', '.join(entries)}}}"

    # From the device.

    def _receive(self, sample: PdoSample) -> Iterator[str]:
        decode = f"decode_{sample.name}"
        yield ""
        yield f"    def _receive_{sample.name}(self, data: bytes, now: int) -> None:"
        targets = [f"v{place}" for place in range(len(sample.fields))]
        values = [
            self.decoded(quantity, target, field.bits)
            for quantity, target, field in zip(
                sample.fields, targets, sample.layout.fields, strict=True
            )
        ]
        if not self.ports.per_object and values == targets:
            made = self.sample(sample, [f"*{decode}(data)"])
            yield f"        self.{self.port(PdoDirection.TPDO, sample.name)}.write({made})"
            return
        together = ", ".join(targets) if len(targets) > 1 else f"({targets[0]},)"
        yield f"        {together} = {decode}(data)"
        if not self.ports.per_object:
            made = self.sample(sample, values)
            yield f"        self.{self.port(PdoDirection.TPDO, sample.name)}.write({made})"
            return
        # All values are converted before the first is written: a PDO arrives whole or not at all.
        members = [
            target if target == value else f"m{place}"
            for place, (target, value) in enumerate(zip(targets, values, strict=True))
        ]
        for member, value in zip(members, values, strict=True):
            if member not in targets:
                yield f"        {member} = {value}"
        for port, member in zip(self.object_ports(sample), members, strict=True):
            made = self.object_sample(port, member)
            yield f"        self.{self.port(PdoDirection.TPDO, port.name)}.write({made})"

    # To the device.

    def _send(self, sample: PdoSample) -> Iterator[str]:
        encode = f"encode_{sample.name}"
        self.use("collections.abc", "Iterator")
        yield ""
        yield f"    def _send_{sample.name}(self) -> Iterator[bytes]:"
        if self.ports.per_object:
            targets = [f"values[{place}]" for place in range(len(sample.fields))]
            yield f"        for values in self._{sample.name}.rounds():"
            if all(map(is_plain, sample.fields)):
                yield f"            yield {encode}(*values)"
                return
        else:
            self.use(_SAMPLES, "unread")
            port = self.port(PdoDirection.RPDO, sample.name)
            struct = self.struct(sample)
            targets = [f"sample.{self.member(struct, q.name)}" for q in sample.fields]
            yield f"        for sample in unread(self.{port}):"
        values = [to_codec(q, v) for q, v in zip(sample.fields, targets, strict=True)]
        yield f"            yield {call(encode, *values)}"

    # The SDO service.

    def _servant(self) -> Iterator[str]:
        """The servant, with the operations that the bus file lists."""
        service = self.model.find(service_of(self.ports.kind))
        assert isinstance(service, Interface)
        names = self.names.operations(service)
        self.use("rtgen.runtime.canopen.master.sdo_service", "SdoService")
        interface = self.types.type_name(service.name)
        yield ""
        yield ""
        yield f"class {self._servant_name}(SdoService, {interface}):"
        yield '    """The objects of the device, by SDO."""'
        yield ""
        for attribute, name in _SERVICE_TYPES.items():
            yield f"    {attribute} = {self.types.type_name(('CANopen', name))}"
        for quantity in self.ports.operations:
            access = quantity.variable.access
            if access.readable:
                yield ""
                yield from self._getter(names[f"get_{quantity.name}"], quantity)
            if access.writable:
                yield ""
                yield from self._setter(names[f"set_{quantity.name}"], quantity)

    def _getter(self, method: str, quantity: Quantity) -> Iterator[str]:
        variable = quantity.variable
        place = number(variable.index, variable.subindex)
        factor = () if quantity.factor is None else (number_literal(quantity.factor),)
        read = call("self._get", place, *factor)
        yield f"    def {method}(self) -> {self._annotation(quantity)}:"
        if self.is_time(quantity):
            read = call("self._get_time", place)
            yield f"        return {self.time}(*{read})"
            return
        yield f"        value: {self._annotation(quantity)} = {read}"
        yield "        return value"

    def _setter(self, method: str, quantity: Quantity) -> Iterator[str]:
        variable = quantity.variable
        place = number(variable.index, variable.subindex)
        factor = () if quantity.factor is None else (number_literal(quantity.factor),)
        value = to_object(quantity, "value") if self.is_time(quantity) else "value"
        annotation = self._annotation(quantity)
        yield f"    def {method}(self, value: {annotation}) -> None:"
        yield f"        {call('self._set', place, value, *factor)}"

    def _annotation(self, quantity: Quantity) -> str:
        if quantity.factor is not None:
            return "float"
        if self.is_time(quantity):
            return self.time
        return python_type(quantity.variable.data_type)


def _codecs(samples: Iterable[PdoSample]) -> list[PdoCodec]:
    return [
        PdoCodec(s.name, f"{s.pdo.direction.upper()} {s.pdo.number}", s.layout)
        for s in samples
    ]
