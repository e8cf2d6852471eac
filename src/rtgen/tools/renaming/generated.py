"""What became of the names of generated Python: two runs of the compiler, side by side."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from rtgen.compiler.backends import Artifact, Owner
from rtgen.compiler.matching import matching

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_MAX_LINKS = 16


@dataclass(slots=True)
class Scope:
    """A module, class or function, with the names in it in order."""

    kind: str
    names: dict[str, Scope] = field(default_factory=dict)
    bases: list[str] = field(default_factory=list)
    imports: dict[str, str] = field(default_factory=dict)
    type_name: str = ""

    def child(self, name: str, kind: str) -> Scope:
        """Return the scope of a name, which is added."""
        return self.names.setdefault(name, Scope(kind))


class Modules:
    """Modules of Python by name, with the classes in them."""

    def __init__(self) -> None:
        self.root = Scope("module")

    def add(self, name: str, text: str, *, is_package: bool = False) -> None:
        """Add a module; one that Python cannot parse has no names."""
        scope = self.root
        for part in name.split("."):
            scope = scope.child(part, "module")
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError, RecursionError):
            return
        package = name if is_package else name.rpartition(".")[0]
        _add_body(scope, tree.body, package)

    def add_artifacts(self, artifacts: Iterable[Artifact], skeletons: str) -> None:
        """Add the modules of a run; those of users are in the package `skeletons`."""
        for artifact in artifacts:
            path = PurePosixPath(artifact.path)
            if path.suffix == ".py":
                is_package = path.name == "__init__.py"
                parts = path.parent.parts if is_package else path.with_suffix("").parts
                if artifact.owner is Owner.USER and skeletons:
                    parts = (skeletons, *parts)
                if parts:
                    self.add(".".join(parts), artifact.text, is_package=is_package)

    def find(self, name: str) -> Scope | None:
        """Return the scope of an absolute name."""
        scope: Scope | None = self.root
        for part in name.split("."):
            scope = None if scope is None else scope.names.get(part)
        return scope

    def canonical(self, name: str) -> str:
        """Return the name by which something is defined, which modules may import."""
        for _ in range(_MAX_LINKS):
            scope, parts = self.root, name.split(".")
            for number, part in enumerate(parts):
                if part in scope.names:
                    scope = scope.names[part]
                elif part in scope.imports:
                    name = ".".join((scope.imports[part], *parts[number + 1 :]))
                    break
                else:
                    return name
            else:
                return name
        return name

    def bases(self, name: str) -> Iterator[str]:
        """Yield a class and its bases, by the names by which they are defined, each once."""
        seen: set[str] = set()
        names = [self.canonical(name)]
        while names:
            name = names.pop(0)
            if name in seen:
                continue
            seen.add(name)
            yield name
            scope = self.find(name)
            if scope is not None:
                module = self._module(name)
                for base in scope.bases:
                    names.append(self.resolved(module, base))

    def resolved(self, module: str, written: str) -> str:
        """Return the name by which a name that a module uses is defined."""
        return self.canonical(f"{module}.{written}" if module else written)

    def _module(self, name: str) -> str:
        parts: list[str] = []
        scope: Scope | None = self.root
        for part in name.split("."):
            scope = None if scope is None else scope.names.get(part)
            if scope is None or scope.kind != "module":
                break
            parts.append(part)
        return ".".join(parts)

    def definitions(self) -> Iterator[tuple[str, Scope, Scope]]:
        """Yield the absolute name of each definition, the scope that has it, and its own."""
        yield from _below(self.root, "")


def _below(scope: Scope, prefix: str) -> Iterator[tuple[str, Scope, Scope]]:
    for name, child in scope.names.items():
        yield prefix + name, scope, child
        yield from _below(child, f"{prefix}{name}.")


def _add_attributes(scope: Scope, node: ast.ClassDef) -> None:
    """Add the attributes that the methods of a class set on `self`."""
    for each in ast.walk(node):
        match each:
            case ast.Attribute(value=ast.Name(id="self"), attr=name, ctx=ast.Store()):
                scope.child(name, "value")


def _add_class(scope: Scope, node: ast.ClassDef, package: str) -> None:
    scope.bases = [name for b in node.bases if (name := dotted(b))]
    for keyword in node.keywords:
        match keyword:
            case ast.keyword(arg="type_name", value=ast.Constant(value=value)):
                scope.type_name = str(value)
    _add_body(scope, node.body, package)
    _add_attributes(scope, node)


def _add_body(scope: Scope, body: Iterable[ast.stmt], package: str) -> None:
    for node in body:
        match node:
            case ast.ClassDef():
                _add_class(scope.child(node.name, "class"), node, package)
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                inner = scope.child(node.name, "function")
                given = node.args
                for each in (*given.posonlyargs, *given.args, *given.kwonlyargs):
                    inner.child(each.arg, "argument")
            case ast.Assign(targets=targets):
                for target in targets:
                    if isinstance(target, ast.Name):
                        scope.child(target.id, "value")
            case ast.AnnAssign(target=ast.Name(id=name)):
                scope.child(name, "value")
            case ast.Import():
                for alias in node.names:
                    name = alias.asname or alias.name.partition(".")[0]
                    scope.imports[name] = alias.name if alias.asname else name
            case ast.ImportFrom():
                source = _source(node, package)
                for alias in node.names:
                    scope.imports[alias.asname or alias.name] = f"{source}.{alias.name}"
            case ast.If() | ast.Try():
                _add_body(scope, [*node.body, *node.orelse], package)


def _source(node: ast.ImportFrom, package: str) -> str:
    """Return the absolute name of the module that names are imported from."""
    if not node.level:
        return node.module or ""
    parts = package.split(".")
    parts = parts[: len(parts) - node.level + 1]
    return ".".join((*parts, *((node.module,) if node.module else ())))


def dotted(node: ast.expr) -> str:
    """Return a dotted name as it is written, of a subscript its value; else an empty text."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=value, attr=name):
            start = dotted(value)
            return f"{start}.{name}" if start else ""
        case ast.Subscript(value=value):
            return dotted(value)
    return ""


def renamed_names(old: Modules, new: Modules) -> Mapping[str, str]:
    """Return the new last parts of the absolute names in `old` that `new` does not have."""
    names: dict[str, str] = {}
    _align(old.root, new.root, "", names)
    return names


def _align(old: Scope, new: Scope, prefix: str, names: dict[str, str]) -> None:
    """Pair the names of two scopes: by name, the others by their order among their kind."""
    shapes = [_shapes(old, new.names), _shapes(new, old.names)]
    found = matching(
        {name: name for name in old.names},
        {name: name for name in new.names},
        shapes[0].get,
        shapes[1].get,
    )
    for one, other in (*found.pairs, *found.renamed):
        if one != other:
            names[prefix + one] = other
        _align(old.names[one], new.names[other], f"{prefix}{one}.", names)


def _shapes(scope: Scope, others: Mapping[str, Scope]) -> dict[str, tuple[str, int]]:
    numbers: defaultdict[str, int] = defaultdict(int)
    shapes = {}
    for name, child in scope.names.items():
        if name not in others:
            shapes[name] = child.kind, numbers[child.kind]
            numbers[child.kind] += 1
    return shapes
