"""Bounds of SDO transfers (CiA 301, 7.2.4.3): sizes of each kind, and refusals."""

import pytest

from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient


@pytest.mark.parametrize(
    ("size", "command"),
    [(0, 0x21), (1, 0x2F), (2, 0x2B), (3, 0x27), (4, 0x23), (5, 0x21)],
)
def test_one_to_four_octets_are_written_expedited(size: int, command: int) -> None:
    [frame] = SdoClient(1).download(0x2000, 3, bytes(size), 0)
    assert frame.data[:4] == bytes((command, 0x00, 0x20, 3))


def test_the_largest_value_is_written_and_one_octet_more_refused() -> None:
    client = SdoClient(1, max_size=8)
    with pytest.raises(ValueError, match="9 octets; up to 8 are written"):
        client.download(0x2000, 0, bytes(9), 0)
    assert client.ready
    assert client.download(0x2000, 0, bytes(8), 0)


def test_there_is_no_result_without_a_transfer() -> None:
    client = SdoClient(1)
    assert not client.busy
    assert client.deadline is None
    with pytest.raises(RuntimeError, match=r"^no transfer has ended$"):
        client.result()


def test_the_text_of_an_unknown_abort_code() -> None:
    assert str(SdoAbort(0x12345678)) == "12345678h unknown abort code"
