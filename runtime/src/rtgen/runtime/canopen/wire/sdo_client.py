"""SDO client (CiA 301, 7.2.4): expedited, segmented and block transfers, one at a time.

Responses that start a transfer, and aborts, are matched by index and sub-index. After a time-out
the client aborts and drains: late responses are dropped until the server has been silent for a
while. Only segments of a block, which are numbered, are ever repeated.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

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

_Step: TypeAlias = Callable[[bytes], list[bytes]]
_BEGUN: Final = "a transfer is under way"


class SdoClient:
    """Reads and writes objects of one server.

    `cob_ids` are those of requests and responses, by default of the predefined server.
    `upload` and `download` return the first frames, and raise RuntimeError unless `ready`. The
    transfer has ended when `busy` is False; `result` then returns the value (empty for a
    download) or raises SdoAbort. `deadline` is the time of the next call of `poll`. `drain` is the
    silence in ns that ends draining, which takes at most ten times as long.
    """

    def __init__(
        self,
        node_id: int,
        *,
        cob_ids: tuple[CobId, CobId] | None = None,
        timeout: int = sdo.TIMEOUT,
        drain: int | None = None,
        max_size: int = sdo.MAX_SIZE,
        block_size: int = sdo.MAX_BLOCK,
    ) -> None:
        self._request, self._response = cob_ids or sdo_cob_ids(node_id)
        self._timeout = timeout
        self._drain = timeout if drain is None else drain
        self._max_size = max_size
        self._block_size = block_size
        self._target = Target(0, 0)
        self._step: _Step | None = None
        self._awaited = sdo.ANSWER
        self._number = 0
        """The number of the segment, or block, in its transfer."""
        self._foreign = False
        self._matching = False
        self._outcome: bytes | SdoAbort | None = None
        self._drain_end = 0
        self._draining = False
        self.deadline: int | None = None
        self.dropped = 0
        """Number of responses that belonged to no transfer, or to an abandoned one."""

    @property
    def busy(self) -> bool:
        """Whether a transfer is in progress."""
        return self._step is not None

    @property
    def ready(self) -> bool:
        """Whether a transfer can start: none is in progress, and draining has ended."""
        return self._step is None and not self._draining

    def result(self) -> bytes:
        """Return the result of the last transfer. Raises SdoAbort; RuntimeError without one."""
        if self._outcome is None:
            raise RuntimeError("no transfer has ended")
        if isinstance(self._outcome, SdoAbort):
            raise self._outcome
        return self._outcome

    def upload(
        self, index: int, subindex: int, now: int, *, block: bool = False
    ) -> list[Frame]:
        """Start reading an object; a server without block transfer may respond by segments."""
        self._begin(index, subindex, now, self._upload_answer)
        if not block:
            return self._frames([self._target.message(sdo.UPLOAD)])
        sizes = bytes((self._block_size, 0))
        return self._frames(
            [self._target.message(sdo.BLOCK_UPLOAD | sdo.WITH_CRC, sizes)]
        )

    def download(
        self, index: int, subindex: int, value: bytes, now: int, *, block: bool = False
    ) -> list[Frame]:
        """Start writing an object. Raises ValueError for more than `max_size` octets."""
        size = len(value)
        if size > self._max_size:
            raise ValueError(f"{size} octets; up to {self._max_size} are written")
        announced = sdo.size_octets(size)
        if block:
            sender = BlockSender(value)
            step: _Step = lambda data: self._block_begun(sender, data)  # noqa: E731
            self._begin(index, subindex, now, step)
            command = sdo.BLOCK_DOWNLOAD | sdo.WITH_CRC | sdo.WITH_SIZE
            return self._frames([self._target.message(command, announced)])
        if 1 <= size <= sdo.EXPEDITED:
            self._begin(index, subindex, now, self._written)
            return self._frames([sdo.expedited(sdo.DOWNLOAD, self._target, value)])
        segments = Segments(value)
        self._begin(index, subindex, now, lambda data: self._begun(segments, data))
        command = sdo.DOWNLOAD | sdo.SIZE_INDICATED
        return self._frames([self._target.message(command, announced)])

    def receive(self, frame: Frame, now: int) -> list[Frame]:
        """Process a frame; return the frames to send."""
        if not self._response.carries(frame) or frame.remote:
            return []
        data = frame.data
        if self._step is None:
            self.dropped += 1
            if self._draining:
                self.deadline = min(now + self._drain, self._drain_end)
            return []
        foreign = len(data) != sdo.FRAME or (
            (self._matching or data[0] == sdo.ABORT) and Target.of(data) != self._target
        )
        if foreign:
            self.dropped += 1
            self._foreign = True
            return []
        if data[0] == sdo.ABORT:
            code = sdo.announced_size(data)
            self._end(SdoAbort(code, received=True, awaited=self._awaited))
            return []
        try:
            messages = self._step(data)
        except SdoAbort as abort:
            abort.awaited = self._awaited
            messages = [self._target.abort(abort.code)]
            self._end(abort)
            self._start_draining(now)
        if self._step is not None:
            self.deadline = now + self._timeout
        return self._frames(messages)

    def poll(self, now: int) -> list[Frame]:
        """Abort the transfer if the server is silent for too long; end draining."""
        if self.deadline is None or now < self.deadline:
            return []
        if self._draining:
            self._draining, self.deadline = False, None
            return []
        return self.cancel(now, sdo.TIMED_OUT)

    def cancel(self, now: int, code: int = sdo.GENERAL_ERROR) -> list[Frame]:
        """Abort the current transfer with a code, and drain."""
        if self._step is None:
            return []
        abort = SdoAbort(code, awaited=self._awaited)
        if code == sdo.TIMED_OUT:
            abort.within, abort.foreign = self._timeout, self._foreign
        self._end(abort)
        self._start_draining(now)
        return self._frames([self._target.abort(code)])

    def reset(self) -> None:
        """Drop the current transfer without a message, because the server has been reset."""
        if self._step is not None:
            self._end(SdoAbort(sdo.DEVICE_STATE))
        self._draining, self.deadline = False, None

    def _frames(self, messages: list[bytes]) -> list[Frame]:
        return [self._request.frame(data) for data in messages]

    def _begin(self, index: int, subindex: int, now: int, step: _Step) -> None:
        if not self.ready:
            raise RuntimeError(_BEGUN)
        self._target = Target(index, subindex)
        self._outcome, self._step, self._matching = None, step, True
        self._awaited, self._number, self._foreign = sdo.ANSWER, 0, False
        self.deadline = now + self._timeout

    def _go(self, awaited: str, step: _Step) -> None:
        """Set the next step, whose responses have no index."""
        self._step, self._matching, self._awaited = step, False, awaited

    def _count(self) -> int:
        """Return the number of the next segment, or block, of the transfer."""
        self._number += 1
        return self._number

    def _end(self, outcome: bytes | SdoAbort) -> None:
        self._outcome, self._step, self.deadline = outcome, None, None

    def _start_draining(self, now: int) -> None:
        self._draining = True
        self.deadline = now + self._drain
        self._drain_end = now + 10 * self._drain

    # Downloads

    def _written(self, data: bytes) -> list[bytes]:
        if data[0] != sdo.DOWNLOAD_DONE:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self._end(b"")
        return []

    def _begun(self, segments: Segments, data: bytes) -> list[bytes]:
        if data[0] != sdo.DOWNLOAD_DONE:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        return self._next_segment(segments)

    def _next_segment(self, segments: Segments) -> list[bytes]:
        self._go(
            f"answer to segment {self._count()}",
            lambda data: self._segment_taken(segments, data),
        )
        return [segments.next(sdo.DOWNLOAD_SEGMENT)]

    def _segment_taken(self, segments: Segments, data: bytes) -> list[bytes]:
        if data[0] & sdo.CODE != sdo.DOWNLOAD_SEGMENT_DONE:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        if data[0] & sdo.TOGGLE == segments.toggle:
            raise SdoAbort(sdo.TOGGLE_ERROR)
        if segments.done:
            self._end(b"")
            return []
        return self._next_segment(segments)

    def _block_begun(self, sender: BlockSender, data: bytes) -> list[bytes]:
        if data[0] & ~sdo.WITH_CRC != sdo.BLOCK_DOWNLOAD_ANSWER:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        with_crc = bool(data[0] & sdo.WITH_CRC)
        return self._next_block(sender, with_crc, data[4])

    def _next_block(
        self, sender: BlockSender, with_crc: bool, size: int
    ) -> list[bytes]:
        segments = sender.block(size)
        self._go(
            f"answer to block {self._count()} ({len(segments)} segments)",
            lambda data: self._block_next(sender, with_crc, data),
        )
        return segments

    def _block_next(
        self, sender: BlockSender, with_crc: bool, data: bytes
    ) -> list[bytes]:
        if data[0] != sdo.BLOCK_ACKNOWLEDGED:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        sender.acknowledge(data[1])
        if not sender.done:
            return self._next_block(sender, with_crc, data[2])
        self._go("answer to the end of the transfer", self._block_written)
        return [sender.end(with_crc)]

    def _block_written(self, data: bytes) -> list[bytes]:
        if data[0] != sdo.BLOCK_ENDED:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self._end(b"")
        return []

    # Uploads

    def _upload_answer(self, data: bytes) -> list[bytes]:
        code = data[0] & sdo.CODE
        if code == sdo.BLOCK_UPLOAD_ANSWER and not data[0] & sdo.SIZE_INDICATED:
            return self._block_upload_begun(data)
        if code != sdo.UPLOAD:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        if data[0] & sdo.WITH_SIZE:
            self._end(sdo.expedited_value(data))
            return []
        size = sdo.announced_size(data) if data[0] & sdo.SIZE_INDICATED else None
        collector = Collector(self._max_size, size)
        return self._ask(collector)

    def _ask(self, collector: Collector) -> list[bytes]:
        self._go(
            f"segment {self._count()}", lambda data: self._segment(collector, data)
        )
        return [bytes((sdo.UPLOAD_SEGMENT | collector.toggle,)) + bytes(7)]

    def _segment(self, collector: Collector, data: bytes) -> list[bytes]:
        if data[0] & sdo.CODE:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        if collector.take(data):
            self._end(collector.value())
            return []
        return self._ask(collector)

    def _block_upload_begun(self, data: bytes) -> list[bytes]:
        size = sdo.announced_size(data) if data[0] & sdo.WITH_SIZE else None
        receiver = BlockReceiver(self._max_size, size, self._block_size)
        with_crc = bool(data[0] & sdo.WITH_CRC)
        self._count()
        self._await_segment(receiver, with_crc)
        return [bytes((sdo.BLOCK_START,)) + bytes(7)]

    def _await_segment(self, receiver: BlockReceiver, with_crc: bool) -> None:
        self._go(
            f"segment {receiver.next} of block {self._number}",
            lambda data: self._block_segment(receiver, with_crc, data),
        )

    def _block_segment(
        self, receiver: BlockReceiver, with_crc: bool, data: bytes
    ) -> list[bytes]:
        answer = receiver.take(data)
        if answer is not None and receiver.complete:
            self._go(
                "end of the transfer",
                lambda data: self._block_end(receiver, with_crc, data),
            )
            return [answer]
        if answer is not None:
            self._count()
        self._await_segment(receiver, with_crc)
        return [] if answer is None else [answer]

    def _block_end(
        self, receiver: BlockReceiver, with_crc: bool, data: bytes
    ) -> list[bytes]:
        if data[0] & ~0x1C != sdo.BLOCK_END:
            raise SdoAbort(sdo.COMMAND_UNKNOWN)
        self._end(receiver.value(data, with_crc))
        return [bytes((sdo.BLOCK_ENDED,)) + bytes(7)]
