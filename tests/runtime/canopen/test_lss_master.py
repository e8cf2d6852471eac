"""The LSS master: selection, fastscan, node-ids, bit rates; and its errors."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

import pytest

from rtgen.runtime.canopen.wire import lss
from rtgen.runtime.canopen.wire.frames import LSS_RESPONSE, Frame
from rtgen.runtime.canopen.wire.lss import LssAddress, LssCommand
from rtgen.runtime.canopen.wire.lss_master import (
    Assigned,
    LssError,
    LssMaster,
    PartialAddress,
    Procedure,
    address_text,
    assign,
    find,
    inquire,
    scan,
    select,
    set_bit_rate,
    switch,
)
from rtgen.runtime.canopen.wire.lss_slave import LssSlave

T = TypeVar("T")
MS = 1_000_000
ADDRESS = LssAddress(0x9A, 0x80000001, 0x00010002, 0xFFFFFFFE)
OTHER = LssAddress(0x9A, 0x80000001, 0x00010002, 0x12345678)
ANY: PartialAddress = (None, None, None, None)


class Line:
    """A master and slaves; every frame takes 0.1 ms, slaves answer in turn."""

    def __init__(self, *slaves: LssSlave) -> None:
        self.master = LssMaster()
        self.slaves = slaves
        self.now = 0
        self.sent: list[bytes] = []
        self.answer: Callable[[bytes], bytes | None] | None = None

    def run(self, procedure: Procedure[T]) -> T | LssError:
        outcomes: list[T | LssError] = []
        self._carry(self.master.submit(procedure, outcomes.append, self.now))
        while not outcomes:
            deadline = self.master.deadline
            assert deadline is not None
            self.now = max(self.now, deadline)
            self._carry(self.master.poll(self.now))
        assert not self.master.busy
        return outcomes[0]

    def _carry(self, frames: Iterable[Frame]) -> None:
        waiting = list(frames)
        while waiting:
            frame = waiting.pop(0)
            self.sent.append(frame.data)
            answers = [a for slave in self.slaves for a in slave.receive(frame)]
            if self.answer is not None and (data := self.answer(frame.data)):
                answers.append(Frame(LSS_RESPONSE, data))
            for answer in answers:
                self.now += MS // 10
                waiting += self.master.receive(answer, self.now)


def slave(address: LssAddress, node_id: int = lss.UNCONFIGURED) -> LssSlave:
    return LssSlave(lambda: tuple(address), node_id)


def test_selection() -> None:
    wanted, other = slave(ADDRESS, 5), slave(OTHER, 6)
    line = Line(other, wanted)
    assert line.run(select(ADDRESS)) is True
    assert wanted.configuring
    assert not other.configuring
    assert [data.hex() for data in line.sent] == [
        "409a000000000000",
        "4101000080000000",
        "4202000100000000",
        "43feffffff000000",
    ]


def test_selection_of_nobody() -> None:
    line = Line(slave(OTHER))
    assert line.run(select(ADDRESS)) is False
    assert line.now == 50 * MS


@pytest.mark.parametrize(
    "address",
    [ADDRESS, OTHER, LssAddress(0, 0, 0, 0), LssAddress(*[0xFFFFFFFF] * 4)],
)
def test_fastscan(address: LssAddress) -> None:
    found = slave(address)
    line = Line(found, slave(LssAddress(1, 2, 3, 4), 7))
    assert line.run(scan()) == address
    assert found.configuring
    assert len(line.sent) == 1 + 4 * 33


def test_fastscan_finds_the_smallest_of_many() -> None:
    """Several slaves answer the same message; none of their answers is taken for the next."""
    slaves = [slave(LssAddress(1, 2, 3, serial)) for serial in (9, 4, 0x80000000, 6)]
    line = Line(*slaves)
    found = line.run(scan())
    assert found == LssAddress(1, 2, 3, 4)
    assert [each.configuring for each in slaves] == [False, True, False, False]


def test_known_parts_are_not_searched() -> None:
    line = Line(slave(ADDRESS), slave(OTHER), slave(LssAddress(1, 1, 1, 1)))
    assert line.run(scan((0x9A, 0x80000001, None, None))) == OTHER
    assert len(line.sent) == 1 + 2 + 2 * 33


def test_fastscan_of_an_empty_bus() -> None:
    line = Line(slave(ADDRESS, 5))
    assert line.run(scan()) is None
    assert len(line.sent) == 1


def test_fastscan_finds_nobody_with_the_known_parts() -> None:
    line = Line(slave(ADDRESS))
    assert line.run(scan((7, None, None, None))) is None


@pytest.mark.parametrize("wanted", [tuple(ADDRESS), (0x9A, None, None, None)])
def test_assignment(wanted: PartialAddress) -> None:
    unnamed = slave(ADDRESS)
    line = Line(unnamed)
    assert line.run(assign(wanted, 5)) == Assigned(ADDRESS, 255, True)
    assert unnamed.pending.node_id == unnamed.stored.node_id == 5
    assert not unnamed.configuring


def test_a_node_gets_another_id() -> None:
    moved = slave(ADDRESS, 9)
    line = Line(moved, slave(OTHER, 5))
    assert line.run(assign(tuple(ADDRESS), 7)) == Assigned(ADDRESS, 9, True)
    assert moved.stored.node_id == 7


def test_assignment_of_nobody() -> None:
    line = Line()
    outcome = line.run(assign((0x9A, None, 0x10002, None), 5))
    assert isinstance(outcome, LssError)
    expected = "no node answers to the LSS address 0000009Ah any 00010002h any"
    assert str(outcome) == expected
    assert address_text(ANY) == "any any any any"


def answered(command: LssCommand, *rest: int) -> Callable[[bytes], bytes | None]:
    """Return a slave that is always selected, and answers one command so."""

    def answer(data: bytes) -> bytes | None:
        reply = {
            LssCommand.SWITCH_SERIAL: bytes((LssCommand.SWITCHED,)),
            LssCommand.INQUIRE_NODE_ID: bytes((LssCommand.INQUIRE_NODE_ID, 255)),
            LssCommand.CONFIGURE_NODE_ID: bytes((LssCommand.CONFIGURE_NODE_ID, 0)),
            LssCommand.CONFIGURE_BIT_TIMING: bytes(
                (LssCommand.CONFIGURE_BIT_TIMING, 0)
            ),
            command: bytes((command, *rest)) if rest else b"",
        }.get(LssCommand(data[0]), b"")
        return reply.ljust(8, b"\0") if reply else None

    return answer


@pytest.mark.parametrize(
    ("command", "rest", "text"),
    [
        (LssCommand.INQUIRE_NODE_ID, (), "INQUIRE_NODE_ID is not answered"),
        (LssCommand.CONFIGURE_NODE_ID, (), "CONFIGURE_NODE_ID is not answered"),
        (LssCommand.CONFIGURE_NODE_ID, (1,), "node-id 5 is refused: out of range"),
        (LssCommand.CONFIGURE_NODE_ID, (255,), "node-id 5 is refused: error 255"),
        (LssCommand.STORE, (), "STORE is not answered"),
        (LssCommand.STORE, (2,), "storing failed"),
        (LssCommand.STORE, (255,), "storing: error 255"),
    ],
)
def test_refusals(command: LssCommand, rest: tuple[int, ...], text: str) -> None:
    line = Line()
    line.answer = answered(command, *rest)
    outcome = line.run(assign(tuple(ADDRESS), 5))
    assert isinstance(outcome, LssError)
    assert str(outcome) == text


def test_a_node_that_cannot_store_has_its_id_till_it_is_switched_off() -> None:
    line = Line()
    line.answer = answered(LssCommand.STORE, lss.STORING_UNSUPPORTED)
    assert line.run(assign(tuple(ADDRESS), 5)) == Assigned(ADDRESS, 255, False)


@pytest.mark.parametrize("node_id", [0, 128, 255])
def test_impossible_node_ids(node_id: int) -> None:
    with pytest.raises(ValueError, match="1 to 127"):
        Line().run(assign(tuple(ADDRESS), node_id))


@pytest.mark.parametrize("bit_rate", sorted(lss.BIT_RATES))
def test_bit_rates(bit_rate: int) -> None:
    changed = slave(ADDRESS, 5)
    line = Line(changed)
    assert line.run(set_bit_rate(tuple(ADDRESS), bit_rate)) is True
    assert changed.pending.bit_rate == changed.stored.bit_rate == bit_rate
    assert not changed.configuring


def test_a_bit_rate_that_is_used_at_once() -> None:
    activations: list[tuple[int, int]] = []
    changed = LssSlave(
        lambda: tuple(ADDRESS), 5, lambda rate, delay: activations.append((rate, delay))
    )
    line = Line(changed)
    line.run(set_bit_rate(tuple(ADDRESS), 250, delay=300))
    assert activations == [(250, 300)]


def test_a_bit_rate_that_is_refused() -> None:
    line = Line()
    line.answer = answered(LssCommand.CONFIGURE_BIT_TIMING, 1)
    outcome = line.run(set_bit_rate(tuple(ADDRESS), None))
    assert isinstance(outcome, LssError)
    assert str(outcome) == "bit rate None is refused: out of range"
    assert line.sent[-1].hex() == "1300090000000000"
    with pytest.raises(KeyError):
        Line().run(set_bit_rate(tuple(ADDRESS), 123))


def test_inquiries() -> None:
    line = Line(slave(ADDRESS, 5))
    line.run(find(tuple(ADDRESS)))
    answers = [
        line.run(inquire(command))
        for command in (
            LssCommand.INQUIRE_VENDOR,
            LssCommand.INQUIRE_PRODUCT,
            LssCommand.INQUIRE_REVISION,
            LssCommand.INQUIRE_SERIAL,
            LssCommand.INQUIRE_NODE_ID,
        )
    ]
    assert answers == [*ADDRESS, 5]


def test_procedures_wait_for_each_other() -> None:
    master = LssMaster()
    ends: list[object] = []
    assert master.submit(select(ADDRESS), ends.append, 0)

    def announce() -> Procedure[None]:
        yield switch(lss.WAITING)

    assert master.submit(announce(), ends.append, 0) == []
    assert ends == []
    frames = master.poll(50 * MS)
    assert ends == [False, None]
    assert [frame.data[:2] for frame in frames] == [b"\x04\0"]
    assert master.deadline is None


def test_foreign_frames_are_no_answers() -> None:
    master = LssMaster()
    ends: list[object] = []
    answer = bytes((LssCommand.SWITCHED,)) + bytes(7)
    assert master.receive(Frame(LSS_RESPONSE, answer), 0) == []
    master.submit(select(ADDRESS), ends.append, 0)
    for frame in (
        Frame(0x7E3, answer),
        Frame(LSS_RESPONSE, answer[:7]),
        Frame(LSS_RESPONSE, answer, extended=True),
        Frame(LSS_RESPONSE, b"\x4f" + bytes(7)),
    ):
        assert master.receive(frame, 1) == []
    assert ends == []
    master.receive(Frame(LSS_RESPONSE, answer), 2)
    assert ends == [True]


def test_what_is_cancelled_tells_nothing() -> None:
    master = LssMaster()
    ends: list[object] = []
    master.submit(select(ADDRESS), ends.append, 0)
    master.submit(select(OTHER), ends.append, 0)
    master.cancel()
    assert not master.busy
    assert master.deadline is None
    assert master.poll(MS * 1000) == []
    assert ends == []
