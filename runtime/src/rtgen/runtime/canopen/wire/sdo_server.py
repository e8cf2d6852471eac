"""SDO server (CiA 301, 7.2.4): expedited, segmented and block transfers, one at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import CobId, Frame, sdo_cob_ids
from rtgen.runtime.canopen.wire.sdo import (
    BlockReceiver,
    BlockSender,
    Collector,
    SdoAbort,
    Segments,
    Target,
)


class ObjectDictionary(Protocol):
    """The objects of a server. Each method may raise SdoAbort."""

    def read(self, index: int, subindex: int) -> bytes:
        """Return the value as octets."""

    def writable_size(self, index: int, subindex: int) -> int:
        """Return the maximum number of octets to write; called before any are accepted."""

    def write(self, index: int, subindex: int, value: bytes) -> None:
        """Write a value."""


_Step: TypeAlias = Callable[[bytes], list[bytes]]
"""Function that processes the next message of the current transfer; returns the responses."""


class SdoServer:
    """Serves one client; `poll` abandons the current transfer at `deadline`.

    `cob_ids` are those of requests and responses, by default of the predefined server.

    A request that starts a transfer ends the previous one, which the client has abandoned. Messages
    that do not have 8 octets are ignored.
    """

    def __init__(
        self,
        node_id: int,
        objects: ObjectDictionary,
        *,
        cob_ids: tuple[CobId, CobId] | None = None,
        timeout: int = sdo.TIMEOUT,
        max_size: int = sdo.MAX_SIZE,
        block_size: int = sdo.MAX_BLOCK,
    ) -> None:
        self.request, self.response = cob_ids or sdo_cob_ids(node_id)
        self._objects = objects
        self._timeout = timeout
        self._max_size = max_size
        self._block_size = block_size
        self._target = Target(0, 0)
        self._step: _Step | None = None
        self._in_block = False
        self.deadline: int | None = None

    def reset(self) -> None:
        """Drop the current transfer without a message."""
        self._step, self._in_block, self.deadline = None, False, None

    def receive(self, frame: Frame, now: int) -> list[Frame]:
        """Return the responses to a frame."""
        if not self.request.carries(frame) or frame.remote:
            return []
        if len(frame.data) != sdo.FRAME:
            return []
        if frame.data[0] == sdo.ABORT:
            self.reset()
            return []
        try:
            answers = self._answers(frame.data)
        except SdoAbort as abort:
            self.reset()
            answers = [self._target.abort(abort.code)]
        self.deadline = now + self._timeout if self._step else None
        return self._frames(answers)

    def poll(self, now: int) -> list[Frame]:
        """Abort the transfer if the client is silent for too long."""
        if self.deadline is None or now < self.deadline:
            return []
        self.reset()
        return self._frames([self._target.abort(sdo.TIMED_OUT)])

    def _frames(self, messages: list[bytes]) -> list[Frame]:
        return [self.response.frame(data) for data in messages]

    def _answers(self, data: bytes) -> list[bytes]:
        begin = None if self._is_segment(data) else self._beginning(data)
        if begin is not None:
            self.reset()
            self._target = Target.of(data)
            return begin(data)
        if self._step is None:
            self._target = Target.of(data)
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        return self._step(data)

    def _is_segment(self, data: bytes) -> bool:
        """Return whether a message can be a segment of the current block download.

        A client whose abort was lost starts its next transfer in the middle of the block.
        """
        return self._in_block and data[0] & ~sdo.LAST_IN_BLOCK <= self._block_size

    def _beginning(self, data: bytes) -> _Step | None:
        code = data[0] & sdo.CODE
        if code == sdo.DOWNLOAD:
            return self._download
        if code == sdo.UPLOAD:
            return self._upload
        if code == sdo.BLOCK_DOWNLOAD and not data[0] & 1:
            return self._block_download
        if code == sdo.BLOCK_UPLOAD and not data[0] & 3:
            return self._block_upload
        return None

    # Downloads

    def _limit(self) -> int:
        target = self._target
        return min(
            self._objects.writable_size(target.index, target.subindex), self._max_size
        )

    def _write(self, value: bytes) -> None:
        self._objects.write(self._target.index, self._target.subindex, value)

    def _download(self, data: bytes) -> list[bytes]:
        limit = self._limit()
        if data[0] & sdo.WITH_SIZE:
            value = sdo.expedited_value(data)
            self._write(value if data[0] & sdo.SIZE_INDICATED else value[:limit])
        else:
            size = self._size(data, data[0] & sdo.SIZE_INDICATED, limit)
            collector = Collector(limit, size)
            self._step = lambda data: self._download_segment(collector, data)
        return [self._target.message(sdo.DOWNLOAD_DONE)]

    @staticmethod
    def _size(data: bytes, announced: int, limit: int) -> int | None:
        if not announced:
            return None
        size = sdo.announced_size(data)
        if size > limit:
            raise SdoAbort(sdo.LENGTH_TOO_HIGH)
        return size

    def _download_segment(self, collector: Collector, data: bytes) -> list[bytes]:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        toggle = data[0] & sdo.TOGGLE
        if collector.take(data):
            self._write(collector.value())
            self.reset()
        return [bytes((sdo.DOWNLOAD_SEGMENT_DONE | toggle,)) + bytes(7)]

    def _block_download(self, data: bytes) -> list[bytes]:
        limit = self._limit()
        size = self._size(data, data[0] & sdo.WITH_SIZE, limit)
        receiver = BlockReceiver(limit, size, self._block_size)
        with_crc = bool(data[0] & sdo.WITH_CRC)
        self._in_block = True
        self._step = lambda data: self._block_segment(receiver, with_crc, data)
        answer = sdo.BLOCK_DOWNLOAD_ANSWER | sdo.WITH_CRC
        return [self._target.message(answer, bytes((self._block_size,)))]

    def _block_segment(
        self, receiver: BlockReceiver, with_crc: bool, data: bytes
    ) -> list[bytes]:
        answer = receiver.take(data)
        if answer is not None and receiver.complete:
            self._in_block = False
            self._step = lambda data: self._block_end(receiver, with_crc, data)
        return [] if answer is None else [answer]

    def _block_end(
        self, receiver: BlockReceiver, with_crc: bool, data: bytes
    ) -> list[bytes]:
        if data[0] & ~0x1C != sdo.BLOCK_END:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self._write(receiver.value(data, with_crc))
        self.reset()
        return [bytes((sdo.BLOCK_ENDED,)) + bytes(7)]

    # Uploads

    def _read(self) -> bytes:
        value = self._objects.read(self._target.index, self._target.subindex)
        if len(value) > self._max_size:
            raise SdoAbort(sdo.OUT_OF_MEMORY)
        return value

    def _upload(self, data: bytes) -> list[bytes]:
        return self._ordinary_upload(self._read())

    def _ordinary_upload(self, value: bytes) -> list[bytes]:
        if 1 <= len(value) <= sdo.EXPEDITED:
            return [sdo.expedited(sdo.UPLOAD, self._target, value)]
        segments = Segments(value)
        self._step = lambda data: self._upload_segment(segments, data)
        announced = sdo.size_octets(len(value))
        return [self._target.message(sdo.UPLOAD | sdo.SIZE_INDICATED, announced)]

    def _upload_segment(self, segments: Segments, data: bytes) -> list[bytes]:
        if data[0] & sdo.CODE != sdo.UPLOAD_SEGMENT:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        if data[0] & sdo.TOGGLE != segments.toggle:
            raise SdoAbort(sdo.TOGGLE_ERROR)
        answer = segments.next(0)
        if segments.done:
            self.reset()
        return [answer]

    def _block_upload(self, data: bytes) -> list[bytes]:
        if not 1 <= data[4] <= sdo.MAX_BLOCK:
            raise SdoAbort(sdo.BLOCK_SIZE_INVALID)
        value = self._read()
        if len(value) <= data[5]:
            return self._ordinary_upload(value)
        sender = BlockSender(value)
        size, with_crc = data[4], bool(data[0] & sdo.WITH_CRC)
        self._step = lambda data: self._block_go(sender, size, with_crc, data)
        answer = sdo.BLOCK_UPLOAD_ANSWER | sdo.WITH_CRC | sdo.WITH_SIZE
        return [self._target.message(answer, sdo.size_octets(len(value)))]

    def _block_go(
        self, sender: BlockSender, size: int, with_crc: bool, data: bytes
    ) -> list[bytes]:
        if data[0] != sdo.BLOCK_START:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self._step = lambda data: self._block_next(sender, with_crc, data)
        return sender.block(size)

    def _block_next(
        self, sender: BlockSender, with_crc: bool, data: bytes
    ) -> list[bytes]:
        if data[0] != sdo.BLOCK_ACKNOWLEDGED:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        sender.acknowledge(data[1])
        if not sender.done:
            return sender.block(data[2])
        self._step = self._block_ended
        return [sender.end(with_crc)]

    def _block_ended(self, data: bytes) -> list[bytes]:
        if data[0] != sdo.BLOCK_ENDED:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self.reset()
        return []
