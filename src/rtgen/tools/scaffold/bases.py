"""A mobile base for ROS 2 as a project: two CANopen drives, velocities in, odometry out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

import msgspec

from rtgen.compiler import compilation
from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.diagnostics import Diagnostic, InputError, Span, has_errors
from rtgen.compiler.frontends import eds
from rtgen.compiler.model import (
    Activation,
    Component,
    Connection,
    Model,
    NamedType,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.can_bus import BusNode
from rtgen.compiler.model.canopen import Device, PdoDirection
from rtgen.compiler.project import FILE_NAME, OUTPUT, Project, load
from rtgen.compiler.typemap.canopen.names import field_names
from rtgen.compiler.typemap.canopen.names import module_name as device_module
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts.canopen import TPDO_COMMUNICATION
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.files import read_start, write_atomically
from rtgen.tools.scaffold import writing
from rtgen.tools.scaffold.names import Names, project_names
from rtgen.tools.scaffold.rules import NO_DRIVE
from rtgen.tools.scaffold.starters import (
    README,
    File,
    base_values,
    files_of,
    new_place,
    readme,
)

_NO_SPAN: Final = Span("", 1, 1, 1, 1)
SIDES: Final = ("left", "right")
_TX, _RX = PdoDirection.TPDO, PdoDirection.RPDO
_OBJECTS: Final = {
    "statusword": ((0x6041, 0), _TX),
    "position": ((0x6064, 0), _TX),
    "controlword": ((0x6040, 0), _RX),
    "mode": ((0x6060, 0), _RX),
    "target": ((0x60FF, 0), _RX),
}
"""What the base needs of a drive (CiA 402): the object, and the direction of its PDO."""
_MOST_OCTETS: Final = 16 << 20


class _Kind(msgspec.Struct, frozen=True):
    """A kind of drive: `file` is the stem of its copy, `data` its description."""

    name: str
    file: str
    suffix: str
    data: bytes
    device: Device


def create(
    name: str,
    paths: Sequence[Path],
    generate: Callable[[Project], None],
    *,
    stamped: bool,
) -> Path:
    """Create the folder of a base; return it. `generate` writes the generated files.

    `paths` are the descriptions of the left and the right drive, one of both, or the CDL file of a
    board. `stamped`: the velocity is a TwistStamped. Raises InputError, ToolError.
    """
    if paths[0].suffix.lower() in CDL_SUFFIXES:
        from rtgen.tools.scaffold import board_bases

        return board_bases.create(name, paths[0], generate, stamped=stamped)
    package, forms = project_names(name)
    target = Path(name)
    with writing.new_folder(target) as folder:
        files, kinds = _first_files(forms, package, folder, paths, stamped)
        settings = _settings(forms, package, folder, complete=False)
        writing.write([*files, settings])
        for kind in kinds:
            copy = folder / "definitions" / f"{kind.file}{kind.suffix}"
            write_atomically(copy, kind.data)
        (folder / "systems").mkdir()
        writing.write(_parts(forms, load(folder), kinds, stamped))
        writing.write(_systems(forms, load(folder)))
        settings.path.unlink()
        writing.write([_settings(forms, package, folder, complete=True)])
        generate(load(folder))
    return target


def _first_files(
    name: Names, package: str, root: Path, paths: Sequence[Path], stamped: bool
) -> tuple[list[File], list[_Kind]]:
    """Return the files that do not depend on the ports of the drives. Raises InputError."""
    kinds = _kinds(paths)
    place = new_place(package, root)
    values = base_values(name, place, stamped)
    sides = [
        {"name": side, "kind": kinds[min(n, len(kinds) - 1)].name, "id": n + 1}
        for n, side in enumerate(SIDES)
    ]
    attributes = {
        root / "pyproject.toml": "pyproject.toml",
        root / ".gitignore": "gitignore.txt",
        root / ".gitattributes": "gitattributes.txt",
    }
    files = files_of("project", attributes, generated=OUTPUT, **values)
    files += files_of(
        "base",
        {
            root / README: readme(),
            place.definitions / f"{name.module}_bus.toml": "bus.toml",
            place.skeletons / "kinematics.py": "kinematics.py",
        },
        kinds=[
            {
                "name": kind.name,
                "file": f"{kind.file}{kind.suffix}",
                "synchronous": [*_synchronous(kind.device)],
            }
            for kind in kinds
        ],
        sides=sides,
        **values,
    )
    return files, kinds


def _settings(name: Names, package: str, root: Path, *, complete: bool) -> File:
    """Return rtgen.toml; `complete`: with the system, which is there."""
    values = base_values(name, new_place(package, root), True)
    [file] = files_of(
        "base", {root / FILE_NAME: "rtgen.toml"}, complete=complete, **values
    )
    return file


def _parts(
    name: Names, project: Project, kinds: Sequence[_Kind], stamped: bool
) -> list[File]:
    """Return the files of a base that depend on the ports of its drives."""
    place = new_place(project.package, project.root)
    read = compilation.read(project, lowered=True)
    if has_errors(read.diagnostics):
        raise InputError(read.diagnostics)
    nodes = read.model.buses[0].nodes
    values = base_values(name, place, stamped)
    ports = [port for node in nodes for port in _ports(node, read.model)]
    files = files_of(
        "base",
        {
            place.definitions / f"{name.module}_base.idl": "base.idl",
            place.behaviour_file(f"{name.module}_base"): "base.py",
            place.skeletons / "drives.py": "drives.py",
            place.root / "tests" / f"test_{name.module}_base.py": "test.py",
        },
        ports=ports,
        behaviour_module=place.behaviour_module(f"{name.module}_base"),
        **values,
    )
    for kind in kinds:
        names = field_names(kind.device.variables)
        device = device_module(kind.file)
        module = module_name(device)
        files += files_of(
            "base",
            {place.behaviour_file(f"{module}_device"): "device.py"},
            device=device,
            device_module=module,
            **{role: names[number] for role, (number, _) in _OBJECTS.items()},
            **values,
        )
    return files


def _systems(name: Names, project: Project) -> list[File]:
    """Return the systems of a base, whose definitions are complete: the robot, its simulation."""
    read = compilation.read(project, lowered=True)
    if has_errors(read.diagnostics):
        raise InputError(read.diagnostics)
    folder = project.root / "systems"
    model = read.model
    return [
        File(folder / f"{name.module}.xml", system_text(_system(name, model, False))),
        File(folder / "simulation.xml", system_text(_system(name, model, True))),
    ]


def _kinds(paths: Sequence[Path]) -> list[_Kind]:
    """Return the kinds of drives of descriptions, those of equal ones once. Raises InputError."""
    kinds: list[_Kind] = []
    findings: list[Diagnostic] = []
    for path, side in zip(paths, SIDES, strict=False):
        read = eds.load([path], root=path.parent)
        findings += [d for d in read.diagnostics if has_errors([d])]
        if has_errors(read.diagnostics):
            continue
        data = read_start(path, _MOST_OCTETS)
        if any(kind.data == data for kind in kinds):
            continue
        [device] = read.model.devices
        findings += _lacking(device)
        stem = module_name(device_module(path.stem))
        if any(kind.file == stem for kind in kinds):
            stem = f"{stem}_{side}"
        name = side if len(paths) > 1 else "drive"
        kinds.append(_Kind(name, stem, path.suffix.lower(), data, device))
    if findings:
        raise InputError(findings)
    if len(kinds) == 1:
        kinds = [msgspec.structs.replace(kinds[0], name="drive")]
    return kinds


def _synchronous(device: Device) -> Iterator[str]:
    """Yield the indices of TPDOs that have to be sent with each SYNC, and do not do so yet."""
    wanted = [number for number, direction in _OBJECTS.values() if direction is _TX]
    for sample in DevicePorts(device).of(_TX):
        mapped = {f.variable.number for f in sample.fields}
        index = TPDO_COMMUNICATION + sample.pdo.number - 1
        variable = device.find(index, 2)
        if (
            not mapped.isdisjoint(wanted)
            and variable is not None
            and variable.access.writable
            and variable.current != 1
        ):
            yield f"{index:04X}"


def _lacking(device: Device) -> Iterator[Diagnostic]:
    """Yield the objects that a drive does not map to PDOs."""
    ports = DevicePorts(device)
    mapped = {
        (f.variable.number, s.pdo.direction) for s in ports.samples for f in s.fields
    }
    for role, (number, direction) in _OBJECTS.items():
        if (number, direction) in mapped:
            continue
        variable = device.find(*number)
        shown = f"{number[0]:04X}h"
        message = f"no {direction.upper()} maps the {role}, {shown}: the base needs it"
        hint = "map it in the description, as a drive of CiA 402 does by default"
        span = device.span if variable is None else variable.span
        yield NO_DRIVE.at(span, message, hint=hint)


def _ports(node: BusNode, model: Model) -> Iterator[dict[str, str]]:
    """Yield the ports of the base for a drive."""
    for role, port in _of_proxy(node).items():
        proxy = model.find((f"{node.kind.module}Proxy",))
        assert isinstance(proxy, Component)
        declared = next(p for p in proxy.ports if p.name == port)
        sent = _OBJECTS[role][1] is _TX
        yield {
            "word": "consumes" if sent else "publishes",
            "type": str(declared.type),
            "name": f"{node.name}_{role}",
        }


def _of_proxy(node: BusNode) -> dict[str, str]:
    """Return the ports of a drive's proxy by their roles."""
    ports = DevicePorts(node.kind.device, node.kind)
    by_object = {
        (p.quantity.variable.number, p.direction): p.name for p in ports.object_ports
    }
    return {role: by_object[wanted] for role, wanted in _OBJECTS.items()}


def _system(name: Names, model: Model, simulated: bool) -> System:
    """Return the system of the robot, or that with simulated drives."""
    bus = model.buses[0]
    components = {d.name[-1]: d for d in model.declarations if isinstance(d, Component)}
    network = ("network", bus.name)
    interface = () if simulated else (("interface", "socketcan"),)
    placed: list[SystemComponent] = []

    def add(instance: str, type_: str, *settings: tuple[str, str]) -> None:
        component = components[type_]
        placed.append(
            SystemComponent(
                instance=instance,
                type=type_,
                id=component.profile_id,
                path_uri=f"localhost/{instance}.rtc",
                span=_NO_SPAN,
                rate=component.rate,
                configuration=(("default", settings),) if settings else (),
            )
        )

    for node in bus.nodes if simulated else ():
        settings = (("node_id", str(node.id)), network)
        instance = f"{node.name.capitalize()}Drive0"
        add(instance, f"{node.kind.module}Device", *settings)
    add("Manager0", "CanopenManager", network, *interface)
    for node in bus.nodes:
        settings = (("node_id", str(node.id)), network, *interface)
        add(f"{node.name.capitalize()}0", f"{node.kind.module}Proxy", *settings)
    add("Base0", f"{name.type}Base")
    title = name.module if not simulated else "simulation"
    return System(
        name=title,
        id=f"RTSystem:rtgen:{title}:1.0.0",
        file="",
        abstract=f"The base {name.type}{' with simulated drives' if simulated else ''}",
        components=tuple(placed),
        connections=tuple(_connections(model, bus.nodes, components)),
        activation=tuple(
            Activation(instance=each.instance, sequence=number)
            for number, each in enumerate(placed, 1)
        ),
    )


def _connections(
    model: Model, nodes: Sequence[BusNode], components: dict[str, Component]
) -> Iterator[Connection]:
    for node in nodes:
        proxy = components[f"{node.kind.module}Proxy"]
        types = {port.name: model.unalias(port.type) for port in proxy.ports}
        for role, port in _of_proxy(node).items():
            ends = [
                PortReference(instance=f"{node.name.capitalize()}0", port=port),
                PortReference(instance="Base0", port=f"{node.name}_{role}"),
            ]
            source, target = ends if _OBJECTS[role][1] is _TX else ends[::-1]
            type_ = types[port]
            assert isinstance(type_, NamedType)
            declared = model.find(type_.name).repository_id
            yield Connection(
                name=f"{source}_{target}",
                source=source,
                target=target,
                service=False,
                span=_NO_SPAN,
                properties=(("dataport.data_type", declared),),
            )
