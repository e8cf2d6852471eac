"""What a behaviour's module shows by itself: texts that are not Python, and callbacks in vain."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Iterator

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.project_rules import MISSPELT_CALLBACK, NO_ANSWER, NOT_PYTHON
from rtgen.compiler.typemap.components.actions import ACTIONS

_CALLBACKS = frozenset(action.method for action in ACTIONS)
_LIKE_A_CALLBACK = re.compile(r"^ +def ([oO]n\w+)\(", re.M)
_ENDS = frozenset({"exit", "_exit", "abort", "assert_never"})
"""Functions that do not return."""


def findings(
    package: str, file: str, text: str, parse: Callable[[str], ast.Module] = ast.parse
) -> Iterator[Diagnostic]:
    """Yield what Python says about a module that it cannot read, else callbacks in vain.

    These have nearly the name of a callback, and nothing in the module uses them, or return
    nothing. `package` is that of the generated modules with the bases of behaviours; `parse` may
    keep the tree for others.
    """
    try:
        tree = parse(text)
    except SyntaxError as error:
        line, column = error.lineno or 1, max(error.offset or 1, 1)
        span = Span(file, line, column, line, column + 1)
        yield NOT_PYTHON.at(span, f"Python cannot read this: {error.msg}")
    except (ValueError, RecursionError) as error:
        yield NOT_PYTHON.at(Span(file, 1, 1, 1, 2), f"Python cannot read this: {error}")
    else:
        for method in _methods(tree, package) if _LIKE_A_CALLBACK.search(text) else ():
            yield from _of_method(method, file, text)


def misspelt(packages: Iterable[str], file: str, text: str) -> Iterator[Diagnostic]:
    """Yield the findings about misspelt callbacks alone, of a module that Python can read.

    `packages` may have the bases of its behaviours.
    """
    if _CALLBACKS.issuperset(_LIKE_A_CALLBACK.findall(text)):
        return
    for package in packages:
        for each in findings(package, file, text):
            if each.code == MISSPELT_CALLBACK.code:
                yield each


def _methods(tree: ast.Module, package: str) -> Iterator[ast.FunctionDef]:
    """Yield the methods of behaviours."""
    bases = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        and (node.module or "").startswith(f"{package}.")
        for alias in node.names
        if alias.name.endswith("Base")
    }
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and any(
            isinstance(base, ast.Name) and base.id in bases for base in node.bases
        ):
            yield from (m for m in node.body if isinstance(m, ast.FunctionDef))


def _of_method(method: ast.FunctionDef, file: str, text: str) -> Iterator[Diagnostic]:
    if method.name in _CALLBACKS:
        lines = text.split("\n")[method.lineno - 1 : method.end_lineno]
        place = _without_answer(method, any("yield" in line for line in lines))
        if place is not None:
            yield NO_ANSWER.at(
                Span(file, *place),
                f"{method.name} ends without a return code, which a run takes for an error",
            )
        return
    near = _callback_meant(method.name)
    if near and len(re.findall(rf"\b{method.name}\b", text)) == 1:
        yield MISSPELT_CALLBACK.at(
            Span(file, *_place_of_name(method)),
            f"{method.name} is no callback of a component, and nothing calls it",
            hint=f"did you mean {near}?",
        )


def _callback_meant(name: str) -> str | None:
    """Return the callback that a method is likely meant as: `onExecute`, `on_excute`."""
    if not name.lower().startswith("on"):
        return None
    from difflib import get_close_matches

    folded = {each.replace("_", ""): each for each in _CALLBACKS}
    word = name.replace("_", "").lower()
    close = get_close_matches(word, folded, n=1, cutoff=0.85)
    return folded[close[0]] if close else None


def _place_of_name(method: ast.FunctionDef) -> tuple[int, int, int, int]:
    start = method.col_offset + len("def ") + 1
    return method.lineno, start, method.lineno, start + len(method.name)


def _without_answer(
    method: ast.FunctionDef, may_yield: bool
) -> tuple[int, int, int, int] | None:
    """Return the place where a callback can end without a value; None if it cannot, or is unclear.

    Unclear are decorated callbacks, generators, and stubs of three dots.
    """
    is_stub = any(
        isinstance(each, ast.Expr)
        and isinstance(each.value, ast.Constant)
        and each.value.value is ...
        for each in method.body
    )
    if method.decorator_list or is_stub:
        return None
    yields = ast.Yield | ast.YieldFrom
    if may_yield and any(isinstance(n, yields) for n in _own_nodes(method.body)):
        return None
    for each in _own_statements(method.body):
        match each:
            case ast.Return(value=None | ast.Constant(value=None)):
                end = each.end_col_offset or each.col_offset
                return each.lineno, each.col_offset + 1, each.lineno, end + 1
    return None if _leaves(method.body) else _place_of_name(method)


def _own_nodes(body: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Yield the nodes of statements, without those of functions and classes in them."""
    for node in body:
        yield node
        if not isinstance(
            node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda
        ):
            yield from _own_nodes(ast.iter_child_nodes(node))


def _own_statements(body: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Yield the statements of a function in order, without those of functions in it."""
    for node in body:
        yield node
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for field in ("body", "handlers", "orelse", "finalbody", "cases"):
                yield from _own_statements(getattr(node, field, ()))


def _leaves(body: Iterable[ast.stmt]) -> bool:
    """Return whether statements never reach their end."""
    return any(map(_never_ends, body))


def _never_ends(node: ast.stmt) -> bool:
    match node:
        case ast.Return() | ast.Raise():
            return True
        case ast.Assert(test=ast.Constant(value=value)):
            return not value
        case ast.If(body=body, orelse=other):
            return _leaves(body) and _leaves(other)
        case ast.While(test=ast.Constant(value=value)) if value:
            return not _breaks(node)
        case ast.While(orelse=other) | ast.For(orelse=other):
            return _leaves(other) and not _breaks(node)
        case ast.With(body=body):
            return _leaves(body)
        case ast.Try(body=body, handlers=handlers, orelse=other, finalbody=last):
            ways = [
                _leaves([*body, *other]),
                *(_leaves(each.body) for each in handlers),
            ]
            return _leaves(last) or all(ways)
        case ast.Match(cases=cases):
            last_case = cases[-1]
            is_complete = last_case.guard is None and _takes_all(last_case.pattern)
            return is_complete and all(_leaves(each.body) for each in cases)
        case ast.Expr(
            value=ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name))
        ):
            return name in _ENDS
    return False


def _takes_all(pattern: ast.pattern) -> bool:
    match pattern:
        case ast.MatchAs(pattern=inner):
            return inner is None or _takes_all(inner)
        case ast.MatchOr(patterns=patterns):
            return any(map(_takes_all, patterns))
    return False


def _breaks(loop: ast.While | ast.For) -> bool:
    """Return whether a loop has a `break` of its own."""
    waiting: list[ast.AST] = [*loop.body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Break):
            return True
        if isinstance(node, ast.While | ast.For):
            waiting += node.orelse
        elif not isinstance(
            node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
        ):
            waiting += ast.iter_child_nodes(node)
    return False
