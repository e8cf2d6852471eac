"""The files of a project's joins through `RTCPlugin`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.backends.kit.python_module import PythonModule, python_module
from rtgen.compiler.backends.kit.python_text import header, header_comment
from rtgen.compiler.backends.tecs.build_files import (
    build_scripts,
    communication_conf,
    tecsgen_plugin,
)
from rtgen.compiler.backends.tecs.codec import codec_texts
from rtgen.compiler.backends.tecs.marshaller_module import marshaller_module
from rtgen.compiler.backends.tecs.server_module import server_module
from rtgen.compiler.backends.tecs.service_text import ServiceText
from rtgen.compiler.backends.tecs.types_module import types_text
from rtgen.compiler.backends.tecs.views_module import views_module
from rtgen.compiler.lowering.tecs.boards import BoardPackage, boards
from rtgen.compiler.lowering.tecs.idl_model import IdlService
from rtgen.compiler.lowering.tecs.plan import FOLDER, TecsPackage
from rtgen.compiler.model import Component, Declaration, Model, SourceFile
from rtgen.compiler.model.tecs import TecsConst
from rtgen.compiler.typemap.python.idl_names import PythonNames, is_emitted


class TecsBackend:
    """Emits codecs, proxies, servers, and files for tecsgen for the package of a CDL file."""

    name = "tecs"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all packages; none if there are errors."""
        found = list(boards(model))
        if not found:
            return Emission()
        [shared] = (p for p in model.packages if p.name == FOLDER)
        inside = options.inside(shared)
        artifacts: list[Artifact] = []
        if not any(
            is_emitted(d) or isinstance(d, Component) for d in model.declarations
        ):
            title = "Code generated from CDL files."
            artifacts.append(_package(options, title, shared.sources))
            typed = f"{options.folder}/py.typed"
            artifacts.append(Artifact(typed, "", artifacts[0].origin))
        title = "TECS boards, a package for each CDL file."
        artifacts.append(_package(inside, title, shared.sources))
        for board in found:
            writer = _Writer(board, options.inside(board))
            artifacts += writer.artifacts([other.plan for other in found])
        return Emission(artifacts)


BACKEND = TecsBackend()


def _package(
    options: Options, title: str, sources: Sequence[SourceFile]
) -> PythonModule:
    """The module of a package that contains only packages."""
    return python_module(
        f"{options.folder}/__init__.py",
        options,
        (source.key for source in sources),
        title,
        plain=True,
    )


class _Writer:
    def __init__(self, board: BoardPackage, options: Options) -> None:
        self._package = board.plan
        self._layouts = board.layouts
        self._side = board.side
        self.options = options
        self._sources = [source.key for source in board.sources]
        self._header = header_comment(options.version, self._sources)

    def artifacts(self, packages: Sequence[TecsPackage]) -> Iterator[Artifact]:
        """The files of the package, one of `packages`."""
        package, side = self._package, self._side
        for idl in side.services:
            yield self._artifact(idl.file, self._idl(idl))
        yield from self._modules()
        for join in package.joins:
            text = communication_conf(package, join, self.options.version)
            yield self._artifact(f"{join.instance}.conf", text)
        plugin = tecsgen_plugin(package, packages, self.options.version)
        yield self._artifact("RTCPlugin.rb", plugin)
        if self.options.corba:
            for name, text in build_scripts(package, self.options).items():
                yield self._artifact(name, text)

    def _artifact(self, name: str, text: str) -> Artifact:
        return Artifact(f"{self.options.folder}/{name}", text, self._package.origin)

    def _idl(self, idl: IdlService) -> str:
        """The interface after its types; declarations shared by several files are guarded."""

        def guard(declaration: Declaration) -> str:
            if declaration.name not in self._side.shared:
                return ""
            parts = ("RTGEN", self._package.stem, *declaration.name, "IDL")
            return _ascii("_".join(parts))

        head = "".join(
            f"// {line}\n" for line in header(self.options.version, self._sources)
        )
        macro = _ascii(f"{self._package.stem}_{idl.service.name}_IDL").upper()
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
            service = ServiceText(idl.service, layout, self.options.package)
            yield marshaller_module(
                service, self._side.model, names, idl, self.options, package.origin
            )
            yield server_module(service, self.options, package.origin)
        if records or any(isinstance(d, TecsConst) for d in unit.declarations):
            types = types_text(unit, layouts, self._header)
            yield self._artifact("_types.py", types)
        if records:
            structs = list(records.values())
            yield views_module(self._side, names, structs, self.options, package.origin)


def _ascii(name: str) -> str:
    """Return a name for the preprocessor, which knows ASCII alone."""
    return "".join(c if c.isascii() else f"U{ord(c):04X}" for c in name)
