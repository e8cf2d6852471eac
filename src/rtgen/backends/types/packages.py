"""The packages that re-export what the implementation modules define, one for each IDL module."""

from __future__ import annotations

from dataclasses import dataclass, field

from rtgen.backends.kit.python_text import fit_text
from rtgen.backends.kit.quoting.python import docstring, string_literal
from rtgen.backends.kit.rendering import render
from rtgen.model import (
    Declaration,
    Enum,
    Interface,
    Model,
    ScopedName,
)
from rtgen.typemap.idl_python_names import PythonNames, is_emitted, package_path


@dataclass(slots=True)
class Package:
    """The names that an IDL module exports, and the files that declare them."""

    scope: ScopedName
    files: list[str] = field(default_factory=list)
    imports: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    enumerators: list[tuple[str, str, str]] = field(default_factory=list)

    def add(self, module: str, local: str, public: str) -> None:
        self.imports.setdefault(module, []).append((local, public))


def packages(
    model: Model, names: PythonNames, codecs: set[ScopedName]
) -> list[Package]:
    """The packages in order of first declaration; the root package first."""
    found: dict[ScopedName, Package] = {(): Package(())}
    for declaration in model.declarations:
        scope = declaration.name[:-1]
        if not is_emitted(declaration) or names.is_nested(declaration.name):
            continue
        for depth in range(len(scope) + 1):
            found.setdefault(scope[:depth], Package(scope[:depth]))
        _fill(found[scope], names, declaration, declaration.name in codecs)
    return list(found.values())


def _fill(
    package: Package, names: PythonNames, declaration: Declaration, codec: bool
) -> None:
    name = declaration.name
    path, local = names.implementation(name)
    module = path.removeprefix("_idl.")
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
            outside = names.attribute((*name[:-1], member))
            package.enumerators.append((outside, public, attribute))


def package_text(package: Package, header: str, lazy: bool = False) -> str:
    """The text of its `__init__.py`; `lazy`: modules are imported at first access to a name."""
    dots = "." * (len(package_path(package.scope)) + 1)
    public = [p for pairs in package.imports.values() for _, p in pairs]
    public += [outside for outside, _, _ in package.enumerators]
    final = "Final" if "Final" not in public else "_Final"
    scoped = "::".join(package.scope)
    title = (
        f"The IDL module `{scoped}`."
        if scoped
        else "What stands in the global scope of IDL."
    )
    imports = []
    homes = []
    for module, pairs in sorted(package.imports.items()):
        ordered = sorted(pairs, key=lambda pair: pair[1])
        names = [
            p if local == p and lazy else f"{local} as {p}" for local, p in ordered
        ]
        imports.append(f"from {dots}_idl.{module} import {', '.join(names)}")
        shown = ", ".join(map(string_literal, names))
        key = string_literal(f"{dots}_idl.{module}")
        homes.append(f"{key}: ({shown}{',' if len(names) == 1 else ''})")
    if lazy and not package.enumerators:
        text = render(
            "types/lazy_package.py.j2",
            header=header,
            docstring=docstring(title, 0),
            imports=imports,
            homes=", ".join(homes),
            exported=", ".join(string_literal(name) for name in sorted(public)),
        )
        return fit_text(text)
    text = fit_text(
        render(
            "types/package.py.j2",
            header=header,
            docstring=docstring(title, 0),
            final="Final" if final == "Final" else "Final as _Final",
            imports=imports,
            constants=[
                f"{o}: {final} = {enum}.{m}" for o, enum, m in package.enumerators
            ],
            exported=", ".join(string_literal(name) for name in sorted(public)),
        )
    )
    return text.rstrip("\n") + "\n"
