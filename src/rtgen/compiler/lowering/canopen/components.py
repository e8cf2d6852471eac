"""Creates the components of CANopen devices (proxy and slave), and the manager (RTC-CANopen)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.lowering.canopen.kinds import file_name, service_of
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    ConstantValue,
    NamedType,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    StringType,
    Type,
)
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import DataType, PdoDirection, Value, resolved
from rtgen.compiler.typemap.canopen.idl import limits
from rtgen.compiler.typemap.canopen.labels import line, object_line
from rtgen.compiler.typemap.canopen.ports import (
    NUMERIC,
    DevicePorts,
    Quantity,
    can_be_parameter,
)
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts.canopen_parameters import (
    COMPONENT_FACTS,
    DEVICE_CONFIGURATION,
    OF_DEVICES,
    OF_PROXIES,
    PROXY_CONFIGURATION,
    SharedParameter,
)

PROXY_BASE = "rtgen.runtime.canopen.master.proxy:CanopenProxy"
SERVICE_PORT = "sdo"
"""The service port of a proxy."""

_TYPES: Mapping[type, Type] = {
    bool: PrimitiveType(Primitive.BOOLEAN),
    int: PrimitiveType(Primitive.LONG),
    str: StringType(),
}
_WAYS = {PdoDirection.TPDO: PortKind.OUTPORT, PdoDirection.RPDO: PortKind.INPORT}


def manager(component: Component, buses: Sequence[Bus]) -> Component:
    """Return the component of the manager, for the networks of a project."""
    only = buses[0].name if len(buses) == 1 else ""
    return replace(
        component,
        configuration=tuple(
            replace(each, default=only) if each.name == "network" else each
            for each in component.configuration
        ),
        runtime_base="rtgen.runtime.canopen.master.manager:CanopenManager",
        factory=".canopen.manager:CanopenManager",
    )


def device_components(
    ports: DevicePorts, networks: Mapping[str, int]
) -> Iterator[Component]:
    """Yield `<Module>Proxy` and `<Module>Device`.

    `networks` maps the networks of the device to the node-id of one instance.
    """
    kind = ports.kind
    span = kind.span
    node_id = _node_id(ports, networks)
    network = next(iter(networks)) if len(networks) == 1 else ""
    file = file_name(ports)
    product = line(ports.device.info.product_name) or kind.module
    data_ports = tuple(_data_ports(ports))
    sdo = Port(
        kind=PortKind.PROVIDER,
        name=SERVICE_PORT,
        identifier=SERVICE_PORT,
        type=NamedType(service_of(kind)),
        port=SERVICE_PORT,
        instance=SERVICE_PORT,
        span=span,
        doc="The objects of the device, read and written by SDO.",
    )
    defaults: dict[str, int | str] = {"node_id": node_id, "network": network}
    name = f"{kind.module}Proxy"
    yield Component(
        **_head(name, file, span),
        doc=(
            f"Proxy of a device on a CANopen bus: {product}.\n\n"
            "OutPorts send the data received from the device, InPorts take the data for it.\n"
            "The life cycle follows the NMT state of the device."
        ),
        description=f"Proxy of {product}",
        ports=(*data_ports, sdo),
        configuration=(*_shared(OF_PROXIES, span, **defaults), *_of_objects(ports)),
        configuration_base=PROXY_CONFIGURATION,
        runtime_base=PROXY_BASE,
        factory=f".components.{module_name(name)}:{name}",
    )
    name = f"{kind.module}Device"
    yield Component(
        **_head(name, file, span),
        doc=(
            f"Device on a CANopen bus: {product}.\n\n"
            "InPorts get the received data, data written to OutPorts are transmitted."
        ),
        description=f"Device {product}",
        ports=data_ports,
        configuration=tuple(_shared(OF_DEVICES, span, **defaults)),
        configuration_base=DEVICE_CONFIGURATION,
        runtime_base=f".components.{module_name(name)}:{kind.module}Slave",
    )


def _head(name: str, file: str, span: Span) -> dict[str, Any]:
    return {
        "name": (name,),
        "repository_id": f"IDL:{name}:1.0",
        "file": file,
        "span": span,
        **COMPONENT_FACTS,
    }


def _node_id(ports: DevicePorts, networks: Mapping[str, int]) -> int:
    return next(iter(networks.values()), ports.device.node_id or 1)


def _data_ports(ports: DevicePorts) -> Iterator[Port]:
    module = ports.kind.module
    if ports.per_object:
        for each in ports.object_ports:
            yield Port(
                kind=_WAYS[each.direction],
                name=each.name,
                identifier=each.name,
                type=NamedType(each.quantity.timed(module)),
                unit=line(each.quantity.unit),
                span=each.quantity.variable.span,
                doc=_unitless(each.quantity),
            )
        return
    for sample in ports.samples:
        fields = ", ".join(field.name for field in sample.fields)
        yield Port(
            kind=_WAYS[sample.pdo.direction],
            name=sample.name,
            identifier=sample.name,
            type=NamedType((module, sample.struct)),
            span=sample.pdo.span,
            doc=f"{sample.pdo.direction.upper()} {sample.pdo.number}: {fields}.",
        )


def _unitless(quantity: Quantity) -> str:
    return object_line(Quantity(quantity.name, quantity.variable, quantity.factor))


def _shared(
    parameters: Iterable[SharedParameter], span: Span, **defaults: int | str
) -> Iterator[ConfigurationParameter]:
    """Yield parameters that all such components have, some with other defaults."""
    for each in parameters:
        yield ConfigurationParameter(
            name=each.name,
            identifier=each.name,
            type=_TYPES[type(each.default)],
            default=defaults.get(each.name, each.default),
            minimum=each.minimum,
            maximum=each.maximum,
            unit=each.unit,
            span=span,
            doc=each.description,
        )


def _of_objects(ports: DevicePorts) -> Iterator[ConfigurationParameter]:
    for quantity in ports.parameters:
        if not can_be_parameter(quantity):
            continue  # reported by the back end
        variable = quantity.variable
        node_id = ports.device.node_id
        default = _shown(quantity, resolved(variable.start(node_id), node_id))
        low, high = _limits(quantity, ports.device.node_id)
        if isinstance(default, int | float) and not isinstance(default, bool):
            low = None if low is not None and low > default else low
            high = None if high is not None and high < default else high
        yield ConfigurationParameter(
            name=quantity.name,
            identifier=quantity.name,
            type=quantity.type,
            default=default,
            minimum=low,
            maximum=high,
            unit=line(quantity.unit),
            span=variable.span,
            doc=f"{_unitless(quantity)}, written by SDO.",
        )


def _shown(quantity: Quantity, value: Value | None) -> ConstantValue | None:
    """A value of the object, converted to the parameter."""
    if quantity.variable.data_type == DataType.BOOLEAN and isinstance(value, int):
        return bool(value)
    if isinstance(value, int | float):
        if quantity.factor is not None:
            shown = float(value * quantity.factor)
            return shown if isfinite(shown) else None
        real = quantity.variable.data_type in (DataType.REAL32, DataType.REAL64)
        return float(value) if real else int(value)
    return value if isinstance(value, str) else None


def _limits(
    quantity: Quantity, node_id: int | None
) -> tuple[int | float | None, int | float | None]:
    """Return the limits in the file, else those of a type whose IDL type has a wider range."""
    variable = quantity.variable
    if variable.data_type not in NUMERIC:
        return None, None
    natural = limits(variable.data_type) or (None, None)
    bounds: list[int | float | None] = []
    for limit, own in zip((variable.low, variable.high), natural, strict=True):
        value = resolved(limit, node_id)
        bound = value if isinstance(value, int | float) else own
        if bound is not None and quantity.factor is not None:
            bound *= quantity.factor
        bounds.append(bound if bound is None or isfinite(bound) else None)
    low, high = bounds
    return (high, low) if (quantity.factor or 1) < 0 else (low, high)
