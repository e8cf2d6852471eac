"""Model to artifacts: implementation modules, packages, `py.typed`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import msgspec

from rtgen.compiler.backends import Artifact, Emission, Options, Part, parts
from rtgen.compiler.backends.kit.python_module import (
    PythonModule,
    composed,
    python_module,
)
from rtgen.compiler.backends.types.calls import Calls
from rtgen.compiler.backends.types.module import TypesModule
from rtgen.compiler.backends.types.packages import Package, package_body, packages
from rtgen.compiler.backends.types.rules import LONG_NAME, NOT_IN_XCDR, NOT_MARSHALLED
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
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
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.typemap.python.idl_names import (
    PythonNames,
    is_emitted,
    package_path,
)

_MAX_NAME_LENGTH = 120

_TYPED = "py.typed"


class TypesBackend(msgspec.Struct, frozen=True):
    """Emits the Python package of the data types and interfaces."""

    name: str = "types"

    def emit(self, model: Model, options: Options) -> Emission:
        """All modules and packages; only diagnostics if there are errors."""
        artifacts: list[Artifact] = []
        findings: list[Diagnostic] = []
        for part in parts(model, options):
            emission = self._emit(part)
            findings += emission.diagnostics
            artifacts += emission.artifacts
        return Emission(tuple(artifacts), tuple(findings))

    def _emit(self, part: Part) -> Emission:
        model, options = part.model, part.options
        if not any(is_emitted(d) or isinstance(d, Component) for d in part.own):
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
        writer = _Writer(part, calls, names, types, representations)
        return Emission(tuple(writer.artifacts()))


BACKEND = TypesBackend()


class _Writer:
    def __init__(
        self,
        part: Part,
        calls: Calls,
        names: PythonNames,
        types: CdrTypes,
        representations: Representations,
    ) -> None:
        self._part = part
        self._model = part.model
        self._representations = representations
        self._calls = calls
        self._names = names
        self._types = types
        self._options = part.options
        scopes: set[ScopedName] = {()}
        for declaration in part.model.declarations:
            scope = declaration.name[:-1]
            while scope not in scopes:
                scopes.add(scope)
                scope = scope[:-1]
        self._packages = {
            ".".join((names.package, *package_path(scope))) for scope in scopes
        }

    def artifacts(self) -> Iterator[Artifact]:
        """Yield the packages, then the implementation modules."""
        codecs: set[ScopedName] = set()
        modules: dict[str, PythonModule] = {}
        of_calls = {self._names.module(file) for file in self._calls.origins}
        for module in self._names.modules:
            if module in of_calls:
                continue
            made, defined = self._module(module)
            codecs |= defined
            if made is not None:
                modules[made.path] = made
        for file in self._calls.origins:
            if (made := self._calls_module(file)) is not None:
                modules[made.path] = made
        types = [d for d in self._part.own if is_emitted(d)]
        everything = self._sources(d.file for d in types or self._part.own)
        for package in packages(self._model, self._names, codecs):
            made = self._package(package, everything)
            yield composed([*filter(None, [modules.pop(made.path, None)]), made])
        folder = f"{self._options.folder}/_idl"
        if any(path.startswith(f"{folder}/") for path in modules):
            title = "One module for each IDL file."
            path = f"{folder}/__init__.py"
            origin = self._origin(everything)
            yield python_module(path, self._options, origin, title, plain=True)
        # The marker of the project's package applies to those inside (PEP 561).
        if self._part.origin is None:
            keys = tuple(dict.fromkeys(file.key for file in everything))
            yield Artifact(f"{self._options.folder}/{_TYPED}", "", keys)
        yield from modules.values()

    def _module(self, module: str) -> tuple[PythonModule | None, set[ScopedName]]:
        """Return a module of types, and the typedefs with codecs in it; None without types."""
        declarations = self._names.declarations(module)
        files = self._sources({d.file for d in declarations})
        builder = self._builder(module)
        if files[0].package:
            return None, {
                d.name
                for d in declarations
                if isinstance(d, Typedef) and builder.has_codec(d)
            }
        body = builder.body()
        made = python_module(
            self._path(self._names.home(module)),
            self._options,
            self._origin(files),
            f"Types of `{_keys(files)}`.",
            imports=builder.scope.imports(),
            body=body,
            defines=builder.scope.defined,
            pragmas=builder.pragmas,
        )
        return made, builder.codecs

    def _calls_module(self, file: str) -> PythonModule | None:
        files = self._sources([self._calls.origins[file]])
        if files[0].package:
            return None
        module = self._names.module(file)
        builder = self._builder(module)
        body = builder.body(self._calls.interfaces(file))
        return python_module(
            self._path(self._names.home(module)),
            self._options,
            self._origin(files),
            f"Calls of the interfaces of `{_keys(files)}`, marshalled.",
            imports=builder.scope.imports(),
            body=body,
            pragmas=builder.pragmas,
        )

    def _builder(self, module: str) -> TypesModule:
        return TypesModule(
            self._calls, self._names, self._types, self._representations, module
        )

    def _package(self, package: Package, everything: list[SourceFile]) -> PythonModule:
        files = self._sources(package.files) or everything
        path = f"{package.name.replace('.', '/')}/__init__.py"
        imports, body = package_body(package, self._options, path)
        return python_module(
            path,
            self._options,
            self._origin(files),
            package.title,
            imports=imports,
            body=body,
            plain=True,
        )

    def _path(self, home: str) -> str:
        """Return the file of a module; that of a package is its `__init__.py`."""
        path = home.replace(".", "/")
        return f"{path}/__init__.py" if home in self._packages else f"{path}.py"

    def _sources(self, names: Iterable[str]) -> list[SourceFile]:
        """The files, and those included in their declarations, in the order of the model."""
        selected = set(names)
        return [
            file
            for file in self._model.files
            if file.name in selected or file.belongs_to in selected
        ]

    def _origin(self, files: list[SourceFile]) -> Sequence[str]:
        return self._part.origin or [file.key for file in files]


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
        if scope and len(scope[-1]) > _MAX_NAME_LENGTH:
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
        if isinstance(model.declared(entry.type), Struct):
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
