"""YAML with places: texts, lists and mappings that have spans in the user's text.

Scalars are texts: YAML's numbers and booleans are not interpreted. Aliases are rejected, so a short
text cannot expand to a large one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from rtgen.diagnostics import Span

Content: TypeAlias = "str | tuple[Node, ...] | Mapping[str, Node]"

_MAX_LENGTH = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Node:
    """A value. `span` is its place, `key` the place of its key in a mapping."""

    content: Content
    span: Span
    key: Span


class YamlError(Exception):
    """The text is not valid YAML, or has an alias; `span` is the place."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


def parse(text: str, file: str) -> Node:
    """Parse a YAML text; `file` is its displayed path. Raises YamlError.

    If a mapping has equal keys, the last one is used.
    """
    import yaml

    class Loader(yaml.BaseLoader):
        def compose_node(self, parent: Any, index: Any) -> Any:
            reader: Any = self  # the methods are untyped
            if reader.check_event(yaml.AliasEvent):
                mark = reader.peek_event().start_mark
                raise YamlError("an alias", _span(file, mark))
            return super().compose_node(parent, index)

    if len(text) > _MAX_LENGTH:
        message = f"it is longer than {_MAX_LENGTH:,} characters"
        raise YamlError(message, _span(file, None))
    try:
        root = yaml.compose(text, Loader=Loader)
        if root is None:
            return Node("", _span(file, None), _span(file, None))
        return _node(root, file)
    except yaml.MarkedYAMLError as error:
        message = f"not YAML: {error.problem or error.context}"
        raise YamlError(message, _span(file, error.problem_mark)) from None
    except (yaml.YAMLError, RecursionError) as error:
        raise YamlError(f"not YAML: {error}", _span(file, None)) from None


def _node(node: Any, file: str, key: Span | None = None) -> Node:
    span = _span(file, node.start_mark, node.end_mark)
    return Node(_content(node, file), span, key or span)


def _content(node: Any, file: str) -> Content:
    if node.id == "sequence":
        return tuple(_node(item, file) for item in node.value)
    if node.id == "scalar":
        return str(node.value)
    content: dict[str, Node] = {}
    for key, value in node.value:
        place = _span(file, key.start_mark, key.end_mark)
        if key.id != "scalar":
            raise YamlError("not YAML: a key that is not text", place)
        content[key.value] = _node(value, file, place)
    return content


def _span(file: str, start: Any, end: Any = None) -> Span:
    """Return the span between two marks in one line; else of the first character."""
    if start is None:
        return Span(file, 1, 1, 1, 2)
    line, column = start.line + 1, start.column + 1
    last = end.column + 1 if end is not None and end.line == start.line else 0
    return Span(file, line, column, line, max(last, column + 1))
