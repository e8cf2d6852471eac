"""Folders that a module adds to `sys.path`, as far as the text tells: it is not executed."""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from rtgen.openrtm.python_modules.values import dotted

_ADDING: Final = ("append", "insert", "extend")
_MAX_DEPTH: Final = 20
_MAX_FOLDERS: Final = 20
_SAME: Final = ("str", "Path", "abspath", "realpath", "normpath", "fspath", "list")
"""Functions whose result is their argument, as far as folders are concerned."""
_SELF: Final = ("resolve", "absolute", "as_posix")
"""Methods of paths of which the same is true."""


def added_folders(tree: ast.Module, file: Path) -> list[Path]:
    """Return the existing folders that a module adds; relative paths begin at the module's."""
    reading = _Reading(tree, file)
    folders: dict[Path, None] = {}
    for node in ast.walk(tree):
        for value in _additions(node):
            for text in reading.texts(value):
                folder = Path(os.path.normpath(file.parent / text))
                if len(folders) < _MAX_FOLDERS and folder.is_dir():
                    folders[folder] = None
    return list(folders)


def _additions(node: ast.AST) -> Iterator[ast.expr]:
    """Yield the expressions that a statement or call adds to `sys.path`."""
    match node:
        case ast.Call(func=ast.Attribute(value=path, attr=name), args=[*_, last]):
            if name in _ADDING and _is_path(path):
                yield last
        case ast.AugAssign(target=path, op=ast.Add(), value=value) if _is_path(path):
            yield value
        case ast.Assign(targets=[path], value=value) if _is_path(path):
            yield value


def _is_path(node: ast.expr) -> bool:
    return dotted(node) == ("sys", "path")


class _Reading:
    """Evaluates expressions of paths."""

    def __init__(self, tree: ast.Module, file: Path) -> None:
        self._file = str(file.absolute())
        self._variables = {
            target.id: node.value
            for node in tree.body
            if isinstance(node, ast.Assign)
            for target in node.targets
            if isinstance(target, ast.Name)
        }

    def texts(self, node: ast.expr, depth: int = 0) -> list[str]:
        """Return the texts of an expression or of the items of a list; none if unknown."""
        if depth > _MAX_DEPTH:
            return []
        below = depth + 1
        match node:
            case ast.List(elts=items) | ast.Tuple(elts=items):
                return [text for each in items for text in self.texts(each, below)]
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                if _is_list(left) or _is_list(right):
                    return [*self.texts(left, below), *self.texts(right, below)]
        text = self._text(node, below)
        return [] if text is None else [text]

    def _text(self, node: ast.expr, depth: int) -> str | None:
        if depth > _MAX_DEPTH:
            return None
        below = depth + 1
        match node:
            case ast.Constant(value=str(text)):
                return text
            case ast.Name(id="__file__"):
                return self._file
            case ast.Name(id=name) if name in self._variables:
                return self._text(self._variables[name], below)
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                parts = self._text(left, below), self._text(right, below)
                return None if None in parts else "".join(map(str, parts))
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return self._joined([left, right], below)
            case ast.Attribute(value=value, attr="parent"):
                return self._parent(value, 1, below)
            case ast.Subscript(
                value=ast.Attribute(value=value, attr="parents"),
                slice=ast.Constant(value=int(number)),
            ):
                return self._parent(value, number + 1, below)
            case ast.Call():
                return self._called(node, below)
        return None

    def _called(self, node: ast.Call, depth: int) -> str | None:
        inner: ast.expr | None = None
        match node.func:
            case ast.Attribute(value=inner, attr=name):
                pass
            case ast.Name(id=name):
                pass
            case _:
                return None
        if name == "join":
            return self._joined(node.args, depth)
        if name == "dirname" and len(node.args) == 1:
            return self._parent(node.args[0], 1, depth)
        if name in _SAME and len(node.args) == 1:
            return self._text(node.args[0], depth)
        if name in _SELF and inner is not None:
            return self._text(inner, depth)
        if name == "joinpath" and inner is not None:
            return self._joined([inner, *node.args], depth)
        return None

    def _joined(self, nodes: list[ast.expr], depth: int) -> str | None:
        parts = [self._text(each, depth) for each in nodes]
        texts = [part for part in parts if part is not None]
        return str(Path(*texts)) if texts and len(texts) == len(parts) else None

    def _parent(self, node: ast.expr, count: int, depth: int) -> str | None:
        text = self._text(node, depth)
        if text is None or not 0 < count <= _MAX_DEPTH:
            return None
        folder = Path(os.path.normpath(text))
        for _ in range(count):
            folder = folder.parent
        return str(folder)


def _is_list(node: ast.expr) -> bool:
    return isinstance(node, ast.List | ast.Tuple) or _is_path(node)
