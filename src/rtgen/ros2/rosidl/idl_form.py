"""Reads IDL files as rosidl_adapter writes them, for packages that have no other files.

Such a file has the messages of one interface in `module PACKAGE { module KIND`. Its names may be
keywords, it declares the same typedef for each message, and its literals are those of rosidl.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.ros2.rosidl.interfaces import PARTS
from rtgen.ros2.rosidl.syntax import (
    MAX_BOUND,
    PRIMITIVES,
    STRINGS,
    Field,
    FieldType,
    Part,
)
from rtgen.ros2.rosidl.values import Value, of_tuple, parsed, unescaped

_TOKEN: Final = re.compile(
    r"(?P<space>\s+|//[^\n]*|/\*.*?\*/|\#include[^\n]*)"
    r'|(?P<text>"(?:[^"\\\n]|\\[^\n])*")'
    r"|(?P<number>(?:\d[\w.]*|\.\d\w*)(?:(?<=[eE])[+-]\d+)?)"
    r"|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark>::|[{}()<>\[\];,=@-])",
    re.DOTALL,
)
_BASES: Final = {
    **{kind.value: name for name, kind in PRIMITIVES.items() if name != "char"},
    **{f"{u}int{n}": f"{u}int{n}" for u in ("", "u") for n in (16, 32, 64)},
    "string": "string",
    "wstring": "wstring",
}
"""Types of messages by their names in IDL."""
_SIGNED: Final = ("unsigned", "long", "short")
_FILLER: Final = "structure_needs_at_least_one_member"
_CONSTANTS: Final = "_Constants"


class OtherFormError(Exception):
    """The text is not in the form; `line` is the first place that differs."""

    def __init__(self, line: int) -> None:
        super().__init__(f"line {line} is not in the form of rosidl_adapter")
        self.line = line


def parts_of(text: str, file: str, name: tuple[str, str, str]) -> list[Part]:
    """Return the parts of an interface by package, kind and name. Raises OtherFormError."""
    return _Reader(text, file, name).parts()


class _Token(NamedTuple):
    kind: str
    text: str
    line: int
    start: int


def _tokens(text: str) -> Iterator[_Token]:
    line, line_start, at = 1, 0, 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise OtherFormError(line)
        if match.lastgroup != "space":
            yield _Token(str(match.lastgroup), match[0], line, at - line_start + 1)
        ends = match[0].count("\n")
        if ends:
            line += ends
            line_start = at + match[0].rindex("\n") + 1
        at = match.end()
    yield _Token("end", "", line, at - line_start + 1)


class _Reader:
    def __init__(self, text: str, file: str, name: tuple[str, str, str]) -> None:
        self._tokens = list(_tokens(text))
        self._at = 0
        self._file = file
        self._name = name
        self._typedefs: dict[str, FieldType] = {}
        self._constants: dict[str, list[Field]] = {}
        self._structs: dict[str, Part] = {}

    def parts(self) -> list[Part]:
        package, kind, name = self._name
        for scope in (package, kind):
            self._take("module", scope, "{")
        while not self._next("}"):
            self._declaration()
        self._take(";", "}", ";")
        if self._here.kind != "end":
            raise self._other()
        names = [f"{name}{suffix}" for suffix in PARTS[kind]]
        if [*self._structs] != names:
            raise self._other()
        return [
            Part(part.fields, tuple(self._constants.get(each, ())), part.doc)
            for each, part in self._structs.items()
        ]

    @property
    def _here(self) -> _Token:
        return self._tokens[self._at]

    def _other(self) -> OtherFormError:
        return OtherFormError(self._here.line)

    def _next(self, text: str) -> bool:
        """Take a token if it is the next one."""
        if self._here.text != text or self._here.kind in ("end", "text"):
            return False
        self._at += 1
        return True

    def _take(self, *texts: str) -> None:
        for text in texts:
            if not self._next(text):
                raise self._other()

    def _of_kind(self, kind: str) -> _Token:
        token = self._here
        if token.kind != kind:
            raise self._other()
        self._at += 1
        return token

    def _span(self, first: _Token, last: _Token) -> Span:
        end = last.start + len(last.text)
        return Span(self._file, first.line, first.start, last.line, end)

    def _declaration(self) -> None:
        annotations = self._annotations()
        if self._next("typedef"):
            element = self._type()
            name = self._of_kind("word").text
            self._typedefs[name] = self._array(element)
            self._take(";")
        elif self._next("module"):
            name = self._of_kind("word").text
            if not name.endswith(_CONSTANTS):
                raise self._other()
            self._take("{")
            constants = self._constants.setdefault(name.removesuffix(_CONSTANTS), [])
            while not self._next("}"):
                constants.append(self._constant())
            self._take(";")
        else:
            self._take("struct")
            name = self._of_kind("word").text
            self._take("{")
            fields = []
            while not self._next("}"):
                fields.append(self._field())
            self._take(";")
            if name in self._structs:
                raise self._other()
            members = tuple(f for f in fields if f.name != _FILLER)
            self._structs[name] = Part(members, (), annotations.get("verbatim", ""))

    def _constant(self) -> Field:
        doc = self._annotations().get("verbatim", "")
        self._take("const")
        type_ = self._type()
        name = self._of_kind("word")
        self._take("=")
        value = self._value(self._literal(), type_)
        self._take(";")
        return Field(name.text, type_, self._span(name, name), doc, value, True)

    def _field(self) -> Field:
        annotations = self._annotations()
        type_ = self._type()
        name = self._of_kind("word")
        type_ = self._array(type_)
        self._take(";")
        doc = annotations.get("verbatim", "")
        if (unit := annotations.get("unit")) is not None:
            doc = f"{doc} [{unit}]".strip()
        value = None
        if "default" in annotations:
            value = self._value(annotations["default"], type_)
        return Field(name.text, type_, self._span(name, name), doc, value)

    def _annotations(self) -> dict[str, str]:
        """Return the values of annotations: of `verbatim` its text, of others `value`."""
        annotations = {}
        while self._next("@"):
            name = self._of_kind("word").text
            self._take("(")
            if name == "verbatim":
                self._take("language", "=")
                self._of_kind("text")
                self._take(",", "text", "=")
            else:
                self._take("value", "=")
            annotations[name] = self._literal()
            self._take(")")
        return annotations

    def _literal(self) -> str:
        """Return a string without its quotes, or the text of another literal."""
        if self._here.kind == "text":
            text = ""
            while self._here.kind == "text":
                text += unescaped(self._of_kind("text").text[1:-1])
            return text
        sign = "-" if self._next("-") else ""
        if self._here.kind not in ("number", "word"):
            raise self._other()
        self._at += 1
        return sign + self._tokens[self._at - 1].text

    def _value(self, text: str, type_: FieldType) -> Value:
        kind = PRIMITIVES.get(type_.base)
        if type_.is_message:
            raise self._other()
        try:
            if type_.is_array or type_.is_sequence:
                return of_tuple(text, kind)
            return text if kind is None else parsed(text, kind)
        except ValueError:
            raise self._other() from None

    def _bound(self) -> int:
        text = self._of_kind("number").text
        if not text.isdecimal() or len(text) > 10 or not 0 < int(text) <= MAX_BOUND:
            raise self._other()
        return int(text)

    def _type(self) -> FieldType:
        if not self._next("sequence"):
            return self._element()
        self._take("<")
        element = self._element()
        size = self._bound() if self._next(",") else None
        self._take(">")
        if element.is_array:
            raise self._other()
        return replace(element, is_sequence=True, size=size)

    def _element(self) -> FieldType:
        first = self._here
        words = [self._of_kind("word").text]
        while words[-1] in _SIGNED and self._here.text in (*_SIGNED, "int", "double"):
            words.append(self._of_kind("word").text)
        while self._next("::"):
            words += ("::", self._of_kind("word").text)
        span = self._span(first, self._tokens[self._at - 1])
        base = _BASES.get(" ".join(words))
        if base is not None:
            length = None
            if base in STRINGS and self._next("<"):
                length = self._bound()
                self._take(">")
            return FieldType(base, span, length)
        match words:
            case [package, "::", "msg", "::", name]:
                return FieldType(f"{package}/{name}", span)
            case [name] if name in self._typedefs:
                return replace(self._typedefs[name], span=span)
            case _:
                raise self._other()

    def _array(self, element: FieldType) -> FieldType:
        """Return the type of a declarator, which may have a length."""
        if not self._next("["):
            return element
        size = self._bound()
        self._take("]")
        if element.is_array or element.is_sequence:
            raise self._other()
        return replace(element, is_array=True, size=size)
