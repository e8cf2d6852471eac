"""IDL files that are printed when they are included: those of other definitions, and of ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

from msgspec.structs import replace

from rtgen.backends import stage as backends
from rtgen.diagnostics import Severity, has_errors
from rtgen.facts.ros import interface_beside, is_interface
from rtgen.files import absolute_path, is_file
from rtgen.frontends import FrontendResult, together
from rtgen.frontends.idl.rules.lexical import INCLUDE_NOT_FOUND
from rtgen.frontends.idl.text.source import Interfaces, Printed
from rtgen.frontends.stage import Settings
from rtgen.model import Model
from rtgen.resources import ros_file, ros_interfaces


def printed_idl(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of IDL files that can be included but are on no disk, by name.

    They are printed from definitions in other languages, and from the ROS 2 interfaces that ship
    with rtgen.
    """
    shipped = {
        f"{name.rpartition('.')[0]}.idl": partial(_idl_of_shipped, name)
        for name in ros_interfaces()
    }
    return {**shipped, **backends.printed_idl(model)}


def _idl_of_shipped(name: str) -> str:
    from rtgen.backends import ros_idl
    from rtgen.frontends import rosidl

    file = ros_file(name)
    model = rosidl.load([file], root=file.parents[2]).model
    return ros_idl.idl_of(model, f"{name.rpartition('.')[0]}.idl")


def interfaces(settings: Settings, sources: Sequence[Path] = ()) -> Interfaces:
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
        from rtgen.frontends import rosidl

        found = rosidl.load(
            [source or path],
            root=settings.root,
            include=settings.include,
            encoding=settings.encoding,
        )
        errors = tuple(d for d in found.diagnostics if d.severity is Severity.ERROR)
        if errors and source is None:
            return None
        from rtgen.backends import ros_idl

        name = "/".join((*path.absolute().parts[-3:-1], f"{path.stem}.idl"))
        text = "" if errors else ros_idl.idl_of(found.model, name)
        return Printed(name, text, found.dependencies, errors)

    return cache(interface)


def merged(of_idl: FrontendResult, others: FrontendResult) -> FrontendResult:
    """Merge all definitions. A ROS 2 interface that was read replaces the IDL printed from it.

    Included files that are missing since other definitions have errors are not reported.
    """
    if has_errors(others.diagnostics):
        found = tuple(d for d in of_idl.diagnostics if d.code != INCLUDE_NOT_FOUND.code)
        of_idl = replace(of_idl, diagnostics=found)
    if not any(is_interface(d.name[:3]) for d in others.model.declarations):
        return together([of_idl, others])
    from rtgen.backends.ros_idl import idl_names

    names = idl_names(others.model)
    model = of_idl.model
    files = tuple(
        replace(file, includes=tuple(names.get(each, each) for each in file.includes))
        for file in model.files
        if file.name not in names
    )
    kept = tuple(d for d in model.declarations if d.file not in names)
    rest = replace(of_idl, model=replace(model, files=files, declarations=kept))
    return together([others, rest])
