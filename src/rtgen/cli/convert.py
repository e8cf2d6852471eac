"""The command `rtgen convert`: writes a component or a system in another form."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    ToolError,
    has_errors,
    in_order,
)
from rtgen.compiler.frontends.profiles.profile_yaml import YAML_SUFFIXES
from rtgen.compiler.model import Component, Model
from rtgen.compiler.project import Project, is_component_profile
from rtgen.facts.files import UnreadableError, read_file
from rtgen.tools.components.chosen_component import chosen
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK

_OF_COMPONENTS = ("idl", "rtc-xml", "rtc-yaml")
_OF_SYSTEMS = ("rts-xml", "rts-yaml")


@command()
@click.argument("file", metavar="FILE")
@click.option(
    "--to",
    "to",
    required=True,
    type=click.Choice((*_OF_COMPONENTS, *_OF_SYSTEMS)),
    help="Output format.",
)
@click.option(
    "--component",
    metavar="NAME",
    help="Name of the component, if FILE defines several.",
)
@click.option(
    "-I",
    "include",
    multiple=True,
    metavar="DIR",
    help="Search DIR for included files and for types of ports.",
)
@with_console
def convert(
    console: Console,
    file: str,
    to: str,
    component: str | None,
    include: tuple[str, ...],
) -> int:
    """Convert a component or a system to another format, on standard output.

    FILE is a definition with a component (*.idl), an RtcProfile (RTC.xml, or the YAML that
    rtc-template writes), or an RtsProfile (XML, or the YAML of rtshell). A profile whose format is
    already the output format is copied unchanged.
    """
    if _is_system(Path(file)):
        return _system(console, Path(file), to)
    return _component(console, file, to, component, include)


def _is_system(path: Path) -> bool:
    suffix = path.suffix.lower()
    return suffix in (".xml", *YAML_SUFFIXES) and not is_component_profile(path)


def _wrong_form(form: str, forms: tuple[str, ...], what: str) -> InputError:
    from rtgen.compiler.project.rules import OTHER_FORM

    hint = f"--to {', --to '.join(forms)}"
    return InputError([OTHER_FORM.at(None, f"{what} has no form {form}", hint=hint)])


def _content(path: Path) -> bytes:
    try:
        return read_file(path)
    except UnreadableError as error:
        raise ToolError(f"cannot read {path.as_posix()}: {error}") from error


# Systems


def _system(console: Console, path: Path, form: str) -> int:
    from rtgen.compiler.frontends.profiles import (
        profile_tree,
        profile_yaml,
        rts_profile,
    )
    from rtgen.compiler.systems.checks import as_warnings, check_properties

    name = path.as_posix()
    read = rts_profile.load(path)
    diagnostics = [*read.diagnostics]
    if read.system is not None:
        diagnostics += as_warnings(check_properties(read.system))
    console.findings(diagnostics, read.sources)
    if has_errors(diagnostics):
        return BAD_INPUT
    if form not in _OF_SYSTEMS:
        raise _wrong_form(form, _OF_SYSTEMS, "a system")
    data = _content(path)
    is_yaml = path.suffix.lower() in YAML_SUFFIXES
    if is_yaml is form.endswith("yaml"):
        write_out(data)
    elif is_yaml:
        text = profile_tree.text_of(data, name, diagnostics.append)
        write_out(profile_yaml.to_xml(text, name))
    else:
        root, _ = profile_tree.parse(data, name, diagnostics.append)
        assert root is not None
        write_out(profile_yaml.to_yaml(root))
    return OK


# Components


def _component(
    console: Console,
    file: str,
    form: str,
    name: str | None,
    include: tuple[str, ...],
) -> int:
    from rtgen.compiler import compilation
    from rtgen.compiler.backends.components.checks import check_component
    from rtgen.compiler.project import load, with_arguments
    from rtgen.tools.components.component_text import component_idl

    if form not in _OF_COMPONENTS:
        raise _wrong_form(form, _OF_COMPONENTS, "a component")
    project = with_arguments(load(), paths=(file,), include=include)
    read = compilation.read(project, lowered=True)
    diagnostics = list(read.diagnostics)
    component = None if has_errors(diagnostics) else chosen(read.model, file, name)
    if component is not None and form != "idl":
        diagnostics = in_order([*diagnostics, *check_component(read.model, component)])
    console.findings(diagnostics, read.sources)
    if component is None or has_errors(diagnostics):
        return BAD_INPUT
    if form == "idl":
        write_out(component_idl(read.model, component))
        return OK
    write_out(_profile(Path(file), form, read.model, component, project))
    return OK


def _profile(
    path: Path, form: str, model: Model, component: Component, project: Project
) -> str | bytes:
    from rtgen.compiler.frontends.kit import located_xml
    from rtgen.compiler.frontends.profiles import profile_tree, profile_yaml
    from rtgen.tools.components.component_text import component_profile

    name = path.as_posix()
    if not is_component_profile(path):
        xml = component_profile(model, component, project)
    else:
        data = _content(path)
        if (path.suffix.lower() in YAML_SUFFIXES) is form.endswith("yaml"):
            return data
        reported: list[Diagnostic] = []
        text = profile_tree.text_of(data, name, reported.append, project.encoding)
        if form == "rtc-xml":
            return profile_yaml.to_xml(text, name)
        xml = text
    if form == "rtc-xml":
        return xml
    return profile_yaml.to_yaml(located_xml.parse(xml, name))
