"""Writes `typescript/`: a module for each scope of IDL, and the codecs that they share.

`_idl/FILE.ts` has the declarations of an IDL file, `A/B.ts` those in the scope `A::B`, `index.ts`
those in the global scope, `_cdr.ts` the codecs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib.resources import files

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.kit.python_text import header
from rtgen.compiler.backends.kit.quoting.typescript import TypeScript, line_comment
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.typescript.module import TypesModule
from rtgen.compiler.backends.typescript.rules import NOT_IN_TYPESCRIPT
from rtgen.compiler.backends.typescript.types import Types, identifier
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    Bitmask,
    Const,
    Declaration,
    Enum,
    ExceptionDecl,
    Model,
    NamedType,
    ScopedName,
    Struct,
    Typedef,
    Union,
)
from rtgen.compiler.typemap.python.idl_names import PythonNames

ROOT = "typescript"
"""The folder of the modules, below the output folder."""
_RUNTIME = "_cdr.ts"
_TYPES = Struct | Union | ExceptionDecl | Enum | Bitmask | Typedef


class TypescriptBackend:
    """Generates the types of a project for a browser."""

    name = "typescript"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return all modules; declarations without a TypeScript codec are reported and omitted."""
        xcdr2 = options.representation == "xcdr2"
        representations = Representations(model, xcdr2, options.extensibility)
        types = Types(model, representations)
        diagnostics: list[Diagnostic] = []
        declarations: list[Declaration] = []
        for declaration in model.declarations:
            if isinstance(declaration, Const):
                if _has_literal(model, declaration):
                    declarations.append(declaration)
            elif isinstance(declaration, _TYPES):
                what = types.missing(declaration)
                if what is None:
                    declarations.append(declaration)
                else:
                    message = f"`{declaration.scoped}` is left out: {what} has no codec"
                    diagnostics.append(NOT_IN_TYPESCRIPT.at(declaration.span, message))
        if not declarations:
            return Emission((), diagnostics)
        tree = _Tree(model, types, declarations, options)
        return Emission(tuple(tree.artifacts()), diagnostics)


BACKEND = TypescriptBackend()


def _has_literal(model: Model, constant: Const) -> bool:
    """Return whether a constant is a number, text or boolean, or a known enumerator."""
    type_ = constant.type
    if isinstance(type_, NamedType):
        return isinstance(model.find(type_.name), Typedef | Enum)
    return True


class _Tree:
    def __init__(
        self,
        model: Model,
        types: Types,
        declarations: list[Declaration],
        options: Options,
    ) -> None:
        self._model = model
        self._types = types
        self._declarations = declarations
        self._version = options.version
        self._keys = {file.name: file.key for file in model.files}
        names = PythonNames(model, options.package)
        self._places = {d.name: names.module(d.file) for d in declarations}

    def artifacts(self) -> Iterator[Artifact]:
        by_module: dict[str, list[Declaration]] = {}
        by_scope: dict[ScopedName, list[Declaration]] = {}
        for each in self._declarations:
            by_module.setdefault(self._places[each.name], []).append(each)
            by_scope.setdefault(each.name[:-1], []).append(each)
        runtime = files("rtgen") / "templates" / ROOT / _RUNTIME
        text = runtime.read_text(encoding="utf-8")
        yield self._artifact(_RUNTIME, text, self._declarations)
        for scope, declarations in sorted(by_scope.items()):
            path = "/".join(scope or ("index",)) + ".ts"
            yield self._artifact(path, self._scope(scope, declarations), declarations)
        for module, declarations in by_module.items():
            builder = TypesModule(self._model, self._types, self._places, module)
            text = builder.text(self._header(declarations), declarations)
            yield self._artifact(f"_idl/{module}.ts", text, declarations)

    def _scope(self, scope: ScopedName, declarations: list[Declaration]) -> str:
        """Return the module with a scope's declarations under their own names."""
        exported: dict[str, list[tuple[str, str]]] = {}
        for each in declarations:
            names = [each.name]
            if isinstance(each, Bitmask):
                names += ((*each.name, member.name) for member in each.members)
            exported.setdefault(self._places[each.name], []).extend(
                (identifier(name), "$".join(name[len(scope) :])) for name in names
            )
        return render(
            "typescript/scope.ts.j2",
            header=self._header(declarations),
            up="../" * max(len(scope) - 1, 0) or "./",
            exported=exported.items(),
        )

    def _header(self, declarations: Iterable[Declaration]) -> TypeScript:
        return line_comment(header(self._version, self._origin(declarations)))

    def _origin(self, declarations: Iterable[Declaration]) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self._keys[d.file] for d in declarations))

    def _artifact(
        self, path: str, text: str, declarations: Iterable[Declaration]
    ) -> Artifact:
        return Artifact(f"{ROOT}/{path}", text, self._origin(declarations))
