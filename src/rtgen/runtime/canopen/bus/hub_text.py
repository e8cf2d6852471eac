"""Frames as text: socketcand's protocol in raw mode, and slcan. Without I/O."""

from __future__ import annotations

import re
from typing import Final

from rtgen.runtime.canopen.wire.frames import SECOND, Frame

_LONGEST: Final = 256
"""Maximum length of an element of socketcand, or of a line of slcan, in octets."""

_SEND: Final = re.compile(
    r"send (?:([0-9A-Fa-f]{1,3})|([01][0-9A-Fa-f]{7})) ([0-8])((?: [0-9A-Fa-f]{1,2})*)"
)
_SLCAN: Final = re.compile(
    r"(?:([tr])([0-7][0-9A-Fa-f]{2})|([TR])([01][0-9A-Fa-f]{7}))([0-8])((?:[0-9A-Fa-f]{2})*)"
)


class Malformed(ValueError):
    """Text that is no valid frame."""


class Elements:
    """Splits a stream into elements `< ... >`."""

    def __init__(self) -> None:
        self._text = bytearray()

    @property
    def waiting(self) -> int:
        """Octets that were fed but not taken."""
        return len(self._text)

    def feed(self, data: bytes) -> None:
        """Append received octets."""
        self._text += data

    def take(self) -> str | None:
        """The content of the next element, None if it is incomplete.

        Raises Malformed for text outside of elements, and for elements that are too long or not
        ASCII; the offending text is dropped.
        """
        text = self._text
        start = text.find(b"<")
        outside = bytes(text[: len(text) if start < 0 else start])
        if outside:
            del text[: len(outside)]
            if outside.strip():
                raise Malformed(_shown(outside))
            if start < 0:
                return None
        end = text.find(b">", 0, _LONGEST)
        if end < 0:
            if len(text) < _LONGEST:
                return None
            inner = text.find(b"<", 1, _LONGEST)
            lost = bytes(text[: inner if inner > 0 else _LONGEST])
            del text[: len(lost)]
            raise Malformed(_shown(lost))
        element = bytes(text[: end + 1])
        del text[: end + 1]
        # An unterminated element does not include the next one.
        last = element.rfind(b"<")
        if last > 0 or not element.isascii():
            if element.isascii():
                text[:0] = element[last:]
                element = element[:last]
            raise Malformed(_shown(element))
        return " ".join(element[1:-1].decode("ascii").split())


def sent_frame(words: str) -> Frame:
    """Parse `send ID DLC B0 B1 ...`. Raises Malformed.

    Up to three digits are an 11-bit identifier, eight digits a 29-bit one. Remote frames do not
    exist: python-can's text for them lacks the data.
    """
    match = _SEND.fullmatch(words)
    if match is None:
        raise Malformed(words)
    short, long, dlc, rest = match.groups()
    octets = rest.split()
    if len(octets) != int(dlc):
        raise Malformed(words)
    return _frame(words, short or long, bytes(int(o, 16) for o in octets), bool(long))


def frame_text(frame: Frame, time: int) -> bytes:
    """Format `< frame ID SECONDS.MICROS DATA >`; `time` in ns, UTC."""
    seconds, rest = divmod(time, SECOND)
    identifier = f"{frame.can_id:08X}" if frame.extended else f"{frame.can_id:03X}"
    data = frame.data.hex().upper()
    return f"< frame {identifier} {seconds}.{rest // 1000:06} {data} >".encode()


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
        """Octets that were fed but not taken."""
        return len(self._text)

    def feed(self, data: bytes) -> None:
        """Append received octets."""
        self._text += data

    def take(self) -> str | None:
        """The next line, None if it is incomplete. Raises Malformed for a line that is too long."""
        text = self._text
        end = text.find(b"\r", 0, _LONGEST)
        if end < 0:
            if len(text) < _LONGEST:
                return None
            lost = bytes(text[:_LONGEST])
            del text[:_LONGEST]
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
