"""The messages of a client: header fields and a body each, both of bounded length.

Source: Language Server Protocol 3.17, "Base Protocol".
"""

from __future__ import annotations

import json
from typing import BinaryIO

from rtgen.facts.files import MAX_BYTES

MAX_HEADER = 8 * 1024
"""Maximum octets of the header of a message."""

MAX_BODY = MAX_BYTES
"""Maximum octets of the body of a message."""

MAX_VALUES = 2_000_000
"""Maximum commas and opening brackets in a body, which bound the memory of its values."""

_DIGITS = 18
_SHOWN = 60
_TOO_LONG = f"a header has more than {MAX_HEADER:,} octets"
_CUT_OFF = "it ends within a message"


class FramingError(Exception):
    """Input in which no further message can be found."""


class Messages:
    """A stream of messages, as pygls reads it, which alone would read any length.

    A body that is refused is replaced by a JSON string that says why, which is no valid message.
    `problem` is the reason why reading has ended before the end of the stream.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._header: list[bytes] = []
        self._body = b""
        self.problem: str | None = None

    def readline(self) -> bytes:
        """Return the next line of a header; empty at the end."""
        if not self._header:
            try:
                body = self._message()
            except FramingError as error:
                self.problem = str(error)
                return b""
            if body is None:
                return b""
            self._body = body
            self._header = [b"\r\n", b"Content-Length: %d\r\n" % len(body)]
        return self._header.pop()

    def read(self, length: int) -> bytes:
        """Return the body after the header that has been read."""
        assert length == len(self._body)
        body, self._body = self._body, b""
        return body

    def _message(self) -> bytes | None:
        """Return the body of the next message; None at the end. Raises FramingError."""
        fields = self._fields()
        if fields is None:
            return None
        length = _length(fields)
        charset = _charset(fields.get(b"content-type", b""))
        if length > MAX_BODY:
            self._skip(length)
            return _refusal(f"the message has more than {MAX_BODY:,} octets")
        body = self._stream.read(length)
        if len(body) < length:
            raise FramingError(_CUT_OFF)
        if charset not in (b"", b"utf-8", b"utf8"):
            return _refusal("the charset of the message is not utf-8")
        if sum(map(body.count, (b",", b"[", b"{"))) > MAX_VALUES:
            return _refusal(f"the message has more than {MAX_VALUES:,} values")
        return body or _refusal("the message is empty")

    def _fields(self) -> dict[bytes, bytes] | None:
        """Return the fields of a header by name in lower case; None at the end of the stream."""
        fields: dict[bytes, bytes] = {}
        remaining = MAX_HEADER
        while line := self._stream.readline(remaining):
            remaining -= len(line)
            if not line.endswith(b"\n"):
                raise FramingError(_TOO_LONG if remaining <= 0 else _CUT_OFF)
            name, colon, value = line.strip().partition(b":")
            if not name:
                return fields
            name, value = name.strip().lower(), value.strip()
            if not colon:
                header = name[:_SHOWN].decode("ascii", "backslashreplace")
                raise FramingError(f"{header!r} is not a field of a header")
            if fields.setdefault(name, value) != value:
                header = name[:_SHOWN].decode("ascii", "backslashreplace")
                raise FramingError(f"a header has two different fields {header!r}")
        if remaining <= 0:
            raise FramingError(_TOO_LONG)
        if fields:
            raise FramingError(_CUT_OFF)
        return None

    def _skip(self, length: int) -> None:
        """Read the octets of a body without storing them. Raises FramingError at the end."""
        while length > 0:
            part = self._stream.read(min(length, MAX_HEADER))
            if not part:
                raise FramingError(_CUT_OFF)
            length -= len(part)


def _length(fields: dict[bytes, bytes]) -> int:
    value = fields.get(b"content-length")
    if value is None:
        raise FramingError("a header has no Content-Length")
    if not (value.isdigit() and len(value) <= _DIGITS):
        text = value[:_SHOWN].decode("ascii", "backslashreplace")
        raise FramingError(f"the Content-Length {text!r} is not a length")
    return int(value)


def _charset(content_type: bytes) -> bytes:
    _, _, charset = content_type.lower().partition(b"charset=")
    return charset.partition(b";")[0].strip(b'" ')


def _refusal(reason: str) -> bytes:
    return json.dumps(reason).encode()
