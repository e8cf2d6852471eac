"""The names that classes of behaviours have, found in syntax trees: nothing is executed.

Classes are followed from the user's modules through generated ones to those of rtgen's runtime,
the only ones that are imported.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module
from inspect import getsource
from typing import TypeAlias

from rtgen.compiler.typemap.components.names import COMPONENT_NAMES

_OWN = "rtgen."
_WITHOUT_NAMES = ("typing", "typing_extensions", "abc")
"""Modules whose classes add no names that a behaviour uses."""
_MAX_DEPTH = 32
_ASSIGNED = re.compile(r"\bself\.(\w+)\b[^=\n]*=[^=]")
_INDENTED_IMPORT = re.compile(
    r"^[ \t]+(?:from|import)[ \t]|;[ \t]*(?:from|import)[ \t]", re.M
)
_DYNAMIC = frozenset({"__getattr__", "__getattribute__", "__dict__"})
"""Names of a class that may have further ones."""
_OF_COMPONENTS = COMPONENT_NAMES - {"config"}
PUBLIC = {
    ("rtgen.runtime", "Component"): _OF_COMPONENTS,
    ("rtgen.runtime.canopen.node.device", "CanopenDevice"): {
        *_OF_COMPONENTS,
        *("bus_lock", "get_object", "node", "set_object"),
    },
}
"""Names of the runtime's classes that most behaviours use, known without importing them."""

_Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True, slots=True)
class RuntimeClass:
    """A class that is not in a syntax tree: its module, its name."""

    module: str
    name: str


@dataclass(eq=False)
class Module:
    """A module: its classes and imports by the names that it binds."""

    name: str
    tree: ast.Module
    is_package: bool = False
    is_generated: bool = False
    classes: dict[str, ast.ClassDef] = field(default_factory=dict)
    imports: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Module and name there; the name is empty for a module."""
    is_flat: bool = True
    """Whether all imports are statements of the module itself."""

    def __post_init__(self) -> None:
        for node in self.tree.body if self.is_flat else self.nodes:
            if isinstance(node, ast.ImportFrom):
                home = self._home(node)
                for alias in node.names:
                    self.imports[alias.asname or alias.name] = (home, alias.name)
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    name = alias.name if alias.asname else alias.name.split(".")[0]
                    self.imports[alias.asname or name] = (name, "")
        for statement in self.tree.body:
            if isinstance(statement, ast.ClassDef):
                self.classes[statement.name] = statement

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All nodes of the tree."""
        return walk(self.tree)

    def _home(self, node: ast.ImportFrom) -> str:
        if not node.level:
            return node.module or ""
        parts = self.name.split(".")
        parts = parts[: len(parts) - node.level + self.is_package]
        return ".".join([*parts, *([node.module] if node.module else [])])


@dataclass(frozen=True, slots=True)
class Class:
    """A class in a syntax tree."""

    module: Module
    node: ast.ClassDef


class Modules:
    """The generated modules by path, and the user's by name; parsed when they are first needed."""

    def __init__(self, generated: Mapping[str, str], users: Mapping[str, str]) -> None:
        self._generated = generated
        self._users = users
        self._modules: dict[str, Module | None] = {}
        self._trees: dict[str, ast.Module] = {}
        self._ancestors: dict[tuple[str, str], list[Class | RuntimeClass] | None] = {}
        self._names: dict[tuple[str, str], frozenset[str] | None] = {}
        self._own: dict[tuple[str, str], frozenset[str] | None] = {}
        self._nodes: dict[ast.AST, list[ast.AST]] = {}
        self._bound: dict[str, frozenset[str] | None] = {}

    def find(self, name: str) -> Module | None:
        """Return a module by its dotted name; None if it is another's, or cannot be parsed."""
        if name not in self._modules:
            self._modules[name] = self._parsed(name)
        return self._modules[name]

    def tree(self, text: str) -> ast.Module:
        """Return the syntax tree of a text, parsed once.

        Raises SyntaxError, ValueError and RecursionError, as Python does.
        """
        if text not in self._trees:
            self._trees[text] = ast.parse(text)
        return self._trees[text]

    def forget(self, name: str) -> None:
        """Release the syntax tree of a user's module; a module that imports it parses it again."""
        self._modules.pop(name, None)
        self._trees.pop(self._users.get(name, ""), None)
        self._nodes.clear()
        for key in [key for key in self._ancestors if key[0] == name]:
            del self._ancestors[key]

    def is_generated(self, name: str) -> bool:
        """Return whether a module or a package of that name is generated."""
        path = name.replace(".", "/")
        return (
            f"{path}.py" in self._generated or f"{path}/__init__.py" in self._generated
        )

    def _text(self, name: str) -> str | None:
        """Return the text of a generated module or package."""
        path = name.replace(".", "/")
        package = self._generated.get(f"{path}/__init__.py")
        return self._generated.get(f"{path}.py", package)

    def _parsed(self, name: str) -> Module | None:
        path = name.replace(".", "/")
        text = self._text(name)
        is_generated = text is not None
        if text is None:
            text = self._users.get(name)
        if text is None:
            return None
        try:
            tree = self.tree(text)
        except (SyntaxError, ValueError, RecursionError):
            return None  # reported when the module is imported
        is_package = is_generated and f"{path}.py" not in self._generated
        is_flat = is_generated or _INDENTED_IMPORT.search(text) is None
        return Module(name, tree, is_package, is_generated, is_flat=is_flat)

    def resolve(
        self, module: Module, expression: ast.expr
    ) -> Class | RuntimeClass | None:
        """Return the class that an expression in a module names; None if that is not known."""
        if isinstance(expression, ast.Subscript):
            return self.resolve(module, expression.value)
        if isinstance(expression, ast.Constant) and isinstance(expression.value, str):
            try:
                return self.resolve(
                    module, ast.parse(expression.value, mode="eval").body
                )
            except (SyntaxError, ValueError, RecursionError):
                return None
        if isinstance(expression, ast.Name):
            return self._class(module, expression.id)
        if isinstance(expression, ast.Attribute):
            home = self._module_of(module, expression.value)
            return self._in_module(home, expression.attr) if home else None
        return None

    def _module_of(self, module: Module, expression: ast.expr) -> str | None:
        """Return the name of the module that an expression names."""
        if isinstance(expression, ast.Name):
            home, name = module.imports.get(expression.id, ("", ""))
            return f"{home}.{name}" if home and name else home or None
        if isinstance(expression, ast.Attribute):
            parent = self._module_of(module, expression.value)
            return f"{parent}.{expression.attr}" if parent else None
        return None

    def _class(
        self, module: Module, name: str, depth: int = 0
    ) -> Class | RuntimeClass | None:
        if name in module.classes:
            return Class(module, module.classes[name])
        home, original = module.imports.get(name, ("", ""))
        if home and original and depth < _MAX_DEPTH:
            return self._in_module(home, original, depth + 1)
        return RuntimeClass("builtins", name) if name == "object" else None

    def _in_module(
        self, home: str, name: str, depth: int = 0
    ) -> Class | RuntimeClass | None:
        if home.startswith(_OWN) or home in _WITHOUT_NAMES:
            return RuntimeClass(home, name)
        module = self.find(home)
        return None if module is None else self._class(module, name, depth)

    def ancestors(self, start: Class) -> list[Class | RuntimeClass] | None:
        """Return a class and all its bases; None if one of them is not known."""
        key = (start.module.name, start.node.name)
        if key not in self._ancestors:
            self._ancestors[key] = self._bases_of(start)
        return self._ancestors[key]

    def _bases_of(self, start: Class) -> list[Class | RuntimeClass] | None:
        result: list[Class | RuntimeClass] = []
        waiting: list[Class | RuntimeClass] = [start]
        while waiting:
            each = waiting.pop(0)
            if each in result:
                continue
            result.append(each)
            if isinstance(each, Class):
                for base in each.node.bases:
                    found = self.resolve(each.module, base)
                    if found is None or len(result) > _MAX_DEPTH:
                        return None
                    waiting.append(found)
        return result

    def has(self, class_: Class, name: str) -> bool | None:
        """Return whether a class or a base has a name; None if not all names are known.

        The runtime is imported only for a name that generated and public ones do not tell.
        """
        bases = reversed(self.ancestors(class_) or ())
        if any(name in self._written(each) for each in bases):
            return True
        names = self.names(class_)
        return None if names is None else name in names

    def _written(self, class_: Class | RuntimeClass) -> Collection[str]:
        """Return the names of a class that are known without importing it."""
        if isinstance(class_, RuntimeClass):
            return PUBLIC.get((class_.module, class_.name), ())
        return self.own_names(class_) or ()

    def names(self, start: Class) -> frozenset[str] | None:
        """Return the names of a class and its bases; None if they are not all known."""
        key = (start.module.name, start.node.name)
        if key not in self._names:
            own = [*map(self.own_names, self.ancestors(start) or ())]
            known = [each for each in own if each is not None]
            is_known = known and len(known) == len(own)
            self._names[key] = frozenset().union(*known) if is_known else None
        return self._names[key]

    def own_names(self, class_: Class | RuntimeClass) -> frozenset[str] | None:
        """Return the names of a class; those of one of the runtime with those of its bases.

        None if it may have further ones.
        """
        if isinstance(class_, RuntimeClass):
            return _runtime_names(class_.module, class_.name)
        key = (class_.module.name, class_.node.name)
        if key not in self._own:
            assigned = _assigned(self.nodes(class_.node))
            names = {*bound(class_.node.body), *assigned}
            self._own[key] = None if _DYNAMIC & names else frozenset(names)
        return self._own[key]

    def nodes(self, node: ast.AST) -> list[ast.AST]:
        """Return the nodes of a class or method, which are collected once."""
        if node not in self._nodes:
            self._nodes[node] = walk(node)
        return self._nodes[node]

    def defines(self, module: str, name: str) -> bool:
        """Return whether the text of a generated module shows that it defines a name."""
        text = self._text(module) or ""
        starts = (
            f"\nclass {name}(",
            f"\nclass {name}:",
            f"\ndef {name}(",
            f"\n{name} =",
        )
        return any(start in text for start in starts)

    def bound_in(self, name: str) -> frozenset[str] | None:
        """Return the names that a generated module binds; None if they are not all known."""
        if name not in self._bound:
            module = self.find(name)
            names = {"*"} if module is None else {*bound(module.tree.body)}
            is_open = names & {"__getattr__", "*"}
            self._bound[name] = None if is_open else frozenset(names)
        return self._bound[name]


def walk(node: ast.AST) -> list[ast.AST]:
    """Return a node and those below it but contexts, in two thirds of the time of `ast.walk`."""
    nodes = [node]
    for each in nodes:
        nodes += children(each)
    return nodes


def children(node: ast.AST) -> list[ast.AST]:
    """Return the nodes directly below a node but its context."""
    nodes: list[ast.AST] = []
    for name in node._fields:
        if name != "ctx":
            value = getattr(node, name, None)
            if isinstance(value, ast.AST):
                nodes.append(value)
            elif isinstance(value, list):
                nodes += [item for item in value if isinstance(item, ast.AST)]
    return nodes


def bound(body: list[ast.stmt]) -> Iterator[str]:
    """Yield the names that statements bind, without those in functions and classes."""
    waiting: list[ast.AST] = [*body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, _Function | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name):
            if isinstance(node.ctx, ast.Store):
                yield node.id
        elif isinstance(node, ast.alias):
            yield (node.asname or node.name).partition(".")[0]
        elif not isinstance(node, ast.Constant):
            waiting += children(node)


def _assigned(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield the attributes that code of a class sets, of any object, and marks of dynamic ones."""
    for each in nodes:
        if isinstance(each, ast.Attribute):
            if isinstance(each.ctx, ast.Store | ast.Del) or each.attr == "__dict__":
                yield each.attr
        elif isinstance(each, ast.Name) and each.id in ("setattr", "vars"):
            yield "__dict__"


@cache
def _runtime_names(module: str, name: str) -> frozenset[str] | None:
    """Return the names of a class of rtgen's runtime, and those of its instances."""
    if module in _WITHOUT_NAMES or name == "object":
        return frozenset(dir(object))
    try:
        class_ = getattr(import_module(module), name)
        names = {*dir(class_)}
        for base in class_.__mro__:
            if base.__module__.startswith(_OWN):
                names.update(_ASSIGNED.findall(_source(base)))
    except (ImportError, AttributeError, OSError, TypeError):
        return None  # of an extra that is missing, or not a class
    return frozenset(names)


def _source(class_: type) -> str:
    """Return the source of a class, without the syntax tree that `getsource` makes of its module.

    Raises OSError if there is none.
    """
    module = getsource(sys.modules[class_.__module__])
    pattern = rf"^class {class_.__name__}\b.*?(?=^[^\s#)]|\Z)"
    match = re.search(pattern, module, re.M | re.S)
    return getsource(class_) if match is None else match[0]


def receiver(function: _Function) -> str | None:
    """Return the name of a method's first parameter; None for a static or class method."""
    for decorator in function.decorator_list:
        if isinstance(decorator, ast.Name) and decorator.id in (
            "staticmethod",
            "classmethod",
        ):
            return None
    arguments = [*function.args.posonlyargs, *function.args.args]
    return arguments[0].arg if arguments else None
