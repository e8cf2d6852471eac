"""Converts components and systems from one form to another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

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
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.tools.components.chosen_component import chosen
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, ReportedError

OF_COMPONENTS = ("idl", "rtc-xml", "rtc-yaml")
OF_SYSTEMS = ("rts-xml", "rts-yaml")
_MODULES = (".py", ".pyw")
_ENDINGS = {"idl": ".idl", "xml": ".xml", "yaml": ".yaml", "dbc": ".dbc"}


@dataclass(frozen=True, slots=True)
class Converted:
    """A component, system or bus in its new form; `name` is that of its file.

    `folders` are those of the files that it includes.
    """

    name: str
    content: str | bytes
    folders: tuple[Path, ...] = ()

    def write(self, folder: Path) -> Path:
        """Write a new file in a folder, and return its path. Raises ToolError."""
        target = folder / self.name
        content = self.content
        data = content.encode() if isinstance(content, str) else content
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with target.open("xb") as stream:
                stream.write(data)
        except FileExistsError:
            raise ToolError(f"{target.as_posix()} exists already") from None
        except OSError as error:
            message = f"cannot write {target.as_posix()}: {error.strerror}"
            raise ToolError(message) from error
        return target


def converted(
    console: Console,
    file: str,
    form: str | None,
    name: str | None,
    include: Sequence[str],
) -> Converted:
    """Return a component, the one called `name` if there are several, or a system in a form.

    By default a component in IDL becomes RTC.xml, others become IDL, and a system in XML becomes
    YAML or the other way round. Raises InputError, ReportedError, ToolError.
    """
    path = Path(file)
    suffix = path.suffix.lower()
    if suffix in _MODULES:
        return adopted_as(console, path, form or "idl", include)
    is_yaml = suffix in YAML_SUFFIXES
    if (suffix == ".xml" or is_yaml) and not is_component_profile(path):
        return _system(console, path, form or ("rts-xml" if is_yaml else "rts-yaml"))
    other = "rtc-xml" if suffix in IDL_SUFFIXES else "idl"
    return _component(console, path, form or other, name, include)


def adopted_as(
    console: Console, path: Path, form: str, include: Sequence[str]
) -> Converted:
    """Return the component that a module of OpenRTM-aist-Python implements.

    Raises InputError, ReportedError, ToolError.
    """
    from rtgen.compiler.project import load
    from rtgen.tools.components.adopted import adopted

    require_form(form, OF_COMPONENTS, "a component")
    adoption = adopted(path, [Path(folder) for folder in include])
    model, component = adoption.model, adoption.component
    _report(console, model, component, form, adoption.diagnostics, adoption.sources)
    if component is None:
        raise ReportedError(BAD_INPUT)
    return _in_form(model, component, form, load())


def require_form(form: str, forms: Sequence[str], what: str) -> None:
    """Raise InputError unless something has a form."""
    if form in forms:
        return
    from rtgen.compiler.project_rules import OTHER_FORM

    hint = f"--to {', --to '.join(forms)}"
    raise InputError([OTHER_FORM.at(None, f"{what} has no form {form}", hint=hint)])


def named(name: str, form: str, content: str | bytes) -> Converted:
    """Return content in a form, with the name of its file."""
    return Converted(f"{name}{_ENDINGS[form.rpartition('-')[2]]}", content)


def _content(path: Path) -> bytes:
    try:
        return read_file(path)
    except UnreadableError as error:
        raise ToolError(f"cannot read {path.as_posix()}: {error}") from error


def _system(console: Console, path: Path, form: str) -> Converted:
    from rtgen.compiler.frontends.profiles import (
        profile_tree,
        profile_yaml,
        rts_profile,
    )
    from rtgen.compiler.systems.checks import as_warnings, check_properties

    file = path.as_posix()
    read = rts_profile.load(path)
    diagnostics = [*read.diagnostics]
    if read.system is not None:
        diagnostics += as_warnings(check_properties(read.system))
    console.findings(diagnostics, read.sources)
    if read.system is None or has_errors(diagnostics):
        raise ReportedError(BAD_INPUT)
    require_form(form, OF_SYSTEMS, "a system")
    name, content = read.system.name, _content(path)
    is_yaml = path.suffix.lower() in YAML_SUFFIXES
    if is_yaml is form.endswith("yaml"):
        return named(name, form, content)
    if is_yaml:
        text = profile_tree.text_of(content, file, diagnostics.append)
        return named(name, form, profile_yaml.to_xml(text, file))
    root, _ = profile_tree.parse(content, file, diagnostics.append)
    assert root is not None
    return named(name, form, profile_yaml.to_yaml(root))


def _component(
    console: Console, path: Path, form: str, name: str | None, include: Sequence[str]
) -> Converted:
    from rtgen.compiler import compilation
    from rtgen.compiler.project import load, with_arguments

    require_form(form, OF_COMPONENTS, "a component")
    project = with_arguments(load(), paths=(str(path),), include=include)
    read = compilation.read(project, lowered=True)
    component = None
    if not has_errors(read.diagnostics):
        component = chosen(read.model, str(path), name)
    _report(console, read.model, component, form, read.diagnostics, read.sources)
    if component is None:
        raise ReportedError(BAD_INPUT)
    if form == "idl" or not is_component_profile(path):
        return _in_form(read.model, component, form, project)
    content = _content(path)
    if (path.suffix.lower() in YAML_SUFFIXES) is form.endswith("yaml"):
        return named(component.name[-1], form, content)
    return named(component.name[-1], form, _profile(path, content, form, project))


def _profile(path: Path, content: bytes, form: str, project: Project) -> str:
    """Return a profile of a component in the other form."""
    from rtgen.compiler.frontends.kit import located_xml
    from rtgen.compiler.frontends.profiles import profile_tree, profile_yaml

    reported: list[Diagnostic] = []
    file = path.as_posix()
    text = profile_tree.text_of(content, file, reported.append, project.encoding)
    if form == "rtc-xml":
        return profile_yaml.to_xml(text, file)
    return profile_yaml.to_yaml(located_xml.parse(text, file))


def _report(
    console: Console,
    model: Model,
    component: Component | None,
    form: str,
    diagnostics: Sequence[Diagnostic],
    sources: Mapping[str, str],
) -> None:
    """Report what was found when a component was read, and what no profile can say.

    Raises ReportedError for errors.
    """
    from rtgen.compiler.backends.components.checks import check_component

    if component is not None and form != "idl":
        diagnostics = in_order([*diagnostics, *check_component(model, component)])
    console.findings(diagnostics, sources)
    if component is not None and form != "idl" and has_errors(diagnostics):
        raise ReportedError(BAD_INPUT)


def _in_form(
    model: Model, component: Component, form: str, project: Project
) -> Converted:
    from rtgen.compiler.frontends.kit import located_xml
    from rtgen.compiler.frontends.profiles import profile_yaml
    from rtgen.tools.components.component_text import (
        component_idl,
        component_profile,
        included_files,
    )

    name = component.name[-1]
    if form == "idl":
        files = [Path(file) for file in included_files(model, component)]
        folders = dict.fromkeys(file.parent for file in files if file.is_file())
        return replace(
            named(name, form, component_idl(model, component)), folders=tuple(folders)
        )
    xml = component_profile(model, component, project)
    if form == "rtc-xml":
        return named(name, form, xml)
    return named(name, form, profile_yaml.to_yaml(located_xml.parse(xml, name)))
