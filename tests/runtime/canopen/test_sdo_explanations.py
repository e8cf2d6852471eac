"""What an SDO client says about a transfer that fails: in each phase, for each kind of fault."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import can
import pytest
from can_commands import command
from sdo_line import Values

from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

MS = 1_000_000
NODE = 5
SHORT, MIDDLE, LONG = bytes(4), bytes(20), bytes(50)
BLOCK = 3
_UNKNOWN = "05040001h command specifier unknown"
_TOGGLE = "05030000h toggle bit not alternated"
_SEQUENCE = "05040003h sequence number invalid"

BLOCKS_UP = [
    *(f"segment {k} of block {block}" for block in (1, 2) for k in (1, 2, 3)),
    *("segment 1 of block 3", "segment 2 of block 3"),
]
TRANSFERS = {
    "expedited upload": (None, SHORT, False, ["answer"]),
    "segmented upload": (
        *(None, MIDDLE, False),
        ["answer", "segment 1", "segment 2", "segment 3"],
    ),
    "block upload": (
        *(None, LONG, True),
        ["answer", *BLOCKS_UP, "end of the transfer"],
    ),
    "expedited download": (SHORT, b"", False, ["answer"]),
    "segmented download": (
        *(MIDDLE, b"", False),
        ["answer", *(f"answer to segment {k}" for k in (1, 2, 3))],
    ),
    "block download": (
        *(LONG, b"", True),
        [
            "answer",
            "answer to block 1 (3 segments)",
            "answer to block 2 (3 segments)",
            "answer to block 3 (2 segments)",
            "answer to the end of the transfer",
        ],
    ),
}
"""For each transfer the value to write, that of the server, whether it goes by blocks, and the
messages of the server."""
PHASES = [
    (transfer, place, awaited)
    for transfer, (_, _, _, messages) in TRANSFERS.items()
    for place, awaited in enumerate(messages)
]


def silent(data: bytes) -> bytes | None:
    return None


def commanded(data: bytes) -> bytes:
    return b"\xe0" + data[1:]


def toggled(data: bytes) -> bytes:
    return bytes((data[0] ^ 0x10,)) + data[1:]


def acknowledged(data: bytes) -> bytes:
    return data[:1] + b"\x7f" + data[2:]


def unnumbered(data: bytes) -> bytes:
    return b"\0" + data[1:]


def aborted(data: bytes) -> bytes:
    return bytes.fromhex("80 00 20 00 00 00 00 08")


def elsewhere(data: bytes) -> bytes:
    return data[:1] + b"\x34\x12" + data[3:]


def cases() -> Iterator[tuple[str, int, object, str]]:
    """Yield the transfer, the number of the message, its change, and what is said."""
    for transfer, place, awaited in PHASES:
        yield transfer, place, silent, f"no {awaited} within 500 ms"
        refused = "08000000h general error"
        named = awaited if awaited.startswith("segment") else f"the {awaited}"
        what = f"the node aborts in place of {named}" if place else "the node refuses"
        yield transfer, place, aborted, f"{what}: {refused}"
        invalid = f"{named} is not valid"
        if "of block" in awaited:
            yield transfer, place, unnumbered, f"{invalid}: {_SEQUENCE}"
            continue
        yield transfer, place, commanded, f"{invalid}: {_UNKNOWN}"
        if transfer.startswith("segmented") and place:
            yield transfer, place, toggled, f"{invalid}: {_TOGGLE}"
        if "to block" in awaited:
            yield transfer, place, acknowledged, f"{invalid}: {_SEQUENCE}"
        if not place:
            others = "only messages of other transfers"
            yield transfer, place, elsewhere, f"no answer within 500 ms, {others}"


@pytest.mark.parametrize(
    ("transfer", "place", "change", "said"),
    list(cases()),
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_what_is_said(transfer: str, place: int, change: object, said: str) -> None:
    value, stored, block, _ = TRANSFERS[transfer]
    values = Values(stored)
    client = SdoClient(NODE, timeout=500 * MS, block_size=BLOCK)
    server = SdoServer(NODE, values, block_size=BLOCK)
    waiting = deque(
        client.upload(0x2000, 0, 0, block=block)
        if value is None
        else client.download(0x2000, 0, value, 0, block=block)
    )
    number, now, dead = 0, 0, False
    while client.busy:
        if not waiting:
            now = client.deadline or now
            client.poll(now)
            continue
        for answer in [] if dead else server.receive(waiting.popleft(), now):
            data: bytes | None = answer.data
            if number == place:
                dead = True
                data = change(answer.data)  # type: ignore[operator]
            elif dead:
                data = None
            number += 1
            if data is not None and client.busy:
                waiting += client.receive(Frame(answer.can_id, data), now)
        if dead:
            waiting.clear()
    with pytest.raises(SdoAbort) as caught:
        client.result()
    assert caught.value.explanation == said
    assert number >= place + 1


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ([], "node 9 does not answer"),
        (["43 01 10 00 00 00 00 00"], "only messages of other transfers"),
        (["41 00 10 00 0e 00 00 00"], "no segment 1 within 50 ms"),
        (
            ["41 00 10 00 0e 00 00 00", "00 61 62 63 64 65 66 67"],
            "no segment 2 within 50 ms",
        ),
        (
            ["41 00 10 00 0e 00 00 00", "10 61 62 63 64 65 66 67"],
            f"segment 1 is not valid: {_TOGGLE}",
        ),
        (
            ["41 00 10 00 0e 00 00 00", "80 00 10 00 00 00 00 08"],
            "the node aborts in place of segment 1: 08000000h general error",
        ),
    ],
)
def test_what_the_command_says(
    answers: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    left = deque(bytes.fromhex(answer) for answer in answers)
    with can.Bus(interface="virtual", channel=said) as bus:

        def answer(message: can.Message) -> None:
            if message.arbitration_id == 0x609 and message.data[0] != 0x80 and left:
                data = left.popleft()
                bus.send(
                    can.Message(arbitration_id=0x589, data=data, is_extended_id=False)
                )

        notifier = can.Notifier(bus, [answer])
        try:
            read = ["sdo", "read", "9", "1000", "--type", "octets", "--no-look"]
            assert command(said, *read, "--timeout", "0.05") != 0
        finally:
            notifier.stop()
    assert said in " ".join(capfd.readouterr().err.split())
