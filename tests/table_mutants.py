"""Mutants of tables and constants: the assignments of modules and classes, which mutmut leaves out.

A mutant increments a number, changes a text, replaces a name or member by another one of the same
statement, or omits an element.
"""

from __future__ import annotations

import ast
import copy
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.abc import MetaPathFinder, SourceLoader
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from multiprocessing import get_context
from pathlib import Path

import pytest

_LEFT_OUT = ("__all__", "__slots__")


@dataclass(frozen=True, slots=True)
class Mutant:
    """A changed source, with the line and a description of the change."""

    line: int
    change: str
    source: str

    def __str__(self) -> str:
        return f"{self.line}: {self.change}"


def mutants(source: str) -> Iterator[Mutant]:
    """Yield each mutant of each table of a module."""
    text = source.encode()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for value in _values(ast.parse(source).body):
        for node, other, left_out in _changes(value):
            assert node.end_lineno is not None
            assert node.end_col_offset is not None
            start = starts[node.lineno - 1] + node.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            after = ast.unparse(other)
            changed = text[:start] + after.encode() + text[end:]
            what = f"{text[start:end].decode()} -> {after}"
            if left_out is not None:
                what = f"without {ast.unparse(left_out)}"
            line = node.lineno if left_out is None else left_out.lineno
            yield Mutant(line, what, changed.decode())


def _values(body: Sequence[ast.stmt]) -> Iterator[ast.expr]:
    """Yield the values of assignments outside of functions."""
    for statement in body:
        if isinstance(statement, ast.ClassDef):
            yield from _values(statement.body)
        elif isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value:
            if _is_type(statement.value):
                continue
            targets = getattr(statement, "targets", [getattr(statement, "target", 0)])
            if not any(isinstance(t, ast.Name) and t.id in _LEFT_OUT for t in targets):
                yield statement.value


def _is_type(value: ast.expr) -> bool:
    match value:
        case ast.Subscript() | ast.Call(func=ast.Name(id="TypeVar" | "ParamSpec")):
            return True
    return False


def _changes(
    value: ast.expr,
) -> Iterator[tuple[ast.expr, ast.expr, ast.expr | None]]:
    """Yield parts of an expression, their replacements, and the omitted element, if any."""
    nodes = [node for node in ast.walk(value) if isinstance(node, ast.expr)]
    names = _distinct(n.id for n in nodes if isinstance(n, ast.Name) and n.id.isupper())
    members = _distinct(n.attr for n in nodes if isinstance(n, ast.Attribute))
    parts_of_texts = {
        part for n in nodes if isinstance(n, ast.JoinedStr) for part in n.values
    }
    for node in nodes:
        match node:
            case ast.Constant() if node not in parts_of_texts:
                if (other := _other(node.value)) is not None:
                    yield node, ast.Constant(other), None
            case ast.Name() if node.id in names and len(names) > 1:
                yield node, ast.Name(_following(names, node.id)), None
            case ast.Attribute() if len(members) > 1:
                other_name = _following(members, node.attr)
                yield node, ast.Attribute(node.value, other_name, node.ctx), None
            case ast.Dict() | ast.Tuple() | ast.List() | ast.Set():
                yield from ((node, rest, one) for rest, one in _without_one(node))


def _distinct(names: Iterator[str]) -> list[str]:
    return list(dict.fromkeys(names))


def _following(names: list[str], name: str) -> str:
    return names[(names.index(name) + 1) % len(names)]


def _other(value: object) -> object:
    match value:
        case bool():
            return not value
        case int() | float():
            return value + 1
        case str() if value:
            return f"XX{value}XX"
        case bytes() if value:
            return b"XX" + value
    return None


def _without_one(
    node: ast.Dict | ast.Tuple | ast.List | ast.Set,
) -> Iterator[tuple[ast.expr, ast.expr]]:
    count = len(node.values if isinstance(node, ast.Dict) else node.elts)
    for at in range(count if count > 1 else 0):
        rest = copy.deepcopy(node)
        if isinstance(rest, ast.Dict):
            one = rest.keys[at] or rest.values[at]
            del rest.keys[at], rest.values[at]
        else:
            one = rest.elts[at]
            del rest.elts[at]
        yield rest, one


class _Changed(MetaPathFinder, SourceLoader):
    """Imports one module from a text."""

    def __init__(self, module: str, path: Path, source: str) -> None:
        self._module, self._path, self._source = module, path, source

    def find_spec(
        self, name: str, path: object = None, target: object = None
    ) -> ModuleSpec | None:
        """Return the spec of the module; None for any other module."""
        if name != self._module:
            return None
        return spec_from_loader(name, self, origin=str(self._path))

    def get_filename(self, name: str) -> str:
        """Return the original file, for tracebacks."""
        return str(self._path)

    def get_data(self, path: str | bytes) -> bytes:
        """Return the changed text; without `path_stats`, bytecode is never cached."""
        return self._source.encode()


def _test(module: str, path: Path, source: str, arguments: list[str]) -> None:
    """Run tests, and exit from this process with pytest's exit code."""
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    sys.meta_path.insert(0, _Changed(module, path, source))
    os._exit(pytest.main(arguments))


def caught(
    module: str, path: Path, source: str, arguments: list[str], seconds: float
) -> bool:
    """Return whether tests fail, or do not end, with a changed source of a module.

    The process is forked: no module of rtgen may have been imported before.
    """
    process = get_context("fork").Process(
        target=_test, args=(module, path, source, arguments)
    )
    process.start()
    process.join(seconds)
    if process.is_alive():
        process.kill()
        process.join()
        return True
    return process.exitcode != 0
