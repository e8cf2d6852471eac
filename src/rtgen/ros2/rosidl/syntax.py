"""Parses the lines of an interface file: fields, constants, comments and separators."""

from __future__ import annotations

import re
from typing import Final

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.facts.primitives import Primitive
from rtgen.ros2.rosidl import rules
from rtgen.ros2.rosidl.values import (
    Scalar,
    Value,
    has_open_quote,
    parsed,
    parsed_list,
)

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
CONSTANT_NAME: Final = re.compile(r"[A-Z](?:[A-Z0-9]|_(?=[A-Z0-9]))*")
_SEPARATOR: Final = "---"
_TYPE: Final = re.compile(
    r"(?P<base>[A-Za-z][A-Za-z0-9_/]*)(?:<=(?P<length>[^\[]*))?"
    r"(?P<array>\[(?P<most><=)?(?P<size>[^\]\[]*)\])?"
)
MAX_BOUND: Final = (1 << 32) - 1
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
    for number, whole in enumerate(text.split("\n"), 1):
        # Other ends of lines, such as a form feed, are those of rosidl only, not of editors.
        at = 0
        for line in whole.splitlines(keepends=True) or [""]:
            # rosidl replaces tabs before all else, also in quotes.
            reader.read(line.replace("\t", " ").rstrip(), number, at)
            at += len(line)
    return reader.finished()


class _Line(msgspec.Struct, frozen=True):
    """A field or constant as written, with the offset of each part; spaces at the end are left out.

    `rest` is what follows the type: a line with `=` there is a constant, whatever it contains.
    """

    text: str
    number: int
    has_comment: bool
    type_at: int
    type_text: str
    name_at: int
    rest: str

    @property
    def is_constant(self) -> bool:
        return "=" in self.rest

    @property
    def name(self) -> str:
        mark = "=" if self.is_constant else " "
        return self.rest.partition(mark)[0].rstrip()

    @property
    def value_at(self) -> int:
        after = self.rest.partition("=" if self.is_constant else " ")[2]
        return len(self.text) - len(after.lstrip())

    @property
    def value(self) -> str:
        """Its default or value."""
        return self.text[self.value_at :]


def _line(text: str, number: int, *, has_comment: bool) -> _Line:
    text = text.rstrip()
    start = len(text) - len(text.lstrip())
    type_text, _, rest = text[start:].partition(" ")
    rest = rest.lstrip()
    name_at = len(text) - len(rest)
    return _Line(text, number, has_comment, start, type_text, name_at, rest)


class _Reader:
    def __init__(self, file: str, findings: Findings) -> None:
        self._file = file
        self._findings = findings
        self._parts: list[Part] = []
        self._at = 0
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

    def read(self, line: str, number: int, at: int) -> None:
        """Parse a line, without its line end, that begins at an offset in that of an editor."""
        self._at = at
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
        parsed_line = _line(content, number, has_comment=bool(mark))
        self._declare(parsed_line, "\n".join(filter(None, (doc, trailing))))

    def _declare(self, line: _Line, doc: str) -> None:
        if not line.name:
            span = self._span(line.number, line.type_at, len(line.text))
            message = f"expected a type and a name, found {line.text.strip()[:60]!r}"
            hint = "fields are `TYPE name`, constants `TYPE NAME=VALUE`"
            self._findings.add(rules.SYNTAX, span, message, hint=hint)
            return
        type_span = self._span(
            line.number, line.type_at, line.type_at + len(line.type_text)
        )
        type_ = self._type(line.type_text, type_span)
        place = self._span(line.number, line.name_at, line.name_at + len(line.name))
        if type_ is None or not self._is_name(line, place):
            return
        name = line.name
        if (other := self._fields.get(name)) is not None:
            message = f"{name} is declared in line {other.span.line} already"
            self._findings.add(rules.DUPLICATE, place, message)
            return
        value = None
        if line.is_constant or line.value:
            value = self._value(line, type_)
            if value is None:
                return
        self._fields[name] = Field(name, type_, place, doc, value, line.is_constant)

    def _is_name(self, line: _Line, span: Span) -> bool:
        name = line.name
        if (CONSTANT_NAME if line.is_constant else FIELD_NAME).fullmatch(name):
            return True
        if line.is_constant:
            message = f"{name or '='} is not a name of a constant"
            hint = "capitals and digits, single underscores between them"
            if " " in name:
                hint = "= makes the line a constant, also in quotes: write \\x3d"
        else:
            message = f"{name} is not a name of a field"
            hint = "lower-case letters and digits, single underscores between them"
            if CONSTANT_NAME.fullmatch(name):
                hint = f"a constant is written {name}=VALUE"
        self._findings.add(rules.BAD_NAME, span, message, hint=hint)
        return False

    def _type(self, text: str, span: Span) -> FieldType | None:
        match = _TYPE.fullmatch(text)
        if match is None:
            message = f"{text} is not a type"
            hint = "arrays are T[3], T[], T[<=3]; bounded strings string<=10"
            if text.startswith("@"):
                message = f"{text} is an annotation, which interface files do not have"
                hint = "ROS 2 has no optional fields and no keys: leave it out"
            self._findings.add(rules.BAD_TYPE, span, message, hint=hint)
            return None
        base, array = match["base"], match["array"] is not None
        try:
            length = _bound(match["length"])
            size = _bound(match["size"] or (None if not match["most"] else ""))
            if length is not None and base not in STRINGS:
                raise ValueError(f"{base} has no bound; strings have")
        except ValueError as error:
            self._findings.add(rules.BAD_TYPE, span, str(error))
            return None
        sequence = array and bool(match["most"] or size is None)
        return FieldType(
            base=base,
            span=span,
            length=length,
            is_sequence=sequence,
            is_array=array and not sequence,
            size=size,
        )

    def _value(self, line: _Line, type_: FieldType) -> Value | None:
        text, constant = line.value, line.is_constant
        span = self._span(line.number, line.value_at, len(line.text))
        many = type_.is_array or type_.is_sequence
        if type_.is_message or (constant and (many or type_.length is not None)):
            what = "constants" if constant else "defaults"
            message = f"{line.type_text} has no {what}"
            self._findings.add(rules.BAD_VALUE, type_.span, message)
            return None
        kind = PRIMITIVES.get(type_.base)
        try:
            if not many:
                value: Value = parsed(text, kind, type_.length)
            else:
                value = parsed_list(text, kind, type_.length)
                _check_length(value, type_)
        except ValueError as error:
            self._findings.add(rules.BAD_VALUE, span, f"{text[:60]} {error}")
            return None
        if kind is None and not many and has_open_quote(text):
            message = f"the quote is not closed, so the text is {str(value)[:60]!r}"
            hint = f"close it with {text[0]}"
            if line.has_comment:
                hint = "# begins a comment, also in quotes: write \\x23"
            self._findings.add(rules.OPEN_QUOTE, span, message, hint=hint)
        return value

    def _span(self, line: int, start: int, end: int) -> Span:
        first, last = self._at + start + 1, self._at + max(end, start + 1) + 1
        return Span(self._file, line, first, line, last)


def _bound(text: str | None) -> int | None:
    """Return a bound, None without one. Raises ValueError."""
    if text is None:
        return None
    if not text:
        raise ValueError("the bound is missing")
    try:
        bound = int(text)
    except ValueError:
        bound = 0
    if not 0 < bound <= MAX_BOUND:
        raise ValueError(f"a bound is a number from 1 to {MAX_BOUND}")
    return bound


def _check_length(values: tuple[Scalar, ...], type_: FieldType) -> None:
    size = type_.size
    if type_.is_array and len(values) != size:
        raise ValueError(f"has {len(values)} values; the array has {size}")
    if size is not None and len(values) > size:
        raise ValueError(f"has {len(values)} values, more than {size}")
