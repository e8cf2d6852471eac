"""Reads a bus file into a network: schema, devices, values, links, then the checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule, Span, in_order
from rtgen.compiler.frontends import Dependency, eds, key_of
from rtgen.compiler.frontends.bus import rules
from rtgen.compiler.frontends.bus.checks import check
from rtgen.compiler.frontends.bus.schema import problems
from rtgen.compiler.frontends.bus.sync import sync_of, synchronised
from rtgen.compiler.frontends.bus.values import (
    NO_ENTRY,
    BadValueError,
    configured,
    is_entry,
    number_of,
)
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.rules.lexical import MISSING_FILE, UNREADABLE
from rtgen.compiler.frontends.kit import characters
from rtgen.compiler.frontends.kit.located_toml import Path as Place
from rtgen.compiler.frontends.kit.located_toml import Toml
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.kit.toml_text import TomlError
from rtgen.compiler.model.can_bus import Bus, BusNode, DeviceKind, PdoLink
from rtgen.compiler.model.canopen import (
    INVALID,
    NO_RTR,
    RPDO_COMMUNICATION,
    TPDO_COMMUNICATION,
    Device,
    PdoDirection,
    Value,
    resolved,
)
from rtgen.compiler.typemap.canopen.drive_units import (
    BY_DESCRIPTION,
    NoFactorError,
    drive_factor,
)
from rtgen.compiler.typemap.canopen.names import identifier, module_name
from rtgen.facts.canopen import can_id_of
from rtgen.facts.encodings import digest
from rtgen.facts.files import UnreadableError, read_file

MANAGER = 127
EVENT = 0.01

_NODE_SETTINGS = (
    *("heartbeat_timeout", "boot_timeout", "restarts", "mandatory", "start", "lss"),
    *("recoveries", "revision", "serial"),
)
_BOOT_TIME = (0x1F89, 0)
"""Boot time in ms (CiA 302-2)."""
_UNREAD = (MISSING_FILE.code, UNREADABLE.code)
_MAX_SECONDS = 3600.0
_MAX_BYTES = 1024 * 1024


@dataclass(frozen=True, slots=True)
class BusResult:
    """Result of `load`: no bus if there are errors; `sources` maps displayed path to text."""

    bus: Bus | None
    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[str, str]
    dependencies: tuple[Dependency, ...]


def load(path: Path, *, root: Path, encoding: str = "auto") -> BusResult:
    """Read a bus file and the device descriptions that it names.

    `root` is the project's folder, `encoding` that of files that do not tell theirs. All problems
    of the input are in the diagnostics.
    """
    return _Reader(path, root, encoding).run()


class _Reader:
    def __init__(self, path: Path, root: Path, encoding: str) -> None:
        self._path = path
        self._encoding = encoding
        self._root = root
        self._file = path.as_posix()
        self._findings = Findings()
        self._sources: dict[str, str] = {}
        self._dependencies: list[Dependency] = []
        self._sha256 = ""
        self._toml: Toml

    def run(self) -> BusResult:
        bus = self._bus() if self._open() else None
        return BusResult(
            None if self._findings.errors else bus,
            tuple(in_order(self._findings.diagnostics)),
            self._sources,
            tuple(self._dependencies),
        )

    def _report(self, rule: Rule, place: Place, message: str) -> None:
        self._findings.add(rule, self._toml.span(place), message)

    def _open(self) -> bool:
        start = Span(self._file, 1, 1, 1, 2)
        try:
            data = read_file(self._path, _MAX_BYTES)
        except UnreadableError as error:
            message = f"{self._file} cannot be read: {error}"
            self._findings.report(rules.BAD_FILE.at(start, message))
            self._dependencies.append(Dependency(self._path, None))
            return False
        self._dependencies.append(Dependency(self._path, sha256(data).hexdigest()))
        self._sha256 = digest(data)
        read = characters.read(data, self._file, self._encoding, standard="TOML")
        for doubt in read.problems:
            self._findings.report(doubt)
        text = self._sources[self._file] = read.text
        try:
            self._toml = Toml(text, self._file)
        except TomlError as error:
            self._findings.report(
                rules.BAD_FILE.at(error.span, str(error), hint=error.hint)
            )
            return False
        for place, problem in problems(self._toml.content):
            where = ".".join(map(str, place))
            self._report(rules.BAD_CONTENT, place, f"{where or 'the file'}: {problem}")
        return not self._findings.errors

    def _bus(self) -> Bus | None:
        content = self._toml.content
        declared = content["bus"]
        kinds = {
            name: kind
            for name in content["device"]
            if (kind := self._kind(name)) is not None
        }
        ids = {declared.get("manager", MANAGER): "the manager"}
        names: dict[str, str] = {}
        nodes = []
        for name, node in content["node"].items():
            same = names.setdefault(name.lower(), name)
            if same != name and declared.get("dcf", True):
                message = f"{name} and {same} differ in case only: so do their DCFs"
                self._report(rules.BAD_CONTENT, ("node", name), message)
            other = ids.setdefault(node["id"], name)
            if other != name:
                message = f"node-id {node['id']} is that of {other}"
                self._report(rules.SAME_ID, ("node", name, "id"), message)
            kind = kinds.get(node["device"])
            if node["device"] not in content["device"]:
                message = f"there is no [device.{node['device']}]"
                span = self._toml.span(("node", name, "device"))
                hint = guess(node["device"], content["device"])
                self._findings.report(rules.UNKNOWN_DEVICE.at(span, message, hint=hint))
            elif kind and (bus_node := self._node(name, kind)) is not None:
                nodes.append(bus_node)
        if self._findings.errors:
            return None
        links = self._links(nodes)
        nodes = self._linked(nodes, links)
        cob_id = sync_of(nodes)
        if declared.get("sync", 0.0):
            counter = declared.get("sync_counter", 0)
            report = self._findings.report
            nodes = [synchronised(n, cob_id, counter, report) for n in nodes]
        bus = Bus(
            name=declared.get("name", identifier(self._path.stem)),
            file=self._file,
            key=key_of(self._path, self._root),
            sha256=self._sha256,
            bit_rate=declared["bit_rate"],
            manager=declared.get("manager", MANAGER),
            sync=declared.get("sync", 0.0),
            heartbeat=declared.get("heartbeat", 0.0),
            event=declared.get("event", EVENT),
            kinds=tuple(kinds.values()),
            nodes=tuple(nodes),
            links=tuple(links),
            sync_counter=declared.get("sync_counter", 0),
            dcf=declared.get("dcf", True),
            sync_cob_id=cob_id,
        )
        for diagnostic in check(bus, self._toml):
            self._findings.report(diagnostic)
        return bus

    def _device(self, path: str, where: Place, node_id: int | None) -> Device | None:
        """Return the device of a description file, named relative to the bus file."""
        read = eds.load(
            [self._path.parent / path],
            root=self._root,
            node_id=node_id,
            encoding=self._encoding,
        )
        named = Related(self._toml.span(where), "named here")
        for d in read.diagnostics:
            unread = d.code in _UNREAD
            self._findings.report(replace(d, related=(named,)) if unread else d)
        self._sources |= read.sources
        self._dependencies += read.dependencies
        return read.model.devices[0] if read.model.devices else None

    def _kind(self, name: str) -> DeviceKind | None:
        declared = self._toml.content["device"][name]
        device = self._device(declared["eds"], ("device", name, "eds"), None)
        if device is None:
            return None
        described = device
        device, _ = self._written(device, ("device", name))
        kind = DeviceKind(
            described=described,
            name=name,
            module=declared.get("name", module_name(Path(declared["eds"]).stem)),
            path=declared["eds"],
            span=self._toml.span(("device", name)),
            device=device,
            ports=declared.get("ports", "pdo"),
            parameters=tuple(
                number_of(text) for text in declared.get("parameters", ())
            ),
            operations=tuple(
                number_of(text) for text in declared.get("operations", ())
            ),
            factors=self._factors(device, name),
            units=_by_number(declared.get("units", {})),
        )
        self._check_objects(kind)
        return kind

    def _factors(
        self, device: Device, name: str
    ) -> tuple[tuple[tuple[int, int], float], ...]:
        """Return the factors of a kind, including those computed by CiA 402."""
        declared = self._toml.content["device"][name]
        units = dict(_by_number(declared.get("units", {})))
        factors = {}
        for text, factor in declared.get("factors", {}).items():
            number, place = number_of(text), ("device", name, "factors", text)
            if factor != BY_DESCRIPTION:
                factors[number] = factor
                if not (isfinite(factor) and factor):
                    message = f"the factor of {text} is {factor}"
                    self._report(rules.BAD_CONTENT, place, message)
            elif device.find(*number) is not None:
                try:
                    factors[number] = drive_factor(
                        device, number, units.get(number, "")
                    )
                except NoFactorError as error:
                    self._report(rules.NO_FACTOR, place, f"{text}: {error}")
        return tuple(sorted(factors.items()))

    def _check_objects(self, kind: DeviceKind) -> None:
        """Check the objects in the settings of a kind: each exists, and is listed once."""
        place: Place = ("device", kind.name)
        named: list[tuple[tuple[int, int], Place]] = [
            (number, (*place, key))
            for key, numbers in (("factors", kind.factors), ("units", kind.units))
            for number, _ in numbers
        ]
        for _, unit in kind.units:
            if not is_entry(unit):
                self._report(rules.BAD_CONTENT, (*place, "units"), NO_ENTRY)
        for key, listed in (
            ("parameters", kind.parameters),
            ("operations", kind.operations),
        ):
            for position, number in enumerate(listed):
                named.append((number, (*place, key, position)))
                if number in listed[:position]:
                    message = f"{number[0]:04X}:{number[1]:X} is listed twice"
                    self._report(rules.BAD_CONTENT, (*place, key, position), message)
        for number, where in named:
            if kind.device.find(*number) is None:
                message = f"{kind.path} has no object {number[0]:04X}:{number[1]:X}"
                self._report(rules.BAD_VALUE, where, message)

    def _written(
        self, device: Device, place: Place
    ) -> tuple[Device, dict[tuple[int, int], Value]]:
        """Return the device with the values in a table, and these values."""
        table: Any = self._toml.content
        for key in place:
            table = table[key]
        values: dict[tuple[int, int], Value] = {}
        for key, value in table.get("values", {}).items():
            where = (*place, "values", key)
            try:
                span = self._toml.span(where)
                device, written = configured(device, number_of(key), value, span)
            except BadValueError as error:
                self._report(rules.BAD_VALUE, where, f"{key}: {error}")
            else:
                values[number_of(key)] = written
        return device, values

    def _node(self, name: str, kind: DeviceKind) -> BusNode | None:
        node = self._toml.content["node"][name]
        device = self._device(kind.path, ("device", kind.name, "eds"), node["id"])
        if device is None:
            return None
        device, common = self._written(device, ("device", kind.name))
        device, own = self._written(device, ("node", name))
        settings = {key: node[key] for key in _NODE_SETTINGS if key in node}
        common_stops = self._toml.content["device"][kind.name].get("emergency_stop", [])
        settings["emergency_stop"] = ",".join(node.get("emergency_stop", common_stops))
        if boot_time := device.number(*_BOOT_TIME):
            settings.setdefault("boot_timeout", min(boot_time / 1000, _MAX_SECONDS))
        return BusNode(
            name=name,
            id=node["id"],
            kind=kind,
            device=device,
            values=tuple(sorted((common | own).items())),
            span=self._toml.span(("node", name)),
            **settings,
        )

    def _links(self, nodes: list[BusNode]) -> list[PdoLink]:
        devices = {node.name: node.device for node in nodes}
        links: list[PdoLink] = []
        for number, entry in enumerate(self._toml.content.get("link", ())):
            source, target = _end(entry["from"]), _end(entry["to"])
            wrong = _wrong(source, target, devices, links)
            if wrong is not None:
                self._report(rules.BAD_LINK, ("link", number), wrong)
            else:
                links.append(PdoLink(source[::2], target[::2]))
        return links

    def _linked(self, nodes: list[BusNode], links: list[PdoLink]) -> list[BusNode]:
        """Return the nodes with the COB-IDs of their links: valid, and the TPDO's at both ends."""
        by_name = {node.name: node for node in nodes}
        for number, link in enumerate(links):
            place = self._toml.span(("link", number))
            name, tpdo = link.source
            sent = next(
                pdo
                for pdo in by_name[name].device.pdos
                if (pdo.direction, pdo.number) == (PdoDirection.TPDO, tpdo)
            )
            declared = resolved(sent.cob_id, by_name[name].id)
            assert isinstance(declared, int)
            if not can_id_of(declared):
                self._report(rules.BAD_LINK, ("link", number), "its TPDO has no COB-ID")
                continue
            for (end, pdo), base, cob_id in (
                (link.source, TPDO_COMMUNICATION, declared & ~INVALID),
                (link.target, RPDO_COMMUNICATION, declared & ~(INVALID | NO_RTR)),
            ):
                index = base + pdo - 1
                node = by_name[end]
                try:
                    device, value = configured(node.device, (index, 1), cob_id, place)
                except BadValueError as error:
                    self._report(rules.BAD_LINK, ("link", number), f"{end}: {error}")
                    continue
                values = dict(node.values) | {(index, 1): value}
                by_name[end] = replace(
                    node, device=device, values=tuple(sorted(values.items()))
                )
        return list(by_name.values())


def _by_number(table: Mapping[str, Any]) -> tuple[tuple[tuple[int, int], Any], ...]:
    return tuple(sorted((number_of(key), value) for key, value in table.items()))


def _end(text: str) -> tuple[str, str, int]:
    """Parse the end of a link into node, direction and number."""
    name, _, pdo = text.partition(".")
    return name, pdo[:4], int(pdo[4:])


def _wrong(
    source: tuple[str, str, int],
    target: tuple[str, str, int],
    devices: Mapping[str, Device],
    links: list[PdoLink],
) -> str | None:
    """Return the error in a link, or None."""
    if (source[1], target[1]) != ("tpdo", "rpdo"):
        return "a link goes from a TPDO to an RPDO"
    if source[0] == target[0]:
        return "a link goes to another node"
    octets = []
    for name, direction, number in (source, target):
        device = devices.get(name)
        if device is None:
            return f"there is no node {name!r}"
        pdos = {(p.direction.value, p.number): p for p in device.pdos}
        pdo = pdos.get((direction, number))
        if pdo is None:
            return f"{name} has no {direction}{number}"
        octets.append((pdo.bits + 7) // 8)
    if octets[0] != octets[1]:
        return f"the TPDO has {octets[0]} octets, the RPDO {octets[1]}"
    if any(link.target == target[::2] for link in links):
        return f"{target[0]}.{target[1]}{target[2]} has a link already"
    return None
