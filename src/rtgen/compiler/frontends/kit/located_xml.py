"""XML with places: a tree whose elements and attributes have spans in the user's text.

Built on expat, which reports line and column of each tag; lxml's elements only have a line.
Document type declarations are rejected, so no entity is expanded and nothing is fetched.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NoReturn
from xml.parsers import expat

from rtgen.compiler.diagnostics import InputError, Rule, Span
from rtgen.compiler.frontends.kit.lines import LineTable
from rtgen.compiler.frontends.kit.xml_rules import DEPTH, DOCTYPE, ENCODING, MALFORMED
from rtgen.facts import encodings
from rtgen.facts.decoded_text import Decoded, encoded
from rtgen.facts.encodings import Encoded

_MAX_DEPTH = 100
_DECLARED = re.compile(rb"""<\?xml[^>]*?encoding\s*=\s*["']([A-Za-z][\w.-]*)["']""")
_ATTRIBUTE = re.compile(r"""([^\s=<>/"']+)\s*=\s*("[^"]*"|'[^']*')""")


@dataclass(slots=True, eq=False)
class Element:
    """An element; names, of attributes too, are `(namespace, local name)`.

    `span` is that of the tag's name, `_places` are those of the attributes' values. `text` is the
    text directly inside, also between the children.
    """

    name: tuple[str, str]
    attributes: Mapping[tuple[str, str], str]
    span: Span
    children: list[Element] = field(default_factory=list)
    text: str = ""
    _places: Mapping[str, Span] = field(default_factory=dict)

    def place(self, local_name: str) -> Span:
        """Return the span of an attribute's value, or of the tag's name without the attribute."""
        return self._places.get(local_name, self.span)

    def get(self, namespace: str, local_name: str, default: str = "") -> str:
        """Return an attribute's value, or the default."""
        return self.attributes.get((namespace, local_name), default)

    def all(self, namespace: str, local_name: str) -> Iterator[Element]:
        """Return the children of that name, in order."""
        return (
            child for child in self.children if child.name == (namespace, local_name)
        )

    def first(self, namespace: str, local_name: str) -> Element | None:
        """Return the first child of that name."""
        return next(self.all(namespace, local_name), None)


def decode(data: bytes, file: str) -> str:
    """Decode an XML file by its byte-order mark or declaration. Raises InputError."""
    label, is_marked = _label(data)
    nowhere = Span(file, 1, 1, 1, 1)
    try:
        if not is_marked:
            return encodings.labelled(data, label)
        read = encodings.decode(data)
    except LookupError:
        raise InputError(
            [ENCODING.at(nowhere, f"unknown encoding {label!r}")]
        ) from None
    except UnicodeError as reason:
        read = encodings.decode(data)
        place = nowhere
        if isinstance(reason, UnicodeDecodeError):
            before = encodings.decode(data[: reason.start]).normal
            line, column = before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1
            place = Span(file, line, column, line, column + 1)
        message = f"these bytes are not {label.upper()}"
        raise InputError([ENCODING.at(place, message, hint=_hint(read))]) from None
    if read.doubt is not None:
        place = Span(file, read.line, 1, read.line, 1)
        raise InputError([ENCODING.at(place, read.doubt, hint=_hint(read))])
    return read.text


def _hint(read: Decoded) -> str:
    if read.encoding in ("sjis", "euc"):
        return f"they look like {read.title}: declare that, or save the file as UTF-8"
    return "save the file as UTF-8"


def encode(text: str, before: bytes) -> bytes:
    """Encode a changed text as the file `before`, from which it was decoded.

    Characters that the encoding lacks become references, which values and texts can contain.
    Raises NotEncodableError, if a character of the file is in it in several ways.
    """
    label, is_marked = _label(before)
    encoding = encodings.encoding_of(label)
    if not is_marked and encoding is None:
        return text.encode(label, errors="xmlcharrefreplace")
    octets = before if is_marked else Encoded(before, encoding or "utf8")
    read = encodings.decode(octets)
    for character in {*text} - {*read.text}:
        try:
            encoded(character, read.encoding)
        except UnicodeEncodeError:
            text = text.replace(character, f"&#{ord(character)};")
    return read.encode(text)


def _label(data: bytes) -> tuple[str, bool]:
    """Return the declared encoding of a file, and whether a mark decides instead."""
    declared = _DECLARED.match(data[:200])
    is_marked = isinstance(data, Encoded) or data.startswith(encodings.MARKS)
    label = declared[1].decode("ascii") if declared and not is_marked else "utf-8"
    return label, is_marked


_NO_XML = "profiles and systems are XML or YAML; rtgen generate accepts definitions"
_CUT_OFF = (
    expat.errors.codes[expat.errors.XML_ERROR_NO_ELEMENTS],
    expat.errors.codes[expat.errors.XML_ERROR_UNCLOSED_TOKEN],
    expat.errors.codes[expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION],
    expat.errors.codes[expat.errors.XML_ERROR_PARTIAL_CHAR],
)
_NEWLINE = re.compile(r"\r\n?|\n")


def parse(text: str, file: str, no_xml: str = _NO_XML) -> Element:
    """Parse an XML text. Raises InputError with one located diagnostic.

    `no_xml` is its hint for a text of another kind.
    """
    return _Builder(text, file, no_xml).run()


class _Builder:
    """Builds the tree from expat's events."""

    def __init__(self, text: str, file: str, no_xml: str) -> None:
        self._text = text
        self._no_xml = no_xml
        self._file = file
        self._data = text.encode("utf-8", errors="replace")
        self._lines = LineTable(file, text, _NEWLINE)
        self._open: list[Element] = []
        self._root: Element | None = None
        parser = expat.ParserCreate(encoding="utf-8", namespace_separator=" ")
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._doctype
        self._parser = parser

    def run(self) -> Element:
        try:
            self._parser.Parse(self._data, True)
        except expat.ExpatError as error:
            message = expat.ErrorString(error.code)
            place = self._span(self._offset(error.lineno, error.offset), 1)
            is_xml = self._text.lstrip("\ufeff \t\r\n").startswith("<")
            hint = None if is_xml else self._no_xml
            if self._open and error.code in _CUT_OFF:
                last = self._open[-1]
                message = f"the file ends inside of <{last.name[1]}>"
                hint = f"it is cut off: the element begins in line {last.span.line}"
            raise InputError(
                [MALFORMED.at(place, f"not well-formed XML: {message}", hint=hint)]
            ) from None
        finally:
            # Its handlers are methods of this, and so keep all elements.
            del self._parser
        assert self._root is not None, "expat accepts no document without an element"
        return self._root

    def _offset(self, line: int, column: int) -> int:
        starts = self._lines.starts
        return min(starts[min(line, len(starts)) - 1] + column, len(self._text))

    def _span(self, offset: int, length: int) -> Span:
        return self._lines.span(offset, min(offset + length, len(self._text)))

    def _here(self) -> int:
        return self._offset(
            self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber
        )

    def _refuse(self, rule: Rule, message: str, length: int) -> NoReturn:
        raise InputError([rule.at(self._span(self._here(), length), message)])

    def _doctype(self, *_: object) -> None:
        message = "document type declarations are not read"
        self._refuse(DOCTYPE, message, len("<!DOCTYPE"))

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= _MAX_DEPTH:
            self._refuse(DEPTH, f"elements are nested more than {_MAX_DEPTH} deep", 1)
        offset = self._here() + 1
        written = re.compile(r"[^\s/>]*").match(self._text, offset)
        length = len(written[0]) if written else 1
        element = Element(
            name=_split(name),
            attributes={_split(key): value for key, value in attributes.items()},
            span=self._span(offset, length),
        )
        if attributes:
            element._places = self._attribute_places(offset + length)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _attribute_places(self, offset: int) -> dict[str, Span]:
        places: dict[str, Span] = {}
        while True:
            while offset < len(self._text) and self._text[offset].isspace():
                offset += 1
            match = _ATTRIBUTE.match(self._text, offset)
            if match is None:
                return places
            key = match[1].rpartition(":")[2]
            places.setdefault(
                key, self._span(match.start(2) + 1, max(len(match[2]) - 2, 1))
            )
            offset = match.end()

    def _characters(self, text: str) -> None:
        if self._open:
            self._open[-1].text += text

    def _end(self, _: str) -> None:
        self._open.pop()


@lru_cache(1024)
def _split(name: str) -> tuple[str, str]:
    """Return namespace and local name, which a file repeats often."""
    namespace, _, local = name.rpartition(" ")
    return namespace, local
