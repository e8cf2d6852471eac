"""CANopen devices as components: reads descriptions and bus files, and makes their IDL.

The IDL of a device is text that other definitions may include, and that the IDL front end reads,
so that every back end for IDL supports devices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.diagnostics import Diagnostic, in_order
from rtgen.frontends import Dependency, FrontendResult, together
from rtgen.frontends.kit.library import VirtualFile
from rtgen.model import Component, Model
from rtgen.resources import idl_file

if TYPE_CHECKING:
    from rtgen.model import Declaration
    from rtgen.model.can_bus import Bus
    from rtgen.project import Project
    from rtgen.typemap.canopen_ports import DevicePorts

_SHARED = ("BasicDataType.idl", "Canopen.idl")
"""The files that the IDL of devices includes; a project may replace the first."""

_MANAGER = "CanopenManager.idl"


def read(
    descriptions: Sequence[Path], buses: Sequence[Path], project: Project
) -> FrontendResult:
    """Read the devices of descriptions, and the networks of bus files."""
    results = []
    if descriptions:
        from rtgen.frontends import eds

        results.append(
            eds.load(descriptions, root=project.root, node_id=project.node_id)
        )
    if buses:
        from rtgen.frontends import bus

        for path in buses:
            found = bus.load(path, root=project.root)
            model = Model(buses=() if found.bus is None else (found.bus,))
            results.append(
                FrontendResult(
                    model, found.diagnostics, found.sources, found.dependencies
                )
            )
    result = together(results)
    # The diagnostics of a description that several bus files name are reported once.
    unique = tuple(in_order(dict.fromkeys(result.diagnostics)))
    return replace(result, diagnostics=unique)


@dataclass(frozen=True, slots=True)
class DeviceIdl:
    """The IDL of devices: files for includes, and the components to add to their model."""

    files: dict[str, VirtualFile | Path]
    diagnostics: tuple[Diagnostic, ...]
    dependencies: tuple[Dependency, ...]
    _components: tuple[Component, ...]
    _hashes: dict[str, str]
    _buses: tuple[Bus, ...]

    def complete(self, model: Model) -> Model:
        """The model with the components of the devices that were `given`.

        The hashes of the IDL files are those of the descriptions.
        """
        files = tuple(
            replace(file, sha256=self._hashes.get(file.name, file.sha256))
            for file in model.files
        )
        return replace(
            model,
            files=files,
            declarations=(*map(self._with_base, model.declarations), *self._components),
        )

    def _with_base(self, declaration: Declaration) -> Declaration:
        if not isinstance(declaration, Component) or declaration.file != _MANAGER:
            return declaration
        from rtgen.lowering.canopen.components import manager

        return manager(declaration, self._buses)


def device_idl(
    result: FrontendResult, definitions: Sequence[Path], *, given: bool
) -> DeviceIdl:
    """The IDL of the result of `read`.

    `definitions` are the project's IDL files. With `given` the devices are part of the project;
    without, their IDL is only available for includes.
    """
    from rtgen.backends.canopen.idl_file import idl_of
    from rtgen.lowering.canopen.components import device_components
    from rtgen.lowering.canopen.kinds import check, file_name, kinds_of
    from rtgen.typemap.canopen_ports import DevicePorts

    model = result.model
    kinds, findings = kinds_of(model.devices, model.buses)
    devices = [DevicePorts(kind.device, kind) for kind in kinds]
    files: dict[str, VirtualFile | Path] = {}
    hashes: dict[str, str] = {}
    components: list[Component] = []
    for ports in devices:
        name = file_name(ports)
        files[name] = VirtualFile(ports.device.key, idl_of(ports), given)
        hashes[name] = ports.device.sha256
        if given:
            findings += check(ports)
            components += device_components(ports, _networks(ports, model.buses))
    dependencies = []
    shared = [*_SHARED, *([_MANAGER] if model.buses and given else [])]
    for name in shared if kinds else ():
        own = next((p for p in definitions if p.name == name), None)
        if own is not None:
            files[name] = own
            continue
        path = idl_file(name)
        data = path.read_bytes()
        dependencies.append(Dependency(path, sha256(data).hexdigest()))
        key = f"rtgen/idl/{name}"
        files[name] = VirtualFile(key, data.decode(), given and name == _MANAGER)
    return DeviceIdl(
        files,
        tuple(findings),
        tuple(dependencies),
        tuple(components),
        hashes,
        model.buses,
    )


def _networks(ports: DevicePorts, buses: Sequence[Bus]) -> dict[str, int]:
    """The networks that a kind of device is in, each with the node-id of the first one there."""
    found: dict[str, int] = {}
    for bus in buses:
        for node in bus.nodes:
            if node.kind.module == ports.kind.module:
                found.setdefault(bus.name, node.id)
    return found
