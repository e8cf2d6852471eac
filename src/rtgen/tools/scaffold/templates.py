"""Copies of rtgen's templates, for a project to change."""

from __future__ import annotations

import re
from pathlib import Path

from rtgen.compiler.backends.kit.rendering import template_names, template_source
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.kit.translation import translated
from rtgen.compiler.project import FILE_NAME, file, find, shown
from rtgen.compiler.project.templates import no_template, template_folder
from rtgen.compiler.project_rules import UNKNOWN_TEMPLATE
from rtgen.facts.columns import table
from rtgen.tools.scaffold.rules import NO_PROJECT, NO_TEMPLATES
from rtgen.tools.scaffold.starters import File

_SUMMARY = re.compile(r"{#\s*(.*?)\s*#}", re.DOTALL)


def listing() -> str:
    """Return the names of all templates with what they make, one a line."""
    summaries = {
        name: translated(_summary(template_source(name))) for name in template_names()
    }
    return "".join(f"{line}\n" for line in table([*summaries.items()]))


def copy_of(name: str) -> File:
    """Return the copy of a template in the project around the working folder.

    Raises InputError without a project, without a folder for it, or if there is no such template.
    """
    if name not in template_names():
        message, hint = no_template(name)
        raise InputError([UNKNOWN_TEMPLATE.at(None, message, hint=hint)])
    project = find(Path.cwd())
    if project is None:
        message = f"there is no {FILE_NAME} here, or in a folder above"
        hint = "rtgen new project NAME makes one"
        raise InputError([NO_PROJECT.at(None, message, hint=hint)])
    folder = template_folder(file.read(project, shown(project)), project.parent)
    if folder is None:
        message = f"{shown(project)} names no folder for templates"
        hint = 'add the section [templates] with path = "templates"'
        raise InputError([NO_TEMPLATES.at(None, message, hint=hint)])
    return File(folder / name, template_source(name))


def _summary(text: str) -> str:
    match = _SUMMARY.match(text)
    return " ".join(match[1].split()) if match else ""
