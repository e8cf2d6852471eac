"""A mobile base for ROS 2 whose wheels are driven by the functions of a TECS board."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from typing import Final

from msgspec.structs import replace

from rtgen.compiler import compilation
from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.diagnostics import InputError, Span, has_errors
from rtgen.compiler.lowering.tecs.boards import boards
from rtgen.compiler.lowering.tecs.rtc_components import MARSHALLER, consumer_name
from rtgen.compiler.model import (
    Activation,
    Connection,
    Model,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.project import OUTPUT, Project, load
from rtgen.facts import opaque_rpc as facts
from rtgen.facts.connector_properties import OWN_PORT
from rtgen.facts.files import read_start, write_atomically
from rtgen.tools.scaffold import writing
from rtgen.tools.scaffold.board_drives import BoardDrive, drive_of
from rtgen.tools.scaffold.names import Names, project_names
from rtgen.tools.scaffold.starters import (
    README,
    VENDOR,
    File,
    base_values,
    files_of,
    new_place,
    readme,
)

_NO_SPAN: Final = Span("", 1, 1, 1, 1)
_MOST_OCTETS: Final = 16 << 20


def create(
    name: str, path: Path, generate: Callable[[Project], None], *, stamped: bool
) -> Path:
    """Create the folder of a base for a CDL file; see `bases.create`."""
    package, forms = project_names(name)
    target = Path(name)
    beside = _files_of(path)
    with writing.new_folder(target) as made, chdir(made):
        # Imports of CDL are searched for in the working folder, too.
        folder = Path.cwd()
        place = new_place(package, folder)
        values = {**base_values(forms, place, stamped), "is_board": True}
        first = files_of(
            "project",
            {
                folder / "pyproject.toml": "pyproject.toml",
                folder / ".gitignore": "gitignore.txt",
                folder / ".gitattributes": "gitattributes.txt",
            },
            generated=OUTPUT,
            **values,
        )
        settings = {folder / "rtgen.toml": "rtgen.toml"}
        place.definitions.mkdir()
        (folder / "systems").mkdir()
        for each, data in beside.items():
            copy = place.definitions / each
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(copy, data)
        writing.write([*first, *files_of("base", settings, complete=False, **values)])
        model = _model(load(folder))
        drive = drive_of(list(boards(model)))
        plan = drive.board.plan
        tecs = f"{package}.{plan.name}"
        service = {
            "tecs": tecs,
            "service": drive.join.service.module,
            "service_type": drive.name,
            "tcp_port": drive.join.port,
            "behaviour_module": place.behaviour_module(f"{forms.module}_base"),
        }
        values |= {**service, **drive.values, **drive.simulated(tecs), "ports": []}
        simulated = f"simulated_{forms.module}_board"
        writing.write(
            files_of(
                "base",
                {
                    folder / README: readme(),
                    place.definitions / f"{forms.module}_base.idl": "base.idl",
                    place.definitions / f"{simulated}.idl": "board.idl",
                    place.skeletons / "kinematics.py": "kinematics.py",
                    place.behaviour_file(f"{forms.module}_base"): "base.py",
                    place.skeletons / "drives.py": "board_drives.py",
                    place.behaviour_file(simulated): "board.py",
                    folder / "tests" / f"test_{forms.module}_base.py": "test.py",
                },
                **values,
            )
        )
        for title, is_simulated in ((forms.module, False), ("simulation", True)):
            text = system_text(_system(title, forms, drive, is_simulated))
            writing.write([File(folder / "systems" / f"{title}.xml", text)])
        (folder / "rtgen.toml").unlink()
        writing.write(files_of("base", settings, complete=True, **values))
        generate(load(folder))
    return target


def _files_of(path: Path) -> dict[str, bytes]:
    """Return a CDL file and those that it imports from its folder. Raises InputError."""
    from rtgen.compiler.frontends import cdl

    read = cdl.load([path], root=path.parent)
    if has_errors(read.diagnostics):
        raise InputError(read.diagnostics)
    files = {path.name: read_start(path, _MOST_OCTETS)}
    folder = path.parent.resolve()
    for file in read.model.files:
        other = Path(file.name)
        if other.is_file() and other.resolve().is_relative_to(folder):
            inner = other.resolve().relative_to(folder).as_posix()
            files[inner] = read_start(other, _MOST_OCTETS)
    return files


def _model(project: Project) -> Model:
    read = compilation.read(project, lowered=True)
    if has_errors(read.diagnostics):
        raise InputError(read.diagnostics)
    return read.model


def _system(title: str, name: Names, drive: BoardDrive, simulated: bool) -> System:
    """Return the system of the robot, or that with a simulated board."""
    join, service = drive.join, drive.join.service
    marshaller, communication = f"{service.name}{MARSHALLER}0", join.instance
    options = join.options
    own: tuple[tuple[str, str], ...]
    own = (("ipaddr", options.address), ("port", str(join.port)))
    if options.device and not simulated:
        own = (("type", "SERIA"), ("port", options.device))
        own = (*own, ("baudrate", str(options.baudrate)))
    types = {
        communication: facts.COMPONENT,
        marshaller: f"{service.name}{MARSHALLER}",
        "Base0": f"{name.type}Base",
    }
    if simulated:
        types = {"Board0": f"Simulated{name.type}Board", **types}
    components = [
        SystemComponent(
            instance=instance,
            type=type_,
            id=(
                f"RTC:{VENDOR}:Base:{type_}:1.0.0"
                if instance in ("Base0", "Board0")
                else f"RTC:rtgen:TECS:{type_}:1.0.0"
            ),
            path_uri=f"localhost/{instance}.rtc",
            span=_NO_SPAN,
        )
        for instance, type_ in types.items()
    ]
    settings = {communication: own}
    ends = (
        (("Base0", service.module), (marshaller, service.module)),
        ((marshaller, consumer_name(service)), (communication, facts.PORT)),
    )
    return System(
        name=title,
        id=f"RTSystem:rtgen:{title}:1.0.0",
        file="",
        abstract=f"The base {name.type}{' with a simulated board' if simulated else ''}",
        components=tuple(
            (
                replace(c, configuration=(("default", settings[c.instance]),))
                if c.instance in settings
                else c
            )
            for c in components
        ),
        connections=tuple(
            Connection(
                name=f"{source[0]}.{source[1]}_{target[0]}.{target[1]}",
                source=PortReference(instance=source[0], port=source[1]),
                target=PortReference(instance=target[0], port=target[1]),
                service=True,
                span=_NO_SPAN,
                # The behaviour gets this port from a base class of the signature.
                properties=((OWN_PORT, ".".join(source)),) * (source[0] == "Base0"),
            )
            for source, target in ends
        ),
        activation=tuple(
            Activation(instance=each.instance, sequence=number)
            for number, each in enumerate(components, 1)
        ),
    )
