"""Frames, identifiers, EMCY, SYNC and TIME."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from rtgen.runtime.canopen.wire.emergency import (
    Emergency,
    ErrorRegister,
    code_text,
    emergency_in,
)
from rtgen.runtime.canopen.wire.frames import CobId, Frame
from rtgen.runtime.canopen.wire.sync import (
    SyncProducer,
    decode_time,
    sync_counter,
)

MS = 1_000_000


def test_cob_ids_that_objects_may_have() -> None:
    for fine in (0x181, 0xC0000181, 0x80000200, 0x20012345, 0xA0012345):
        assert CobId(fine).configurable
    for wrong in (0x101, 0x981, 0x10000181, 0xC0000981):
        assert not CobId(wrong).configurable


def test_cob_id_flags() -> None:
    cob_id = CobId(0xC0000185)
    assert (cob_id.bit31, cob_id.bit30, cob_id.extended) == (True, True, False)
    assert cob_id.can_id == 0x185
    assert CobId(0x20012345).frame(b"a") == Frame(0x12345, b"a", extended=True)
    assert not CobId(0x20000185).carries(Frame(0x185))
    with pytest.raises(ValueError, match="no COB-ID"):
        CobId(1 << 32)


def test_frames_that_cannot_be() -> None:
    with pytest.raises(ValueError, match="identifier"):
        Frame(0x800)
    with pytest.raises(ValueError, match="9 octets"):
        Frame(1, bytes(9))


def test_emergency() -> None:
    sent = Emergency(0x8130, ErrorRegister.COMMUNICATION | ErrorRegister.GENERIC, b"\1")
    frame = sent.frame(3)
    assert frame == Frame(0x083, bytes.fromhex("3081110100000000"))
    assert str(emergency_in(frame)) == (
        "8130h heartbeat or guarding lost (generic, communication)"
    )
    assert emergency_in(Frame(0x083, bytes(7))) is None
    assert Emergency(0, ErrorRegister(0)).cleared
    with pytest.raises(ValueError, match="6 octets"):
        Emergency(0x1000, ErrorRegister.GENERIC, bytes(6)).frame(1)


@pytest.mark.parametrize(
    ("code", "text"),
    [
        (0x2310, "current, output side"),
        (0x2410, "current"),
        (0x4210, "device temperature"),
        (0x8140, "recovered from bus-off"),
        (0x8199, "communication"),
        (0xFF01, "device specific"),
        (0xA000, "unknown error"),
    ],
)
def test_codes_in_words(code: int, text: str) -> None:
    assert code_text(code) == text


def test_sync_counts_and_keeps_its_raster() -> None:
    producer = SyncProducer(10 * MS, overflow=2)
    assert producer.poll(0) is None
    producer.start(5)
    counters = [producer.poll(5), producer.poll(10 * MS), producer.poll(10 * MS + 5)]
    assert counters == [Frame(0x80, b"\1"), None, Frame(0x80, b"\2")]
    assert producer.poll(47 * MS) == Frame(0x80, b"\1")
    assert producer.deadline == 50 * MS + 5
    producer.start(60 * MS)
    assert producer.poll(60 * MS) == Frame(0x80, b"\1")
    producer.stop()
    assert producer.poll(70 * MS) is None
    assert SyncProducer(1).deadline is None
    with pytest.raises(ValueError, match="overflow 1"):
        SyncProducer(1, 1)


def test_lengths_of_sync() -> None:
    assert sync_counter(Frame(0x80)) == 0
    assert sync_counter(Frame(0x80, b"\7")) == 7
    assert sync_counter(Frame(0x80, b"\7\0")) is None


def test_time() -> None:
    moment = int(datetime(1984, 1, 3, 0, 0, 1, tzinfo=UTC).timestamp()) * 1000 * MS
    assert decode_time(Frame(0x100, bytes.fromhex("e80300000200"))) == moment
    assert decode_time(Frame(0x100, bytes.fromhex("e80300f00200"))) == moment
    assert decode_time(Frame(0x100, bytes(5))) is None
