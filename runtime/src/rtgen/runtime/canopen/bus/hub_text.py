"""Frames as text: socketcand's protocol in raw mode, and slcan. Without I/O."""

from __future__ import annotations

import re
from binascii import hexlify
from functools import lru_cache
from typing import Final

from rtgen.runtime.canopen.wire.frames import MAX_DATA, SECOND, Frame

_MAX_LENGTH: Final = 256
"""Maximum length of an element of socketcand, or of a line of slcan, in octets."""

_ELEMENT: Final = re.compile(rb"\s*<([\0-;=?-\x7f]{0,%d})>" % (_MAX_LENGTH - 2))
_STANDARD, _EXTENDED = rb"[0-7]?[0-9A-F]{1,2}", rb"[01][0-9A-F]{7}"
_SENT: Final = re.compile(
    rb"\s*< send (%b|%b) ([0-8]) ([0-9A-Fa-f ]{0,%d})>"
    % (_STANDARD, _EXTENDED, 3 * MAX_DATA)
)
_RECEIVED: Final = re.compile(
    rb"\s*< frame (%b|%b) ([0-9]{1,10}\.[0-9]{6}) ((?:[0-9A-F]{2}){0,%d}) >"
    % (_STANDARD, _EXTENDED, MAX_DATA)
)
"""Frames in their usual spelling, parsed without splitting them into words."""
_IDENTIFIER: Final = re.compile(r"[0-9A-Fa-f]{1,3}|[01][0-9A-Fa-f]{7}")
_LONG_IDENTIFIER: Final = 8
_MAX_NAME: Final = 32
_END_OF_TIME: Final = 1e11
"""Maximum of a time stamp in seconds."""
_DIGITS: Final = "0123456789ABCDEFabcdef"
_OCTETS: Final = {
    high + low: int(high + low, 16) for high in ("", *_DIGITS) for low in _DIGITS
}
_SLCAN: Final = re.compile(
    r"(?:([tr])([0-7][0-9A-Fa-f]{2})|([TR])([01][0-9A-Fa-f]{7}))([0-8])((?:[0-9A-Fa-f]{2})*)"
)


class Malformed(ValueError):
    """Text that is not a valid frame."""


class Elements:
    """Splits a stream into elements `< ... >`."""

    def __init__(self) -> None:
        self._text = b""
        self._position = 0

    @property
    def waiting(self) -> int:
        """Number of octets fed but not taken."""
        return len(self._text) - self._position

    def feed(self, data: bytes) -> None:
        """Append received octets."""
        self._text = self._text[self._position :] + data if self.waiting else data
        self._position = 0

    def take(self) -> str | None:
        """Return the content of the next element, None if it is incomplete.

        Raises Malformed for text outside of elements, and for elements that are too long or not
        ASCII; the offending text is dropped.
        """
        match = _ELEMENT.match(self._text, self._position)
        if match is None:
            if self.waiting:
                self._drop_malformed()
            return None
        self._position = match.end()
        return " ".join(match[1].decode("ascii").split())

    def take_sent(self) -> Frame | None:
        """Take the next element if it is `send` in its usual spelling; else None.

        In that case use `take` and `sent_frame`.
        """
        match = _SENT.match(self._text, self._position)
        if match is None:
            return None
        identifier, length, octets = match.groups()
        try:
            data = bytes([_OCTETS[octet] for octet in octets.decode().split()])
        except KeyError:
            return None
        if len(data) != int(length):
            return None
        self._position = match.end()
        return Frame(
            int(identifier, 16), data, False, len(identifier) == _LONG_IDENTIFIER
        )

    def take_received(self) -> tuple[Frame, float] | None:
        """Take the next element if it is `frame` in its usual spelling; else None.

        In that case use `take` and `received_frame`.
        """
        match = _RECEIVED.match(self._text, self._position)
        if match is None:
            return None
        identifier, seconds, data = match.groups()
        self._position = match.end()
        frame = Frame(
            int(identifier, 16),
            bytes.fromhex(data.decode()),
            False,
            len(identifier) == _LONG_IDENTIFIER,
        )
        return frame, float(seconds)

    def _drop_malformed(self) -> None:
        """Raise Malformed unless the text is the start of an element."""
        text = self._text
        start = text.find(b"<", self._position)
        outside = text[self._position : len(text) if start < 0 else start]
        self._position += len(outside)
        if outside.strip():
            raise Malformed(_shown(outside))
        if start < 0:
            return
        limit = start + _MAX_LENGTH
        # An unterminated element ends before the next one.
        inner = text.find(b"<", start + 1, limit)
        end = text.find(b">", start, limit) + 1
        if not end and len(text) < limit:
            return
        self._position = min(part for part in (inner, end or limit) if part > 0)
        raise Malformed(_shown(text[start : self._position]))


def is_channel(name: str) -> bool:
    """Return whether a hub's bus can have the name."""
    return (
        0 < len(name) <= _MAX_NAME
        and name.isascii()
        and name.isprintable()
        and " " not in name
    )


def sent_frame(words: str) -> Frame:
    """Parse `send ID DLC B0 B1 ...`. Raises Malformed.

    Up to three digits are an 11-bit identifier, eight digits a 29-bit one. Remote frames do
    not exist here: python-can's text for them has no data.
    """
    command, *parts = words.split(" ")
    try:
        identifier, length, *octets = parts
        can_id, extended = _identifier(identifier)
        data = bytes([_OCTETS[octet] for octet in octets])
        if command == "send" and length == str(len(octets)):
            return Frame(can_id, data, extended=extended)
    except (KeyError, ValueError) as error:
        raise Malformed(words) from error
    raise Malformed(words)


@lru_cache(4096)
def _identifier(digits: str) -> tuple[int, bool]:
    """Return an identifier, and whether it has 29 bits. Raises ValueError."""
    if _IDENTIFIER.fullmatch(digits) is None:
        raise ValueError(digits)
    return int(digits, 16), len(digits) == _LONG_IDENTIFIER


def send_text(frame: Frame) -> bytes:
    """Format `< send ID DLC B0 B1 ... >`."""
    data = frame.data
    form = b"< send %08X %d %b >" if frame.extended else b"< send %03X %d %b >"
    return form % (frame.can_id, len(data), hexlify(data, b" ").upper())


def received_frame(words: str) -> tuple[Frame, float]:
    """Parse `frame ID SECONDS.MICROS DATA`: a frame and its time, UTC. Raises Malformed."""
    parts = words.split(" ")
    try:
        kind, identifier, time = parts[:3]
        can_id, extended = _identifier(identifier)
        data = bytes.fromhex("".join(parts[3:]))
        seconds = _seconds(time)
        if kind == "frame":
            return Frame(can_id, data, extended=extended), seconds
    except ValueError as error:
        raise Malformed(words) from error
    raise Malformed(words)


def received_error(words: str) -> tuple[int, float]:
    """Parse `error CLASS SECONDS.MICROS`: a class of SocketCAN. Raises Malformed."""
    try:
        kind, error_class, time = words.split(" ")
        if kind == "error":
            return _identifier(error_class)[0], _seconds(time)
    except ValueError as error:
        raise Malformed(words) from error
    raise Malformed(words)


def _seconds(digits: str) -> float:
    seconds = float(digits)
    if not 0 <= seconds < _END_OF_TIME:
        raise ValueError(digits)
    return seconds


def frame_text(frame: Frame, time: int) -> bytes:
    """Format `< frame ID SECONDS.MICROS DATA >`; `time` in ns, UTC."""
    seconds, rest = divmod(time, SECOND)
    form = (
        b"< frame %08X %d.%06d %b >" if frame.extended else b"< frame %03X %d.%06d %b >"
    )
    return form % (frame.can_id, seconds, rest // 1000, hexlify(frame.data).upper())


def error_text(kind: int, time: int) -> bytes:
    """Format `< error CLASS SECONDS.MICROS >`, an error frame of SocketCAN; `time` in ns, UTC."""
    seconds, rest = divmod(time, SECOND)
    return f"< error {kind:08X} {seconds}.{rest // 1000:06} >".encode()


class Lines:
    """Splits a stream into the lines of slcan, which end with a carriage return."""

    def __init__(self) -> None:
        self._text = bytearray()

    @property
    def waiting(self) -> int:
        """Number of octets fed but not taken."""
        return len(self._text)

    def feed(self, data: bytes) -> None:
        """Append received octets."""
        self._text += data

    def take(self) -> str | None:
        """Return the next line, None if it is incomplete. Raises Malformed for a long line."""
        text = self._text
        end = text.find(b"\r", 0, _MAX_LENGTH)
        if end < 0:
            if len(text) < _MAX_LENGTH:
                return None
            lost = bytes(text[:_MAX_LENGTH])
            del text[:_MAX_LENGTH]
            raise Malformed(_shown(lost))
        line = bytes(text[:end]).decode("latin-1").strip("\n")
        del text[: end + 1]
        return line


def slcan_frame(line: str) -> Frame:
    """Parse a line: `tIIIL..`, `TIIIIIIIIL..`, remote `rIIIL`, `RIIIIIIIIL`.

    Raises Malformed.
    """
    match = _SLCAN.fullmatch(line)
    if match is None:
        raise Malformed(_shown(line.encode("latin-1")))
    kind, short, long_kind, long, length, data = match.groups()
    remote = (kind or long_kind) in "rR"
    if len(data) != (0 if remote else 2 * int(length)):
        raise Malformed(line)
    return _frame(line, short or long, bytes.fromhex(data), bool(long), remote)


def slcan_text(frame: Frame) -> bytes:
    """Format a frame as a line with its terminator."""
    kind = "r" if frame.remote else "t"
    identifier = f"{frame.can_id:03X}"
    if frame.extended:
        kind, identifier = kind.upper(), f"{frame.can_id:08X}"
    return f"{kind}{identifier}{len(frame.data)}{frame.data.hex().upper()}\r".encode()


def _frame(
    text: str, identifier: str, data: bytes, extended: bool, remote: bool = False
) -> Frame:
    try:
        return Frame(int(identifier, 16), data, remote, extended)
    except ValueError as error:
        raise Malformed(text) from error


def _shown(data: bytes) -> str:
    text = data[:60].decode("latin-1")
    return "".join(c if c.isprintable() and c.isascii() else "?" for c in text)
