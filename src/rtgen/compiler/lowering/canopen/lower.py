"""Lowers CANopen devices: types of their ports, proxies and devices as components, the manager.

The declarations of a device are those of an IDL file of its name. Where a definition has included
that file, it has been read from the text that `backends.canopen.idl_file` prints; what the
lowering makes takes its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.lowering.canopen.components import device_components, manager
from rtgen.compiler.lowering.canopen.kinds import (
    OBJECT_DICTIONARY,
    check,
    file_name,
    kinds_of,
    package_of,
)
from rtgen.compiler.lowering.canopen.rules import MISSING_TYPE, TAKEN_NAME
from rtgen.compiler.lowering.canopen.types import TIME, declarations
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import (
    Component,
    Declaration,
    Enum,
    Interface,
    Model,
    NamedType,
    ScopedName,
    SourceFile,
    Struct,
)
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.typemap.canopen.names import TABLES, table_class
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.compiler.typemap.python.idl_names import COMPANIONS
from rtgen.compiler.typemap.python.implementation_modules import referred

MANAGER = "CanopenManager"


def lower(model: Model, settings: Settings) -> Lowered:
    """The model with the types and components of its devices."""
    kinds, findings = kinds_of(model.devices, model.buses)
    declared = _Made(model, findings)
    for kind in kinds:
        declared.add(DevicePorts(kind.device, kind))
    return Lowered(declared.whole(), tuple(findings))


@dataclass
class _Made:
    model: Model
    findings: list[Diagnostic]
    files: dict[str, SourceFile] = field(default_factory=dict)
    types: dict[ScopedName, Declaration] = field(default_factory=dict)
    components: list[Component] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._by_name = {d.name: d for d in self.model.declarations}

    def add(self, ports: DevicePorts) -> None:
        """Add the declarations of a device."""
        file = file_name(ports)
        networks = _networks(ports, self.model.buses)
        types = {each.name: each for each in declarations(ports)}
        components = [*device_components(ports, networks)]
        for each in (*types.values(), *components):
            other = self._by_name.get(each.name)
            if other is None or other.file == file:
                continue
            if not _same(each, other):
                self._report_taken(each, other)
            types.pop(each.name, None)
        self.findings += check(ports)
        self.findings += self._missing(ports, [*types.values(), *components])
        self.types |= types
        self.components += components
        self.files[file] = SourceFile(
            name=file,
            key=ports.device.key,
            sha256=ports.device.sha256,
            main=True,
            includes=tuple(self._included()),
            module=package_of(ports.kind),
            taken=frozenset(self._beside(ports)),
        )

    def _beside(self, ports: DevicePorts) -> Iterator[str]:
        """Yield the names that definitions of the project declare in the module of a device.

        Reports those that the package reserves for the device.
        """
        module = ports.kind.module
        of_device = {*TABLES, table_class(module)}
        for declaration in self.model.declarations:
            scope, name = declaration.name[:-1], declaration.name[-1]
            if scope != (module,) or declaration.file == file_name(ports):
                continue
            if name in of_device:
                message = f"{declaration.scoped} has the name of a table of the device"
                hint = "rename it, or give the device another `name` in a bus file"
                self.findings.append(
                    TAKEN_NAME.at(declaration.span, message, hint=hint)
                )
            yield from (name, *(f"{name}{suffix}" for suffix in COMPANIONS))
            if isinstance(declaration, Enum):
                yield from (member.name for member in declaration.members)

    def whole(self) -> Model:
        """The model with everything that was added."""
        included = {file.name for file in self.model.files} & self.files.keys()
        declarations = [self._replaced(d) for d in self.model.declarations]
        added = [d for d in self.types.values() if d.file not in included]
        return replace(
            self.model,
            files=(
                *(self.files.get(file.name, file) for file in self.model.files),
                *(f for name, f in self.files.items() if name not in included),
            ),
            declarations=(*declarations, *added, *self.components),
        )

    def _replaced(self, declaration: Declaration) -> Declaration:
        if declaration.name == (MANAGER,) and isinstance(declaration, Component):
            return manager(declaration, self.model.buses)
        if declaration.file in self.files:
            return self.types.get(declaration.name, declaration)
        return declaration

    def _included(self) -> Iterator[str]:
        """The displayed paths of the files that the IDL of a device includes."""
        for name in (TIME.name, OBJECT_DICTIONARY):
            if name in self._by_name:
                yield self._by_name[name].file

    def _missing(
        self, ports: DevicePorts, declarations: Sequence[Declaration]
    ) -> Iterator[Diagnostic]:
        """Report types of ports and members that no definition declares."""
        own = {declaration.name for declaration in declarations}
        for declaration in declarations:
            for name in dict.fromkeys(_referred(declaration)):
                if name not in self._by_name and name not in own:
                    text = "::".join(name)
                    message = f"{declaration.scoped} needs the type {text}"
                    hint = f"declare it in the {name[0]} module of your own IDL file"
                    yield MISSING_TYPE.at(ports.kind.span, message, hint=hint)

    def _report_taken(self, declaration: Declaration, other: Declaration) -> None:
        message = f"{declaration.scoped} of the device is declared elsewhere, too"
        related = [Related(other.span, "the other declaration")]
        hint = "rename one, or give the device another `name` in a bus file"
        self.findings.append(
            TAKEN_NAME.at(declaration.span, message, related=related, hint=hint)
        )


def _referred(declaration: Declaration) -> Iterator[ScopedName]:
    """The named types that a declaration uses."""
    if isinstance(declaration, Component):
        for port in declaration.ports:
            if isinstance(port.type, NamedType):
                yield port.type.name
    else:
        yield from referred(declaration)


def _same(declaration: Declaration, other: Declaration) -> bool:
    """Whether both are the same type, read from a copy of the device's IDL file."""
    if isinstance(declaration, Struct) and isinstance(other, Struct):
        return [(m.name, m.type) for m in declaration.members] == [
            (m.name, m.type) for m in other.members
        ]
    if isinstance(declaration, Interface) and isinstance(other, Interface):
        return declaration.bases == other.bases and [
            (o.name, o.returns, [(p.name, p.type) for p in o.parameters])
            for o in declaration.operations
        ] == [
            (o.name, o.returns, [(p.name, p.type) for p in o.parameters])
            for o in other.operations
        ]
    return False


def _networks(ports: DevicePorts, buses: Sequence[Bus]) -> dict[str, int]:
    """The networks that a kind of device is in, each with the node-id of the first one there."""
    networks: dict[str, int] = {}
    for bus in buses:
        for node in bus.nodes:
            if node.kind.module == ports.kind.module:
                networks.setdefault(bus.name, node.id)
    return networks
