"""Which files the joins of a project through `RTCPlugin` give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from rtgen.backends import Artifact, Emission, Options, Owner, rtc_profile
from rtgen.backends.components.checks import check
from rtgen.backends.components.skeleton import skeleton_module
from rtgen.backends.idl_text import idl_text
from rtgen.backends.python_text import header, header_comment
from rtgen.backends.quoting.python import docstring
from rtgen.backends.rendering import render
from rtgen.backends.tecs.build_files import (
    build_scripts,
    communication_conf,
    tecsgen_plugin,
)
from rtgen.backends.tecs.codec import codec_texts
from rtgen.backends.tecs.communication import (
    FACTORY,
    FILE,
    RUNTIME,
    communication_model,
)
from rtgen.backends.tecs.idl_model import IdlService, IdlSide, idl_side
from rtgen.backends.tecs.marshaller_module import marshaller_module
from rtgen.backends.tecs.plan import FOLDER, Service, TecsPackage, packages
from rtgen.backends.tecs.rtc_text import client_module
from rtgen.backends.tecs.rules import NOT_TRANSFERRED
from rtgen.backends.tecs.server_module import server_module
from rtgen.backends.tecs.service_text import ServiceText
from rtgen.backends.tecs.types_module import types_text
from rtgen.backends.tecs.views_module import views_module
from rtgen.backends.types import BACKEND as TYPES
from rtgen.diagnostics import Diagnostic, has_errors
from rtgen.facts import opaque_rpc as facts
from rtgen.layouts.tdr import SignatureLayout, TransferError
from rtgen.layouts.tdr_messages import layout_of, problems
from rtgen.model import Component, Declaration, Model, SourceFile
from rtgen.model.tecs import TecsConst
from rtgen.typemap.idl_python import PythonNames, is_emitted
from rtgen.typemap.python_names import identifier, module_name


class TecsBackend:
    """Makes a package for each CDL file with a join through `RTCPlugin`, and what they share."""

    name = "tecs"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all packages; none where anything has errors."""
        tecs, findings = _read(model)
        if tecs is None or has_errors(findings):
            return Emission((), findings)
        sources = tecs.sources
        shared = _options(options, FOLDER)
        artifacts: list[Artifact] = []
        if not any(
            is_emitted(d) or isinstance(d, Component) for d in model.declarations
        ):
            artifacts += _package(options, "What is made of CDL files.", sources)
        title = "TECS boards, a package for each CDL file."
        artifacts += _package(shared, title, sources)
        entries = {facts.COMPONENT: FACTORY}
        skeletons: dict[str, Artifact] = {}
        for package, side, layouts in tecs.sides:
            writer = _Writer(package, side, layouts, options)
            artifacts += writer.artifacts([other for other, _, _ in tecs.sides])
            for skeleton in writer.skeletons():
                skeletons.setdefault(skeleton.path, skeleton)
            entries = {**_entries(package, writer.options), **entries}
        artifacts.append(_entry_points(entries, shared, sources))
        artifacts += skeletons.values()
        return Emission(artifacts, findings)


BACKEND = TecsBackend()


def _package(
    options: Options, title: str, sources: Sequence[SourceFile]
) -> Iterator[Artifact]:
    """A package that has nothing but others."""
    origin = tuple(source.key for source in sources)
    header = header_comment(options.version, origin)
    text = f"{header}{docstring(title, 0)}"
    yield Artifact(f"{options.folder}/__init__.py", text, origin)
    yield Artifact(f"{options.folder}/py.typed", "", origin)


@dataclass(frozen=True, slots=True)
class RtcPackage:
    """The RTCs of a package and their IDL as a model; `factories` has `module:name` by type.

    `external` maps the displayed path of a file whose conversions another package has to that
    one, `types` that of a file whose types another package has.
    """

    model: Model
    options: Options
    factories: Mapping[str, str]
    external: Mapping[str, str]
    types: Mapping[str, str]


def rtc_packages(model: Model, options: Options) -> list[RtcPackage]:
    """The packages with RTCs that `emit` makes; none where anything has errors."""
    tecs, findings = _read(model)
    if tecs is None or has_errors(findings):
        return []
    shared = _options(options, FOLDER)
    types = {FILE: RUNTIME}
    found = [RtcPackage(tecs.communication, shared, {}, {}, types)]
    external = {FILE: shared.package}
    for package, side, _ in tecs.sides:
        own = _options(options, package.name)
        entries = _entries(package, own)
        found.append(RtcPackage(side.model, own, entries, external, types))
    return found


@dataclass(frozen=True, slots=True)
class _Tecs:
    """The packages of a project, each with its IDL side, and what they share."""

    sources: tuple[SourceFile, ...]
    communication: Model
    sides: tuple[tuple[TecsPackage, IdlSide, list[SignatureLayout]], ...]


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
        layouts, untransferable = _layouts(package, side)
        findings += [*found, *untransferable]
        sides.append((package, side, layouts))
        if not has_errors(findings):
            findings += check(side.model)
    return _Tecs(sources, communication, tuple(sides)), findings


def _options(options: Options, name: str, *, anys: bool = False) -> Options:
    """The options for the IDL of a package below the project's own.

    Only CORBA and `any` marshal its values.
    """
    return replace(
        options,
        package=f"{options.package}.{name}",
        lazy=True,
        marshalled=anys or options.tecs_corba or options.target == "openrtm",
    )


def _entries(package: TecsPackage, options: Options) -> dict[str, str]:
    """The factories of a package's components; `options` are those of the package."""
    found = {}
    for service in package.services:
        marshaller, client = f"{service.name}Marshaller", f"{service.name}Client"
        module = f"{options.package}.{service.module}_marshaller"
        found[marshaller] = f"{module}:{identifier(marshaller)}"
        module = f"{options.skeleton_prefix}{module_name(client)}"
        found[client] = f"{module}:{identifier(client)}"
    return found


def _layouts(
    package: TecsPackage, side: IdlSide
) -> tuple[list[SignatureLayout], list[Diagnostic]]:
    """The layouts of all signatures; and what OpaqueRPC cannot carry, though IDL can."""
    layouts = []
    found = []
    for service in package.services:
        signature = service.signature
        try:
            layouts.append(layout_of(package.unit, signature))
        except TransferError:
            kept = [f for f in signature.functions if f.span not in side.refused]
            sound = replace(signature, functions=tuple(kept))
            for p in problems(package.unit, sound):
                found.append(NOT_TRANSFERRED.at(p.span, p.reason, hint=p.hint))
    return layouts, found


class _Writer:
    def __init__(
        self,
        package: TecsPackage,
        side: IdlSide,
        layouts: Sequence[SignatureLayout],
        options: Options,
    ) -> None:
        self._package = package
        self._layouts = layouts
        self._side = side
        anys = any(s.options.array == "any" for s in package.services)
        self.options = replace(
            _options(options, package.name, anys=anys), external={FILE: RUNTIME}
        )
        self._sources = [source.key for source in package.sources]
        self._header = header_comment(options.version, self._sources)

    def artifacts(self, packages: Sequence[TecsPackage]) -> Iterator[Artifact]:
        """The files of the package, which is one of these."""
        package, side = self._package, self._side
        yield from _types(side.model, self.options, package.sources)
        for idl in side.services:
            yield self._artifact(idl.file, self._idl(idl))
        yield from self._modules()
        for join in package.joins:
            text = communication_conf(package, join, self.options.version)
            yield self._artifact(f"{join.instance}.conf", text)
        plugin = tecsgen_plugin(package, packages, self.options.version)
        yield self._artifact("RTCPlugin.rb", plugin)
        for name, text in build_scripts(package, self.options).items():
            yield self._artifact(name, text)

    def skeletons(self) -> Iterator[Artifact]:
        """The clients for the user to complete."""
        model, options = self._side.model, self.options
        names = PythonNames(model, options.package)
        for service in self._package.services:
            component = model.find((f"{service.name}Client",))
            assert isinstance(component, Component)
            text = skeleton_module(model, names, component, options)
            path = f"{module_name(component.name[-1])}.py"
            yield Artifact(path, text, self._package.origin, Owner.USER)

    def _artifact(self, name: str, text: str) -> Artifact:
        return Artifact(f"{self.options.folder}/{name}", text, self._package.origin)

    def _idl(self, idl: IdlService) -> str:
        """The interface, after what it needs; what other files have, too, is guarded."""

        def guard(declaration: Declaration) -> str:
            if declaration.name not in self._side.shared:
                return ""
            return "_".join(("RTGEN", self._package.stem, *declaration.name, "IDL"))

        head = "".join(
            f"// {line}\n" for line in header(self.options.version, self._sources)
        )
        macro = f"{self._package.stem}_{idl.service.name}_IDL".upper()
        body = idl_text(
            self._side.model, idl.declarations, annotations=False, guard=guard
        )
        return (
            f"{head}\n#ifndef {macro}\n#define {macro}\n\n{body}\n#endif // {macro}\n"
        )

    def _modules(self) -> Iterator[Artifact]:
        package = self._package
        names = PythonNames(self._side.model, self.options.package)
        unit = package.unit
        layouts = self._layouts
        records = {r.struct.name: r for layout in layouts for r in layout.records}
        orders = [service.options.reply for service in package.services]
        pairs = zip(layouts, orders, strict=True)
        for file, text in codec_texts(unit, pairs, self._header).items():
            yield self._artifact(file, text)
        for idl, layout in zip(self._side.services, layouts, strict=True):
            service = ServiceText(idl.service, layout, self._header)
            stem = idl.service.module
            marshaller = marshaller_module(service, self._side.model, names, idl)
            yield self._artifact(f"{stem}_marshaller.py", marshaller)
            yield self._artifact(f"{stem}_server.py", server_module(service))
            yield from self._rtcs(idl.service, names)
        folder = render("components/components.py.j2", header=self._header)
        yield self._artifact("components/__init__.py", folder)
        if records or any(isinstance(d, TecsConst) for d in unit.declarations):
            types = types_text(unit, layouts, self._header)
            yield self._artifact("_types.py", types)
        if records:
            structs = list(records.values())
            views = views_module(self._side, names, structs, self._header)
            yield self._artifact("_views.py", views)

    def _rtcs(self, service: Service, names: PythonNames) -> Iterator[Artifact]:
        """The client's base, and the profiles of both RTCs."""
        model, options = self._side.model, self.options
        for kind in ("Marshaller", "Client"):
            name = f"{service.name}{kind}"
            component = model.find((name,))
            assert isinstance(component, Component)
            folder = f"components/{module_name(name)}"
            profile = rtc_profile.profile_text(model, component, options)
            if kind == "Marshaller":
                yield self._artifact(f"{folder}/RTC.xml", profile)
                continue
            base = client_module(component, model, names, self._header)
            yield self._artifact(f"{folder}/__init__.py", base)
            place = _profile_name(self._package, service.name)
            yield self._artifact(place, profile)


def _profile_name(package: TecsPackage, name: str) -> str:
    first = package.services[0].name == name
    return "RTC.xml" if first else f"{name}.RTC.xml"


def _types(
    model: Model, options: Options, sources: Sequence[SourceFile]
) -> Iterator[Artifact]:
    """The Python package of a model's types and interfaces."""
    origin = tuple(source.key for source in sources)
    inner = replace(
        model,
        files=tuple(f for f in model.files if f.name not in options.external),
        declarations=tuple(
            d for d in model.declarations if d.file not in options.external
        ),
    )
    for artifact in TYPES.emit(inner, options).artifacts:
        yield replace(artifact, origin=origin)


def _entry_points(
    entries: dict[str, str], options: Options, sources: Sequence[SourceFile]
) -> Artifact:
    origin = tuple(source.key for source in sources)
    text = render(
        "tecs/entry_points.txt.j2",
        header=header_comment(options.version, origin),
        entries=sorted(entries.items()),
    )
    return Artifact(f"{options.folder}/entry_points.txt", text, origin)
