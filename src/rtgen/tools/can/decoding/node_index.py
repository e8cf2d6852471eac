"""Index of the nodes and objects on a bus, from a bus file or from descriptions of devices."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity, has_errors
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import Access, Device, Value, resolved
from rtgen.compiler.project import is_other_kind
from rtgen.compiler.typemap.canopen.names import field_names
from rtgen.compiler.typemap.canopen.values import kind
from rtgen.facts.device_files import DEVICE_SUFFIXES, is_device_file
from rtgen.runtime.canopen.description import Kind
from rtgen.tools.can.decoding.drive_text import PROFILE, drive_words, value_names
from rtgen.tools.can.project_bus import require_bus_file
from rtgen.tools.kit.exits import Refusal

Number = tuple[int, int]
"""Index and sub-index of an object."""

MANAGER = 127
"""Default node-id of the manager, if no bus file sets it."""


class NoNodeIdError(Refusal):
    """Neither a description nor the caller states the node-id of a node."""


@dataclass(frozen=True, slots=True)
class DescribedObject:
    """An object of a node.

    Physical value = `factor` * value; `factor` is None if the description has none. `words`
    formats values that are more than a number, such as a statusword; `value_names` names
    frequent values.
    """

    number: Number
    name: str
    kind: Kind
    access: Access
    unit: str = ""
    factor: float | None = None
    low: int | float | None = None
    high: int | float | None = None
    words: Callable[[int], str] | None = None
    value_names: Mapping[int, str] = field(default_factory=dict, repr=False)

    def __str__(self) -> str:
        return f"{written(self.number)} {self.name}".rstrip()


@dataclass(frozen=True, kw_only=True)
class DescribedNode:
    """A node: its id, display name, description, and objects by number."""

    id: int
    name: str
    device: Device
    objects: Mapping[Number, DescribedObject] = field(repr=False)

    @cached_property
    def by_name(self) -> dict[str, DescribedObject]:
        """The objects by identifier, in lower case."""
        return {thing.name.lower(): thing for thing in self.objects.values()}

    def object(self, text: str) -> DescribedObject:
        """Find an object by name, or by a number such as `6401:1`. Raises Refusal."""
        named = self.by_name.get(text.lower())
        if named is not None:
            return named
        number = number_of(text)
        if number is not None and number in self.objects:
            return self.objects[number]
        if number is not None and number[1] == 0 and ":" not in text:
            subs = sorted(n for n in self.objects if n[0] == number[0])
            if subs:
                numbers = ", ".join(written(n) for n in subs[:4])
                raise Refusal(f"{self.name} has {numbers}, but no {text}")
        close = get_close_matches(text.lower(), self.by_name, n=1)
        hint = f"; did you mean {self.by_name[close[0]].name}?" if close else ""
        raise Refusal(f"{self.name} has no object {text!r}{hint}")

    @property
    def identity(self) -> tuple[int | None, ...]:
        """Device type, vendor, product and revision, as described (1000h, 1018h)."""
        numbers = ((0x1000, 0), (0x1018, 1), (0x1018, 2), (0x1018, 3))
        variables = (self.device.find(*number) for number in numbers)
        values = (None if v is None else v.current for v in variables)
        return tuple(value if isinstance(value, int) else None for value in values)

    @property
    def parameters(self) -> dict[Number, int]:
        """The integers in the communication profile area (1000h to 1FFFh), as configured.

        COB-IDs are those in force.
        """
        values = {}
        for variable in self.device.variables:
            value = resolved(variable.in_force(self.id), self.id)
            if 0x1000 <= variable.index < 0x2000 and isinstance(value, int):
                values[variable.index, variable.subindex] = value
        return values


@dataclass(frozen=True, kw_only=True)
class NodeIndex:
    """The nodes by id, with the bus file if there is one."""

    nodes: Mapping[int, DescribedNode]
    bus: Bus | None = None

    @property
    def manager(self) -> int:
        """The node-id of the manager."""
        return self.bus.manager if self.bus else MANAGER

    def name(self, node_id: int) -> str:
        """Return the display name of a node."""
        node = self.nodes.get(node_id)
        if node is not None:
            return node.name
        return "manager" if self.bus and node_id == self.manager else f"node {node_id}"

    def node(self, text: str) -> int:
        """Find a node-id by name or number. Raises Refusal."""
        for node in self.nodes.values():
            if text == node.name:
                return node.id
        try:
            node_id = int(text, 0)
        except ValueError:
            names = [node.name for node in self.nodes.values()]
            close = get_close_matches(text, names, n=1)
            advice = (
                f"known: {', '.join(names)}" if names else "give its node-id, or --bus"
            )
            hint = f"did you mean {close[0]}?" if close else advice
            raise Refusal(f"there is no node {text!r}; {hint}") from None
        if not 1 <= node_id <= 127:
            raise Refusal(f"node-id {node_id}: it is 1 to 127")
        return node_id

    def find(self, text: str) -> list[tuple[DescribedNode, DescribedObject]]:
        """Find the objects that `NODE.OBJECT` names, or `OBJECT` in all nodes that have it.

        Raises Refusal if there is none.
        """
        name, dot, thing = text.partition(".")
        if dot:
            node = self.nodes.get(self.node(name))
            if node is None:
                raise Refusal(f"nothing is known of the objects of {name}")
            return [(node, node.object(thing))]
        objects = []
        missing = Refusal(f"no node is known that has {text!r}: give --bus or --eds")
        for node in self.nodes.values():
            try:
                objects.append((node, node.object(text)))
            except Refusal as error:
                missing = error
        if not objects:
            raise missing
        return objects


def number_of(text: str) -> Number | None:
    """Parse `6401:1`, `0x6401:01` or `1000` into index and sub-index; None for any other text."""
    index, _, subindex = text.lower().removeprefix("0x").partition(":")
    try:
        number = int(index, 16), int(subindex or "0", 16)
    except ValueError:
        return None
    return number if 0 <= number[0] <= 0xFFFF and 0 <= number[1] <= 0xFF else None


def written(number: Number) -> str:
    """Format index and sub-index as `6401:1`."""
    return f"{number[0]:04X}:{number[1]:X}"


def read_node_index(
    bus_file: Path | None, descriptions: Sequence[tuple[int | None, Path]]
) -> NodeIndex:
    """Read a bus file and descriptions of single nodes. Raises InputError with their errors.

    A description without a node-id must be a DCF that contains one. Descriptions take precedence
    over the bus file.
    """
    findings: list[Diagnostic] = []
    nodes: dict[int, DescribedNode] = {}
    bus = None
    _check_kinds(bus_file, descriptions)
    if bus_file is not None:
        from rtgen.compiler.frontends import bus as front_end

        result = front_end.load(bus_file, root=Path.cwd())
        findings += result.diagnostics
        bus = result.bus
        if bus is not None:
            nodes.update(bus_index(bus).nodes)
    described = []
    for node_id, path in descriptions:
        device, diagnostics = _described(node_id, path)
        findings += diagnostics
        if device is not None:
            described.append(device)
    if has_errors(findings):
        raise InputError(d for d in findings if d.severity is Severity.ERROR)
    _check_ids(described)
    for node_id, name, device in _named(described):
        nodes[node_id] = describe_node(node_id, name, device)
    return NodeIndex(nodes=dict(sorted(nodes.items())), bus=bus)


def bus_index(bus: Bus) -> NodeIndex:
    """Index the nodes of a bus."""
    nodes = (
        describe_node(
            node.id,
            node.name,
            node.device,
            units=dict(node.kind.units),
            factors=dict(node.kind.factors),
        )
        for node in bus.nodes
    )
    return NodeIndex(nodes={node.id: node for node in nodes}, bus=bus)


def _check_kinds(
    bus_file: Path | None, descriptions: Sequence[tuple[int | None, Path]]
) -> None:
    """Raise Refusal for files of other kinds, as when a bus file and a description are swapped."""
    if bus_file is not None and is_device_file(bus_file):
        raise Refusal(f"--bus {bus_file}: that describes one node: --eds NODE-ID=FILE")
    if bus_file is not None:
        require_bus_file(bus_file)
    for _, path in descriptions:
        if path.suffix.lower() == ".toml":
            raise Refusal(f"--eds {path}: that looks like a bus file: --bus FILE")
        if is_other_kind(path, DEVICE_SUFFIXES):
            raise Refusal(f"{path} is not a description of a device")


def _check_ids(devices: Iterable[Device]) -> None:
    """Raise Refusal if two descriptions are of one node."""
    files: dict[int | None, str] = {}
    for device in devices:
        other = files.setdefault(device.node_id, device.file)
        if other != device.file:
            raise Refusal(
                f"--eds {device.file}: node-id {device.node_id} is that of {other}"
            )


def describe_node(
    node_id: int,
    name: str,
    device: Device,
    *,
    units: Mapping[Number, str] | None = None,
    factors: Mapping[Number, float] | None = None,
) -> DescribedNode:
    """Index a device with its node-id; `units` and `factors` override those of the description."""
    names = field_names(device.variables)
    units, factors = units or {}, factors or {}
    objects = {}
    is_drive = _profile(device) == PROFILE
    for v in device.variables:
        number = v.index, v.subindex
        objects[number] = DescribedObject(
            number=number,
            name=names[number],
            kind="octets" if v.domain else kind(v.data_type),
            access=v.access,
            unit=units.get(number, v.unit),
            factor=factors.get(number, v.factor),
            low=_limit(v.low, node_id),
            high=_limit(v.high, node_id),
            words=drive_words(v.index) if is_drive and not v.subindex else None,
            value_names=value_names(v.index) if is_drive and not v.subindex else {},
        )
    return DescribedNode(id=node_id, name=name, device=device, objects=objects)


def _profile(device: Device) -> int:
    """Return the device profile number in the device type (1000h), 0 without one."""
    kind = device.find(0x1000)
    current = None if kind is None else kind.current
    return current & 0xFFFF if isinstance(current, int) else 0


def _limit(value: Value | None, node_id: int) -> int | float | None:
    limit = resolved(value, node_id)
    return limit if isinstance(limit, (int, float)) else None


def _described(
    node_id: int | None, path: Path
) -> tuple[Device | None, tuple[Diagnostic, ...]]:
    from rtgen.compiler.frontends import eds

    result = eds.load([path], root=Path.cwd(), node_id=node_id)
    device = result.model.devices[0] if result.model.devices else None
    if device is not None and device.node_id is None:
        raise NoNodeIdError(f"--eds {path}: whose is it? Write --eds NODE-ID={path}")
    return device, result.diagnostics


def _named(devices: Iterable[Device]) -> Iterable[tuple[int, str, Device]]:
    """Yield devices with ids and names; the id is appended to a name that is not unique."""
    described = []
    for device in devices:
        assert device.node_id is not None
        name = device.commissioning.node_name if device.commissioning else ""
        described.append((device.node_id, name or Path(device.file).stem, device))
    counts = Counter(name for _, name, _ in described)
    for node_id, name, device in described:
        yield node_id, name if counts[name] == 1 else f"{name}_{node_id}", device
