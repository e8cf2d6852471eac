"""The checks of downloads by segments and by blocks (CiA 301, 7.2.4.3.3 to 12).

They write its present value to 1017h.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.description import ObjectNumber
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import SdoAbort, Segments, Target
from rtgen.tools.conformance.canopen.node import NodeUnderTest, refusal
from rtgen.tools.conformance.check import Problems, SkipError, check

HEARTBEAT: Final = (0x1017, 0)
NAME: Final = (0x1008, 0)
_LENGTH: Final = (sdo.LENGTH_TOO_HIGH, sdo.LENGTH_MISMATCH, sdo.LENGTH_TOO_LOW)
_NO_TRANSFER: Final = (sdo.COMMAND_UNKNOWN, sdo.ACCESS_UNSUPPORTED)


def writable_heartbeat(node: NodeUnderTest) -> bytes:
    """Return the octets of 1017h. Raises SkipError if it is not writable."""
    thing = node.described.objects.get(HEARTBEAT)
    if thing is None or not thing.access.writable:
        raise SkipError("1017h is not described as writable")
    return node.upload(HEARTBEAT)


def long_name(node: NodeUnderTest, least: int = sdo.EXPEDITED + 1) -> ObjectNumber:
    """Return 1008h, if its value has enough octets. Raises SkipError."""
    if len(node.values.get(NAME, b"")) < least:
        raise SkipError(f"1008h has no value of more than {least - 1} octets")
    return NAME


def abort_code(answer: bytes) -> int | None:
    """Return the abort code of a response, None for another response."""
    return sdo.announced_size(answer) if answer[0] == sdo.ABORT else None


def _begin(node: NodeUnderTest, command: int, data: bytes = b"") -> bytes:
    """Return the response to the first message of a transfer of 1017h. Raises SdoAbort."""
    answer = node.ask(Target(*HEARTBEAT).message(command, data))
    code = abort_code(answer)
    if code is not None:
        raise SdoAbort(code)
    return answer


def _is_kept(node: NodeUnderTest, before: bytes) -> str | None:
    now = node.upload(HEARTBEAT)
    return None if now == before else f"1017h is {now.hex()} then, not {before.hex()}"


@check("sdo.segments", "downloads by segments", "CiA 301, 7.2.4.3.3")
def segments(node: NodeUnderTest) -> Problems:
    """Check that segmented downloads are accepted, unless toggle bit or length is wrong."""
    before = writable_heartbeat(node)
    command = sdo.DOWNLOAD | sdo.SIZE_INDICATED
    announced = sdo.size_octets(len(before))
    try:
        _begin(node, command, announced)
    except SdoAbort as abort:
        if abort.code in _NO_TRANSFER:
            raise SkipError("1017h does not accept segments") from None
        raise
    answer = node.ask(Segments(before).next(sdo.DOWNLOAD_SEGMENT))
    taken = answer[0] == sdo.DOWNLOAD_SEGMENT_DONE
    yield None if taken else f"the answer to a segment is {answer.hex(' ')}"
    yield _is_kept(node, before)

    _begin(node, command, announced)
    wrong = Segments(before)
    wrong.toggle = sdo.TOGGLE
    code = abort_code(node.ask(wrong.next(sdo.DOWNLOAD_SEGMENT)))
    yield refusal("the first segment with toggle bit 1", code, sdo.TOGGLE_ERROR)
    if code is None:
        node.abandon(HEARTBEAT)

    for size in (1, 3):
        what = f"{size} octets in a segment"
        try:
            _begin(node, command, sdo.size_octets(size))
            code = abort_code(
                node.ask(Segments(bytes(size)).next(sdo.DOWNLOAD_SEGMENT))
            )
        except SdoAbort as abort:
            code = abort.code
        yield refusal(what, code, *_LENGTH)
    yield _is_kept(node, before)


def _blocks(node: NodeUnderTest, before: bytes) -> bytes:
    """Return the first response to a block download of 1017h. Raises SkipError, SdoAbort."""
    command = sdo.BLOCK_DOWNLOAD | sdo.WITH_CRC | sdo.WITH_SIZE
    try:
        return _begin(node, command, sdo.size_octets(len(before)))
    except SdoAbort as abort:
        if abort.code in _NO_TRANSFER:
            raise SkipError("the node has no block transfer") from None
        raise


def _end(check: int, size: int) -> bytes:
    """Return the message that ends a block download of one segment with `size` octets."""
    unused = sdo.SEGMENT - size
    end = bytes((sdo.BLOCK_END | unused << 2,))
    return end + check.to_bytes(2, "little") + bytes(5)


@check(
    "sdo.block-download",
    "downloads by blocks, with their check sum",
    "CiA 301, 7.2.4.3.9",
)
def block_download(node: NodeUnderTest) -> Problems:
    """Check that a block download is accepted, and rejected with a wrong check sum."""
    before = writable_heartbeat(node)
    for flipped in (0, 1):
        answer = _blocks(node, before)
        with_crc = bool(answer[0] & sdo.WITH_CRC)
        if flipped and not with_crc:
            return
        size = answer[4]
        fits = 1 <= size <= sdo.MAX_BLOCK
        yield None if fits else f"the node offers blocks of {size} segments"
        last = bytes((sdo.LAST_IN_BLOCK | 1,)) + before.ljust(sdo.SEGMENT, b"\0")
        answer = node.ask(last)
        taken = answer[:2] == bytes((sdo.BLOCK_ACKNOWLEDGED, 1))
        yield None if taken else f"the answer to a segment is {answer.hex(' ')}"
        check = sdo.crc(before) ^ flipped if with_crc else 0
        answer = node.ask(_end(check, len(before)))
        if flipped:
            yield refusal("a wrong check sum", abort_code(answer), sdo.CRC_ERROR)
        else:
            ended = answer[0] == sdo.BLOCK_ENDED
            yield None if ended else f"the answer to the end is {answer.hex(' ')}"
        yield _is_kept(node, before)


@check(
    "sdo.block-sizes",
    "uploads by blocks of a wrong size are refused",
    "CiA 301, 7.2.4.3.13",
)
def block_sizes(node: NodeUnderTest) -> Problems:
    """Check that block uploads with 0 or over 127 segments, or a false count, are rejected."""
    target = Target(*long_name(node, sdo.SEGMENT + 1))
    command = sdo.BLOCK_UPLOAD | sdo.WITH_CRC
    for size in (0, sdo.MAX_BLOCK + 1):
        answer = node.ask(target.message(command, bytes((size,))))
        code = abort_code(answer)
        if code in _NO_TRANSFER:
            raise SkipError("the node has no block transfer")
        yield refusal(f"blocks of {size} segments", code, sdo.BLOCK_SIZE_INVALID)
        if code is None:
            node.abandon(NAME)
    answer = node.ask(target.message(command, bytes((1,))))
    if answer[0] & sdo.CODE != sdo.BLOCK_UPLOAD_ANSWER:
        raise SkipError("the node answers a block upload of 1008h by segments")
    node.ask(bytes((sdo.BLOCK_START,)).ljust(sdo.FRAME, b"\0"))
    false = bytes((sdo.BLOCK_ACKNOWLEDGED, 2, 1)).ljust(sdo.FRAME, b"\0")
    code = abort_code(node.ask(false))
    yield refusal("two segments of one acknowledged", code, sdo.SEQUENCE_INVALID)
    if code is None:
        node.abandon(NAME)
    same = node.upload(NAME) == node.values[NAME]
    yield None if same else "1008h differs after that"


@check(
    "sdo.block-repeats", "lost segments of blocks are repeated", "CiA 301, 7.2.4.3.11"
)
def block_repeats(node: NodeUnderTest) -> Problems:
    """Check that segments of a block that were lost, in either direction, are repeated."""
    yield _upload_repeats(node)
    before = writable_heartbeat(node)
    answer = _blocks(node, before)
    check = sdo.crc(before) if answer[0] & sdo.WITH_CRC else 0
    last = before.ljust(sdo.SEGMENT, b"\0")
    for number, expected in ((2, 0), (1, 1)):
        answer = node.ask(bytes((sdo.LAST_IN_BLOCK | number,)) + last)
        fits = answer[:2] == bytes((sdo.BLOCK_ACKNOWLEDGED, expected))
        octets = answer.hex(" ")
        yield None if fits else f"the answer to segment {number} is {octets}"
        if not fits:
            node.abandon(HEARTBEAT)
            return
    node.ask(_end(check, len(before)))
    yield _is_kept(node, before)


def _upload_repeats(node: NodeUnderTest) -> str | None:
    """Return a problem unless a block is repeated from the last acknowledged segment."""
    target = Target(*long_name(node, sdo.SEGMENT + 1))
    command = sdo.BLOCK_UPLOAD | sdo.WITH_CRC
    answer = node.ask(target.message(command, bytes((sdo.MAX_BLOCK,))))
    if abort_code(answer) in _NO_TRANSFER:
        raise SkipError("the node has no block transfer")
    if answer[0] & sdo.CODE != sdo.BLOCK_UPLOAD_ANSWER:
        raise SkipError("the node answers a block upload of 1008h by segments")
    _block_of(node, bytes((sdo.BLOCK_START,)))
    lost = bytes((sdo.BLOCK_ACKNOWLEDGED, 0, sdo.MAX_BLOCK))
    again = _block_of(node, lost)
    node.abandon(NAME)
    value = node.values[NAME]
    content = b"".join(segment[1:] for segment in again)[: len(value)]
    same = again[0][0] & ~sdo.LAST_IN_BLOCK == 1 and content == value
    return None if same else "a block without acknowledgement is not repeated"


def _block_of(node: NodeUnderTest, request: bytes) -> list[bytes]:
    """Return the segments up to the last one of a transfer, or up to an abort."""
    answers = [node.ask(request.ljust(sdo.FRAME, b"\0"))]
    while not answers[-1][0] & sdo.LAST_IN_BLOCK and len(answers) < sdo.MAX_BLOCK:
        answers.append(node.next_answer())
    return answers
