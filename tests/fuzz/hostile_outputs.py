"""Content of generated files, by the parser of each language: shape, names, strings.

The shape is what a file does, without the names and texts in it; two files of one shape differ in
data only. Statements are sorted, since rtgen sorts some by their names.
"""

from __future__ import annotations

import ast
import configparser
import re
import shlex
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any
from xml.etree import ElementTree

from hostile_texts import MARK

from rtgen.compiler.backends.kit.quoting.python import string_literal

_MISLEADING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
_BREAK = re.compile(r"\r\n|\r|\n")


@dataclass
class Content:
    """`shape` is comparable; `names` are identifiers and keys, `strings` are data."""

    shape: Any = None
    names: set[str] = field(default_factory=set)
    strings: set[str] = field(default_factory=set)


def content(path: str, text: str) -> Content:
    """Return the content of a generated file; an ill-formed one raises the parser's error."""
    found = Content()
    name = PurePosixPath(path)
    reader = _READERS.get(name.suffix or name.name)
    if reader is None:
        raise ValueError(f"{path}: no parser for files of this kind")
    reader(text, found)
    return found


def _python(text: str, found: Content) -> None:
    found.shape = _node(ast.parse(text), found)
    # Comments are not in the tree.
    if (odd := _MISLEADING.search(text)) is not None:
        raise ValueError(f"U+{ord(odd[0]):04X} stands in the text")


def _node(node: Any, found: Content) -> Any:
    if isinstance(node, list):
        shapes = [_node(item, found) for item in node if not _is_docstring(item)]
        if node and isinstance(node[0], ast.stmt):
            return tuple(sorted(map(repr, shapes)))
        return tuple(shapes)
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        found.strings.add(node.value)
        return "text"
    if not isinstance(node, ast.AST):
        if isinstance(node, str):
            found.names.update(node.split("."))
            return "name"
        return node
    return (
        type(node).__name__,
        *(_node(getattr(node, name, None), found) for name in node._fields),
    )


def _is_docstring(node: object) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _xml(text: str, found: Content) -> None:
    parser = ElementTree.XMLParser(
        target=ElementTree.TreeBuilder(insert_comments=False)
    )
    parser.feed(text.encode())
    root = parser.close()
    shapes = []
    for element in root.iter():
        if MARK not in element.tag and element.tag.endswith("Properties"):
            found.strings.update(element.attrib.values())
            continue
        found.strings.update(v for v in element.attrib.values())
        found.strings.add(element.text or "")
        shapes.append((element.tag, tuple(sorted(element.attrib))))
    found.shape = tuple(shapes)


def _conf(text: str, found: Content) -> None:
    """Parse as OpenRTM does: lines, comments, keys before the first `:` or `=`."""
    keys = []
    for line in _BREAK.split(text):
        line = line.lstrip(" \t")
        if not line or line[0] in "#!":
            continue
        if line.endswith("\\"):
            raise ValueError(f"a line that goes on: {line!r}")
        key, _, value = line.replace("=", ":", 1).partition(":")
        found.strings.add(value.strip())
        found.names.add(key.strip())
        if not key.startswith("conf."):  # what cannot be written there, connect.py sets
            keys.append(key.strip())
    found.shape = tuple(
        sorted("" if MARK in key or "twin" in key else key for key in keys)
    )


def _shell(text: str, found: Content) -> None:
    """Add words and operators of the lines that may contain a text; other lines unchanged."""
    shapes: list[object] = []
    for line in text.split("\n"):
        if line.lstrip().startswith("#"):
            continue
        try:
            lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
            lexer.whitespace_split = True
            words = list(lexer)
        except ValueError:
            words = [line]
        shapes.append(
            tuple("" if MARK in word or "twin" in word else word for word in words)
        )
        found.strings.update(words)
    found.shape = tuple(shapes)


def _batch(text: str, found: Content) -> None:
    found.shape = tuple(
        line for line in text.split("\n") if not line.lower().startswith("rem ")
    )


def _ruby(text: str, found: Content) -> None:
    found.shape = tuple(
        line for line in text.split("\n") if not line.lstrip().startswith("#")
    )


def _entries(text: str, found: Content) -> None:
    if "[rtgen.components]" not in text:
        found.shape = len(text.split("\n"))
        return
    parser = configparser.ConfigParser(delimiters=("=",), interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read_string(text)
    found.names.update(*(section.keys() for section in parser.values()))
    found.shape = tuple((name, len(parser[name])) for name in parser.sections())


def _eds(text: str, found: Content) -> None:
    shapes: Counter[str] = Counter()
    section = ""
    for line in _BREAK.split(text):
        if line.startswith("[") and line.endswith("]"):
            section = line
            found.names.add(line)
        elif line and not line.startswith(";"):
            key, _, value = line.partition("=")
            found.strings.add(value)
            own = MARK in section + key or "twin" in section + key
            shapes["text" if own else f"{section} {key}"] += 1
    found.shape = tuple(sorted(shapes.items()))


def _idl(text: str, found: Content) -> None:
    _tokens(_IDL_TOKEN, text, found)


def _typescript(text: str, found: Content) -> None:
    _tokens(_TYPESCRIPT_TOKEN, text, found)


def _msg(text: str, found: Content) -> None:
    _tokens(_MSG_TOKEN, text, found)


def _tokens(pattern: re.Pattern[str], text: str, found: Content) -> None:
    """Add tokens, without comments; strings separately."""
    shapes = []
    for kind, token in pattern.findall(text):
        if kind:
            continue
        if token[0] in "\"'":
            found.strings.add(token)
            token = "text"
        elif token[0].isalpha() or token[0] == "_":
            found.names.add(token)
            token = "name"
        shapes.append(token)
    found.shape = tuple(shapes)


_IDL_TOKEN = re.compile(
    r"(//[^\n]*|/\*.*?\*/|\s+)|(\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|\w+|.)",
    re.DOTALL,
)

# A line comment ends at each line terminator of ECMA-262 (12.3); a template is code.
_TYPESCRIPT_TOKEN = re.compile(
    r"(//[^\n\r\u2028\u2029]*|/\*.*?\*/|\s+)"
    r"|(\"(?:\\.|[^\"\\\n\r])*\"|'(?:\\.|[^'\\\n\r])*'|\w+|.)",
    re.DOTALL,
)

_MSG_TOKEN = re.compile(
    r"(#[^\n]*|\s+)|(\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|\w+|.)", re.DOTALL
)

_READERS: dict[str, Callable[[str, Content], None]] = {
    ".py": _python,
    ".xml": _xml,
    ".svg": _xml,
    ".conf": _conf,
    ".sh": _shell,
    ".bat": _batch,
    ".rb": _ruby,
    ".txt": _entries,
    ".eds": _eds,
    ".dcf": _eds,
    ".idl": _idl,
    ".ts": _typescript,
    ".msg": _msg,
    ".srv": _msg,
    ".action": _msg,
    ".typed": lambda _text, _found: None,
    ".gitignore": lambda _text, _found: None,
}


def compare(path: str, made: Content, twin: Content) -> None:
    """Raise ValueError if the file differs in more than data from its harmless twin."""
    if made.shape != twin.shape:
        raise ValueError(f"{path} is not what its twin is: {_difference(made, twin)}")
    for name in made.names - twin.names:
        if MARK.lower() not in name.lower():
            raise ValueError(f"{path} has the name {string_literal(name)}")


def _difference(made: Content, twin: Content) -> str:
    pairs = zip(_flat(made.shape), _flat(twin.shape), strict=False)
    for one, other in pairs:
        if one != other:
            return f"{str(one)[:300]} where {str(other)[:300]} was"
    return f"{str(made.shape)[-200:]} at the end, {str(twin.shape)[-200:]} was"


def _flat(shape: Any) -> list[Any]:
    if isinstance(shape, tuple) and any(isinstance(part, tuple) for part in shape):
        return [leaf for part in shape for leaf in _flat(part)]
    return [shape]
