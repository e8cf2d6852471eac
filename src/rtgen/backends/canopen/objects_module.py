"""The part of a device's package besides its types: the typed table of objects, the description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec.structs import replace

from rtgen.backends import Options
from rtgen.backends.canopen.literals import (
    call,
    items,
    literal,
    named,
    number,
    octets_literal,
)
from rtgen.backends.kit.python_module import (
    Import,
    PythonModule,
    python_module,
)
from rtgen.backends.kit.python_text import fit
from rtgen.backends.kit.quoting.python import docstring, string_literal
from rtgen.layouts.can_startup import StartWrite, configuration, configured
from rtgen.model.can_bus import DeviceKind
from rtgen.model.canopen import (
    DataType,
    Device,
    NodeRelative,
    Pdo,
    Value,
    Variable,
    cob_id_in_force,
)
from rtgen.typemap.canopen.labels import line
from rtgen.typemap.canopen.names import TABLES, identifier, table_class
from rtgen.typemap.canopen.ports import DevicePorts
from rtgen.typemap.canopen.values import kind, object_value, python_type

DESCRIPTION, CONFIGURATION, REMAPPED = TABLES
"""The description, the writes that configure the device, and its PDOs after them."""

_OWN = "_"
"""The prefix of imported names, with which no name of an object or type begins."""

_CLASSES = {
    "bool": "Boolean",
    "int": "Integer",
    "float": "Real",
    "str": "Text",
    "bytes": "Octets",
}
"""The classes of entries by the types of their values."""
_IDENTITY = 0x1018
_EVENT_DRIVEN = 255


def objects_module(path: str, ports: DevicePorts, options: Options) -> PythonModule:
    """Return the part of the module at the path."""
    module, kind, names = ports.module, ports.kind, ports.names
    remapped = configured(kind).pdos if is_remapped(kind) else ()
    writes = configuration(kind)
    device = as_delivered(kind.device)
    used = ["DeviceDescription"]
    used += ["PdoDescription"] * bool(device.pdos or remapped)
    used += ["Write"] * bool(writes)
    entries = {_class(variable) for variable in device.variables}
    lines = [
        fit(f"class {table_class(module)}({_OWN}Objects):"),
        docstring(
            f"The values of {module}'s object dictionary, as they are on the wire.", 4
        ),
        "    __slots__ = ()",
        "",
        *_entries(device, names),
        "",
        "",
        fit(f"DESCRIPTION = {_description(module, device)}"),
        *_remapped(remapped, device),
        *_configuration(writes),
    ]
    return python_module(
        path,
        options.package,
        options.version,
        [device.key],
        f"The device of `{device.key}`: types of its ports, its objects, its description.",
        imports=[
            *_imports("description", used),
            *_imports("objects", ["Objects", "descriptions", *entries]),
        ],
        body="\n".join(lines),
    )


def _description(module: str, device: Device) -> str:
    info = device.info
    return call(
        f"{_OWN}DeviceDescription",
        name=string_literal(module),
        objects=call(f"{_OWN}descriptions", table_class(module)),
        pdos=items([pdo_text(pdo, device, prefix=_OWN) for pdo in device.pdos]),
        vendor_id=_hex(identity_of(device, 1)),
        product_code=_hex(identity_of(device, 2)),
        revision_number=_hex(identity_of(device, 3)),
        lss="True" if info.lss else "",
        granularity=(
            "" if info.granularity in (None, 8) else str(info.granularity or 0)
        ),
        dummies=items([f"0x{code:04X}" for code in device.dummies]),
        bit_rates=items(list(map(str, info.bit_rates if info.lss else ()))),
    )


def is_remapped(kind: DeviceKind) -> bool:
    """Whether the PDOs of the configured device differ from its default ones."""
    return configured(kind).pdos != as_delivered(kind.device).pdos


def _configuration(writes: Sequence[StartWrite]) -> Iterator[str]:
    if writes:
        yield ""
        yield fit(f"{CONFIGURATION} = {items([write_text(w, _OWN) for w in writes])}")
        yield '"""What a master writes to a node that is in no network."""'


def write_text(write: StartWrite, prefix: str = "") -> str:
    """Return a write as `Write(...)`; `prefix` is that of the imported name."""
    return call(
        f"{prefix}Write",
        f"0x{write.variable.index:04X}",
        str(write.variable.subindex),
        octets_literal(write.value),
        verify="" if write.verify else "False",
        relative="True" if write.relative else "",
    )


def _remapped(pdos: Sequence[Pdo], device: Device) -> Iterator[str]:
    if pdos:
        texts = [pdo_text(pdo, device, prefix=_OWN) for pdo in pdos]
        yield ""
        yield fit(f"{REMAPPED} = {items(texts)}")
        yield '"""The PDOs as the description, and the mappings of the kind, configure them."""'


def as_delivered(device: Device) -> Device:
    """The device before configuration; a device described by a DCF is configured already."""
    if device.commissioning is not None:
        return device
    objects = tuple(
        replace(o, variables=tuple(replace(v, value=None) for v in o.variables))
        for o in device.objects
    )
    plain = replace(device, objects=objects)
    return replace(plain, pdos=tuple(_default(pdo, plain) for pdo in device.pdos))


def _default(pdo: Pdo, device: Device) -> Pdo:
    """A PDO by the defaults of its objects."""

    def default(subindex: int) -> Value | None:
        variable = device.find(pdo.communication, subindex)
        return None if variable is None else variable.default

    def number(subindex: int) -> int | None:
        value = default(subindex)
        return value if isinstance(value, int) else None

    number_of_cob_id = pdo.communication, 1
    cob_id = cob_id_in_force(number_of_cob_id, default(1), device.node_id)
    assert isinstance(cob_id, int | NodeRelative)
    return replace(
        pdo,
        cob_id=cob_id,
        transmission_type=number(2),
        entries=pdo.default_entries,
        inhibit_time=number(3),
        event_timer=number(5),
        sync_start=number(6),
    )


def identity_of(device: Device, subindex: int) -> int | None:
    """A number of the identity: 1018h's, else (sub-indices 1 to 3) DeviceInfo's."""
    variable = device.find(_IDENTITY, subindex)
    current = None if variable is None else variable.current
    if isinstance(current, int) and current:
        return current
    info = device.info
    numbers = (info.vendor_number, info.product_number, info.revision_number)
    return numbers[subindex - 1] if subindex <= len(numbers) else None


def _hex(value: int | None) -> str:
    return f"0x{value:X}" if value else ""


def _entry(variable: Variable, device: Device) -> str:
    value = object_value(variable.data_type, variable.current)
    if not value and variable.index == _IDENTITY and variable.subindex:
        value = identity_of(device, variable.subindex) or value
    relative = isinstance(variable.current, NodeRelative)
    default = _default_text(variable, value, relative)
    return call(
        f"{_OWN}{_class(variable)}",
        string_literal(kind(variable.data_type)),
        number(variable.index, variable.subindex),
        string_literal(variable.access.value),
        *([default] if default else []),
        low=_limit(variable.low),
        high=_limit(variable.high),
        relative="True" if relative else "",
        mappable="True" if variable.pdo_mappable else "",
    )


def _default_text(
    variable: Variable, value: bool | int | float | str | bytes | None, relative: bool
) -> str:
    if value is None:
        return ""
    if isinstance(value, int) and value >= 0:
        wide = variable.data_type == DataType.UNSIGNED32 and value >= 0x1000
        if wide or relative:
            return f"0x{value:X}"
    return literal(value)


def _limit(value: int | float | NodeRelative | None) -> str:
    return "" if value is None or isinstance(value, NodeRelative) else literal(value)


def pdo_text(
    pdo: Pdo, device: Device, node_id: int | None = None, prefix: str = ""
) -> str:
    """A PDO as a `PdoDescription`; with a node-id, with the COB-ID of that node."""
    given = pdo.cob_id
    relative = isinstance(given, NodeRelative)
    cob_id = given.offset if isinstance(given, NodeRelative) else given
    if relative and node_id is not None:
        relative, cob_id = False, cob_id + node_id
    used = device.find(pdo.mapping, 0)
    transmission = pdo.transmission_type
    return call(
        f"{prefix}PdoDescription",
        string_literal(pdo.direction.value),
        str(pdo.number),
        _signed_hex(cob_id),
        str(relative),
        str(_EVENT_DRIVEN if transmission is None else transmission),
        items([f"(0x{e.index:04X}, {e.subindex}, {e.bits})" for e in pdo.entries]),
        inhibit_time=_number(pdo.inhibit_time),
        event_timer=_number(pdo.event_timer),
        sync_start=_number(pdo.sync_start),
        fixed="True" if used is None or not used.access.writable else "",
    )


def _signed_hex(value: int) -> str:
    return f"-0x{-value:X}" if value < 0 else f"0x{value:X}"


def _number(value: int | None) -> str:
    return str(value) if value else ""


def _class(variable: Variable) -> str:
    """The class of entries with its type."""
    return _CLASSES[python_type(variable.data_type)]


def _imports(module: str, names: Iterable[str]) -> Iterator[Import]:
    """Yield the imports of names of the runtime, under names that no definition has."""
    for name in names:
        yield Import(f"rtgen.runtime.canopen.{module}", name, f"{_OWN}{name}")


def _entries(device: Device, names: Mapping[tuple[int, int], str]) -> Iterator[str]:
    for variable in device.variables:
        name = names[variable.index, variable.subindex]
        yield fit(f"{name} = {_entry(variable, device)}", 4)
        shown, unit = line(variable.name), line(variable.unit)
        # In most cases the identifier is the name already.
        if unit or not shown.isascii() or not name.startswith(identifier(shown)):
            text = f"{named(variable.index, variable.subindex)} {shown}"
            yield docstring(f"{text} [{unit}]." if unit else f"{text}.", 4).rstrip("\n")
