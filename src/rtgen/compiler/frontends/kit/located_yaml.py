"""YAML with places: texts, lists and mappings that have spans in the user's text.

Scalars are texts: YAML's numbers and booleans are not interpreted. Aliases are rejected, so a short
text cannot expand to a large one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

from rtgen.compiler.diagnostics import Span

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

    If a mapping has equal keys, the last one is used. libyaml reads the text if PyYAML has it;
    what libyaml rejects is read by the parser in Python, for the same messages without libyaml.
    """
    import yaml

    if len(text) > _MAX_LENGTH:
        message = f"it is longer than {_MAX_LENGTH:,} characters"
        raise YamlError(message, _span(file, None))
    try:
        if yaml.__with_libyaml__:
            with suppress(yaml.YAMLError, UnicodeEncodeError):
                return _document(yaml.parse(text, Loader=yaml.CBaseLoader), file)
        return _document(yaml.parse(text, Loader=yaml.BaseLoader), file)
    except yaml.MarkedYAMLError as error:
        message = f"not YAML: {error.problem or error.context}"
        raise YamlError(message, _span(file, error.problem_mark)) from None
    except (yaml.YAMLError, RecursionError) as error:
        raise YamlError(f"not YAML: {error}", _span(file, None)) from None


def _document(events: Iterator[Any], file: str) -> Node:
    """Return the only document of PyYAML's events, which are untyped."""
    next(events)  # the start of the stream
    if next(events).__class__.__name__ == "StreamEndEvent":
        return Node("", _span(file, None), _span(file, None))
    root = _node(next(events), events, file)
    next(events)  # the end of the document
    if (event := next(events)).__class__.__name__ != "StreamEndEvent":
        place = _span(file, event.start_mark)
        raise YamlError("not YAML: expected a single document", place)
    return root


def _node(
    event: Any, events: Iterator[Any], file: str, key: Span | None = None
) -> Node:
    match event.__class__.__name__:
        case "ScalarEvent":
            span = _span(file, event.start_mark, event.end_mark)
            return Node(event.value, span, key or span)
        case "SequenceStartEvent":
            content, last = _items(events, file)
        case "MappingStartEvent":
            content, last = _entries(events, file)
        case _:
            raise YamlError("an alias", _span(file, event.start_mark))
    # The two parsers disagree about the end of a block.
    span = _span(file, event.start_mark, last.end_mark if event.flow_style else None)
    return Node(content, span, key or span)


def _items(events: Iterator[Any], file: str) -> tuple[Content, Any]:
    """Return the nodes of a sequence, and the event at its end."""
    items: list[Node] = []
    while (event := next(events)).__class__.__name__ != "SequenceEndEvent":
        items.append(_node(event, events, file))
    return tuple(items), event


def _entries(events: Iterator[Any], file: str) -> tuple[Content, Any]:
    """Return the nodes of a mapping by their keys, and the event at its end."""
    entries: dict[str, Node] = {}
    while (event := next(events)).__class__.__name__ != "MappingEndEvent":
        key = _node(event, events, file)
        if not isinstance(key.content, str):
            raise YamlError("not YAML: a key that is not text", key.span)
        entries[key.content] = _node(next(events), events, file, key.span)
    return entries, event


def _span(file: str, start: Any, end: Any = None) -> Span:
    """Return the span between two marks in one line; else of the first character."""
    if start is None:
        return Span(file, 1, 1, 1, 2)
    line, column = start.line + 1, start.column + 1
    last = end.column + 1 if end is not None and end.line == start.line else 0
    return Span(file, line, column, line, max(last, column + 1))
