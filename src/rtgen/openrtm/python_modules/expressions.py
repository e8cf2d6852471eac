"""Abstract evaluation of expressions: values that are known without running the module."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterable
from typing import Any, Protocol

from rtgen.openrtm.python_modules.values import (
    CONSTANTS,
    UNKNOWN,
    Bound,
    Class,
    Component,
    Frame,
    Function,
    Made,
    Named,
    Super,
    Unknown,
    Value,
    merged,
)

_MAX_DEPTH = 60
_WIDE = re.compile(r"\d{4}")
_MAX_LENGTH = 100_000
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    function.__name__: function
    for function in (
        *(str, int, float, bool, repr, len, list, tuple, dict, range, zip, enumerate),
        *(sorted, reversed, format, min, max, abs, chr, ord, sum),
    )
}
"""The functions of Python that are called to find out what a module does."""
_METHODS: dict[type, frozenset[str]] = {
    str: frozenset(
        (
            *("format", "join", "upper", "lower", "title", "capitalize", "replace"),
            *("strip", "lstrip", "rstrip", "split", "zfill", "rjust", "ljust"),
        )
    ),
    list: frozenset(("append", "extend", "insert", "index", "copy", "count")),
    tuple: frozenset(("index", "count")),
    dict: frozenset(("items", "keys", "values", "get", "update", "setdefault", "copy")),
}
_STORING_METHODS = frozenset(
    ("append", "extend", "insert", "update", "setdefault", "get")
)
"""Methods that only store or forward values, so that these may be unknown."""


def is_known(value: Value, depth: int = 0) -> bool:
    """Return whether a value is a constant, or consists of constants."""
    if isinstance(value, CONSTANTS):
        return True
    if isinstance(value, list | tuple | range) and depth < 10:
        return len(value) <= _MAX_LENGTH and all(is_known(v, depth + 1) for v in value)
    if isinstance(value, dict) and depth < 10:
        return all(is_known(v, depth + 1) for v in value.values())
    return False


def iterated(value: Value) -> list[Value] | None:
    """Return the items that a loop iterates over; None if unknown."""
    if isinstance(value, list | tuple | str | dict | range):
        return list(value) if len(value) <= _MAX_LENGTH else None
    return None


class Statements(Protocol):
    """Interface to the walker, which evaluates statements."""

    def step(self) -> None: ...

    def call(self, node: ast.Call, frame: Frame, /) -> Value: ...

    def assign(self, target: ast.expr, value: Value, frame: Frame, /) -> None: ...


class Expressions:
    """Evaluates expressions in a frame; calls are delegated to the walker."""

    def __init__(self, walker: Statements) -> None:
        self._walker = walker
        self._depth = 0

    def value(self, node: ast.expr | None, frame: Frame) -> Value:
        """Return the value of an expression, UNKNOWN if it is computed at run time."""
        if node is None or self._depth >= _MAX_DEPTH:
            return UNKNOWN
        self._walker.step()
        self._depth += 1
        try:
            return self._value(node, frame)
        finally:
            self._depth -= 1

    def _value(self, node: ast.expr, frame: Frame) -> Value:
        match node:
            case ast.Constant(value=constant):
                return constant
            case ast.Name(id=name):
                return frame.find(name)
            case ast.Attribute(value=inner, attr=name):
                return self.attribute(self.value(inner, frame), name)
            case ast.List(elts=items):
                return self._items(items, frame)
            case ast.Tuple(elts=items):
                return tuple(self._items(items, frame))
            case ast.Dict(keys=keys, values=values):
                return self._dict(keys, values, frame)
            case ast.BinOp(left=left, op=op, right=right):
                return self._joined(left, op, right, frame)
            case ast.UnaryOp(op=op, operand=operand):
                return self._unary(op, self.value(operand, frame))
            case ast.BoolOp():
                return self._logic(node, frame)
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                return self._compared(left, op, right, frame)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                condition = self.value(test, frame)
                yes, no = self.value(body, frame), self.value(orelse, frame)
                if is_known(condition):
                    return yes if condition else no
                return merged(yes, no)
            case ast.JoinedStr(values=parts):
                return self._text([self.value(part, frame) for part in parts])
            case ast.FormattedValue(value=inner, format_spec=spec):
                return self._formatted(inner, spec, node.conversion, frame)
            case ast.Subscript(value=inner, slice=index):
                return self._subscript(self.value(inner, frame), index, frame)
            case ast.ListComp(elt=element, generators=[loop]):
                return self._comprehension(element, loop, frame)
            case ast.GeneratorExp(elt=element, generators=[loop]):
                return self._comprehension(element, loop, frame)
            case ast.Call():
                return self._walker.call(node, frame)
        return UNKNOWN

    def attribute(self, holder: Value, name: str) -> Value:
        """Return an attribute of a value."""
        match holder:
            case Component():
                if name in holder.attributes:
                    return holder.attributes[name]
                return Bound(holder, name, holder.method(name))
            case Super(component, owner):
                return Bound(component, name, component.method(name, owner))
            case Class():
                for node in holder.node.body:
                    if isinstance(node, ast.FunctionDef) and node.name == name:
                        return Function(node, holder.module, holder)
                return UNKNOWN
            case Named(path, imported):
                return Named((*path, name), imported)
            case Unknown():
                return UNKNOWN
        if hasattr(holder, "attribute_of"):
            return holder.attribute_of(name)
        return Bound(holder, name)

    def _items(self, nodes: Iterable[ast.expr], frame: Frame) -> list[Value]:
        values: list[Value] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                inner = iterated(self.value(node.value, frame))
                values += [UNKNOWN] if inner is None else inner
            else:
                values.append(self.value(node, frame))
        return values

    def _dict(
        self, keys: list[ast.expr | None], nodes: list[ast.expr], frame: Frame
    ) -> Value:
        values = {}
        for key, node in zip(keys, nodes, strict=True):
            name = self.value(key, frame)
            if not isinstance(name, CONSTANTS):
                return UNKNOWN
            values[name] = self.value(node, frame)
        return values

    def _joined(
        self, left: ast.expr, op: ast.operator, right: ast.expr, frame: Frame
    ) -> Value:
        # A long sum is nested to the left: it is not counted as depth.
        parts = [(op, right)]
        while isinstance(left, ast.BinOp):
            parts.append((left.op, left.right))
            left = left.left
        joined = self.value(left, frame)
        for each, node in reversed(parts):
            joined = self._operation(joined, each, self.value(node, frame))
        return joined

    def _operation(self, one: Value, op: ast.operator, other: Value) -> Value:
        function = _OPERATORS.get(type(op))
        lists = isinstance(one, list) and isinstance(other, list | int)
        if function is None or not (lists or (is_known(one) and is_known(other))):
            return UNKNOWN
        if isinstance(op, ast.Mod) and isinstance(one, str) and _WIDE.search(one):
            return UNKNOWN
        if isinstance(op, ast.Mult):
            sizes = [len(v) for v in (one, other) if isinstance(v, str | list | tuple)]
            counts = [v for v in (one, other) if isinstance(v, int)]
            if sizes and counts and sizes[0] * counts[0] > _MAX_LENGTH:
                return UNKNOWN
        return self.guarded(function, one, other)

    def guarded(
        self, function: Callable[..., Any], *args: Value, **more: Value
    ) -> Value:
        """Return the result of a Python function for known values; UNKNOWN if it fails or is
        large.
        """
        try:
            result = function(*args, **more)
            if isinstance(result, int) and abs(result) >= 1 << 256:
                return UNKNOWN
            if (
                isinstance(result, str | list | tuple | bytes)
                and len(result) > _MAX_LENGTH
            ):
                return UNKNOWN
            return result
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            return UNKNOWN

    def _unary(self, op: ast.unaryop, operand: Value) -> Value:
        if not is_known(operand):
            return UNKNOWN
        if isinstance(op, ast.Not):
            return not operand
        if isinstance(op, ast.USub):
            return self.guarded(operator.neg, operand)
        return operand if isinstance(op, ast.UAdd) else UNKNOWN

    def _logic(self, node: ast.BoolOp, frame: Frame) -> Value:
        values = [self.value(part, frame) for part in node.values]
        if not all(map(is_known, values)):
            return UNKNOWN
        deciding = isinstance(node.op, ast.Or)
        return next((v for v in values if bool(v) is deciding), values[-1])

    def _compared(
        self, left: ast.expr, op: ast.cmpop, right: ast.expr, frame: Frame
    ) -> Value:
        one, other = self.value(left, frame), self.value(right, frame)
        if not (is_known(one) and is_known(other)):
            return UNKNOWN
        return self.guarded(_COMPARISONS[type(op)], one, other)

    def _text(self, parts: list[Value]) -> Value:
        if not all(isinstance(part, str) for part in parts):
            return UNKNOWN
        return self.guarded("".join, parts)

    def _formatted(
        self, inner: ast.expr, spec: ast.expr | None, conversion: int, frame: Frame
    ) -> Value:
        value = self.value(inner, frame)
        form = "" if spec is None else self.value(spec, frame)
        if not is_known(value) or not isinstance(form, str) or len(form) > 20:
            return UNKNOWN
        if conversion == ord("r"):
            value = repr(value)
        return self.guarded(format, value, form)

    def _subscript(self, holder: Value, index: ast.expr, frame: Frame) -> Value:
        key = self.value(index, frame)
        if not isinstance(holder, list | tuple | dict | str) or not isinstance(
            key, str | int
        ):
            return UNKNOWN
        return self.guarded(operator.getitem, holder, key)

    def _comprehension(
        self, element: ast.expr, loop: ast.comprehension, frame: Frame
    ) -> Value:
        items = iterated(self.value(loop.iter, frame))
        if items is None:
            return UNKNOWN
        values = []
        for item in items:
            inner = frame.inner()
            self._walker.assign(loop.target, item, inner)
            tests = [self.value(test, inner) for test in loop.ifs]
            if not all(map(is_known, tests)):
                return UNKNOWN
            if all(tests):
                values.append(self.value(element, inner))
        return values

    # Calls of Python's built-in functions.

    def builtin(
        self, name: str, args: list[Value], keywords: dict[str, Value]
    ) -> Value:
        """Return the result of a built-in function; UNKNOWN if it is irrelevant here."""
        function = FUNCTIONS.get(name)
        passing = name in ("len", "list", "tuple", "zip", "enumerate", "reversed")
        fine = all(is_known(a) or (passing and iterated(a) is not None) for a in args)
        if function is None or not fine or not all(map(is_known, keywords.values())):
            return UNKNOWN
        if name == "range" and any(
            isinstance(a, int) and abs(a) > _MAX_LENGTH for a in args
        ):
            return UNKNOWN
        result = self.guarded(function, *args, **keywords)
        lazy = isinstance(result, zip | enumerate | reversed | range)
        return self.guarded(list, result) if lazy else result

    def method(
        self, holder: Value, name: str, args: list[Value], keywords: dict[str, Value]
    ) -> Value:
        """Return the result or effect of a method of a text, list or dict."""
        if name not in _METHODS.get(type(holder), ()):
            return UNKNOWN
        if name not in _STORING_METHODS and not all(
            map(is_known, (*args, *keywords.values()))
        ):
            return UNKNOWN
        if isinstance(holder, list) and len(holder) > _MAX_LENGTH:
            return UNKNOWN
        if any(isinstance(a, int) and a > _MAX_LENGTH for a in args):
            return UNKNOWN
        if isinstance(holder, str):
            texts = [holder, *(a for a in args if isinstance(a, str))]
            large = sum(map(len, texts)) > _MAX_LENGTH // 10 and name == "replace"
            if large or (name == "format" and _WIDE.search(holder)):
                return UNKNOWN
        result = self.guarded(getattr(holder, name), *args, **keywords)
        views = isinstance(
            result, type({}.items()) | type({}.keys()) | type({}.values())
        )
        return list(result) if views else result


def is_made(value: Value, *names: str) -> bool:
    """Return whether a value is the result of a call of one of these classes."""
    return isinstance(value, Made) and value.path[-1:] in {(name,) for name in names}
