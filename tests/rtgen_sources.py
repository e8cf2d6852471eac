"""The source files of rtgen, which two distributions install into one namespace."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import rtgen


def sources() -> dict[str, Path]:
    """Return all Python files by their path below `rtgen` (`runtime/idl.py`), in order."""
    found = {
        path.relative_to(root).as_posix(): path
        for root in map(Path, rtgen.__path__)
        for path in root.rglob("*.py")
    }
    return dict(sorted(found.items()))


def trees(pattern: str) -> Iterator[tuple[str, ast.Module]]:
    """Yield the syntax trees of the files whose text matches a pattern somewhere."""
    for name, path in sources().items():
        text = path.read_text("utf-8")
        if re.search(pattern, text, re.MULTILINE):
            yield name, ast.parse(text)


def statements(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield all statements, of which a tree has far fewer than expressions."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for field in ("body", "orelse", "finalbody", "handlers", "cases"):
            waiting += getattr(node, field, ())


@cache
def imports(path: Path) -> frozenset[tuple[str, str]]:
    """Return what a file imports anywhere in its text: a module, and a name of it or nothing."""
    found: set[tuple[str, str]] = set()
    for node in statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {(alias.name, "") for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {(node.module, alias.name) for alias in node.names}
    return frozenset(found)
