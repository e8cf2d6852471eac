"""Prints the modules `_corba/<module>.py`: conversions of values, servants and stubs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rtgen.backends import Artifact
from rtgen.backends.kit.python_text import fit_text, header_comment
from rtgen.backends.kit.quoting.python import docstring
from rtgen.backends.kit.rendering import render
from rtgen.backends.openrtm.classic import Classic
from rtgen.backends.openrtm.conversion_code import ConversionCode
from rtgen.backends.openrtm.plan import IdlFile, Unit
from rtgen.backends.openrtm.wire_names import CORBA_PACKAGE, WireNames
from rtgen.backends.openrtm.wire_scope import WireScope
from rtgen.backends.openrtm.wire_services import WireServices
from rtgen.model import (
    Declaration,
    ExceptionDecl,
    Interface,
    SourceFile,
    Struct,
    Union,
)

_CONVERTED = (Struct, Union, ExceptionDecl)


def conversions(unit: Unit) -> Iterator[Artifact]:
    """Yield the conversions of all types supported by classic IDL, a module for each IDL file."""
    names = WireNames(unit)
    classic = Classic(unit.model)
    modules = []
    for file in unit.idl_files:
        if file.files[0] in unit.external:
            continue
        wanted = [
            declaration
            for declaration in names.python.declarations(file.module)
            if isinstance(declaration, (*_CONVERTED, Interface))
            and not classic.reason(declaration.name)
        ]
        if wanted:
            modules.append(_Module(unit, names, classic, file, wanted).artifact())
    if modules:
        yield _package(unit, modules)
        yield from modules


def _package(unit: Unit, modules: Iterable[Artifact]) -> Artifact:
    keys = tuple(dict.fromkeys(key for module in modules for key in module.origin))
    sources = [file for file in unit.model.files if file.key in keys]
    text = _header(unit, sources) + docstring("Conversions to omniORB's objects.", 0)
    path = f"{unit.options.folder}/{CORBA_PACKAGE}/__init__.py"
    return Artifact(path, text, keys)


def _header(unit: Unit, sources: Iterable[SourceFile]) -> str:
    return header_comment(unit.options.version, (file.key for file in sources))


class _Module:
    """A module of conversions."""

    def __init__(
        self,
        unit: Unit,
        names: WireNames,
        classic: Classic,
        file: IdlFile,
        declarations: Sequence[Declaration],
    ) -> None:
        self._unit = unit
        self._names = names
        self._file = file
        self._declarations = declarations
        self._scope = WireScope(
            unit, names, file.module, self._defined(), self._parameters()
        )
        self._code = ConversionCode(unit.model, names, classic, self._scope)
        self._services = WireServices(unit.model, names, self._scope, self._code)

    def artifact(self) -> Artifact:
        """Return the file of the module."""
        sources = [f for f in self._unit.model.files if f.name in self._file.files]
        keys = tuple(dict.fromkeys(file.key for file in sources))
        blocks = [self._block(declaration) for declaration in self._declarations]
        title = f"Types of `{', '.join(keys)}` as omniORB's objects, and back."
        text = render(
            "openrtm/conversions.py.j2",
            header=_header(self._unit, sources),
            docstring=docstring(title, 0),
            imports=self._scope.import_lines(),
            constants=self._scope.constant_lines(),
            blocks="\n\n".join(blocks),
        )
        folder = f"{self._unit.options.folder}/{CORBA_PACKAGE}"
        path = f"{folder}/{self._file.module}.py"
        return Artifact(path, fit_text(text), keys)

    def _block(self, declaration: Declaration) -> str:
        if isinstance(declaration, Interface):
            return self._services.text(declaration)
        assert isinstance(declaration, _CONVERTED)
        scope, code = self._scope, self._code
        if isinstance(declaration, ExceptionDecl):
            fill: list[str] = []
        else:
            fill = code.fill(declaration)
        return render(
            "openrtm/conversion.py.j2",
            any=scope.helper("Any", "typing"),
            known=self._names.conversions(declaration),
            scoped=declaration.scoped,
            type=scope.type(declaration.name),
            record=not isinstance(declaration, ExceptionDecl),
            fill=fill,
            to=code.to(declaration),
            of=code.of(declaration),
        )

    def _defined(self) -> Iterator[str]:
        for declaration in self._declarations:
            known = self._names.conversions(declaration)
            if isinstance(declaration, Interface):
                yield from (known.servant, known.stub, known.objects)
            else:
                yield from (known.to, known.of, known.new, known.fill)

    def _parameters(self) -> Iterator[str]:
        for declaration in self._declarations:
            if isinstance(declaration, Interface):
                for operation in declaration.operations:
                    yield from (parameter.name for parameter in operation.parameters)
