"""Model to artifacts: implementation modules, packages, `py.typed`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.backends import Artifact, Emission, Options, parts
from rtgen.backends.kit.python_text import header_comment
from rtgen.backends.kit.quoting.python import docstring
from rtgen.backends.types.calls import Calls
from rtgen.backends.types.module import TypesModule
from rtgen.backends.types.packages import Package, package_text, packages
from rtgen.backends.types.rules import LONG_NAME, NOT_IN_XCDR, NOT_MARSHALLED
from rtgen.diagnostics import Diagnostic
from rtgen.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.layouts.representations import Representations
from rtgen.model import (
    Case,
    Component,
    Declaration,
    ExceptionDecl,
    Member,
    Model,
    NamedType,
    ScopedName,
    SourceFile,
    Struct,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.typemap.idl_python_names import PythonNames, is_emitted, package_path

_LONGEST_NAME = 120

_TYPED = "py.typed"


@dataclass(frozen=True, slots=True)
class TypesBackend:
    """Emits the Python package of the data types and interfaces."""

    name: str = "types"

    def emit(self, model: Model, options: Options) -> Emission:
        """All modules and packages; only diagnostics if there are errors."""
        artifacts: list[Artifact] = []
        findings: list[Diagnostic] = []
        for part in parts(model, options):
            made = self._emit(part.own, part.options)
            findings += made.diagnostics
            if part.origin is None:
                artifacts += made.artifacts
                continue
            # The marker of the project's package holds for those inside (PEP 561).
            artifacts += (
                replace(each, origin=part.origin)
                for each in made.artifacts
                if not each.path.endswith(f"/{_TYPED}")
            )
        return Emission(tuple(artifacts), tuple(findings))

    def _emit(self, model: Model, options: Options) -> Emission:
        if not any(
            is_emitted(d) or isinstance(d, Component) for d in model.declarations
        ):
            return Emission()
        representations = Representations(
            model, options.representation == "xcdr2", options.extensibility
        )
        calls = Calls(model, representations, options.marshalled)
        names = PythonNames(calls.model, options.package)
        types = CdrTypes(calls.model, representations)
        diagnostics = list(_check(model, types, representations))
        if diagnostics:
            return Emission((), diagnostics)
        writer = _Writer(model, calls, names, types, representations, options)
        return Emission(tuple(writer.artifacts()))


BACKEND = TypesBackend()


class _Writer:
    def __init__(
        self,
        model: Model,
        calls: Calls,
        names: PythonNames,
        types: CdrTypes,
        representations: Representations,
        options: Options,
    ) -> None:
        self._model = model
        self._representations = representations
        self._calls = calls
        self._names = names
        self._types = types
        self._options = options
        self._files = {file.name: file for file in model.files}

    def artifacts(self) -> Iterator[Artifact]:
        root = self._options.folder
        codecs: set[ScopedName] = set()
        modules: list[Artifact] = []
        of_calls = {self._names.module(file) for file in self._calls.origins}
        for module in self._names.modules:
            if module in of_calls:
                continue
            files = self._sources({d.file for d in self._names.declarations(module)})
            builder = TypesModule(
                self._calls, self._names, self._types, self._representations, module
            )
            text = builder.text(self._header(files), f"Types of `{_keys(files)}`.")
            codecs |= builder.codecs
            modules.append(self._artifact(f"{root}/_idl/{module}.py", text, files))
        modules += map(self._calls_module, self._calls.origins)
        everything = self._sources(
            d.file for d in self._model.declarations if is_emitted(d)
        )
        for package in packages(self._model, self._names, codecs):
            yield self._package(root, package, everything)
        inner = self._header(everything) + docstring("One module for each IDL file.", 0)
        yield self._artifact(f"{root}/_idl/__init__.py", inner, everything)
        yield self._artifact(f"{root}/{_TYPED}", "", everything)
        yield from modules

    def _calls_module(self, file: str) -> Artifact:
        files = self._sources([self._calls.origins[file]])
        module = self._names.module(file)
        builder = TypesModule(
            self._calls, self._names, self._types, self._representations, module
        )
        text = builder.text(
            self._header(files),
            f"Calls of the interfaces of `{_keys(files)}`, marshalled.",
            self._calls.interfaces(file),
        )
        return self._artifact(f"{self._options.folder}/_idl/{module}.py", text, files)

    def _package(
        self, root: str, package: Package, everything: list[SourceFile]
    ) -> Artifact:
        files = self._sources(package.files) or everything
        lazy = self._options.lazy and bool(package.imports)
        path = "/".join((root, *package_path(package.scope), "__init__.py"))
        return self._artifact(
            path, package_text(package, self._header(files), lazy), files
        )

    def _sources(self, names: Iterable[str]) -> list[SourceFile]:
        """The files, and those included in their declarations, in the order of the model."""
        wanted = set(names)
        return [
            file
            for file in self._model.files
            if file.name in wanted or file.belongs_to in wanted
        ]

    def _header(self, files: list[SourceFile]) -> str:
        return header_comment(self._options.version, (file.key for file in files))

    def _artifact(self, path: str, text: str, files: list[SourceFile]) -> Artifact:
        return Artifact(path, text, tuple(dict.fromkeys(file.key for file in files)))


def _keys(files: list[SourceFile]) -> str:
    """The keys of the files, for a title, without those of other packages."""
    keys = (file.key for file in files if file.belongs_to is None)
    return ", ".join(dict.fromkeys(keys))


def _check(
    model: Model, types: CdrTypes, representations: Representations
) -> Iterator[Diagnostic]:
    """Report types that cannot be emitted."""
    for scope in dict.fromkeys(
        d.name[:-1] for d in model.declarations if is_emitted(d)
    ):
        if scope and len(scope[-1]) > _LONGEST_NAME:
            declaration = next(d for d in model.declarations if d.name[:-1] == scope)
            message = (
                f"the name of the module `{'::'.join(scope)}` is too long for a folder"
            )
            yield LONG_NAME.at(declaration.span, message)
    for declaration in model.declarations:
        in_xcdr = _is_in_xcdr(types, representations, declaration)
        for entry in _entries(declaration):
            fault = _fault(model, types, declaration, entry)
            if fault is None and in_xcdr:
                fault = _xcdr_fault(representations, entry)
            if fault is not None:
                yield fault


def _entries(declaration: Declaration) -> tuple[Member | Case | ValueBox, ...]:
    """The members of a declaration that are marshalled."""
    match declaration:
        case Struct(members=members) | ExceptionDecl(members=members):
            return members
        case Union(cases=cases):
            return cases
        case Valuetype(custom=False, state=state):
            return state
        case ValueBox():
            return (declaration,)
    return ()


def _fault(
    model: Model,
    types: CdrTypes,
    declaration: Declaration,
    entry: Member | Case | ValueBox,
) -> Diagnostic | None:
    """The diagnostic at a member; None for a struct whose own member has one."""
    name = entry.name if isinstance(entry.name, str) else entry.name[-1]
    optional = isinstance(entry, Member) and entry.optional
    if optional or types.has_headers(entry.type):
        is_aggregate = isinstance(declaration, Struct | Union)
        whole = NamedType(declaration.name) if is_aggregate else entry.type
        if types.is_dynamic(whole) or isinstance(declaration, Valuetype | ValueBox):
            reason = (
                "optional members and mutable types do not go together with `any`,"
                " type codes and values"
            )
            return NOT_MARSHALLED.at(entry.span, f"`{name}`: {reason}")
    try:
        types.check(entry.type)
    except NotMarshalledError as failure:
        type_ = model.unalias(entry.type)
        if isinstance(type_, NamedType) and isinstance(model.find(type_.name), Struct):
            return None
        return NOT_MARSHALLED.at(entry.span, f"`{name}`: {failure}")
    return None


def _is_in_xcdr(
    types: CdrTypes, representations: Representations, declaration: Declaration
) -> bool:
    """Whether `to_cdr` of the declaration returns XCDR."""
    if not isinstance(declaration, Struct | Union):
        return False
    holder = NamedType(declaration.name)
    headers = types.has_headers(holder) and not types.is_dynamic(holder)
    return headers or representations.is_xcdr2(declaration)


def _xcdr_fault(
    representations: Representations, entry: Member | Case | ValueBox
) -> Diagnostic | None:
    """The diagnostic at a member that XCDR cannot represent."""
    missing = representations.missing(entry.type)
    if missing is None:
        return None
    message = f"`{entry.name}`: XCDR has no representation of `{missing}`"
    return NOT_IN_XCDR.at(entry.span, message)
