"""IDL files of ROS 2 interfaces that definitions include: printed, and read in their place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends import FrontendResult, together
from rtgen.compiler.frontends.idl.text.source import Interfaces, Printed
from rtgen.compiler.frontends.stage import Settings
from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.model import Model
from rtgen.facts.files import absolute_path, is_file
from rtgen.facts.ros import INTERFACE_SUFFIXES, interface_beside, is_interface


def texts(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of IDL files of interfaces, by name: those that ship with rtgen, and a
    model's.
    """
    shipped: dict[str, Callable[[], str]] = {
        f"{name.rpartition('.')[0]}.idl": partial(_idl_of_shipped, name)
        for name in ros_interfaces()
    }
    if not any(file.name.endswith(INTERFACE_SUFFIXES) for file in model.files):
        return shipped
    from rtgen.ros2 import ros_idl

    return shipped | ros_idl.idl_files(model)


@cache
def _idl_of_shipped(name: str) -> str:
    from rtgen.ros2 import ros_idl, rosidl

    file = ros_file(name)
    model = rosidl.load([file], root=file.parents[2]).model
    return ros_idl.idl_of(model, f"{name.rpartition('.')[0]}.idl")


def interfaces(settings: Settings, sources: Sequence[Path]) -> Interfaces:
    """Return the function for IDL files of packages of ROS 2 that definitions include.

    The interface file of that name is read in place of IDL, which an installation has beside it.
    IDL alone is read in the form that ROS 2 generates; in another form it is plain IDL. Those among
    the `sources` are read as such.
    """
    read = {absolute_path(path) for path in sources}

    def interface(path: Path, in_package: bool) -> Printed | None:
        beside = interface_beside(path)
        if beside is None:
            return None
        if absolute_path(beside) in read:
            return None
        source = beside if is_file(beside) else None
        if source is None and not (in_package and is_file(path)):
            return None
        from rtgen.ros2 import ros_idl, rosidl

        result = rosidl.load(
            [source or path],
            root=settings.root,
            include=settings.include,
            encoding=settings.encoding,
        )
        errors = tuple(d for d in result.diagnostics if d.severity is Severity.ERROR)
        if errors and source is None:
            return None
        name = "/".join((*path.absolute().parts[-3:-1], f"{path.stem}.idl"))
        text = "" if errors else ros_idl.idl_of(result.model, name)
        return Printed(name, text, result.dependencies, errors)

    return cache(interface)


def merged(of_idl: FrontendResult, others: FrontendResult) -> FrontendResult:
    """Merge all definitions. A ROS 2 interface that was read replaces the IDL printed from it."""
    if not any(is_interface(d.name[:3]) for d in others.model.declarations):
        return together([of_idl, others])
    from rtgen.ros2.ros_idl import idl_names

    names = idl_names(others.model)
    model = of_idl.model
    files = tuple(
        replace(file, includes=tuple(names.get(each, each) for each in file.includes))
        for file in model.files
        if file.name not in names
    )
    remaining = tuple(d for d in model.declarations if d.file not in names)
    rest = replace(of_idl, model=replace(model, files=files, declarations=remaining))
    return together([others, rest])
