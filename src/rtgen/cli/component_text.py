"""A component of a model as text in the forms that people exchange."""

from __future__ import annotations

from pathlib import PurePosixPath

from rtgen import __version__
from rtgen.backends import Options, rtc_profile
from rtgen.backends.idl_text import idl_text
from rtgen.model import Component, Declaration, Model, NamedType
from rtgen.model.declarations import OPAQUE
from rtgen.project import Project


def component_idl(model: Model, component: Component) -> str:
    """The component in IDL: includes of the files that declare its types, placeholders, itself."""
    types = [item.type for item in component.ports]
    types += [item.type for item in component.configuration]
    named = [type_.name for type_ in types if isinstance(type_, NamedType)]
    named += [component.base] if component.base is not None else []
    needed = [model.find(name) for name in dict.fromkeys((*named, *component.supports))]
    opaque = [d for d in needed if d.annotation(OPAQUE) is not None]
    files = dict.fromkeys(PurePosixPath(d.file).name for d in needed if d not in opaque)
    includes = "".join(f'#include "{name}"\n' for name in files)
    text = idl_text(model, _ordered(model, opaque, component), components=True)
    return f"{includes}\n{text}" if includes else text


def _ordered(
    model: Model, opaque: list[Declaration], component: Component
) -> list[Declaration]:
    """In the order of the model, so that each module is opened once where that can be."""
    wanted = {declaration.name for declaration in opaque}
    return [d for d in model.declarations if d.name in wanted] + [component]


def component_profile(model: Model, component: Component, project: Project) -> str:
    """The component as RtcProfile (RTC.xml)."""
    options = Options(
        package=project.package,
        skeleton_package=project.skeleton_package,
        version=__version__,
    )
    return rtc_profile.profile_text(model, component, options)
