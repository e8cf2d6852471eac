"""The component of a module of OpenRTM-aist-Python, with the types of its ports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rtgen import compiler
from rtgen.backends.components.places import summary
from rtgen.backends.openrtm.plan import openrtm_port_name
from rtgen.backends.openrtm.rules import OTHER_PROFILE
from rtgen.component_profiles import declared_in, type_names
from rtgen.diagnostics import Diagnostic, Span, has_errors, in_order
from rtgen.frontends import openrtm_python
from rtgen.frontends.rtc_profile import Profiles
from rtgen.model import Component, Model, NamedType, PortKind, SourceFile
from rtgen.model.rtc_profile import RtcProfile
from rtgen.project import Project, load, with_arguments
from rtgen.typemap.parameters import Parameters

_PROFILE = "RTC.xml"
_WITH_TYPES = (".idl", ".eds", ".dcf", ".toml")
_DATA_PORTS = (PortKind.INPORT, PortKind.OUTPORT)


@dataclass(frozen=True, slots=True)
class Adopted:
    """The component and its model; no component if there are errors."""

    component: Component | None
    model: Model = field(default_factory=Model)
    diagnostics: tuple[Diagnostic, ...] = ()
    sources: Mapping[str, str] = field(default_factory=dict)


def adopted(path: Path, include: Sequence[Path]) -> Adopted:
    """What a module says; of one that rtgen made what its profile says, if that is the same."""
    module = openrtm_python.read(path, include)
    if module.profile is None:
        return Adopted(None, Model(), module.diagnostics, module.sources)
    shown = module.profile.file
    profiles = Profiles(
        (module.profile,),
        (SourceFile(name=shown, key=path.name, sha256="", main=True),),
        module.diagnostics,
        dict(module.sources),
    )
    beside = path.with_name(_PROFILE)
    if not module.generated or not beside.is_file():
        return _with_neighbours(path, include, shown, profiles)
    alone = with_arguments(
        load(), paths=(str(beside),), include=[str(folder) for folder in include]
    )
    told = _with_types(alone, beside.as_posix(), None)
    if told.component is not None and _agree(
        told.model, told.component, module.profile
    ):
        return told
    plain = _with_neighbours(path, include, shown, profiles)
    message = f"{beside.as_posix()} says something else"
    other = OTHER_PROFILE.at(Span(shown, 1, 1, 1, 2), message)
    return replace(plain, diagnostics=tuple(in_order([*plain.diagnostics, other])))


def _with_neighbours(
    path: Path, include: Sequence[Path], shown: str, profiles: Profiles
) -> Adopted:
    """The component with types of IDL files beside the module, if those can be read.

    They are in its folder, or in a folder `idl` there or next to it, and declare what a port needs.
    """
    wanted = type_names(profiles)
    folders = [
        path.parent,
        *(path.parent / each for each in ("idl", "../idl")),
    ]
    beside = [
        file
        for folder in folders
        for file in sorted(folder.glob("*.idl"))
        if not wanted.isdisjoint(declared_in(file))
    ]
    plain = _definitions(include, ())
    given = {file.resolve() for file in plain.sources}
    beside = [file for file in beside if file.resolve() not in given]
    if beside:
        found = _with_types(_definitions(include, beside), shown, profiles)
        if found.component is not None:
            return found
    return _with_types(plain, shown, profiles)


def _definitions(include: Sequence[Path], beside: Sequence[Path]) -> Project:
    """The project with the IDL files of the folders as well, and what else may declare types."""
    project = load()
    files = [path for folder in include for path in sorted(folder.glob("*.idl"))]
    files += beside
    files += [p for p in project.sources if p.suffix.lower() in _WITH_TYPES]
    folders = dict.fromkeys(file.parent for file in beside)
    included = (*include, *folders, *project.include)
    return replace(project, sources=tuple(files), include=included, adapters=())


def _with_types(project: Project, shown: str, profiles: Profiles | None) -> Adopted:
    """The component of the file that is shown so."""
    read = compiler.read(project, lowered=True, adopted=profiles)
    found = tuple(in_order(read.diagnostics))
    components = [
        d
        for d in read.model.declarations
        if isinstance(d, Component) and d.file == shown
    ]
    component = components[0] if components and not has_errors(found) else None
    return Adopted(component, read.model, found, read.sources)


def _agree(model: Model, component: Component, module: RtcProfile) -> bool:
    """Whether a module says what rtgen would write for the component."""
    same = (
        component.name[-1] == module.name
        and component.vendor == module.vendor
        and component.category == module.category
        and component.version == module.version
        and component.component_type == module.component_type
        and component.execution == module.execution
        and component.rate == module.rate
        and component.max_instances == module.max_instances
        and summary(component) == module.description
    )
    return (
        same
        and set(_ports_of(model, component)) == set(_ports_in(module))
        and set(_parameters_of(model, component)) == set(_parameters_in(module))
    )


def _ports_of(model: Model, component: Component) -> Iterator[tuple[object, ...]]:
    for port in component.ports:
        name = openrtm_port_name(component, port)
        type_ = model.unalias(port.type)
        assert isinstance(type_, NamedType), "the type of a port has a name"
        scoped = model.find(type_.name).scoped
        if port.kind in _DATA_PORTS:
            yield name, port.kind is PortKind.OUTPORT, scoped
        else:
            yield name, port.instance, port.kind is PortKind.PROVIDER, scoped


def _ports_in(module: RtcProfile) -> Iterator[tuple[object, ...]]:
    for data in module.data_ports:
        yield data.name, data.output, data.type
    for service in module.service_ports:
        for each in service.interfaces:
            yield service.name, each.name, each.provided, each.type


def _parameters_of(model: Model, component: Component) -> Iterator[tuple[object, ...]]:
    parameters = Parameters(model)
    for each in component.configuration:
        yield (
            each.name,
            parameters.profile_type(each.type),
            parameters.default_text(each),
            each.widget or "text",
            parameters.constraint(each),
        )


def _parameters_in(module: RtcProfile) -> Iterator[tuple[object, ...]]:
    for each in module.parameters:
        yield each.name, each.type, each.default, each.widget, each.constraint
