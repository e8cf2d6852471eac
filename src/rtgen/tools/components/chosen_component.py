"""Selects the component of a definition for a command."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.model import Component, Model
from rtgen.compiler.project import is_component_profile


def chosen(model: Model, file: str | None, name: str | None) -> Component:
    """Return the component of a file, by its name if there are several; None: of the project.

    Raises InputError.
    """
    from rtgen.compiler.project_rules import WHICH_COMPONENT

    files = {source.name for source in model.files if source.main}
    if file is None:
        file = "the project"
    elif is_component_profile(Path(file)):
        files = {Path(file).as_posix()}
    components = [d for d in model.declarations if isinstance(d, Component)]
    components = [d for d in components if d.file in files]
    matches = [d for d in components if name in (None, d.name[-1], d.scoped)]
    if len(matches) == 1:
        return matches[0]
    names = ", ".join(d.scoped for d in components)
    if not components:
        message, hint = f"{file} defines no component", None
    elif name is None:
        message, hint = (
            f"{file} defines {len(components)} components",
            "--component NAME",
        )
    else:
        message, hint = f"{file} defines no component {name}", None
    hint = f"{hint + ': ' if hint else 'it has '}{names}" if components else None
    raise InputError([WHICH_COMPONENT.at(None, message, hint=hint)])
