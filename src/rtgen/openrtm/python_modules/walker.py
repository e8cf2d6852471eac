"""Abstract interpretation of a component's construction: evaluates statements over partial
values.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rtgen.compiler.kit.words import words
from rtgen.openrtm.python_modules.expressions import (
    FUNCTIONS,
    Expressions,
    is_known,
    iterated,
)
from rtgen.openrtm.python_modules.modules import ModuleName, Modules, definition
from rtgen.openrtm.python_modules.state import State
from rtgen.openrtm.python_modules.values import (
    UNKNOWN,
    Bound,
    Class,
    Component,
    Frame,
    Function,
    Made,
    Module,
    Named,
    Super,
    Unknown,
    Value,
    dotted,
)

MAX_STEPS = 200_000
"""Maximum number of expressions and statements evaluated."""

_MAX_DEPTH = 20
_NO_DATA = ("OpenRTM_aist", "typing")
"""Packages without data types."""

_MAX_ROUNDS = 1000


class TooMuchError(Exception):
    """The module exceeds MAX_STEPS steps."""


@dataclass(eq=False, slots=True)
class Call:
    """A call of a method that the repository does not define: it is OpenRTM's own."""

    name: str
    holder: Value
    made: Made

    def argument(self, place: int, *names: str) -> Value:
        """Return an argument by position, or by one of its names."""
        return self.made.argument(place, *names)


@dataclass(frozen=True, slots=True)
class _End:
    """How a block of statements ends early."""

    kind: type[ast.stmt]
    value: Value = None


@dataclass(eq=False)
class Walker:
    """Evaluates statements over partial values; both branches of a condition are evaluated."""

    modules: Modules
    calls: list[Call] = field(default_factory=list)
    made: list[Made] = field(default_factory=list)
    walked: set[ast.FunctionDef] = field(default_factory=set)
    _certain: bool = True
    _steps: int = 0
    _stack: list[ast.FunctionDef] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.expressions = Expressions(self)
        self._executed: set[Module] = set()

    def step(self) -> None:
        """Count a step. Raises TooMuchError."""
        self._steps += 1
        if self._steps > MAX_STEPS:
            raise TooMuchError

    def module(self, module: Module) -> None:
        """Run a module, once."""
        if module not in self._executed:
            self._executed.add(module)
            module.names["__name__"] = "module"
            certain, self._certain = self._certain, True
            self._block(module.tree.body, Frame(module))
            self._certain = certain

    def method(self, component: Component, name: str) -> None:
        """Run a method of the component, if it exists."""
        function = component.method(name)
        if function is not None:
            self._called(function, component, [UNKNOWN] * 9, {})

    def perhaps(self, function: Function, component: Component) -> None:
        """Run a method that may be called later."""
        certain, self._certain = self._certain, False
        self._called(function, component, [UNKNOWN] * 9, {})
        self._certain = certain

    # Statements.

    def _block(self, body: Sequence[ast.stmt], frame: Frame) -> _End | None:
        for node in body:
            self.step()
            end = self._statement(node, frame)
            if end is not None:
                return end
        return None

    def _statement(self, node: ast.stmt, frame: Frame) -> _End | None:
        value = self.expressions.value
        match node:
            case ast.Assign(targets=targets, value=expression):
                result = value(expression, frame)
                for target in targets:
                    self.assign(target, result, frame)
            case ast.AnnAssign(target=target, annotation=annotation):
                result = value(node.value, frame)
                if isinstance(result, Unknown | Made) and dotted(annotation):
                    result = self._of_type(
                        value(annotation, frame), result, node, frame
                    )
                self.assign(target, result, frame)
            case ast.AugAssign(target=target, op=op, value=expression):
                joined = ast.copy_location(ast.BinOp(target, op, expression), node)
                self.assign(target, value(joined, frame), frame)
            case ast.Expr(value=expression):
                value(expression, frame)
            case ast.Return(value=expression):
                result = value(expression, frame) if expression is not None else None
                return _End(ast.Return, result)
            case ast.Raise() | ast.Break() | ast.Continue():
                return _End(type(node))
            case ast.If():
                return self._branches(node, frame)
            case ast.For(target=target, iter=iterable):
                return self._loop(node, target, value(iterable, frame), frame)
            case ast.While():
                return self._while(node, frame)
            case ast.With(items=items, body=body):
                for item in items:
                    entered = value(item.context_expr, frame)
                    if item.optional_vars is not None:
                        self.assign(item.optional_vars, entered, frame)
                return self._block(body, frame)
            case ast.Try():
                return self._try(node, frame)
            case ast.Import() | ast.ImportFrom():
                self._import(node, frame)
            case ast.ClassDef() | ast.FunctionDef():
                frame.bind(node.name, definition(node, frame.module))
        return None

    def _of_type(
        self, type_: Value, value: Value, node: ast.AnnAssign, frame: Frame
    ) -> Value:
        """Return the annotated type of a variable assigned from an unknown call."""
        if not isinstance(type_, Named) or type_.path[0] in _NO_DATA:
            return value
        known = isinstance(value, Made) and value.path
        if known and (value.path == type_.path or value.path[0] in _NO_DATA):
            return value
        call = ast.copy_location(ast.Call(node.annotation, [], []), node)
        return self._new(type_.path, type_.imported, [], {}, call, frame)

    def assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        """Assign a value to a target."""
        match target:
            case ast.Name(id=name):
                frame.bind(name, value)
            case ast.Attribute(value=holder, attr=name):
                container = self.expressions.value(holder, frame)
                if isinstance(container, Component):
                    container.attributes[name] = value
            case ast.Tuple(elts=targets) | ast.List(elts=targets):
                items = iterated(value)
                if items is None or len(items) != len(targets):
                    items = [UNKNOWN] * len(targets)
                for each, item in zip(targets, items, strict=True):
                    self.assign(each, item, frame)
            case ast.Subscript(value=holder, slice=index):
                container = self.expressions.value(holder, frame)
                key = self.expressions.value(index, frame)
                if (isinstance(container, dict) and isinstance(key, str | int)) or (
                    isinstance(container, list)
                    and key in range(-len(container), len(container))
                ):
                    container[key] = value

    def _branches(self, node: ast.If, frame: Frame) -> _End | None:
        # An `elif` is nested in the `else` of the one before: it is not counted as depth.
        ways: list[Sequence[ast.stmt]] = []
        rest: Sequence[ast.stmt] = [node]
        while len(rest) == 1 and isinstance(rest[0], ast.If):
            current = rest[0]
            test = self.expressions.value(current.test, frame)
            rest = current.orelse
            if not is_known(test):
                ways.append(current.body)
            elif test:
                rest = current.body
                break
        if not ways:
            return self._block(rest, frame)
        return self._any_of([*ways, rest], frame)

    def _any_of(self, ways: Sequence[Sequence[ast.stmt]], frame: Frame) -> _End | None:
        """Run alternative blocks and merge their states, except of those that end early."""
        start = State.of(frame)
        certain, self._certain = self._certain, False
        left: State | None = None
        end: _End | None = None
        for way in ways:
            start.restore(frame)
            stopped = self._block(way, frame)
            if stopped is None:
                here = State.of(frame)
                left = here if left is None else left.merged(here)
            else:
                end = stopped
        self._certain = certain
        if left is None:
            return end
        left.restore(frame)
        return None

    def _loop(
        self, node: ast.For, target: ast.expr, value: Value, frame: Frame
    ) -> _End | None:
        items = iterated(value)
        if items is None or len(items) > _MAX_ROUNDS:
            self.assign(target, UNKNOWN, frame)
            return self._any_of([node.body, []], frame)
        for item in items:
            self.assign(target, item, frame)
            end = self._block(node.body, frame)
            if end is not None and end.kind is ast.Break:
                return None
            if end is not None and end.kind is not ast.Continue:
                return end
        return self._block(node.orelse, frame)

    def _while(self, node: ast.While, frame: Frame) -> _End | None:
        for _ in range(_MAX_ROUNDS):
            test = self.expressions.value(node.test, frame)
            if not is_known(test):
                break
            if not test:
                return self._block(node.orelse, frame)
            end = self._block(node.body, frame)
            if end is not None and end.kind is ast.Break:
                return None
            if end is not None and end.kind is not ast.Continue:
                return end
        return self._any_of([node.body, []], frame)

    def _try(self, node: ast.Try, frame: Frame) -> _End | None:
        end = self._block(node.body, frame)
        if end is None:
            end = self._block(node.orelse, frame)
        for handler in node.handlers:
            self._any_of([handler.body, []], frame)
        return self._block(node.finalbody, frame) or end

    def _import(self, node: ast.Import | ast.ImportFrom, frame: Frame) -> None:
        here = frame.module.source.path
        if isinstance(node, ast.Import):
            for alias in node.names:
                path = tuple(alias.name.split("."))
                bound = path if alias.asname else path[:1]
                module = self._module(bound, here, 0)
                value = (
                    Named(bound, imported=True)
                    if module is None
                    else ModuleName(module, bound)
                )
                frame.bind(alias.asname or path[0], value)
            return
        path = tuple(node.module.split(".")) if node.module else ()
        module = self._module(path, here, node.level) if path else None
        for alias in node.names:
            if alias.name == "*":
                if module is not None:
                    frame.module.open_names.append(module)
                else:
                    frame.module.open_modules.append(".".join(path))
                continue
            imported = None if module is None else module.find(alias.name)
            if imported is None:
                inner = self._module((*path, alias.name), here, node.level)
                named = (*path, alias.name)
                imported = (
                    Named(named, imported=True)
                    if inner is None
                    else ModuleName(inner, named)
                )
            frame.bind(alias.asname or alias.name, imported)

    def _module(self, path: tuple[str, ...], here: Path, level: int) -> Module | None:
        module = self.modules.imported(path, here, level)
        if module is not None:
            self.module(module)
        return module

    # Calls.

    def call(self, node: ast.Call, frame: Frame) -> Value:
        """Return the result of a call; calls of OpenRTM are recorded."""
        value = self.expressions.value
        function = value(node.func, frame)
        arguments: list[Value] = []
        for part in node.args:
            if isinstance(part, ast.Starred):
                inner = iterated(value(part.value, frame))
                arguments += [] if inner is None else inner
            else:
                arguments.append(value(part, frame))
        keywords = {k.arg: value(k.value, frame) for k in node.keywords if k.arg}
        match function:
            case Named(("super",)) if frame.component and frame.owner:
                return Super(frame.component, frame.owner)
            case Named(("getattr",)) if len(arguments) > 1:
                name = arguments[1]
                is_component = isinstance(name, str) and isinstance(
                    arguments[0], Component
                )
                return (
                    self.expressions.attribute(arguments[0], name)
                    if is_component
                    else UNKNOWN
                )
            case Named(("setattr",)) if len(arguments) == 3:
                holder, name, new = arguments
                if isinstance(holder, Component) and isinstance(name, str):
                    holder.attributes[name] = new
                return None
            case Named((name,), False) if name in _PYTHON:
                return self.expressions.builtin(name, arguments, keywords)
            case Named(path, imported):
                return self._new(path, imported, arguments, keywords, node, frame)
            case Class():
                path = (function.node.name,)
                return self._new(path, True, arguments, keywords, node, frame)
            case Function(owner=None):
                return self._called(function, None, arguments, keywords)
            case Function():
                holder = arguments[0] if arguments else None
                if isinstance(holder, Component):
                    return self._called(function, holder, arguments[1:], keywords)
                return UNKNOWN
            case Bound(holder, name, method) if isinstance(holder, Component):
                if method is not None:
                    return self._called(method, holder, arguments, keywords)
                return self._noted(name, holder, arguments, keywords, node, frame)
            case Bound(holder, name) if isinstance(holder, Made):
                return self._noted(name, holder, arguments, keywords, node, frame)
            case Bound(holder, name):
                return self.expressions.method(holder, name, arguments, keywords)
        if isinstance(node.func, ast.Attribute):
            return self._noted(
                node.func.attr, UNKNOWN, arguments, keywords, node, frame
            )
        return UNKNOWN

    def _new(
        self,
        path: tuple[str, ...],
        imported: bool,
        arguments: list[Value],
        keywords: dict[str, Value],
        node: ast.Call,
        frame: Frame,
    ) -> Made:
        file = frame.module.source.file
        instance = Made(path, imported, arguments, keywords, node, file, self._certain)
        self.made.append(instance)
        return instance

    def _noted(
        self,
        name: str,
        holder: Value,
        arguments: list[Value],
        keywords: dict[str, Value],
        node: ast.Call,
        frame: Frame,
    ) -> Value:
        if name == "bindParameter" and len(arguments) > 1:
            variable = arguments[1]
            if isinstance(variable, list):
                # its value now depends on the configuration
                arguments[1] = [*variable]
                variable[:] = [UNKNOWN] * len(variable)
        instance = self._new((), False, arguments, keywords, node, frame)
        self.calls.append(Call(name, holder, instance))
        return UNKNOWN

    def _called(
        self,
        function: Function,
        component: Component | None,
        arguments: Sequence[Value],
        keywords: dict[str, Value],
    ) -> Value:
        node = function.node
        if node in self._stack or len(self._stack) >= _MAX_DEPTH:
            return UNKNOWN
        parameters = [*node.args.posonlyargs, *node.args.args]
        defaults = node.args.defaults
        outer = Frame(function.module)
        names: dict[str, Value] = {}
        for parameter, default in zip(
            parameters[len(parameters) - len(defaults) :], defaults, strict=True
        ):
            names[parameter.arg] = self.expressions.value(default, outer)
        static = any(dotted(d) == ("staticmethod",) for d in node.decorator_list)
        all_arguments = (
            [*arguments] if component is None or static else [component, *arguments]
        )
        names |= {
            p.arg: value for p, value in zip(parameters, all_arguments, strict=False)
        }
        names |= keywords
        for parameter in (*parameters, *node.args.kwonlyargs):
            names.setdefault(parameter.arg, UNKNOWN)
        self.walked.add(node)
        self._stack.append(node)
        try:
            frame = Frame(function.module, names, component, function.owner)
            end = self._block(node.body, frame)
        finally:
            self._stack.pop()
        return end.value if end is not None and end.kind is ast.Return else None


_PYTHON = FUNCTIONS.keys() | words("print isinstance open hasattr map filter")
