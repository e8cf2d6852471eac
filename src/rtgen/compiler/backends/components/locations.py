"""Locations of a component's files, and the origin comments in them."""

from __future__ import annotations

from rtgen.compiler.backends import Options
from rtgen.compiler.kit.words import words
from rtgen.compiler.model import Component, Model, SourceFile
from rtgen.compiler.typemap.profiles import escapes as profile_escapes
from rtgen.compiler.typemap.python.names import identifier, module_name, skeleton_module

_COMPONENTS = "components"
SKELETON_NAMES = words("""
    RTC_OK ReturnCode_t NotImplementedError annotations property bool bytes dict float int list
    object self str tuple
    """)
"""Names that the module of a skeleton uses."""


def package_folder(options: Options, component: Component) -> str:
    """The folder of a component's package, below the output folder."""
    return f"{components_folder(options)}/{module_name(component.name[-1])}"


def components_folder(options: Options) -> str:
    """The folder of all components' packages, below the output folder."""
    return f"{options.folder}/{_COMPONENTS}"


def base_location(package: str, component: Component) -> str:
    """Return the absolute name of the module with a component's base."""
    own = f"{_COMPONENTS}.{module_name(component.name[-1])}"
    return f"{package}.{component.module or own}"


def module_path(package: str, component: Component) -> str:
    """Return the file of that module, below the output folder."""
    path = base_location(package, component).replace(".", "/")
    return f"{path}.py" if component.module else f"{path}/__init__.py"


def imported_from(options: Options, target: str) -> tuple[str, str]:
    """Module and name of `module:name`; a module with a dot in front is below the package."""
    module, _, name = target.partition(":")
    return f"{options.package}{module}" if module.startswith(".") else module, name


def factory(component: Component, options: Options) -> tuple[str, str]:
    """Module and name of what makes a component: its own, else the class of its skeleton."""
    if component.factory:
        return imported_from(options, component.factory)
    return skeleton_location(component, options), skeleton_class(component)


def skeleton_location(component: Component, options: Options) -> str:
    """Return the absolute name of the module of a component's skeleton."""
    return skeleton_module(
        component.name[-1], options.package, options.skeleton_package
    )


def skeleton_class(component: Component) -> str:
    """Return the name of the class of a component's skeleton."""
    return identifier(component.name[-1], SKELETON_NAMES)


def source_of(model: Model, component: Component) -> SourceFile:
    """The file that a component is defined in."""
    return next(file for file in model.files if file.name == component.file)


def summary(component: Component) -> str:
    """The description of the component in one line; may be empty."""
    return profile_escapes.summary(component.description, component.doc)


def heading(component: Component) -> str:
    """Name and summary in one line, for docstrings."""
    title = summary(component)
    return (
        f"{component.name[-1]}: {title}"
        if title
        else f"The component {component.name[-1]}."
    )
