"""The packages with the names of IDL modules, one for each.

A package re-exports the names of implementation modules, besides those that it defines itself.
"""

from __future__ import annotations

from itertools import chain

import msgspec

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.python_module import (
    Import,
    import_blocks,
    relative_name,
)
from rtgen.compiler.backends.kit.python_text import tuple_of
from rtgen.compiler.backends.kit.quoting.python import string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model import Declaration, Enum, Interface, Model, ScopedName
from rtgen.compiler.typemap.python.idl_names import (
    PythonNames,
    is_emitted,
    package_path,
)

_LAZY = Import("rtgen.runtime.lazy", "lazy_names", "lazy_names")
_CHECKING = Import("typing", "TYPE_CHECKING", "TYPE_CHECKING")


class Package(msgspec.Struct):
    """The names that an IDL module exports, and the files that declare them.

    `name` is the absolute name of its package. `imports` are re-exported names, `aliases`
    (public, local) names that the package itself defines, `enumerators` the values of exported
    enums.
    """

    scope: ScopedName
    name: str
    files: list[str] = []
    imports: list[Import] = []
    aliases: list[tuple[str, str]] = []
    enumerators: list[tuple[str, str, str]] = []
    defines: bool = False

    @property
    def title(self) -> str:
        """The docstring."""
        scoped = "::".join(self.scope)
        if scoped:
            return f"The IDL module `{scoped}`."
        return "Definitions in the global scope of IDL."

    def add(self, module: str, local: str, public: str) -> None:
        if module != self.name:
            self.imports.append(Import(module, local, public, exported=True))
            return
        self.defines = True
        if local != public:
            self.aliases.append((public, local))


def packages(
    model: Model, names: PythonNames, codecs: set[ScopedName]
) -> list[Package]:
    """The packages in order of first declaration; the root package first."""
    files = {file.name: file for file in model.files}
    packages_of: dict[ScopedName, Package] = {(): Package((), names.package)}
    for declaration in model.declarations:
        scope = declaration.name[:-1]
        exported = files[declaration.file].exported and is_emitted(declaration)
        if not exported or names.is_nested(declaration.name):
            continue
        known = len(scope)
        while scope[:known] not in packages_of:
            known -= 1
        for depth in range(known + 1, len(scope) + 1):
            inner = scope[:depth]
            name = ".".join((names.package, *package_path(inner)))
            packages_of[inner] = Package(inner, name)
        _fill(packages_of[scope], names, declaration, declaration.name in codecs)
    return list(packages_of.values())


def _fill(
    package: Package, names: PythonNames, declaration: Declaration, codec: bool
) -> None:
    name = declaration.name
    module, local = names.implementation(name)
    public = names.attribute(name)
    if declaration.file not in package.files:
        package.files.append(declaration.file)
    package.add(module, local, public)
    suffixes = ["Stub", "Skeleton"] if isinstance(declaration, Interface) else []
    for suffix in suffixes + ["Codec"] * codec:
        package.add(
            module, names.companion(name, suffix), names.public_companion(name, suffix)
        )
    if isinstance(declaration, Enum):
        for member, attribute in names.enumerators(declaration).items():
            exported_name = names.attribute((*name[:-1], member))
            package.enumerators.append((exported_name, public, attribute))


def package_body(
    package: Package, options: Options, path: str
) -> tuple[list[Import], str]:
    """Return the imports and statements of its `__init__.py`.

    With `options.lazy`, and if it has definitions, names of other modules are imported
    on demand, since a module that the package imports may import the package.
    """
    lazy = bool(package.imports) and (options.lazy or package.defines)
    imported = {each.local for each in package.imports}
    names = imported.union(exported_name for exported_name, _, _ in package.enumerators)
    final = "_Final" if "Final" in names else "Final"
    constants = [
        f"{exported_name}: {final} = {enum}.{member}"
        for exported_name, enum, member in package.enumerators
        if not (lazy and enum in imported)
    ]
    imports = [Import("typing", "Final", final)] * bool(constants)
    imports += [_CHECKING, _LAZY] if lazy else package.imports
    listed = ", ".join(map(string_literal, sorted(names)))
    exported = f"__all__ = [{listed}]" if names and not package.defines else ""
    blocks = [
        "\n".join(f"{public} = {local}" for public, local in package.aliases),
        "\n".join(constants),
        _lazy(package, options, path, exported) if lazy else exported,
    ]
    return imports, "\n\n".join(filter(None, blocks))


def _lazy(package: Package, options: Options, path: str, exported: str) -> str:
    """Return the statements that import names of other modules on demand."""
    homes: dict[str, list[str]] = {}
    for each in sorted(package.imports):
        renamed = f" as {each.local}" * (each.name != each.local)
        homes.setdefault(each.module, []).append(f"{each.name}{renamed}")
    enums = {each.local: each for each in package.imports}
    constants = []
    for exported_name, enum, member in package.enumerators:
        if enum in enums:
            entries = homes[enums[enum].module]
            entries.append(f"{enums[enum].name}.{member} as {exported_name}")
            constants.append(f"{exported_name} = {enum}.{member}")
    type_checking_imports = (
        Import(each.module, each.name, each.local, exported=package.defines)
        for each in package.imports
    )
    return render(
        "types/lazy_names.py.j2",
        imports=list(
            chain(*import_blocks(type_checking_imports, options.package, path))
        ),
        constants=constants,
        homes=", ".join(
            f"{string_literal(relative_name(module, options.package, path))}: "
            f"{tuple_of([*map(string_literal, names)]).flat}"
            for module, names in homes.items()
        ),
        exported=exported,
    ).rstrip("\n")
