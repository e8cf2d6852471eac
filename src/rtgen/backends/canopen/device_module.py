"""The part of a device's component besides its base: its slave, without ports and configuration."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.backends import Options
from rtgen.backends.canopen.component_module import ComponentModule
from rtgen.backends.canopen.conversions import to_object
from rtgen.backends.canopen.literals import items, number
from rtgen.backends.kit.python_module import PythonModule
from rtgen.backends.kit.quoting.python import docstring, string_literal
from rtgen.model import Component, Model
from rtgen.model.canopen import PdoDirection
from rtgen.typemap.canopen.names import table_class
from rtgen.typemap.canopen.ports import DevicePorts, ObjectPort, PdoSample, Quantity
from rtgen.typemap.python.idl_names import PythonNames

_HOOKS = "rtgen.runtime.canopen.hooks"


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
        self._name = f"{ports.module}Slave"
        self._objects = table_class(ports.module)
        super().__init__(model, names, component, ports, options, {self._objects})
        self._received = ports.of(PdoDirection.RPDO)
        self._sent = ports.of(PdoDirection.TPDO)

    def device(self, networks: str) -> PythonModule:
        """The whole module."""
        self.use("rtgen.runtime.canopen.node.device", "CanopenDevice")
        self.use("collections.abc", "Mapping")
        self.use(_HOOKS, "Incoming")
        self.use(_HOOKS, "Outgoing")
        outgoing = list(self._outgoing())
        incoming = (f"{s.pdo.number}: _incoming_{s.name}" for s in self._received)
        taken = (f"{string_literal(name)}: {taker}" for name, taker, _ in outgoing)
        about = f"What the component {self.component.name[-1]} consists of, apart from ports."
        body = [
            f"class {self._name}(CanopenDevice):",
            docstring(about, 4).rstrip("\n"),
            "",
            "    description = DESCRIPTION",
            *([f"    networks = {string_literal(networks)}"] if networks else []),
            "",
            "    def __init__(self, instance_name: str | None = None) -> None:",
            "        super().__init__(instance_name)",
            f"        self.objects = {self._objects}(self.get_object, self.set_object)",
            '        """The object dictionary of the device, by the names of the objects."""',
            "",
            "    def _incoming(self) -> Mapping[int, Incoming]:",
            f"        return {{{', '.join(incoming)}}}",
            "",
            "    def _outgoing(self) -> Mapping[str, Outgoing]:",
            f"        return {{{', '.join(taken)}}}",
        ]
        for sample in self._received:
            body += self._incoming(sample)
        for _, _, function in outgoing:
            body += function
        title = f"The device of `{self.ports.device.key}` as a component."
        tables = ["DESCRIPTION", self._objects]
        text = "\n".join(body)
        return self.module(title, text, tables=tables, defines=[self._name])

    def _incoming(self, sample: PdoSample) -> Iterator[str]:
        self.use(_HOOKS, "Getter")
        self.use("typing", "Any")
        values = [self.of_object(q, f"get(({_place(q)}))") for q in sample.fields]
        if self.ports.per_object:
            made = [
                (port.name, self.object_sample(port, value))
                for port, value in zip(self.object_ports(sample), values, strict=True)
            ]
        else:
            made = [(sample.name, self.sample(sample, values))]
        pairs = [f"({string_literal(name)}, {text})" for name, text in made]
        yield ""
        yield ""
        yield (
            f"def _incoming_{sample.name}(get: Getter, now: int)"
            " -> tuple[tuple[str, Any], ...]:"
        )
        yield f"    return {items(pairs)}"

    def _outgoing(self) -> Iterator[tuple[str, str, list[str]]]:
        """For each OutPort its name, the function for its samples, and the function's text."""
        if not self.ports.per_object:
            for sample in self._sent:
                struct = self.struct(sample)
                fields = [(q, self.member(struct, q.name)) for q in sample.fields]
                yield self._taker(sample.name, fields)
            return
        for port in self._out_ports():
            yield self._taker(port.name, [(port.quantity, "data")])

    def _out_ports(self) -> list[ObjectPort]:
        return [
            port
            for port in self.ports.object_ports
            if port.direction is PdoDirection.TPDO
        ]

    def _taker(
        self, port: str, fields: list[tuple[Quantity, str]]
    ) -> tuple[str, str, list[str]]:
        self.use(_HOOKS, "Setter")
        self.use("typing", "Any")
        name = f"_outgoing_{port}"
        text = ["", "", f"def {name}(sample: Any, set_: Setter) -> None:"]
        for quantity, member in fields:
            value = to_object(quantity, f"sample.{member}")
            text.append(f"    set_(({_place(quantity)}), {value})")
        return port, name, text


def _place(quantity: Quantity) -> str:
    return number(quantity.variable.index, quantity.variable.subindex)
