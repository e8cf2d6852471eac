"""Which files the joins of a project through `RTCPlugin` give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from rtgen.backends import Artifact, Emission, Options, Owner, rtc_profile
from rtgen.backends.components import BACKEND as COMPONENTS
from rtgen.backends.idl_text import idl_text
from rtgen.backends.python_text import header, header_comment
from rtgen.backends.rendering import render
from rtgen.backends.tecs.build_files import (
    build_scripts,
    communication_conf,
    tecsgen_plugin,
)
from rtgen.backends.tecs.codec import codec_text
from rtgen.backends.tecs.communication import (
    COMPONENT,
    FILE,
    communication_artifacts,
    communication_model,
)
from rtgen.backends.tecs.idl_model import IdlService, IdlSide, idl_side
from rtgen.backends.tecs.marshaller_module import marshaller_module
from rtgen.backends.tecs.plan import ROOT, TecsPackage, packages
from rtgen.backends.tecs.rules import NOT_TRANSFERRED
from rtgen.backends.tecs.server_module import server_module
from rtgen.backends.tecs.service_text import ServiceText
from rtgen.backends.tecs.types_module import types_text
from rtgen.backends.tecs.views_module import views_module
from rtgen.backends.types import BACKEND as TYPES
from rtgen.diagnostics import Diagnostic, has_errors
from rtgen.layouts.tdr import Record
from rtgen.layouts.tdr_messages import layout_of, problems
from rtgen.model import Declaration, Model, SourceFile
from rtgen.model.tecs import TecsConst
from rtgen.typemap.idl_python import PythonNames
from rtgen.typemap.python_names import identifier, module_name
from rtgen.typemap.tecs_python import codec_module


class TecsBackend:
    """Makes a package for each CDL file with a join through `RTCPlugin`, and what they share."""

    name = "tecs"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all packages; none where anything has errors."""
        tecs, findings = _read(model)
        if tecs is None or has_errors(findings):
            return Emission((), findings)
        sources, communication = tecs.sources, tecs.communication
        shared = _options(options, ROOT)
        artifacts = [
            *_through_idl(communication, shared, sources, {COMPONENT: None}),
            *communication_artifacts(communication, options.version, sources),
        ]
        entries = dict(_COMMUNICATION)
        for package, side in tecs.sides:
            writer = _Writer(package, side, options)
            artifacts += writer.artifacts()
            entries = {**_entries(package), **entries}
        artifacts.append(_entry_points(entries, options, sources))
        return Emission(artifacts, findings)


BACKEND = TecsBackend()

_COMMUNICATION = {COMPONENT: f"{ROOT}.opaque_rpc_communication:{COMPONENT}"}


@dataclass(frozen=True, slots=True)
class RtcPackage:
    """The RTCs of a package and their IDL as a model; `factories` has `module:name` by type.

    `external` maps the displayed path of a file whose types another package has to that one.
    """

    model: Model
    options: Options
    factories: Mapping[str, str]
    external: Mapping[str, str]


def rtc_packages(model: Model, options: Options) -> list[RtcPackage]:
    """The packages with RTCs that `emit` makes; none where anything has errors."""
    tecs, findings = _read(model)
    if tecs is None or has_errors(findings):
        return []
    shared = _options(options, ROOT)
    found = [RtcPackage(tecs.communication, shared, _COMMUNICATION, {})]
    for package, side in tecs.sides:
        own = _options(options, package.package)
        found.append(RtcPackage(side.model, own, _entries(package), {FILE: ROOT}))
    return found


@dataclass(frozen=True, slots=True)
class _Tecs:
    """The packages of a project, each with its IDL side, and what they share."""

    sources: tuple[SourceFile, ...]
    communication: Model
    sides: tuple[tuple[TecsPackage, IdlSide], ...]


def _read(model: Model) -> tuple[_Tecs | None, list[Diagnostic]]:
    """What a project has of TECS, None without a join; and what is wrong with it."""
    planned, findings = packages(model)
    if not planned:
        return None, findings
    sources = tuple(dict.fromkeys(s for p in planned for s in p.sources))
    communication = communication_model(sources)
    sides = []
    for package in planned:
        side, found = idl_side(package, communication)
        sides.append((package, side))
        findings += [*found, *_untransferable(package, side)]
    return _Tecs(sources, communication, tuple(sides)), findings


def _options(options: Options, package: str) -> Options:
    return replace(options, package=package, skeleton_package=package)


def _entries(package: TecsPackage) -> dict[str, str]:
    """The factories of a package's components."""
    found = {}
    for service in package.services:
        marshaller, client = f"{service.name}Marshaller", f"{service.name}Client"
        module = f"{package.package}.{service.module}_marshaller"
        found[marshaller] = f"{module}:{identifier(marshaller)}"
        found[client] = f"{package.package}.{client}:{identifier(client)}"
    return found


def _untransferable(package: TecsPackage, side: IdlSide) -> Iterator[Diagnostic]:
    """What OpaqueRPC cannot carry, of functions that IDL can have."""
    for service in package.services:
        kept = [f for f in service.signature.functions if f.span not in side.refused]
        signature = replace(service.signature, functions=tuple(kept))
        for problem in problems(package.unit, signature):
            yield NOT_TRANSFERRED.at(problem.span, problem.reason, hint=problem.hint)


class _Writer:
    def __init__(self, package: TecsPackage, side: IdlSide, options: Options) -> None:
        self._package = package
        self._side = side
        self._version = options.version
        self._options = replace(
            _options(options, package.package), external={FILE: "...."}
        )
        self._sources = [(s.key, s.sha256) for s in package.sources]
        self._header = header_comment(options.version, self._sources)

    def artifacts(self) -> Iterator[Artifact]:
        package, side = self._package, self._side
        clients = {
            f"{s.name}Client": _profile_name(package, s.name) for s in package.services
        }
        own = {f"{s.name}Marshaller": None for s in package.services}
        yield from _through_idl(
            side.model, self._options, package.sources, {**clients, **own}
        )
        for idl in side.services:
            yield self._artifact(idl.file, self._idl(idl))
        yield from self._modules()
        for join in package.joins:
            text = communication_conf(package, join, self._version)
            yield self._artifact(f"{join.instance}.conf", text)
        yield self._artifact("RTCPlugin.rb", tecsgen_plugin(package, self._version))
        for name, text in build_scripts(package, self._version).items():
            yield self._artifact(name, text)

    def _artifact(self, name: str, text: str) -> Artifact:
        return Artifact(f"{self._package.folder}/{name}", text, self._package.origin)

    def _idl(self, idl: IdlService) -> str:
        """The interface, after what it needs; what other files have, too, is guarded."""

        def guard(declaration: Declaration) -> str:
            if declaration.name not in self._side.shared:
                return ""
            return "_".join(("RTGEN", self._package.stem, *declaration.name, "IDL"))

        head = "".join(f"// {line}\n" for line in header(self._version, self._sources))
        macro = f"{self._package.stem}_{idl.service.name}_IDL".upper()
        body = idl_text(
            self._side.model, idl.declarations, annotations=False, guard=guard
        )
        return (
            f"{head}\n#ifndef {macro}\n#define {macro}\n\n{body}\n#endif // {macro}\n"
        )

    def _modules(self) -> Iterator[Artifact]:
        package = self._package
        names = PythonNames(self._side.model, package.package)
        unit = package.unit
        signatures = [service.signature for service in package.services]
        records: dict[tuple[str, ...], Record] = {}
        for idl in self._side.services:
            signature = idl.service.signature
            layout = layout_of(unit, signature)
            records.update((r.struct.name, r) for r in layout.records)
            codec = codec_text(unit, signature, self._header)
            yield self._artifact(f"{codec_module(signature)}.py", codec)
            text = ServiceText(idl.service, layout, self._header)
            stem = idl.service.module
            marshaller = marshaller_module(text, self._side.model, names, idl)
            yield self._artifact(f"{stem}_marshaller.py", marshaller)
            yield self._artifact(f"{stem}_server.py", server_module(text))
        if records or any(isinstance(d, TecsConst) for d in unit.declarations):
            types = types_text(unit, signatures, self._header)
            yield self._artifact("_types.py", types)
        if records:
            structs = list(records.values())
            views = views_module(self._side, names, structs, self._header)
            yield self._artifact("_views.py", views)


def _profile_name(package: TecsPackage, name: str) -> str:
    first = package.services[0].name == name
    return "RTC.xml" if first else f"{name}.RTC.xml"


def _through_idl(
    model: Model,
    options: Options,
    sources: Sequence[SourceFile],
    components: dict[str, str | None],
) -> Iterator[Artifact]:
    """What the back ends for IDL make of a model.

    `components` are those to be made, with the place of their profile in the package for those
    that are the user's to complete.
    """
    origin = tuple(source.key for source in sources)
    folder = options.folder
    inner = model
    if options.external:
        inner = replace(
            model,
            files=tuple(f for f in model.files if f.name not in options.external),
            declarations=tuple(
                d for d in model.declarations if d.file not in options.external
            ),
        )
    made = [*TYPES.emit(inner, options).artifacts]
    for backend in (COMPONENTS, rtc_profile.BACKEND):
        made += backend.emit(model, options).artifacts
    profiles = {
        f"{folder}/components/{module_name(name)}/RTC.xml": f"{folder}/{profile}"
        for name, profile in components.items()
        if profile is not None
    }
    skeletons = {
        f"{module_name(name)}.py": f"{folder}/{name}.py"
        for name, profile in components.items()
        if profile is not None
    }
    for artifact in made:
        if artifact.path.endswith("entry_points.txt"):
            continue
        path = profiles.get(artifact.path, artifact.path)
        if artifact.owner is Owner.USER:
            if artifact.path not in skeletons:
                continue
            yield replace(
                artifact, path=skeletons[artifact.path], origin=origin, in_output=True
            )
            continue
        yield replace(artifact, path=path, origin=origin)


def _entry_points(
    entries: dict[str, str], options: Options, sources: Sequence[SourceFile]
) -> Artifact:
    listed = [(s.key, s.sha256) for s in sources]
    text = render(
        "tecs/entry_points.txt.j2",
        header=header_comment(options.version, listed),
        entries=sorted(entries.items()),
    )
    origin = tuple(source.key for source in sources)
    return Artifact(f"{ROOT}/entry_points.txt", text, origin)
