"""Python modules with parts from several back ends: imports and bodies, printed as one.

A part names modules absolutely; those of the generated package are imported relatively. If a
part imports a name from its own module, the part that defines the name precedes it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import msgspec

from rtgen.compiler.backends import Artifact, Options
from rtgen.compiler.backends.kit.python_text import fit_text, header_comment
from rtgen.compiler.backends.kit.quoting.python import docstring

_STANDARD: Final = frozenset(
    {"abc", "builtins", "collections", "dataclasses", "decimal", "struct", "typing"}
)
"""The packages of the standard library that generated code uses."""
_IMPORT: Final = re.compile(r"from (\S+) import (.+)")
_THIRD_PARTY: Final = ("msgspec", "numpy")


class Import(msgspec.Struct, frozen=True, order=True):
    """`from module import name as local`; without a name `import module as local`.

    `exported`: other modules import it from this one, too (`import name as name`).
    """

    module: str
    name: str
    local: str
    exported: bool = False


class PythonModule(Artifact, frozen=True, kw_only=True):
    """A module, or the part of it from one back end; `text` is that of the part alone.

    `package` is the generated package, below which imports are relative. `title` is the docstring,
    in which a later back end replaces an earlier one. `defines` are names that other parts import.
    `pragmas` are comments for tools below the header. `plain`: the module has no annotations.
    """

    package: str
    version: str
    title: str
    imports: tuple[Import, ...]
    body: str
    defines: frozenset[str] = frozenset()
    pragmas: tuple[str, ...] = ()
    plain: bool = False

    @property
    def name(self) -> str:
        """The absolute name of the module."""
        return ".".join(_parts(self.path))


def python_module(
    path: str,
    options: Options,
    origin: Iterable[str],
    title: str = "",
    *,
    imports: Iterable[Import] = (),
    body: str = "",
    defines: Iterable[str] = (),
    pragmas: Iterable[str] = (),
    plain: bool = False,
) -> PythonModule:
    """Return a module, or a part of one. `origin` are the keys of the inputs in its header.

    Long statements of the body are split, like those of the whole module. The imports with which
    the body begins are those of the module.
    """
    stated, body = _imports_at_head(body)
    return _printed(
        PythonModule(
            path=path,
            text="",
            origin=tuple(dict.fromkeys(origin)),
            package=options.package,
            version=options.version,
            title=title,
            imports=(*imports, *stated),
            body=fit_text(body.strip("\n")),
            defines=frozenset(defines),
            pragmas=tuple(pragmas),
            plain=plain,
        )
    )


def _imports_at_head(body: str) -> tuple[list[Import], str]:
    """Return the imports with which a text begins, one a line, and the rest of it."""
    imports: list[Import] = []
    begin = 0
    while begin < len(body):
        end = (body.find("\n", begin) + 1 or len(body) + 1) - 1
        line = body[begin:end]
        match = _IMPORT.fullmatch(line)
        if match is not None:
            items = (item.partition(" as ") for item in match[2].split(", "))
            imports += [
                Import(match[1], name, local or name) for name, _, local in items
            ]
        elif line:
            return imports, body[begin:]
        begin = end + 1
    return imports, ""


def composed(parts: Sequence[PythonModule]) -> PythonModule:
    """Return the module of parts with the same path, which are in the order of their back ends."""
    first, *others = parts
    if not others:
        return first
    bodies = [part.body for part in _in_order(parts) if part.body]
    return _printed(
        msgspec.structs.replace(
            first,
            origin=tuple(dict.fromkeys(key for part in parts for key in part.origin)),
            title=next((part.title for part in reversed(parts) if part.title), ""),
            imports=tuple({each: None for part in parts for each in part.imports}),
            body="\n\n\n".join(bodies),
            defines=frozenset().union(*(part.defines for part in parts)),
            pragmas=tuple({each: None for part in parts for each in part.pragmas}),
            plain=all(part.plain for part in parts),
        )
    )


def _in_order(parts: Sequence[PythonModule]) -> list[PythonModule]:
    """Return the parts, each after those that define the names that it imports from the module."""
    ordered: list[PythonModule] = []
    seen: set[int] = set()

    def add(part: PythonModule) -> None:
        if id(part) in seen:
            return
        seen.add(id(part))
        needed = {each.name for each in part.imports if each.module == part.name}
        for other in parts:
            if other is not part and not needed.isdisjoint(other.defines):
                add(other)
        ordered.append(part)

    for part in parts:
        add(part)
    return ordered


def _printed(module: PythonModule) -> PythonModule:
    """Return the module with its text."""
    text: str = header_comment(module.version, module.origin)
    text += "".join(f"{pragma}\n" for pragma in module.pragmas)
    text += docstring(module.title, 0)
    others = (each for each in module.imports if each.module != module.name)
    blocks = import_blocks(others, module.package, module.path)
    if not module.plain:
        blocks.insert(0, ["from __future__ import annotations"])
    text += "".join(f"\n{lines}\n" for lines in map("\n".join, blocks))
    text = fit_text(text)
    if module.body:
        wide = module.body.startswith(("@", "class ", "def "))
        text += ("\n\n" if wide else "\n") + module.body + "\n"
    return msgspec.structs.replace(module, text=text)


def imports_of(names: Mapping[tuple[str, str], str]) -> list[Import]:
    """Return the imports of a table from module and name to the local name.

    Numpy is the only module that is imported itself.
    """
    return [
        Import(module, "" if name == module in _THIRD_PARTY else name, local)
        for (module, name), local in names.items()
    ]


def imports_from(module: str, names: Iterable[str]) -> list[Import]:
    """Return the imports of names of a module, each under its name."""
    return [Import(module, name, name) for name in names]


def import_blocks(
    imports: Iterable[Import], package: str = "", path: str = ""
) -> list[list[str]]:
    """Import statements in blocks: standard library, msgspec and numpy, the runtime, the own
    package.

    Modules of `package` are imported relatively by the file at `path`; without a path, all are
    imported absolutely.
    """
    modules: dict[str, list[Import]] = {}
    for each in sorted(set(imports)):
        module = relative_name(each.module, package, path) if path else each.module
        modules.setdefault(module, []).append(each)
    blocks: dict[int, list[str]] = {}
    for module in sorted(modules, key=_order):
        blocks.setdefault(_rank(module), []).extend(
            _statements(module, modules[module])
        )
    return [blocks[rank] for rank in sorted(blocks)]


def _statements(module: str, imports: Sequence[Import]) -> Iterable[str]:
    for each in imports:
        if not each.name:
            yield f"import {module}" + f" as {each.local}" * (each.local != module)
    items = [
        f"{i.name} as {i.local}" if i.exported or i.name != i.local else i.name
        for i in imports
        if i.name
    ]
    if items:
        yield f"from {module} import {', '.join(sorted(items, key=_item_order))}"


def relative_name(module: str, package: str, path: str) -> str:
    """Return the name of a module for an import in a file, relative below `package`."""
    if module != package and not module.startswith(f"{package}."):
        return module
    here, there = _parts(path), module.split(".")
    if not path.endswith("/__init__.py"):
        here = here[:-1]
    common = 0
    while common < min(len(here), len(there)) and here[common] == there[common]:
        common += 1
    return "." * (len(here) - common + 1) + ".".join(there[common:])


def _parts(path: str) -> list[str]:
    return path.removesuffix(".py").removesuffix("/__init__").split("/")


def _rank(module: str) -> int:
    """Return the block of a module."""
    if module.startswith("."):
        return 3
    outermost = module.partition(".")[0]
    if outermost in _STANDARD:
        return 0
    return 1 if outermost in _THIRD_PARTY else 2


def _order(module: str) -> tuple[int, str]:
    """Return the sort key of isort: outer packages first."""
    depth = len(module) - len(module.lstrip("."))
    return -depth, module.lower()


def _item_order(name: str) -> tuple[int, str]:
    """Return the sort key of isort: constants, classes, functions."""
    bare = name.partition(" ")[0]
    return (0 if bare.isupper() else 1 if bare[0].isupper() else 2, name)
