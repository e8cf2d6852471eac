"""Prints a component of a model as IDL or as RTC.xml."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.backends.profiles import rtc_profile
from rtgen.compiler.model import Component, Declaration, Model, ScopedName
from rtgen.compiler.model.declarations import OPAQUE
from rtgen.compiler.project import Project
from rtgen.compiler.typemap.components.needs import declarations_of
from rtgen.facts.version import __version__


def component_idl(model: Model, component: Component) -> str:
    """Return the component as IDL: includes for its types, placeholders for unknown ones."""
    needed = declarations_of(model, component)
    opaque = {d.name for d in needed if d.annotation(OPAQUE) is not None}
    own = {component.file, component.other_file}
    included = opaque | set(_ancestors(model, component))
    inside = [d for d in model.declarations if d.name in included or _is_beside(d, own)]
    inside = [d for d in inside if d.name != component.name]
    files = included_files(model, component)
    names = dict.fromkeys(PurePosixPath(file).name for file in files)
    includes = "".join(f'#include "{name}"\n' for name in names)
    text = idl_text(model, [*inside, component], components=True)
    return f"{includes}\n{text}" if includes else text


def included_files(model: Model, component: Component) -> list[str]:
    """Return the displayed paths of the files that the component's IDL includes."""
    own = {component.file, component.other_file}
    files = [name for each in model.files if each.name in own for name in each.includes]
    for each in declarations_of(model, component):
        if each.annotation(OPAQUE) is None and each.file not in own:
            files.append(each.file)
    return files


def _is_beside(declaration: Declaration, files: set[str]) -> bool:
    return declaration.file in files and not isinstance(declaration, Component)


def _ancestors(model: Model, component: Component) -> Iterator[ScopedName]:
    """Yield the bases that are defined in the component's own file."""
    while component.base is not None:
        base = model.find(component.base)
        if not isinstance(base, Component) or base.file != component.file:
            return
        yield base.name
        component = base


def component_profile(model: Model, component: Component, project: Project) -> str:
    """Return the component as RtcProfile (RTC.xml)."""
    options = Options(
        package=project.package,
        skeleton_package=project.skeleton_package,
        version=__version__,
    )
    return rtc_profile.profile_text(model, component, options)
