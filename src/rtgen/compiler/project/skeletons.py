"""Behaviours that do nothing yet: the skeletons that rtgen makes, recognised by their content."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from rtgen.compiler.diagnostics import Span
from rtgen.facts.encodings import decode
from rtgen.facts.files import read_start

_MAX_BYTES = 256 * 1024
_OWN = re.compile(r"\bself\.(?!\w+\.set_servant\()")
"""A use of something of the component, which skeletons do not have."""


def is_untouched(file: Path) -> bool:
    """Return whether a module has nothing but the classes of a skeleton. Raises OSError."""
    data = read_start(file, _MAX_BYTES)
    return is_skeleton(decode(data, standard=True).normal)


def text_of(file: Path) -> str | None:
    """Return the text of a behaviour; None if it cannot be read."""
    try:
        return decode(read_start(file, _MAX_BYTES), standard=True).normal
    except OSError:
        return None


def place(text: str, name: str, class_: str) -> Span | None:
    """Return the place of a class in a skeleton displayed as `name`; None for anything else."""
    if not is_skeleton(text):
        return None
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith((f"class {class_}(", f"class {class_}:")):
            start = len("class ") + 1
            return Span(name, number, start, number, start + len(class_))
    return None


def is_skeleton(text: str) -> bool:
    """Return whether a module's classes have callbacks, and none of their methods does anything."""
    if _OWN.search(text) is not None or "RTC_OK" not in text:
        return False
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return False
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    others = [node for node in _statements(tree.body) if node not in classes]
    if not all(isinstance(node, ast.Import | ast.ImportFrom) for node in others):
        return False
    methods = [node for each in classes for node in _statements(each.body)]
    return bool(methods) and all(map(_is_empty, methods))


def _statements(body: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield the statements of a body that are not texts, such as docstrings."""
    for node in body:
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not is_text and not isinstance(node, ast.Pass):
            yield node


def _is_empty(node: ast.stmt) -> bool:
    """Return whether a method is as rtgen makes it."""
    if not isinstance(node, ast.FunctionDef):
        return False
    for statement in _statements(node.body):
        match statement:
            case ast.Return(value=ast.Name(id="RTC_OK")):
                pass
            case ast.Raise(exc=ast.Name(id="NotImplementedError"), cause=None):
                pass
            case ast.Expr(
                value=ast.Call(
                    func=ast.Attribute(attr="set_servant"),
                    args=[ast.Call(args=[], keywords=[])],
                )
            ):
                pass
            case _:
                return False
    return True
