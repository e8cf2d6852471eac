"""Parses the lines of an interface file: fields, constants, comments and separators."""

from __future__ import annotations

import re
from typing import Final

import msgspec

from rtgen.diagnostics import Span
from rtgen.facts.primitives import Primitive
from rtgen.frontends.kit.findings import Findings
from rtgen.frontends.rosidl import rules
from rtgen.frontends.rosidl.values import Value, parsed

PRIMITIVES: Final = {
    "bool": Primitive.BOOLEAN,
    "byte": Primitive.OCTET,
    "char": Primitive.UINT8,
    "int8": Primitive.INT8,
    "uint8": Primitive.UINT8,
    "int16": Primitive.SHORT,
    "uint16": Primitive.UNSIGNED_SHORT,
    "int32": Primitive.LONG,
    "uint32": Primitive.UNSIGNED_LONG,
    "int64": Primitive.LONG_LONG,
    "uint64": Primitive.UNSIGNED_LONG_LONG,
    "float32": Primitive.FLOAT,
    "float64": Primitive.DOUBLE,
}
STRINGS: Final = ("string", "wstring")
MESSAGE_NAME: Final = re.compile(r"[A-Z][A-Za-z0-9]*")
PACKAGE_NAME: Final = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
FIELD_NAME: Final = PACKAGE_NAME
_CONSTANT_NAME: Final = re.compile(r"[A-Z](?:[A-Z0-9]|_(?=[A-Z0-9]))*")
_SEPARATOR: Final = "---"
_LINE: Final = re.compile(
    r"\s*(?P<type>\S+)\s+(?P<name>[^\s=]+)\s*(?P<equals>=(?!=))?\s*(?P<value>.*?)\s*"
)
_TYPE: Final = re.compile(
    r"(?P<base>[A-Za-z][A-Za-z0-9_/]*)(?:<=(?P<length>\d+))?"
    r"(?P<array>\[(?P<most><=)?(?P<size>\d*)\])?"
)
_MAX_BOUND: Final = (1 << 32) - 1
"""Maximum bound: CDR's lengths have 32 bits."""


class FieldType(msgspec.Struct, frozen=True):
    """A type as written.

    `base` is a primitive, a string, or a message as `Name`, `package/Name` or `package/msg/Name`.
    `length` bounds a string. `size` and `is_array` describe `[]`: an array of `size`, or a
    sequence, bounded by `size` unless that is None.
    """

    base: str
    span: Span
    length: int | None = None
    is_sequence: bool = False
    is_array: bool = False
    size: int | None = None

    @property
    def is_message(self) -> bool:
        """Whether it is another message."""
        return self.base not in PRIMITIVES and self.base not in STRINGS


class Field(msgspec.Struct, frozen=True):
    """A field, or a constant if `constant`; `value` is its default or its value."""

    name: str
    type: FieldType
    span: Span
    doc: str
    value: Value | None = None
    constant: bool = False


class Part(msgspec.Struct, frozen=True):
    """The lines between two separators."""

    fields: tuple[Field, ...]
    constants: tuple[Field, ...]
    doc: str


def parts_of(text: str, file: str, findings: Findings) -> list[Part]:
    """Return the parts of a file, one for a message. Invalid lines are reported and dropped."""
    reader = _Reader(file, findings)
    for number, line in enumerate(text.split("\n"), 1):
        reader.read(line, number)
    return reader.finished()


class _Reader:
    def __init__(self, file: str, findings: Findings) -> None:
        self._file = file
        self._findings = findings
        self._parts: list[Part] = []
        self._begin()

    def _begin(self) -> None:
        self._fields: dict[str, Field] = {}
        self._comment: list[str] = []
        self._doc: str | None = None

    def finished(self) -> list[Part]:
        """Return the parts, including the last one."""
        self._end_part()
        return self._parts

    def _end_part(self) -> None:
        self._end_of_comment()
        fields = self._fields.values()
        self._parts.append(
            Part(
                tuple(f for f in fields if not f.constant),
                tuple(f for f in fields if f.constant),
                self._doc or "",
            )
        )
        self._begin()

    def _end_of_comment(self) -> str:
        """Return the comment above; the first one before a blank line or the end is the part's."""
        comment = "\n".join(self._comment).strip("\n")
        self._comment = []
        return comment

    def read(self, line: str, number: int) -> None:
        """Parse a line, without its line end."""
        content, mark, comment = line.partition("#")
        if not content.strip():
            if mark:
                self._comment.append(comment.removeprefix(" ").rstrip())
            elif (doc := self._end_of_comment()) and self._doc is None:
                self._doc = "" if self._fields else doc
            return
        if content.strip() == _SEPARATOR:
            if self._doc is None and not self._fields:
                self._doc = self._end_of_comment()
            self._end_part()
            return
        doc = self._end_of_comment()
        if self._doc is None:
            self._doc = ""
        trailing = comment.strip()
        self._declare(content, number, "\n".join(filter(None, (doc, trailing))))

    def _declare(self, content: str, number: int, doc: str) -> None:
        match = _LINE.fullmatch(content)
        if match is None:
            start = len(content) - len(content.lstrip())
            span = self._span(number, start, len(content.rstrip()))
            message = f"expected a type and a name, found {content.strip()[:60]!r}"
            hint = "fields are `TYPE name`, constants `TYPE NAME=VALUE`"
            self._findings.add(rules.SYNTAX, span, message, hint=hint)
            return
        type_ = self._type(match["type"], self._span(number, *match.span("type")))
        name, place = match["name"], self._span(number, *match.span("name"))
        constant = match["equals"] is not None
        if type_ is None or not self._is_name(name, place, constant):
            return
        if (other := self._fields.get(name)) is not None:
            message = f"{name} is declared in line {other.span.line} already"
            self._findings.add(rules.DUPLICATE, place, message)
            return
        value = None
        if constant or match["value"]:
            value = self._value(match, type_, number, constant)
            if value is None:
                return
        self._fields[name] = Field(name, type_, place, doc, value, constant)

    def _is_name(self, name: str, span: Span, constant: bool) -> bool:
        if (_CONSTANT_NAME if constant else FIELD_NAME).fullmatch(name):
            return True
        if constant:
            message = f"{name} is not a name of a constant"
            hint = "capitals and digits, single underscores between them"
        else:
            message = f"{name} is not a name of a field"
            hint = "lower-case letters and digits, single underscores between them"
            if _CONSTANT_NAME.fullmatch(name):
                hint = f"a constant is written {name}=VALUE"
        self._findings.add(rules.BAD_NAME, span, message, hint=hint)
        return False

    def _type(self, text: str, span: Span) -> FieldType | None:
        match = _TYPE.fullmatch(text)
        if match is None:
            message = f"{text} is not a type"
            hint = "arrays are T[3], T[], T[<=3]; bounded strings string<=10"
            self._findings.add(rules.BAD_TYPE, span, message, hint=hint)
            return None
        base, length, size = match["base"], match["length"], match["size"]
        problem = None
        if length and base not in STRINGS:
            problem = f"{base} has no bound; strings have"
        elif match["most"] and not size:
            problem = "the bound is missing"
        elif any(n and not 0 < int(n) <= _MAX_BOUND for n in (length, size)):
            problem = f"a bound is a number from 1 to {_MAX_BOUND}"
        if problem is not None:
            self._findings.add(rules.BAD_TYPE, span, problem)
            return None
        array = match["array"] is not None
        sequence = array and bool(match["most"] or not size)
        return FieldType(
            base=base,
            span=span,
            length=int(length) if length else None,
            is_sequence=sequence,
            is_array=array and not sequence,
            size=int(size) if size else None,
        )

    def _value(
        self, match: re.Match[str], type_: FieldType, number: int, constant: bool
    ) -> Value | None:
        text = match["value"]
        span = self._span(number, *match.span("value"))
        many = type_.is_array or type_.is_sequence
        bounded = type_.length is not None
        if type_.is_message or (constant and (many or bounded)):
            message = (
                f"{match['type']} has no {'constants' if constant else 'defaults'}"
            )
            self._findings.add(rules.BAD_VALUE, type_.span, message)
            return None
        try:
            kind = PRIMITIVES.get(type_.base)
            value = parsed(text, kind, many=many, verbatim=constant)
            _check_length(value, type_)
        except ValueError as error:
            self._findings.add(rules.BAD_VALUE, span, f"{text[:60]} {error}")
            return None
        return value

    def _span(self, line: int, start: int, end: int) -> Span:
        return Span(self._file, line, start + 1, line, max(end, start + 1) + 1)


def _check_length(value: Value, type_: FieldType) -> None:
    if isinstance(value, tuple):
        size = type_.size
        if type_.is_array and size is not None and len(value) != size:
            raise ValueError(f"has {len(value)} values; the array has {size}")
        if size is not None and len(value) > size:
            raise ValueError(f"has {len(value)} values, more than {size}")
    for text in value if isinstance(value, tuple) else (value,):
        if len(str(text)) > (type_.length or _MAX_BOUND):
            raise ValueError(f"is longer than {type_.length} characters")
