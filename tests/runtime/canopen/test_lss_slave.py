"""The LSS slave: selection, fastscan, inquiry and configuration, by messages (CiA 305)."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest
from device_bench import DEVICE, Bench
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.node_events import NodeEvents
from rtgen.runtime.canopen.wire.frames import LSS_REQUEST, LSS_RESPONSE, Frame
from rtgen.runtime.canopen.wire.lss import BIT_RATES, UNCONFIGURED, LssAddress
from rtgen.runtime.canopen.wire.lss_slave import LssSlave
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

ADDRESS = LssAddress(0x00FFFF01, 0x4242, 0x00010002, 77)
ALL = 0


def request(command: int, *octets: int, number: int | None = None) -> Frame:
    data = bytes(octets) if number is None else number.to_bytes(4, "little")
    return Frame(LSS_REQUEST, (bytes((command,)) + data).ljust(8, b"\0"))


def answer(command: int, *octets: int) -> list[Frame]:
    return [Frame(LSS_RESPONSE, bytes((command, *octets)).ljust(8, b"\0"))]


def slave(node_id: int = UNCONFIGURED, address: LssAddress = ADDRESS) -> LssSlave:
    return LssSlave(lambda: address, node_id)


def configuring(node_id: int = UNCONFIGURED) -> LssSlave:
    found = slave(node_id)
    assert found.receive(request(0x04, 1)) == []
    return found


def test_only_the_slave_of_the_address_is_selected() -> None:
    found = slave(5)
    for part, number in enumerate(ADDRESS[:3]):
        assert found.receive(request(0x40 + part, number=number)) == []
    assert not found.configuring
    assert found.receive(request(0x43, number=77)) == answer(0x44)
    assert found.configuring
    assert found.receive(request(0x04, 0)) == []
    assert not found.configuring


@pytest.mark.parametrize("wrong", range(4))
def test_a_slave_of_another_address_keeps_silent(wrong: int) -> None:
    found = slave(5)
    for part, number in enumerate(ADDRESS):
        other = number + (part == wrong)
        assert found.receive(request(0x40 + part, number=other)) == []
    assert not found.configuring


def test_parts_out_of_their_order_select_nobody() -> None:
    found = slave(5)
    for part in (0, 2, 1, 3):
        assert found.receive(request(0x40 + part, number=ADDRESS[part])) == []


def test_inquiries() -> None:
    found = configuring(5)
    for part, number in enumerate(ADDRESS):
        octets = number.to_bytes(4, "little")
        assert found.receive(request(0x5A + part)) == answer(0x5A + part, *octets)
    assert found.receive(request(0x5E)) == answer(0x5E, 5)


@pytest.mark.parametrize("command", [0x11, 0x13, 0x15, 0x17, 0x5A, 0x5E])
def test_configuration_takes_the_configuration_state(command: int) -> None:
    found = slave()
    assert found.receive(request(command, 7)) == []
    assert found.pending.node_id == UNCONFIGURED


@pytest.mark.parametrize(
    ("node_id", "error"),
    [(0, 1), (1, 0), (127, 0), (128, 1), (254, 1), (255, 0)],
)
def test_node_ids(node_id: int, error: int) -> None:
    found = configuring(5)
    assert found.receive(request(0x11, node_id)) == answer(0x11, error)
    assert found.pending.node_id == (5 if error else node_id)
    assert found.active == 5


@pytest.mark.parametrize(
    ("table", "index", "error"),
    [(0, index, 0) for index in BIT_RATES.values()]
    + [(0, 5, 1), (0, 10, 1), (1, 0, 1)],
)
def test_bit_timing(table: int, index: int, error: int) -> None:
    found = configuring()
    assert found.receive(request(0x13, table, index)) == answer(0x13, error)
    assert (found.pending.bit_rate is None) == bool(error)


def test_bit_rate_is_activated_with_its_delay() -> None:
    activated_rates: list[tuple[int, int]] = []
    found = LssSlave(
        lambda: ADDRESS,
        activated=lambda rate, delay: activated_rates.append((rate, delay)),
    )
    found.receive(request(0x04, 1))
    assert found.receive(request(0x15, 0xE8, 3)) == []
    assert activated_rates == []
    found.receive(request(0x13, 0, 3))
    found.receive(request(0x15, 0xE8, 3))
    assert activated_rates == [(250, 1000)]


def test_what_is_not_stored_is_gone_after_a_reset_of_the_node() -> None:
    found = configuring(5)
    found.receive(request(0x11, 9))
    assert found.take_over(stored=False) == 9
    assert found.take_over(stored=True) == 5
    found.receive(request(0x04, 1))
    found.receive(request(0x11, 9))
    assert found.receive(request(0x17)) == answer(0x17, 0)
    assert found.take_over(stored=True) == 9


def identify(found: LssSlave, *numbers: int) -> list[Frame]:
    answers = []
    for step, number in enumerate(numbers):
        answers += found.receive(request(0x46 + step, number=number))
    return answers


def test_slaves_in_a_range_tell_that_they_are_there() -> None:
    vendor, product, revision, serial = ADDRESS
    exact = (vendor, product, revision, revision, serial, serial)
    assert identify(slave(5), *exact) == answer(0x4F)
    wide = (vendor, product, 0, 2**32 - 1, 0, 2**32 - 1)
    assert identify(slave(5), *wide) == answer(0x4F)
    for place, change in ((0, 1), (1, 1), (2, 1), (3, -1), (4, 1), (5, -1)):
        other = [*exact]
        other[place] += change
        assert identify(slave(5), *other) == []


def test_only_slaves_without_a_node_id_are_unconfigured() -> None:
    assert slave().receive(request(0x4C)) == answer(0x50)
    assert slave(5).receive(request(0x4C)) == []


@pytest.mark.parametrize(
    "frame",
    [
        Frame(LSS_REQUEST, b"\x4c"),
        Frame(LSS_REQUEST, bytes(8), remote=True),
        Frame(LSS_REQUEST, b"\x4c" + bytes(7), extended=True),
        Frame(LSS_RESPONSE, b"\x4c" + bytes(7)),
        request(0xAA),
    ],
)
def test_what_is_no_request_has_no_answer(frame: Frame) -> None:
    assert slave().receive(frame) == []


def scan(slaves: Sequence[LssSlave]) -> tuple[int, ...] | None:
    """Return the smallest address, by an independent fastscan master; None without a slave."""

    def ask(number: int, bit: int, part: int, following: int) -> bool:
        frame = Frame(
            LSS_REQUEST,
            b"\x51" + number.to_bytes(4, "little") + bytes((bit, part, following)),
        )
        answers = [answer for one in slaves for answer in one.receive(frame)]
        assert all(got == Frame(LSS_RESPONSE, b"\x4f" + bytes(7)) for got in answers)
        return bool(answers)

    if not ask(0, 0x80, 0, 0):
        return None
    found = []
    for part in range(4):
        number = 0
        for bit in range(31, -1, -1):
            if not ask(number, bit, part, part):
                number |= 1 << bit
        assert ask(number, 0, part, (part + 1) % 4)
        found.append(number)
    return tuple(found)


_numbers = st.integers(0, 2**32 - 1) | st.integers(0, 3)


@settings(max_examples=40, deadline=None)
@given(st.sets(st.tuples(*[_numbers] * 4), min_size=1, max_size=6))
def test_fastscan_finds_every_slave(addresses: set[tuple[int, int, int, int]]) -> None:
    slaves = [slave(address=LssAddress(*a)) for a in addresses]
    random.Random(0).shuffle(slaves)
    found = []
    for node_id in range(1, len(slaves) + 1):
        address = scan(slaves)
        assert address is not None
        found.append(address)
        (one,) = [s for s in slaves if s.configuring]
        assert one.receive(request(0x11, node_id)) == answer(0x11, 0)
        one.receive(request(0x04, 0))
        one.take_over(stored=False)
    assert sorted(found) == sorted(addresses)
    assert scan(slaves) is None


def test_a_slave_with_a_node_id_takes_no_part_in_a_scan() -> None:
    assert scan([slave(5)]) is None


def test_scan_messages_that_cannot_be_have_no_answer() -> None:
    found = slave()
    for bit, part, following in ((32, 0, 0), (0, 4, 0), (0, 0, 4), (0, 1, 2)):
        frame = Frame(LSS_REQUEST, b"\x51" + bytes(4) + bytes((bit, part, following)))
        assert found.receive(frame) == []


def node() -> tuple[Bench, list[tuple[int, int]]]:
    rates: list[tuple[int, int]] = []
    events = NodeEvents(bit_rate=lambda rate, delay: rates.append((rate, delay)))
    return Bench(DeviceNode(DEVICE, events=events, serial_number=77)), rates


def lss(bench: Bench, frame: Frame) -> list[Frame]:
    return bench.note(bench.node.receive(frame, bench.now))


def test_a_node_without_node_id_only_hears_lss_and_nmt() -> None:
    bench, _ = node()
    assert bench.sent == []
    assert bench.node.state is NmtState.INITIALISING
    assert bench.node.identifiers == {0, LSS_REQUEST}
    assert bench.node.deadline is None
    assert bench.command(NmtCommand.START, ALL) == []
    assert bench.command(NmtCommand.RESET_COMMUNICATION, ALL) == []
    assert bench.node.fail(0) == bench.node.reset(0) == []
    bench.node.link_changed(False, 0)


def test_a_node_boots_when_it_has_its_node_id() -> None:
    bench, rates = node()
    for part, number in enumerate(ADDRESS):
        lss(bench, request(0x40 + part, number=number))
    lss(bench, request(0x11, 9))
    lss(bench, request(0x13, 0, 2))
    lss(bench, request(0x15, 100))
    assert rates == [(500, 100)]
    bench.sent.clear()
    assert lss(bench, request(0x04, 0)) == [Frame(0x709, b"\0")]
    assert bench.node.node_id == 9
    assert bench.node.get(0x1014) == 0x89
    assert 0x609 in bench.node.identifiers


@pytest.mark.parametrize("stored", [False, True])
def test_store_then_reset(stored: bool) -> None:
    bench, _ = node()
    lss(bench, request(0x04, 1))
    lss(bench, request(0x11, 9))
    if stored:
        lss(bench, request(0x17))
    assert bench.command(NmtCommand.RESET_COMMUNICATION, ALL) == [Frame(0x709, b"\0")]
    again = bench.command(NmtCommand.RESET_NODE, ALL)
    assert again == ([Frame(0x709, b"\0")] if stored else [])
    assert bench.node.node_id == (9 if stored else UNCONFIGURED)


def test_a_node_that_has_lost_its_node_id_is_never_due() -> None:
    bench, _ = node()
    lss(bench, request(0x04, 1))
    lss(bench, request(0x11, 9))
    bench.command(NmtCommand.RESET_COMMUNICATION, ALL)
    bench.node.set(0x1017, 0, 100)
    bench.flush()
    assert bench.node.deadline is not None
    assert bench.command(NmtCommand.RESET_NODE, ALL) == []
    assert bench.node.deadline is None


def test_a_configured_node_takes_another_node_id_by_reset_communication() -> None:
    bench = Bench()
    lss(bench, request(0x04, 1))
    lss(bench, request(0x11, 9))
    assert lss(bench, request(0x04, 0)) == []
    assert bench.node.node_id == 5
    frames = bench.command(NmtCommand.RESET_COMMUNICATION)
    assert frames == [Frame(0x709, b"\0")]
    assert bench.node.get(0x1014) == 0x89


def test_a_device_without_lss_does_not_answer() -> None:
    bench = Bench(DeviceNode(replace(DEVICE, lss=False), 5))
    assert lss(bench, request(0x04, 1)) == lss(bench, request(0x5E)) == []
    assert LSS_REQUEST not in bench.node.identifiers


@pytest.mark.parametrize("node_id", [0, 128, 254, -1])
def test_node_ids_that_cannot_be(node_id: int) -> None:
    with pytest.raises(ValueError, match=str(node_id)):
        DeviceNode(DEVICE, node_id)
    with pytest.raises(ValueError, match=str(node_id)):
        DeviceNode(DEVICE).take_node_id(node_id)


def test_a_bit_rate_that_the_description_denies_is_refused() -> None:
    found = LssSlave(lambda: ADDRESS, bit_rates=(125, 500))
    found.receive(request(0x04, 1))
    assert found.receive(request(0x13, 0, BIT_RATES[1000])) == answer(0x13, 1)
    assert found.pending.bit_rate is None
    assert found.receive(request(0x13, 0, BIT_RATES[125])) == answer(0x13, 0)
    assert found.pending.bit_rate == 125


def test_a_device_takes_the_bit_rates_of_its_description() -> None:
    node = DeviceNode(replace(DEVICE, bit_rates=(500,)), 5)
    bench = Bench(node)
    bench.give(0x7E5, bytes((0x04, 1)).ljust(8, b"\0"))
    for rate, error in ((500, 0), (250, 1)):
        data = bytes((0x13, 0, BIT_RATES[rate])).ljust(8, b"\0")
        (answered,) = bench.give(0x7E5, data)
        assert answered.data[:2] == bytes((0x13, error))
