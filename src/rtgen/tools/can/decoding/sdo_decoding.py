"""Decodes SDO transfers between two other stations (CiA 301, 7.2.4) as an observer sees them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import Target

MAX_VALUE: Final = 1 << 16
"""Length in octets up to which a value is assembled; longer ones are only counted."""

Number: TypeAlias = tuple[int, int]


@dataclass(frozen=True, slots=True)
class SdoStep:
    """The effect of one message.

    `number` is the object of the transfer, None if unknown. `value` is the complete value that
    the message carries or completes. `holds` is the value of the object from now on: a value that
    was read, or written and confirmed by the server. `abort` is an abort code.
    """

    verb: str
    number: Number | None
    detail: str = ""
    value: bytes | None = None
    holds: bytes | None = None
    abort: int | None = None


class _Octets:
    """A value that arrives in parts.

    Its octets are kept up to `MAX_VALUE`; `announced` is the declared size.
    """

    def __init__(self, announced: int | None) -> None:
        self.announced = announced
        self.size = 0
        self._parts = bytearray()

    def add(self, part: bytes) -> None:
        self.size += len(part)
        if self.size <= MAX_VALUE + sdo.SEGMENT:
            self._parts += part

    def cut(self, unused: int) -> None:
        """Remove octets at the end."""
        self.size = max(0, self.size - unused)
        del self._parts[self.size :]

    def value(self) -> bytes | None:
        return bytes(self._parts) if self.size <= MAX_VALUE else None

    def progress(self) -> str:
        return (
            f"{self.size} of {self.announced} octets"
            if self.announced
            else self.length()
        )

    def length(self) -> str:
        return f"{self.size} octets"


_Step: TypeAlias = Callable[[bytes], SdoStep | None]
"""Interprets the next message of one side of a transfer; None if it belongs to another transfer."""


class SdoFollower:
    """Follows the transfers of one server; observation may start in the middle of a transfer."""

    def __init__(self) -> None:
        self._target: Number | None = None
        self._request: _Step | None = None
        self._response: _Step | None = None
        self._octets = _Octets(None)
        self._block: dict[int, bytes] = {}
        self._last: int | None = None
        self._reading = False

    def reset(self) -> None:
        """Forget the current transfer."""
        self._target = self._request = self._response = None

    def request(self, data: bytes) -> SdoStep:
        """Decode a message of the client, which has 8 octets."""
        if data[0] == sdo.ABORT:
            return self._aborted(data, "client")
        step = self._request(data) if self._request else None
        return step or self._start_requested(data) or self._unknown("request")

    def response(self, data: bytes) -> SdoStep:
        """Decode a message of the server, which has 8 octets."""
        if data[0] == sdo.ABORT:
            return self._aborted(data, "server")
        step = self._response(data) if self._response else None
        return step or self._start_answered(data) or self._unknown("answer")

    def _unknown(self, what: str) -> SdoStep:
        return SdoStep(f"{what} of a transfer that began before", self._target)

    def _aborted(self, data: bytes, by: str) -> SdoStep:
        number, code = _number(data), sdo.announced_size(data)
        self.reset()
        text = sdo.ABORT_TEXTS.get(code, "unknown abort code")
        detail = f"{code:08X}h {text} (by the {by})"
        return SdoStep("abort", number, detail, abort=code)

    def _step(self, verb: str, detail: str = "") -> SdoStep:
        return SdoStep(verb, self._target, detail)

    def _expect(self, request: _Step | None, response: _Step | None) -> None:
        self._request, self._response = request, response

    # Start of a transfer

    def _start_requested(self, data: bytes) -> SdoStep | None:
        code, number = data[0] & sdo.CODE, _number(data)
        if code == sdo.UPLOAD:
            self._target = number
            self._expect(None, None)
            return self._step("read request")
        if code == sdo.DOWNLOAD:
            return self._download_begun(data, number)
        if code == sdo.BLOCK_DOWNLOAD and not data[0] & 1:
            self._target = number
            self._octets = _Octets(_announced(data, sdo.WITH_SIZE))
            self._expect(None, self._block_accepted)
            return self._step("block write request", _length(self._octets.announced))
        if code == sdo.BLOCK_UPLOAD and not data[0] & 3:
            self._target = number
            self._expect(None, None)
            return self._step("block read request", f"blocks of {data[4]}")
        return None

    def _download_begun(self, data: bytes, number: Number) -> SdoStep:
        self._target = number
        if data[0] & sdo.WITH_SIZE:
            value = sdo.expedited_value(data)
            self._expect(None, lambda data: self._written(data, value))
            return SdoStep("write request", number, value=value)
        self._octets = _Octets(_announced(data, sdo.SIZE_INDICATED))
        self._expect(None, self._segments_accepted)
        return self._step("write request", _length(self._octets.announced))

    def _start_answered(self, data: bytes) -> SdoStep | None:
        code, number = data[0] & sdo.CODE, _number(data)
        if code == sdo.UPLOAD:
            self._target = number
            if data[0] & sdo.WITH_SIZE:
                value = sdo.expedited_value(data)
                self.reset()
                return SdoStep("read answer", number, value=value, holds=value)
            self._octets = _Octets(_announced(data, sdo.SIZE_INDICATED))
            self._expect(self._segment_asked, self._segment_read)
            return self._step("read answer", _length(self._octets.announced))
        if code == sdo.BLOCK_UPLOAD_ANSWER and not data[0] & 1:
            self._target = number
            self._octets = _Octets(_announced(data, sdo.WITH_SIZE))
            self._expect(self._block_started, None)
            return self._step("block read answer", _length(self._octets.announced))
        if data[0] == sdo.DOWNLOAD_DONE:
            self.reset()
            return SdoStep("write done", number)
        return None

    # Downloads

    def _written(self, data: bytes, value: bytes) -> SdoStep | None:
        if data[0] != sdo.DOWNLOAD_DONE or _number(data) != self._target:
            return None
        number = self._target
        self.reset()
        return SdoStep("write done", number, holds=value)

    def _segments_accepted(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.DOWNLOAD_DONE or _number(data) != self._target:
            return None
        self._expect(self._segment_written, None)
        return self._step("write accepted")

    def _segment_written(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT:
            return None
        self._octets.add(_segment(data))
        last = bool(data[0] & sdo.LAST)
        self._expect(
            self._segment_written, lambda data: self._segment_response(data, last)
        )
        if not last:
            return self._step("write segment", self._octets.progress())
        return self._complete("last write segment")

    def _segment_response(self, data: bytes, last: bool) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT_DONE:
            return None
        if not last:
            return self._step("segment taken")
        return self._done("write done")

    def _complete(self, verb: str) -> SdoStep:
        value = self._octets.value()
        return SdoStep(verb, self._target, self._octets.length(), value=value)

    # Uploads

    def _segment_asked(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.UPLOAD_SEGMENT:
            return None
        return self._step("segment request")

    def _segment_read(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE:
            return None
        self._octets.add(_segment(data))
        if not data[0] & sdo.LAST:
            return self._step("read segment", self._octets.progress())
        return self._read("last read segment")

    def _read(self, verb: str) -> SdoStep:
        number, value = self._target, self._octets.value()
        length = self._octets.length()
        self.reset()
        return SdoStep(verb, number, length, value=value, holds=value)

    # Blocks

    def _block_accepted(self, data: bytes) -> SdoStep | None:
        if data[0] & ~sdo.WITH_CRC != sdo.BLOCK_DOWNLOAD_ANSWER:
            return None
        self._next_block(reading=False)
        self._expect(self._block_segment, self._block_taken)
        return self._step("block write accepted", f"blocks of {data[4]}")

    def _block_started(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_START:
            return None
        self._next_block(reading=True)
        self._expect(self._block_taken, self._block_segment)
        return self._step("block read started")

    def _next_block(self, *, reading: bool) -> None:
        self._block, self._last, self._reading = {}, None, reading

    def _block_segment(self, data: bytes) -> SdoStep | None:
        sequence = data[0] & ~sdo.LAST_IN_BLOCK
        if not 1 <= sequence <= sdo.MAX_BLOCK:
            return None
        self._block[sequence] = data[1 : sdo.FRAME]
        if data[0] & sdo.LAST_IN_BLOCK:
            self._last = sequence
        return self._step("block segment", str(sequence))

    def _block_taken(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_ACKNOWLEDGED:
            return None
        taken = data[1]
        for sequence in range(1, min(taken, sdo.MAX_BLOCK) + 1):
            self._octets.add(self._block.get(sequence, bytes(sdo.SEGMENT)))
        sent, last = len(self._block), self._last
        if last is not None and taken >= last:
            if self._reading:
                self._expect(None, self._block_end)
            else:
                self._expect(self._block_end, None)
        self._next_block(reading=self._reading)
        lost = f"; {sent - taken} again" if taken < sent else ""
        return self._step("block taken", f"{self._octets.progress()}{lost}")

    def _block_end(self, data: bytes) -> SdoStep | None:
        if data[0] & ~0x1C != sdo.BLOCK_END:
            return None
        self._octets.cut(data[0] >> 2 & 7)
        if self._reading:
            self._expect(self._block_done, None)
            return self._complete("block read end")
        self._expect(None, self._block_done)
        return self._complete("block write end")

    def _block_done(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_ENDED:
            return None
        return self._done(f"block {'read' if self._reading else 'write'} done")

    def _done(self, verb: str) -> SdoStep:
        done = SdoStep(verb, self._target, holds=self._octets.value())
        self.reset()
        return done


def _number(data: bytes) -> Number:
    target = Target.of(data)
    return target.index, target.subindex


def _announced(data: bytes, flag: int) -> int | None:
    return sdo.announced_size(data) if data[0] & flag else None


def _length(size: int | None) -> str:
    return "" if size is None else f"{size} octets follow"


def _segment(data: bytes) -> bytes:
    return data[1 : sdo.FRAME - (data[0] >> 1 & 7)]
