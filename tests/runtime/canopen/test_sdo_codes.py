"""The numbers of SDO that CiA 301 gives: commands (7.2.4.3) and abort codes (table 22)."""

from __future__ import annotations

import pytest

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import ABORT_TEXTS, SdoAbort

CODES = {
    "05030000h": "toggle bit not alternated",
    "05040000h": "protocol timed out",
    "05040001h": "command specifier unknown",
    "05040002h": "block size invalid",
    "05040003h": "sequence number invalid",
    "05040004h": "CRC error",
    "05040005h": "out of memory",
    "06010000h": "access not supported",
    "06010001h": "read of a write-only object",
    "06010002h": "write of a read-only object",
    "06010003h": "sub-index cannot be written while sub-index 0 is not 0",
    "06020000h": "object does not exist",
    "06040041h": "object cannot be mapped to the PDO",
    "06040042h": "mapped objects exceed the PDO",
    "06040043h": "general parameter incompatibility",
    "06040047h": "general internal incompatibility",
    "06060000h": "hardware error",
    "06070010h": "type or length does not match",
    "06070012h": "length too high",
    "06070013h": "length too low",
    "06090011h": "sub-index does not exist",
    "06090030h": "value invalid",
    "06090031h": "value too high",
    "06090032h": "value too low",
    "06090036h": "maximum less than minimum",
    "060A0023h": "resource not available",
    "08000000h": "general error",
    "08000020h": "data cannot be transferred or stored",
    "08000021h": "data cannot be transferred or stored because of local control",
    "08000022h": "data cannot be transferred or stored in the present device state",
    "08000023h": "no object dictionary",
    "08000024h": "no data available",
}
COMMANDS = {
    "ABORT": 0x80,
    "DOWNLOAD_SEGMENT": 0x00,
    "DOWNLOAD": 0x20,
    "DOWNLOAD_DONE": 0x60,
    "DOWNLOAD_SEGMENT_DONE": 0x20,
    "UPLOAD": 0x40,
    "UPLOAD_SEGMENT": 0x60,
    "BLOCK_DOWNLOAD": 0xC0,
    "BLOCK_DOWNLOAD_ANSWER": 0xA0,
    "BLOCK_UPLOAD": 0xA0,
    "BLOCK_UPLOAD_ANSWER": 0xC0,
    "BLOCK_END": 0xC1,
    "BLOCK_ENDED": 0xA1,
    "BLOCK_ACKNOWLEDGED": 0xA2,
    "BLOCK_START": 0xA3,
    "CODE": 0xE0,
    "WITH_CRC": 0x04,
    "WITH_SIZE": 0x02,
    "SIZE_INDICATED": 0x01,
    "TOGGLE": 0x10,
    "LAST": 0x01,
    "LAST_IN_BLOCK": 0x80,
}


def test_abort_codes() -> None:
    assert {f"{code:08X}h": text for code, text in ABORT_TEXTS.items()} == CODES
    assert str(SdoAbort(0x06020000)) == "06020000h object does not exist"
    assert str(SdoAbort(0x12345678)) == "12345678h unknown abort code"


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name: str) -> None:
    assert getattr(sdo, name) == COMMANDS[name]


def test_each_constant_is_one_of_them() -> None:
    names = {
        name
        for name, value in vars(sdo).items()
        if name.isupper() and isinstance(value, int)
    }
    limits = {
        *("MAX_SIZE", "TIMEOUT", "FRAME", "EXPEDITED", "SEGMENT", "MAX_BLOCK"),
        "_ATTEMPTS",
    }
    codes = names - limits - set(COMMANDS)
    assert {getattr(sdo, name) for name in codes} <= set(ABORT_TEXTS)
    assert len(codes) == len({getattr(sdo, name) for name in codes})


def test_limits() -> None:
    assert sdo.MAX_SIZE == 1024 * 1024
    assert sdo.TIMEOUT == 1_000_000_000, "a second"
    assert (sdo.FRAME, sdo.EXPEDITED, sdo.SEGMENT, sdo.MAX_BLOCK) == (8, 4, 7, 127)
