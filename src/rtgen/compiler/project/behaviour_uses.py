"""Finds uses of ports, parameters, services and types that the definitions do not have."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.project import Project
from rtgen.compiler.project.behaviour_classes import (
    Class,
    Module,
    Modules,
    RuntimeClass,
    bound,
    receiver,
    walk,
)
from rtgen.compiler.project_rules import UNKNOWN_NAME

_PORTS = {
    kind: RuntimeClass("rtgen.runtime", name)
    for kind, name in (
        ("inport", "InPort"),
        ("outport", "OutPort"),
        ("provider", "Provider"),
        ("consumer", "Consumer"),
    )
}
"""The runtime's class of each kind of declaration in a generated class."""

_SET = re.compile(r"\bself\.(\w+)\s*(?::[^=\n]*)?=[^=]")
_ALIAS = re.compile(
    r"\b(\w+)\s*=\s*\(*\s*self((?:[\s\\]*\.[\s\\]*\w+)+)\s*\)*[ \t]*(?=$|[;#])", re.M
)
_CHAIN = re.compile(r"\b(\w+)((?:[\s\\]*\.[\s\\]*\w+)+)")
_USED = {
    "inport": ("is_new", "read", "read_newest"),
    "outport": ("write",),
    "provider": ("set_servant",),
    "consumer": ("object",),
}
"""What most behaviours use of ports, which is known without importing their classes."""


def module_of(project: Project, file: str) -> str:
    """Return the dotted name of a module beside skeletons, by its displayed path."""
    name = Path(file).stem
    folder = project.skeleton_package
    return f"{folder}.{name}" if folder else name


def findings(
    project: Project, modules: Modules, file: str, text: str
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for the first use of each name in a module that is not defined."""
    if re.search(rf"\b{re.escape(project.package)}\b", text) is None:
        return
    module = modules.find(module_of(project, file))
    if module is None:
        return
    lines = text.split("\n")
    seen = set()
    for use in (
        *_imports(project, modules, module),
        *_attributes_of_modules(modules, module, text),
        *_of_classes(modules, module, lines),
    ):
        if (use.message, use.hint) not in seen:
            seen.add((use.message, use.hint))
            span = _span(file, lines, use.node, use.name)
            yield UNKNOWN_NAME.at(span, use.message, hint=use.hint)


class _Use:
    """A use of a name that is not there; `owner` is what has it, as a rename names it."""

    def __init__(
        self,
        node: ast.AST,
        name: str,
        message: str,
        candidates: Iterable[str] = (),
        owner: str = "",
        likely: str | None = None,
    ) -> None:
        from rtgen.compiler.frontends.kit.suggestions import nearest

        self.node = node
        self.name = name
        self.message = message
        public = {each for each in candidates if not each.startswith("_")}
        near = nearest(name, sorted(public)) or likely
        command = f"rtgen generate --rename {owner}{name}={near}"
        self.hint = (
            f"did you mean {near}? If it was renamed: {command}" if near else None
        )


def _span(file: str, lines: Sequence[str], node: ast.AST, name: str) -> Span:
    """Return the place of the name at the end of an attribute, or at the start of an alias."""
    if isinstance(node, ast.Attribute):
        line, end = node.end_lineno or 1, node.end_col_offset or 0
        start = end - len(name.encode())
    else:
        line = getattr(node, "lineno", 1)
        start = getattr(node, "col_offset", 0)
        if isinstance(node, ast.ImportFrom):
            start += len(b"from ")
    before = lines[line - 1].encode()[:start].decode(errors="replace")
    return Span(file, line, len(before) + 1, line, len(before) + 1 + len(name))


def _imports(project: Project, modules: Modules, module: Module) -> Iterator[_Use]:
    """Yield imports from generated modules, and attributes of these, that do not exist."""
    components = f"{project.package}.components."
    for node in module.tree.body if module.is_flat else module.nodes:
        if not isinstance(node, ast.ImportFrom) or node.level or not node.module:
            continue
        home = node.module
        if not f"{home}.".startswith(f"{project.package}."):
            continue
        if not modules.is_generated(home):
            if not home.startswith(
                components
            ):  # the behaviour of one is reported as a whole
                yield _Use(node, home, f"there is no generated module {home}")
            continue
        for alias in node.names:
            if modules.defines(home, alias.name):
                continue
            names = modules.bound_in(home)
            if alias.name != "*" and names is not None and alias.name not in names:
                if modules.is_generated(f"{home}.{alias.name}"):
                    continue
                message = f"{home} has no {alias.name!r}"
                yield _Use(alias, alias.name, message, names)


def _attributes_of_modules(
    modules: Modules, module: Module, text: str
) -> Iterator[_Use]:
    """Yield attributes of imported generated modules that do not exist."""
    imported = {
        name: f"{home}.{original}" if original else home
        for name, (home, original) in module.imports.items()
    }
    homes = {n: home for n, home in imported.items() if modules.is_generated(home)}
    unknown = {
        (name, attribute)
        for name, home in homes.items()
        for attribute in re.findall(rf"\b{name}[\s\\]*\.[\s\\]*(\w+)", text)
        if not _has(modules, home, attribute)
    }
    if not unknown:
        return
    bound_anew = {
        node.arg if isinstance(node, ast.arg) else node.id
        for node in module.nodes
        if isinstance(node, ast.arg)
        or (isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load))
    }
    for node in module.nodes:
        match node:
            case ast.Attribute(value=ast.Name(id=name), attr=attribute) if (
                name not in bound_anew and (name, attribute) in unknown
            ):
                home = homes[name]
                message = f"{home} has no {attribute!r}"
                yield _Use(node, attribute, message, modules.bound_in(home) or ())


def _has(modules: Modules, home: str, name: str) -> bool:
    names = modules.bound_in(home)
    is_known = names is None or name in names or name.startswith("__")
    return is_known or modules.is_generated(f"{home}.{name}")


def _of_classes(
    modules: Modules, module: Module, lines: Sequence[str]
) -> Iterator[_Use]:
    for node in module.classes.values():
        ancestors = modules.ancestors(Class(module, node))
        if ancestors is None or not any(map(_is_generated, ancestors)):
            continue
        text = "\n".join(lines[node.lineno - 1 : node.end_lineno])
        behaviour = _Behaviour(modules, Class(module, node), ancestors, text)
        methods = [
            (statement, receiver(statement))
            for statement in node.body
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef)
        ]
        for statement, name in methods if ".stamp(" in text else ():
            own = lines[statement.lineno - 1 : statement.end_lineno]
            if any(".stamp(" in line for line in own):
                yield from behaviour.stamps(statement, name)
        if {name for _, name in methods} <= {"self", None} and behaviour.is_plain(text):
            continue
        for statement, name in methods:
            if name is not None:
                yield from behaviour.uses(statement, name)


def _valued(class_: Class) -> Iterator[ast.stmt]:
    """Yield the statements of a class without those that only annotate a name."""
    for statement in class_.node.body:
        if not isinstance(statement, ast.AnnAssign) or statement.value:
            yield statement


def _parts(path: str) -> tuple[str, ...]:
    return tuple(re.findall(r"\w+", path))


def _is_generated(class_: Class | RuntimeClass) -> bool:
    return isinstance(class_, Class) and class_.module.is_generated


class _Behaviour:
    """A class derived from a generated one."""

    def __init__(
        self,
        modules: Modules,
        class_: Class,
        ancestors: Sequence[Class | RuntimeClass],
        text: str,
    ) -> None:
        self._modules = modules
        self._component = next(
            (
                each.node.name
                for each in ancestors
                if isinstance(each, Class) and _is_generated(each)
            ),
            "",
        ).removesuffix("Base")
        self._class = class_
        self._ancestors = ancestors
        self._own = {*bound([*_valued(class_)]), *_SET.findall(text)}
        """Names that the class sets, as far as its text tells."""
        self._declared: dict[str, tuple[str, Class | RuntimeClass | None]] = {}
        """Kind of what the generated classes declare, by name, with the class for what it has."""
        for each in reversed(ancestors):
            if _is_generated(each):
                self._declared.update(self._declarations(each))
            elif isinstance(each, Class):
                own = self._own if each is class_ else {*bound([*_valued(each)])}
                for name in own:
                    self._declared.pop(name, None)

    @cached_property
    def _unused(self) -> str | None:
        """What the class does not use, if it is one name: likely that of something renamed."""
        nodes = self._modules.nodes(self._class.node)
        used = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
        unused = [name for name in self._declared if name not in used | {"config"}]
        return unused[0] if len(unused) == 1 else None

    def is_plain(self, text: str) -> bool:
        """Return whether each name that the text of the class uses is known, without its tree."""
        aliases: dict[str, tuple[str, ...]] = {"self": ()}
        for name, path in _ALIAS.findall(text):
            if aliases.setdefault(name, _parts(path)) != _parts(path):
                return False
        return all(
            self._is_known((*aliases[name], *_parts(path)))
            for name, path in {*_CHAIN.findall(text)}
            if name in aliases
        )

    @cached_property
    def _bound(self) -> set[str]:
        return self._own.union(bound(self._class.node.body))

    def _has(self, name: str) -> bool:
        """Return whether the class may have an attribute."""
        return name in self._bound or self._modules.has(self._class, name) is not False

    def _is_known(self, path: Sequence[str]) -> bool:
        if not self._has(path[0]):
            return False
        kind, type_ = self._declared.get(path[0], ("", None))
        used = _USED.get(kind, ())
        if path[1:2] and path[1] in used and (len(path) == 2 or kind != "consumer"):
            return True
        if isinstance(type_, Class) and (
            (kind == "configuration" and len(path) == 2)
            or (kind == "consumer" and len(path) > 2 and path[1] in used)
        ):
            return self._modules.has(type_, path[1 + (kind == "consumer")]) is not False
        members = [
            self._members(kind, type_, path[1:n])[0]
            for n in range(2, min(len(path), 3) + 1)
        ]
        return all(
            names is None or name in names
            for names, name in zip(members, path[1:], strict=False)
        )

    def _declarations(
        self, class_: Class | RuntimeClass
    ) -> Iterator[tuple[str, tuple[str, Class | RuntimeClass | None]]]:
        assert isinstance(class_, Class)
        for statement in class_.node.body:
            match statement:
                case ast.Assign(
                    targets=[ast.Name(id=name)],
                    value=ast.Call(func=ast.Name(id=kind), args=[type_, *_]),
                ):
                    own = kind in ("configuration", "consumer")
                    resolve = self._modules.resolve
                    yield name, (kind, resolve(class_.module, type_) if own else None)

    def uses(
        self, method: ast.FunctionDef | ast.AsyncFunctionDef, receiver: str
    ) -> Iterator[_Use]:
        """Yield the uses of names that do not exist in a method."""
        aliases = _aliases(method, receiver)
        if aliases is None:
            return
        further: dict[int, str] = {}
        for node in _visible(method, {*aliases, receiver}):
            if isinstance(node, ast.Attribute):
                further[id(node.value)] = node.attr
                path = _path(node, receiver, aliases)
                if path:
                    yield from self._checked(node, path, further.get(id(node), ""))

    def stamps(
        self, method: ast.FunctionDef | ast.AsyncFunctionDef, receiver: str | None
    ) -> Iterator[_Use]:
        """Yield the samples that a method stamps, whose types have no member for it."""
        values: dict[str, list[ast.expr | None]] = {}
        calls = []
        relevant = ast.Assign | ast.Name | ast.Call
        for node in self._modules.nodes(method):
            if not isinstance(node, relevant):
                continue
            match node:
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    values.setdefault(name, []).append(value)
                case ast.Name(id=name) if not isinstance(node.ctx, ast.Load):
                    values.setdefault(name, []).append(None)
                case ast.Call(
                    func=ast.Attribute(value=ast.Name(id=own), attr="stamp"),
                    args=[sample],
                ) if (
                    own == receiver
                ):
                    calls.append(sample)
        for sample in calls:
            made: ast.expr | None = sample
            if isinstance(sample, ast.Name):
                assigned = values.get(sample.id, ())
                made = (
                    next(filter(None, assigned), None) if len(assigned) == 2 else None
                )
            if not isinstance(made, ast.Call):
                continue
            type_ = self._modules.resolve(self._class.module, made.func)
            if (
                isinstance(type_, Class)
                and type_.module.is_generated
                and self._modules.has(type_, "tm") is False
            ):
                place = ast.unparse(sample).partition("(")[0]
                use = _Use(sample, place, f"{type_.node.name} has no 'tm' to stamp")
                use.hint = "declare `RTC::Time tm;` in it, or do not stamp it"
                yield use

    def _checked(
        self, node: ast.Attribute, path: Sequence[str], further: str
    ) -> Iterator[_Use]:
        """Yield the use of a name that is not there; `further` is the name after it, if any."""
        first = path[0]
        if len(path) == 1:
            if first.startswith("__") or self._has(first):
                return
            if isinstance(node.ctx, ast.Load):
                message = (
                    f"the definition has no port {first!r}"
                    if further in (*_USED["inport"], *_USED["outport"])
                    else f"neither the definition nor the class has {first!r}"
                )
                candidates = self._declared or self._modules.names(self._class) or ()
                owner = f"{self._component}."
                yield _Use(node, first, message, candidates, owner, self._unused)
            return
        kind, type_ = self._declared.get(first, ("", None))
        names, what = self._members(kind, type_, path[1:])
        if names is not None and path[-1] not in names:
            message = f"{first!r}, {what}, has no {path[-1]!r}"
            owner = f"{self._component}."
            if kind == "consumer" and isinstance(type_, Class):
                owner = f"{type_.node.name}::"
            yield _Use(node, path[-1], message, names, owner)

    def _members(
        self, kind: str, type_: Class | RuntimeClass | None, path: Sequence[str]
    ) -> tuple[Iterable[str] | None, str]:
        """Return the names of what is declared, None if not known, and what it is."""
        if kind == "configuration" and len(path) == 1:
            return self._all(type_), "the configuration"
        if kind == "consumer":
            of_type = self._all(type_)
            if of_type is None or not isinstance(type_, Class):
                return None, ""
            what = f"a consumer of {type_.node.name}"
            if len(path) == 1:
                own = self._modules.own_names(_PORTS[kind])
                return (None, "") if own is None else (own | of_type, what)
            return (of_type, what) if [*path[:-1]] == ["object"] else (None, "")
        if kind in _PORTS and len(path) == 1:
            article = "an" if kind.endswith("port") else "a"
            own = self._modules.own_names(_PORTS[kind])
            return own, f"{article} {_PORTS[kind].name}"
        return None, ""

    def _all(self, type_: Class | RuntimeClass | None) -> frozenset[str] | None:
        return self._modules.names(type_) if isinstance(type_, Class) else None


def _path(
    node: ast.expr, receiver: str, aliases: dict[str, tuple[str, ...]]
) -> tuple[str, ...]:
    """Return the names from the receiver to an attribute; empty for another expression."""
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name) or not names:
        return ()
    if node.id == receiver:
        return tuple(reversed(names))
    return (*aliases[node.id], *reversed(names)) if node.id in aliases else ()


def _aliases(
    method: ast.FunctionDef | ast.AsyncFunctionDef, receiver: str
) -> dict[str, tuple[str, ...]] | None:
    """Return the attributes that local names stand for; None if the receiver is bound anew."""
    stores: list[str] = []
    assigned = []
    for node in walk(method):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            stores.append(node.id)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Attribute):
            assigned.append(node)
    if receiver in stores:
        return None
    aliases = {}
    for node in assigned:
        match node.targets:
            case [ast.Name(id=name)] if stores.count(name) == 1:
                path = _path(node.value, receiver, {})
                if path:
                    aliases[name] = path
    return aliases


def _visible(
    method: ast.FunctionDef | ast.AsyncFunctionDef, names: set[str]
) -> Iterator[ast.AST]:
    """Yield the nodes of a method, without functions and classes that bind one of the names."""
    waiting: list[ast.AST] = [*method.body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ClassDef):
            continue
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            arguments = (a.arg for a in walk(node.args) if isinstance(a, ast.arg))
            if not names.isdisjoint(arguments):
                continue
        yield node
        waiting += reversed([*ast.iter_child_nodes(node)])
