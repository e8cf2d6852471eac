"""Reads an XML text for changes, and writes it with them; the rest of the text stays as it is.

Attributes can be set and added, elements be added and removed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple
from xml.sax.saxutils import escape

from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.kit import xml_text
from rtgen.compiler.model.profile_elements import RTS, RTS_EXT, XSI, Name
from rtgen.ui.documents.elements import Editable, Place

_TOKEN: Final = re.compile(
    r"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|</(?P<closed>[^\s>]+)\s*>"
    r"|<(?P<opened>[^\s/>!?]+)(?P<inside>(?:[^>\"']|\"[^\"]*\"|'[^']*')*)>",
    re.DOTALL,
)
"""A token of a well-formed text without a document type declaration (XML 1.0, 2.8)."""
_ATTRIBUTE: Final = re.compile(r"""([^\s=<>/"']+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_COMMENTS: Final = re.compile(r"(?:[^\S\r\n]|<!--(?:(?!-->)[^\r\n])*-->)*(?=\r|\n|\Z)")
"""The rest of a line that has only comments."""
_LINE_END: Final = re.compile(r"[^\S\r\n]*(?:\r\n?|\n)")
_BLANK_OR_LAST: Final = re.compile(r"[^\S\r\n]*(?:\r|\n|</)")
_PREFIXES: Final = {RTS: "rts", RTS_EXT: "rtsExt", XSI: "xsi"}
_TYPE: Final[Name] = (XSI, "type")
_STEP: Final = "    "


def parse(text: str, file: str) -> Editable:
    """Return the root of a text. Raises InputError with one located diagnostic."""

    def element(element_read: Element, place: Place) -> Editable:
        pairs = zip(element_read.children, place.children, strict=True)
        children = [element(*pair) for pair in pairs]
        attributes = dict(element_read.attributes)
        return Editable(
            element_read.name, attributes, children, element_read.text, place
        )

    root = located_xml.parse(text, file)
    return element(root, _root(text))


def _root(text: str) -> Place:
    """Return the place of the root of a well-formed text, with those of all elements."""
    top = Place(0, 0, len(text), len(text), "", {}, {})
    opened = [top]
    for token in _TOKEN.finditer(text):
        if token["closed"] is not None:
            place = opened.pop()
            place.tail, place.end = token.span()
        elif token["opened"] is not None:
            place = _opened(token, opened[-1].prefixes)
            opened[-1].children.append(place)
            if not token["inside"].endswith("/"):
                place.end = len(text)
                opened.append(place)
    [root] = top.children
    return root


def _opened(token: re.Match[str], prefixes: Mapping[str, str]) -> Place:
    """Return the place of a start tag, as if it had no content."""
    places: dict[str, tuple[int, int]] = {}
    for each in _ATTRIBUTE.finditer(token.string, *token.span("inside")):
        name = each[1]
        places[name] = each.span(2 if each[2] is not None else 3)
        if name == "xmlns" or name.startswith("xmlns:"):
            prefixes = {**prefixes, name[6:]: each[2] or each[3] or ""}
    attributes = {}
    for name, place in places.items():
        prefix, _, local = name.rpartition(":")
        if "xmlns" not in (prefix, name):
            attributes[prefixes.get(prefix, "") if prefix else "", local] = place
    start, end = token.span()
    return Place(start, end, end, end, token["opened"], attributes, prefixes)


class _Patch(NamedTuple):
    start: int
    end: int
    text: str


def written(text: str, root: Editable) -> str:
    """Return the text from which `root` was read, with its changes."""
    parts, offset = [], 0
    for patch in sorted(_Writer(text, root).patches(root)):
        parts += [text[offset : patch.start], patch.text]
        offset = patch.end
    return "".join((*parts, text[offset:]))


class _Writer:
    """Finds where a text changes; `root` was read from it."""

    def __init__(self, text: str, root: Editable) -> None:
        self._text = text
        newline = re.search(r"\r\n?|\n", text)
        self._newline = newline[0] if newline else "\n"
        assert root.place is not None
        outer = self._indentation(root.place.start)
        inner = [self._indentation(each.start) for each in root.place.children[:1]]
        self._step = "".join(inner).removeprefix(outer) or _STEP

    def patches(self, element: Editable) -> Iterator[_Patch]:
        """Yield the changes in an element of the text."""
        place = element.place
        assert place is not None
        yield from self._attributes(element, place)
        yield from self._children(element, place)
        for child in element.children:
            if child.place is not None:
                yield from self.patches(child)

    def _attributes(self, element: Editable, place: Place) -> Iterator[_Patch]:
        added = []
        for name, value in element.attributes.items():
            if name not in place.attributes:
                added.append(name)
                continue
            start, end = place.attributes[name]
            if value != _value(self._text[start:end]):
                yield _Patch(start, end, _quoted(value, self._text[start - 1]))
        if added:
            attributes = {name: element.attributes[name] for name in added}
            [line] = _lines(Editable(("", "a"), attributes), place.prefixes)
            end = self._before_space(place.head - (2 if place.is_empty else 1))
            yield _Patch(end, end, line[len("<a") : -len("/>")])

    def _children(self, element: Editable, place: Place) -> Iterator[_Patch]:
        places = {child.place for child in element.children}
        for each in place.children:
            if each not in places:
                yield self._removed(each, place)
        after: Place | None = None
        waiting: list[Editable] = []
        for child in element.children:
            if child.place is None:
                waiting.append(child)
                continue
            if waiting:
                yield self._inserted(waiting, after, place)
            after, waiting = child.place, []
        if waiting:
            yield self._inserted(waiting, after, place)

    def _removed(self, place: Place, parent: Place) -> _Patch:
        """Return the patch that removes an element, with its lines and a blank one before them."""
        text = self._text
        start, rest = self._line(place.start), _LINE_END.match(text, place.end)
        if text[start : place.start].strip() or rest is None:
            return _Patch(place.start, place.end, "")
        before = self._line(max(start - 1, 0))
        is_blank = before >= parent.head and not text[before:start].strip()
        if is_blank and _BLANK_OR_LAST.match(text, rest.end()):
            start = before
        return _Patch(start, rest.end(), "")

    def _inserted(
        self, children: list[Editable], after: Place | None, parent: Place
    ) -> _Patch:
        """Return the patch that adds children behind one of the text, or as the first ones."""
        margin = self._margin(after, parent)
        at = parent.head if after is None else after.end
        if margin is None:
            printed = "".join(
                line for child in children for line in _lines(child, parent.prefixes)
            )
        else:
            if comments := _COMMENTS.match(self._text, at):
                at = comments.end()
            blank = after is not None and self._follows_blank_line(after, parent)
            printed = "".join(
                f"{self._newline}{line}"
                for child in children
                for line in (
                    *([""] if blank else []),
                    *_lines(child, parent.prefixes, self._step, margin),
                )
            )
        if not parent.is_empty:
            return _Patch(at, at, printed)
        start = self._before_space(parent.head - len("/>"))
        last = ""
        if margin is not None:
            last = self._newline + self._indentation(parent.start)
        return _Patch(start, parent.head, f">{printed}{last}</{parent.tag}>")

    def _margin(self, after: Place | None, parent: Place) -> str | None:
        """Return the indentation of new children; None if they share the line of others."""
        beside = [after] if after is not None else parent.children[:1]
        for each in beside:
            before = self._text[self._line(each.start) : each.start]
            return before if not before.strip() else None
        if self._newline not in self._text.strip():
            return None
        return self._indentation(parent.start) + self._step

    def _follows_blank_line(self, place: Place, parent: Place) -> bool:
        line = self._line(place.start)
        before = self._line(max(line - 1, 0))
        return before >= parent.head and not self._text[before:line].strip()

    def _indentation(self, offset: int) -> str:
        line = self._text[self._line(offset) : offset]
        return line[: len(line) - len(line.lstrip())]

    def _line(self, offset: int) -> int:
        """Return where the line of an offset begins."""
        return self._text.rfind(self._newline[-1], 0, offset) + 1

    def _before_space(self, offset: int) -> int:
        return len(self._text[:offset].rstrip())


def _lines(
    element: Editable, scope: Mapping[str, str], step: str = "", margin: str = ""
) -> Iterator[str]:
    """Yield the lines of a new element where prefixes are in scope."""
    prefix_of = {uri: prefix for prefix, uri in scope.items() if prefix}
    new = {u: p for u, p in _PREFIXES.items() if u not in prefix_of and p not in scope}
    declared = xml_text.new_prefixes(element, {**prefix_of, **dict.fromkeys(new, "")})
    used = xml_text.new_prefixes(element, prefix_of)
    declared |= {uri: prefix for uri, prefix in new.items() if uri in used}
    prefixes = {**prefix_of, **declared}
    return xml_text.lines(
        _typed(element, prefixes.get(RTS_EXT, "")),
        prefixes,
        step=step,
        margin=margin,
        declared=declared,
    )


def _typed(element: Editable, prefix: str) -> Editable:
    """Return an element whose types (`xsi:type`), which are qualified names, have a prefix."""
    attributes = dict(element.attributes)
    if (_TYPE in attributes) and prefix:
        attributes[_TYPE] = f"{prefix}:{attributes[_TYPE].rpartition(':')[2]}"
    children = [_typed(child, prefix) for child in element.children]
    return Editable(element.name, attributes, children, element.text)


def _value(raw: str) -> str:
    """Return the value of an attribute (XML 1.0, 3.3.3)."""
    if "&" not in raw and raw.isprintable():
        return raw
    quoted = f'"{raw}"' if '"' not in raw else f"'{raw}'"
    return located_xml.parse(f"<a b={quoted}/>", "").attributes["", "b"]


def _quoted(value: str, quote: str) -> str:
    """Return a value for between two quotes."""
    marks = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
    marks[quote] = "&quot;" if quote == '"' else "&apos;"
    return escape(value, marks)
