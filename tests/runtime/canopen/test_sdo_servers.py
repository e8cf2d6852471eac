"""SDO servers of a device besides the predefined one (1201h ff.), and their clients."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest
from can_nodes import SPECS, description
from device_bench import DEVICE, NODE_ID, Bench, var
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.description import DeviceDescription
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import CobId, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.timing.clocks import RealClock
from rtgen.tools.can.decoding.decoder import Decoder
from rtgen.tools.can.decoding.node_index import read_node_index

INVALID = 1 << 31
REQUEST, RESPONSE = 0x6A0, 0x560
"""Identifiers that CiA 301 does not restrict."""
UPLOAD = bytes.fromhex("4000100000000000")
"""The request to read 1000h."""


def with_server(request: int | None, response: int | None) -> DeviceDescription:
    return replace(
        DEVICE,
        objects=(
            *DEVICE.objects,
            var(0x1201, 0, "u8", "const", 3),
            var(0x1201, 1, "u32", "rw", request),
            var(0x1201, 2, "u32", "rw", response),
            var(0x1201, 3, "u8", "rw", 0),
        ),
    )


def bench_of(request: int | None, response: int | None) -> Bench:
    return Bench(DeviceNode(with_server(request, response), NODE_ID))


def read(bench: Bench, client: SdoClient, index: int, subindex: int = 0) -> bytes:
    """Return an object read by a client."""
    frames = client.upload(index, subindex, bench.now)
    while client.busy:
        answers: list[Frame] = []
        for frame in frames:
            answers += bench.note(bench.node.receive(frame, bench.now))
        assert answers, "no answer"
        frames = [f for a in answers for f in client.receive(a, bench.now)]
    return client.result()


def second() -> SdoClient:
    return SdoClient(NODE_ID, cob_ids=(CobId(REQUEST), CobId(RESPONSE)))


def test_a_second_server_has_its_own_identifiers() -> None:
    bench = bench_of(REQUEST, RESPONSE)
    assert read(bench, second(), 0x1008) == b"Bench device"
    assert {frame.can_id for frame in bench.sent[1:]} == {RESPONSE}
    assert read(bench, SdoClient(NODE_ID), 0x1008) == b"Bench device"


def test_transfers_of_two_clients_do_not_disturb_each_other() -> None:
    bench = bench_of(REQUEST, RESPONSE)
    first, other = SdoClient(NODE_ID), second()
    frames = [*first.upload(0x1008, 0, 0), *other.upload(0x1008, 0, 0)]
    while first.busy or other.busy:
        answers = [a for f in frames for a in bench.node.receive(f, 0)]
        assert answers
        frames = [
            f for a in answers for c in (first, other) for f in c.receive(a, bench.now)
        ]
    assert first.result() == other.result() == b"Bench device"


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        (None, None),
        (0, 0),
        (REQUEST, None),
        (INVALID | REQUEST, RESPONSE),
        (REQUEST, INVALID | RESPONSE),
        (0x10, RESPONSE),
        (REQUEST, 0x585),
    ],
)
def test_a_server_without_two_valid_identifiers_is_off(
    request_: int | None, response: int | None
) -> None:
    bench = bench_of(request_, response)
    assert bench.give(REQUEST, UPLOAD) == []
    assert bench.give(0x10, UPLOAD) == []


def test_a_server_is_switched_on_and_moved_by_sdo() -> None:
    bench = bench_of(None, None)
    for sub, cob_id in ((1, REQUEST), (2, RESPONSE)):
        bench.write(0x1201, sub, cob_id.to_bytes(4, "little"))
    assert len(read(bench, second(), 0x1000)) == 4
    for value in (REQUEST + 1, 0, 0x605):
        with pytest.raises(SdoAbort) as caught:
            bench.write(0x1201, 1, value.to_bytes(4, "little"))
        assert caught.value.code == sdo.VALUE_INVALID
    for value in (INVALID | REQUEST, INVALID | (REQUEST + 1), REQUEST + 1):
        bench.write(0x1201, 1, value.to_bytes(4, "little"))
    assert bench.give(REQUEST, UPLOAD) == []
    moved = SdoClient(NODE_ID, cob_ids=(CobId(REQUEST + 1), CobId(RESPONSE)))
    assert len(read(bench, moved, 0x1000)) == 4


def test_a_stopped_node_serves_none() -> None:
    bench = bench_of(REQUEST, RESPONSE)
    bench.command(NmtCommand.STOP)
    assert bench.give(REQUEST, UPLOAD) == []
    bench.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    assert len(bench.give(REQUEST, UPLOAD)) == 1


def test_a_silent_client_is_aborted_on_its_own_identifier() -> None:
    bench = bench_of(REQUEST, RESPONSE)
    bench.give(REQUEST, bytes.fromhex("4008100000000000"))
    deadline = bench.node.deadline
    assert deadline is not None
    bench.now = deadline
    [abort] = bench.note(bench.node.poll(bench.now))
    assert (abort.can_id, abort.data[0]) == (RESPONSE, sdo.ABORT)


def described(folder: Path, *values: str) -> Path:
    """Return the palette with a second SDO server."""
    text = (SPECS / "f_palette.eds").read_text()
    text += "\n[1201]\nParameterName=SDO server 2\nObjectType=9\nSubNumber=3\n"
    for sub, value in enumerate(("2", *values)):
        text += (
            f"\n[1201sub{sub}]\nParameterName=Sub {sub}\nDataType={7 if sub else 5}\n"
            f"AccessType=rw\nDefaultValue={value}\n"
        )
    path = folder / "served.eds"
    path.write_text(text)
    return path


class Watch:
    """A station that records identifiers."""

    identifiers = None
    deadline = None

    def __init__(self) -> None:
        self.seen: set[int] = set()

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.seen.add(frame.can_id)
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        return ()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()


def test_a_command_uses_the_second_server(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    eds = described(tmp_path, "$NODEID+0x680", "$NODEID+0x500")
    node, watch = DeviceNode(description(eds), 5, serial_number=1), Watch()
    link = open_link(RealClock(), "virtual", "second server")
    with link.lock:
        link.attach(node)
        link.attach(watch)
        link.send(node.boot(link.now()), node)
    where = ["--interface", "virtual", "--channel", "second server"]
    asked = ["can", "sdo", "read", "5", "1000", "--eds", f"5={eds}", "--no-look"]
    try:
        assert run([*asked, *where, "--server", "2"]) == 0
        assert watch.seen - {0x705} == {0x685, 0x505}
        assert run([*asked, *where, "--server", "3"]) == 2
    finally:
        link.detach(node)
        link.detach(watch)
    assert "has no SDO server 3" in capsys.readouterr().err


def test_transfers_with_the_second_server_are_decoded(tmp_path: Path) -> None:
    eds = described(tmp_path, "$NODEID+0x680", "$NODEID+0x500")
    decoder = Decoder(read_node_index(None, [(5, eds)]))
    asked = decoder.decode(Frame(0x685, UPLOAD))
    answer = decoder.decode(Frame(0x505, bytes.fromhex("4300100091010000")))
    assert (asked.kind, asked.node, asked.text[:12]) == ("sdo", 5, "read request")
    assert answer.fields[0].value == 0x191
