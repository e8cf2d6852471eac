"""SDO transfers as a third station sees them (CiA 301, 7.2.4): what each message does in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from rtgen.runtime.canopen import sdo
from rtgen.runtime.canopen.sdo import Target

MAX_VALUE: Final = 1 << 16
"""The longest value, in octets, that is put together; of longer ones only the length is told."""

Number: TypeAlias = tuple[int, int]


@dataclass(frozen=True, slots=True)
class SdoStep:
    """What a message does.

    `number` is the variable that it is about, None if nobody knows. `value` is the whole value
    that the message carries or completes. `holds` is the value that the variable is known to have
    from now on: a read one, or a written one when the server confirms it. `abort` is an abort code.
    """

    verb: str
    number: Number | None
    detail: str = ""
    value: bytes | None = None
    holds: bytes | None = None
    abort: int | None = None


class _Octets:
    """A value that comes in parts, as far as it is short enough."""

    def __init__(self, told: int | None) -> None:
        self.told = told
        self.size = 0
        self._parts = bytearray()

    def add(self, part: bytes) -> None:
        self.size += len(part)
        if self.size <= MAX_VALUE + sdo.SEGMENT:
            self._parts += part

    def cut(self, unused: int) -> None:
        """Takes octets away at the end."""
        self.size = max(0, self.size - unused)
        del self._parts[self.size :]

    def value(self) -> bytes | None:
        return bytes(self._parts) if self.size <= MAX_VALUE else None

    def progress(self) -> str:
        return f"{self.size} of {self.told} octets" if self.told else self.length()

    def length(self) -> str:
        return f"{self.size} octets"


_Step: TypeAlias = Callable[[bytes], SdoStep | None]
"""What the transfer under way makes of the next message of an end; None: not its own."""


class SdoFollower:
    """Follows the transfers of one server; it may begin to listen in the middle of one."""

    def __init__(self) -> None:
        self._target: Number | None = None
        self._request: _Step | None = None
        self._response: _Step | None = None
        self._octets = _Octets(None)
        self._block: dict[int, bytes] = {}
        self._last: int | None = None
        self._reading = False

    def reset(self) -> None:
        """Forgets the transfer under way."""
        self._target = self._request = self._response = None

    def request(self, data: bytes) -> SdoStep:
        """A message of the client; it has 8 octets."""
        if data[0] == sdo.ABORT:
            return self._aborted(data, "client")
        step = self._request(data) if self._request else None
        return step or self._begun(data) or self._unknown("request")

    def response(self, data: bytes) -> SdoStep:
        """A message of the server; it has 8 octets."""
        if data[0] == sdo.ABORT:
            return self._aborted(data, "server")
        step = self._response(data) if self._response else None
        return step or self._answered(data) or self._unknown("answer")

    def _unknown(self, what: str) -> SdoStep:
        return SdoStep(f"{what} of a transfer that began before", self._target)

    def _aborted(self, data: bytes, by: str) -> SdoStep:
        number, code = _number(data), sdo.told_size(data)
        self.reset()
        text = sdo.ABORT_TEXTS.get(code, "unknown abort code")
        detail = f"{code:08X}h {text} (by the {by})"
        return SdoStep("abort", number, detail, abort=code)

    def _say(self, verb: str, detail: str = "") -> SdoStep:
        return SdoStep(verb, self._target, detail)

    def _await(self, request: _Step | None, response: _Step | None) -> None:
        self._request, self._response = request, response

    # How a transfer begins

    def _begun(self, data: bytes) -> SdoStep | None:
        code, number = data[0] & sdo.CODE, _number(data)
        if code == sdo.UPLOAD:
            self._target = number
            self._await(None, None)
            return self._say("read request")
        if code == sdo.DOWNLOAD:
            return self._download_begun(data, number)
        if code == sdo.BLOCK_DOWNLOAD and not data[0] & 1:
            self._target = number
            self._octets = _Octets(_told(data, sdo.WITH_SIZE))
            self._await(None, self._block_accepted)
            return self._say("block write request", _length(self._octets.told))
        if code == sdo.BLOCK_UPLOAD and not data[0] & 3:
            self._target = number
            self._await(None, None)
            return self._say("block read request", f"blocks of {data[4]}")
        return None

    def _download_begun(self, data: bytes, number: Number) -> SdoStep:
        self._target = number
        if data[0] & sdo.WITH_SIZE:
            value = sdo.expedited_value(data)
            self._await(None, lambda data: self._written(data, value))
            return SdoStep("write request", number, value=value)
        self._octets = _Octets(_told(data, sdo.SIZE_TOLD))
        self._await(None, self._segments_accepted)
        return self._say("write request", _length(self._octets.told))

    def _answered(self, data: bytes) -> SdoStep | None:
        code, number = data[0] & sdo.CODE, _number(data)
        if code == sdo.UPLOAD:
            self._target = number
            if data[0] & sdo.WITH_SIZE:
                value = sdo.expedited_value(data)
                self.reset()
                return SdoStep("read answer", number, value=value, holds=value)
            self._octets = _Octets(_told(data, sdo.SIZE_TOLD))
            self._await(self._segment_asked, self._segment_read)
            return self._say("read answer", _length(self._octets.told))
        if code == sdo.BLOCK_UPLOAD_ANSWER and not data[0] & 1:
            self._target = number
            self._octets = _Octets(_told(data, sdo.WITH_SIZE))
            self._await(self._block_started, None)
            return self._say("block read answer", _length(self._octets.told))
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
        self._await(self._segment_written, None)
        return self._say("write accepted")

    def _segment_written(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT:
            return None
        self._octets.add(_segment(data))
        last = bool(data[0] & sdo.LAST)
        self._await(self._segment_written, lambda data: self._taken(data, last))
        if not last:
            return self._say("write segment", self._octets.progress())
        return self._whole("last write segment")

    def _taken(self, data: bytes, last: bool) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT_DONE:
            return None
        if not last:
            return self._say("segment taken")
        done = SdoStep("write done", self._target, holds=self._octets.value())
        self.reset()
        return done

    def _whole(self, verb: str) -> SdoStep:
        value = self._octets.value()
        return SdoStep(verb, self._target, self._octets.length(), value=value)

    # Uploads

    def _segment_asked(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE != sdo.UPLOAD_SEGMENT:
            return None
        return self._say("segment request")

    def _segment_read(self, data: bytes) -> SdoStep | None:
        if data[0] & sdo.CODE:
            return None
        self._octets.add(_segment(data))
        if not data[0] & sdo.LAST:
            return self._say("read segment", self._octets.progress())
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
        self._await(self._block_segment, self._block_taken)
        return self._say("block write accepted", f"blocks of {data[4]}")

    def _block_started(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_START:
            return None
        self._next_block(reading=True)
        self._await(self._block_taken, self._block_segment)
        return self._say("block read started")

    def _next_block(self, *, reading: bool) -> None:
        self._block, self._last, self._reading = {}, None, reading

    def _block_segment(self, data: bytes) -> SdoStep | None:
        sequence = data[0] & ~sdo.LAST_IN_BLOCK
        if not 1 <= sequence <= sdo.MAX_BLOCK:
            return None
        self._block[sequence] = data[1 : sdo.FRAME]
        if data[0] & sdo.LAST_IN_BLOCK:
            self._last = sequence
        return self._say("block segment", str(sequence))

    def _block_taken(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_ACKNOWLEDGED:
            return None
        taken = data[1]
        for sequence in range(1, min(taken, sdo.MAX_BLOCK) + 1):
            self._octets.add(self._block.get(sequence, bytes(sdo.SEGMENT)))
        sent, last = len(self._block), self._last
        if last is not None and taken >= last:
            if self._reading:
                self._await(None, self._block_read)
            else:
                self._await(self._block_written, None)
        self._next_block(reading=self._reading)
        lost = f"; {sent - taken} again" if taken < sent else ""
        return self._say("block taken", f"{self._octets.progress()}{lost}")

    def _block_written(self, data: bytes) -> SdoStep | None:
        if data[0] & ~0x1C != sdo.BLOCK_END:
            return None
        self._octets.cut(data[0] >> 2 & 7)
        self._await(None, self._block_done)
        return self._whole("block write end")

    def _block_done(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_ENDED:
            return None
        done = SdoStep("block write done", self._target, holds=self._octets.value())
        self.reset()
        return done

    def _block_read(self, data: bytes) -> SdoStep | None:
        if data[0] & ~0x1C != sdo.BLOCK_END:
            return None
        self._octets.cut(data[0] >> 2 & 7)
        self._await(self._block_read_done, None)
        return self._whole("block read end")

    def _block_read_done(self, data: bytes) -> SdoStep | None:
        if data[0] != sdo.BLOCK_ENDED:
            return None
        done = SdoStep("block read done", self._target, holds=self._octets.value())
        self.reset()
        return done


def _number(data: bytes) -> Number:
    target = Target.of(data)
    return target.index, target.subindex


def _told(data: bytes, flag: int) -> int | None:
    return sdo.told_size(data) if data[0] & flag else None


def _length(size: int | None) -> str:
    return "" if size is None else f"{size} octets follow"


def _segment(data: bytes) -> bytes:
    return data[1 : sdo.FRAME - (data[0] >> 1 & 7)]
