"""PDOs of the slave: rules of mapping by SDO, reception, and transmission."""

from __future__ import annotations

from typing import Any

import pytest
from device_bench import (
    APPLICATION,
    COMMUNICATION,
    DEVICE,
    KINDS,
    NODE_ID,
    Bench,
    number_of,
    pdo,
    pdo_objects,
    var,
    with_pdos,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from test_object_values import BOUNDARIES

from rtgen.facts.canopen import KIND_BITS
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import Kind, ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.pdo_mapping import MappedField, Mapping, entry_of
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.runtime.canopen.wire.sdo import SdoAbort

TPDO1, TPDO2 = 0x180 + NODE_ID, 0x280 + NODE_ID
RPDO1, RPDO2 = 0x200 + NODE_ID, 0x300 + NODE_ID
EMERGENCY = 0x80 + NODE_ID
INVALID = 1 << 31
SPARE = 0x2FFF


def remap(
    bench: Bench, communication: int, *entries: tuple[int, int, int], **parameters: int
) -> None:
    """Map by SDO in the order of CiA 301, from invalid to valid; parameters as `s2=255`."""
    cob_id = int(bench.node.get(communication, 1)) & ~INVALID
    mapped = communication + 0x200
    bench.write(communication, 1, cob_id | INVALID)
    bench.write(mapped, 0, 0)
    for place, entry in enumerate(entries, 1):
        bench.write(mapped, place, entry_of(*entry))
    bench.write(mapped, 0, len(entries))
    for name, value in parameters.items():
        bench.write(communication, int(name[1:]), value)
    bench.write(communication, 1, cob_id)


# Mapping rules


def test_mapping_takes_effect_when_the_pdo_is_valid() -> None:
    bench = Bench()
    bench.start()
    remap(bench, 0x1400, (number_of("u8"), 0, 8), (3, 0, 16), (number_of("i24"), 0, 24))
    assert bench.give(RPDO1, bytes.fromhex("7f ffff feffff")) == []
    assert bench.node.get(number_of("u8")) == 0x7F
    assert bench.node.get(number_of("i24")) == -2
    assert bench.node.get(0x6040) == 0


@pytest.mark.parametrize("communication", [0x1400, 0x1800])
def test_a_mapping_is_locked_while_the_pdo_is_valid(communication: int) -> None:
    bench = Bench()
    mapped = communication + 0x200
    entry = entry_of(number_of("u8"), 0, 8)
    assert bench.refusal(mapped, 0, 0) == sdo.ACCESS_UNSUPPORTED
    assert bench.refusal(mapped, 1, entry) == sdo.ACCESS_UNSUPPORTED
    cob_id = int(bench.node.get(communication, 1))
    bench.write(communication, 1, cob_id | INVALID)
    assert bench.refusal(mapped, 1, entry) == 0x06010003
    assert bench.refusal(mapped, 0, 0) == 0
    assert bench.refusal(mapped, 1, entry) == 0
    assert bench.refusal(mapped, 0, 1) == 0


@pytest.mark.parametrize(
    ("communication", "entry", "code"),
    [
        (0x1400, (0x3000, 0, 8), sdo.NO_OBJECT),
        (0x1400, (0x2100, 3, 16), sdo.NO_OBJECT),
        (0x1400, (0x2102, 0, 16), 0x06040041),
        (0x1400, (0x2100, 0, 16), 0x06040041),
        (0x1400, (0x2105, 0, 16), 0x06040041),
        (0x1400, (0x2101, 0, 16), 0),
        (0x1400, (0x2106, 0, 16), 0),
        (0x1400, (0x2103, 0, 16), 0),
        (0x1400, (0x2103, 0, 8), 0x06040041),
        (0x1400, (0x2103, 0, 17), 0x06040041),
        (0x1400, (0x2103, 0, 0), 0x06040041),
        (0x1400, (5, 0, 8), 0),
        (0x1400, (5, 1, 8), 0x06040041),
        (0x1400, (5, 0, 16), 0x06040041),
        (0x1400, (1, 0, 1), 0x06040041),
        (0x1400, (8, 0, 32), 0x06040041),
        (0x1800, (5, 0, 8), 0x06040041),
        (0x1800, (0x2100, 0, 16), 0),
        (0x1800, (0x2105, 0, 16), 0),
        (0x1800, (0x2101, 0, 16), 0x06040041),
        (0x1800, (0x2106, 0, 16), 0x06040041),
        (0x1800, (0x1001, 0, 8), 0),
        (0x1800, (number_of("bool"), 0, 1), 0),
        (0x1800, (number_of("bool"), 0, 8), 0),
        (0x1800, (number_of("bool"), 0, 2), 0x06040041),
        (0x1800, (number_of("string"), 0, 64), 0),
        (0x1800, (number_of("octets"), 0, 24), 0),
        (0x1800, (number_of("octets"), 0, 20), 0x06040041),
        (0x1800, (number_of("octets"), 0, 72), 0x06040041),
        (0x1800, (0, 0, 0), 0),
    ],
)
def test_what_can_be_mapped(
    communication: int, entry: tuple[int, int, int], code: int
) -> None:
    bench = Bench()
    mapped = communication + 0x200
    bench.write(communication, 1, INVALID)
    bench.write(mapped, 0, 0)
    assert bench.refusal(mapped, 1, entry_of(*entry)) == code


@pytest.mark.parametrize(
    ("granularity", "bits", "code"),
    [(8, 1, 0x06040041), (8, 8, 0), (1, 1, 0), (0, 8, 0x06040041), (64, 8, 0x06040041)],
)
def test_granularity(granularity: int, bits: int, code: int) -> None:
    bench = Bench(DeviceNode(replace(DEVICE, granularity=granularity), NODE_ID))
    bench.write(0x1801, 1, INVALID)
    entry = entry_of(number_of("bool"), 0, bits)
    assert bench.refusal(0x1A01, 1, entry) == code


def test_how_much_can_be_mapped() -> None:
    bench = Bench()
    bench.write(0x1801, 1, INVALID)
    for place in range(1, 65):
        bench.write(0x1A01, place, entry_of(number_of("bool"), 0, 1))
    assert bench.refusal(0x1A01, 0, 65) == 0x06040042
    assert bench.refusal(0x1A01, 0, 255) == 0x06040042
    assert bench.refusal(0x1A01, 0, 64) == 0
    bench.write(0x1A01, 0, 0)
    bench.write(0x1A01, 64, entry_of(number_of("u8"), 0, 8))
    assert bench.refusal(0x1A01, 0, 64) == 0x06040042
    bench.write(0x1A01, 2, 0)
    assert bench.refusal(0x1A01, 0, 2) == sdo.NO_OBJECT
    assert bench.refusal(0x1A01, 65, 0) == sdo.NO_SUBINDEX


def test_a_fixed_mapping_cannot_be_changed() -> None:
    rpdo = replace(pdo("rpdo", 1, (0x6040, 0, 16)), fixed=True)
    bench = Bench(DeviceNode(with_pdos(rpdo), NODE_ID))
    bench.write(0x1400, 1, INVALID)
    assert bench.refusal(0x1600, 0, 0) == sdo.ACCESS_UNSUPPORTED
    objects = tuple(
        o for o in DEVICE.objects if not 0x1600 <= o.index < 0x1800
    ) + tuple(o for o in pdo_objects(0x1400, 8, access="const") if o.index == 0x1600)
    bench = Bench(DeviceNode(replace(with_pdos(rpdo), objects=objects), NODE_ID))
    assert bench.refusal(0x1600, 0, 0) == sdo.READ_ONLY
    assert bench.read(0x1600, 1) == entry_of(0x6040, 0, 16).to_bytes(4, "little")


def test_what_the_device_maps_by_itself_it_can_map_again() -> None:
    odd = pdo("tpdo", 1, (0x2102, 0, 16), (0x7777, 0, 8), (0x6064, 0, 16))
    bench = Bench(DeviceNode(with_pdos(odd), NODE_ID))
    bench.node.set(0x6064, 0, -2)
    assert [f.data.hex() for f in bench.start()] == ["090000feff"]
    remap(bench, 0x1800, (0x6064, 0, 16), (0x2102, 0, 16))
    assert bench.sent[-1].data.hex() == "feff0900"


def test_default_mappings_that_are_too_long_make_no_pdo() -> None:
    long = pdo("tpdo", 1, *[(0x6064, 0, 32)] * 3)
    bench = Bench(DeviceNode(with_pdos(long), NODE_ID))
    assert bench.start() == []


def test_pdos_without_objects_of_their_own_keep_what_they_have() -> None:
    objects = tuple(o for o in DEVICE.objects if not 0x1400 <= o.index < 0x1C00)
    bench = Bench(DeviceNode(replace(DEVICE, objects=objects), NODE_ID))
    assert [f.can_id for f in bench.start()] == [TPDO1]
    bench.give(RPDO1, bytes.fromhex("0f0001000000"))
    assert bench.node.get(0x6040) == 15


# Communication parameters


@pytest.mark.parametrize("communication", [0x1400, 0x1800])
def test_cob_ids(communication: int) -> None:
    bench = Bench()
    old = int(bench.node.get(communication, 1))
    assert bench.refusal(communication, 1, old) == 0
    assert bench.refusal(communication, 1, old + 1) == sdo.VALUE_INVALID
    assert bench.refusal(communication, 1, old | 1 << 29) == sdo.VALUE_INVALID
    assert bench.refusal(communication, 1, old | 1 << 30) == 0
    assert bench.refusal(communication, 1, old | INVALID) == 0
    for wrong in (0, 0x7F, 0x101, 0x180, 0x581, 0x67F, 0x6E0, 0x701, 0x7FF):
        assert bench.refusal(communication, 1, wrong) == sdo.VALUE_INVALID
        assert bench.refusal(communication, 1, wrong | INVALID) == 0
    assert bench.refusal(communication, 1, 0x3FF) == 0
    assert 0x3FF in bench.node.identifiers
    assert old not in bench.node.identifiers


def test_pdos_with_29_bits() -> None:
    bench = Bench()
    bench.start()
    for communication in (0x1400, 0x1800):
        bench.write(communication, 1, INVALID)
        bench.write(communication, 1, 1 << 29 | 0x1234567)
    bench.give(0x1234567, bytes.fromhex("0f0001000000"), extended=True)
    assert bench.node.get(0x6040) == 15
    bench.node.set(0x6041, 0, 1)
    assert bench.flush()[0].extended


@pytest.mark.parametrize(
    ("communication", "refused"),
    [(0x1400, range(241, 254)), (0x1800, range(241, 252))],
)
def test_transmission_types(communication: int, refused: range) -> None:
    bench = Bench()
    for kind in range(256):
        code = sdo.VALUE_INVALID if kind in refused else 0
        assert bench.refusal(communication, 2, kind) == code


def test_times_that_are_fixed_while_the_pdo_is_valid() -> None:
    bench = Bench()
    assert bench.refusal(0x1800, 3, 10) == sdo.VALUE_INVALID
    assert bench.refusal(0x1800, 6, 10) == sdo.VALUE_INVALID
    assert bench.refusal(0x1800, 5, 10) == 0
    bench.write(0x1800, 1, INVALID)
    assert bench.refusal(0x1800, 3, 10) == 0
    assert bench.refusal(0x1800, 6, 10) == 0
    assert bench.refusal(0x1800, 6, 241) == sdo.VALUE_TOO_HIGH


# RPDOs


def test_too_short_is_ignored_and_too_long_cut_until_a_right_one_comes() -> None:
    bench = Bench()
    bench.start()
    short = bench.give(RPDO1, b"\1\2\3\4\5")
    assert [f.data.hex() for f in short] == ["1082110100000000"]
    assert bench.node.get(0x6040) == 0
    assert bench.give(RPDO1, b"\1\2\3") == []
    long = bench.give(RPDO1, b"\1\0\2\0\0\0\7\7")
    assert [f.data.hex() for f in long] == ["2082110100000000"]
    assert bench.node.get(0x607A) == 2
    gone = bench.give(RPDO1, b"\1\0\2\0\0\0")
    assert [f.data.hex() for f in gone] == ["0000110100000000", "0000000100000000"]


def test_an_rpdo_that_is_overdue() -> None:
    bench = Bench()
    bench.write(0x1400, 5, 100)
    bench.start()
    assert bench.run(1000) == []
    bench.give(RPDO1, bytes(6))
    assert bench.run(99) == []
    assert [f.data.hex() for f in bench.run(1)] == ["5082110100000000"]
    assert bench.run(1000) == []
    assert [f.data.hex() for f in bench.give(RPDO1, bytes(6))] == ["0000000100000000"]


@pytest.mark.parametrize("kind", [0, 1, 240])
def test_synchronous_rpdos_are_taken_at_the_sync_the_newest_wins(kind: int) -> None:
    received: list[int] = []
    node = DeviceNode(DEVICE, NODE_ID)
    node.events.received = received.append
    bench = Bench(node)
    bench.write(0x1400, 2, kind)
    bench.start()
    bench.give(RPDO1, bytes.fromhex("010000000000"))
    bench.give(RPDO1, bytes.fromhex("020000000000"))
    assert bench.node.get(0x6040) == 0
    bench.give(0x80)
    assert bench.node.get(0x6040) == 2
    assert received == [1]
    bench.give(0x80)
    assert received == [1]


def test_values_that_an_object_cannot_have_are_left_out_and_counted() -> None:
    bench = Bench()
    bench.start()
    remap(bench, 0x1400, (0x2103, 0, 16), (number_of("u8"), 0, 8))
    bench.give(RPDO1, bytes.fromhex("65 00 07"))
    assert bench.node.get(0x2103) == 0
    assert bench.node.get(number_of("u8")) == 7
    assert bench.node.pdos.refused == 1

    def refuse(value: ObjectValue) -> None:
        raise SdoAbort(sdo.LOCAL_CONTROL)

    bench.node.on_write(number_of("u8"), 0, refuse)
    bench.give(RPDO1, bytes.fromhex("64 00 08"))
    assert bench.node.get(0x2103) == 100
    assert bench.node.get(number_of("u8")) == 7
    assert bench.node.pdos.refused == 2


def test_remote_and_foreign_frames_are_no_rpdos() -> None:
    bench = Bench()
    bench.start()
    assert bench.give(RPDO1, remote=True) == []
    assert bench.give(RPDO1, b"\1", extended=True) == []
    assert bench.give(0x3AB, b"\1") == []


# TPDOs


def test_a_change_is_sent_once_and_only_a_change() -> None:
    bench = Bench()
    bench.start()
    bench.node.set(0x6041, 0, 0x27)
    bench.node.set(0x6064, 0, 1)
    assert [f.data.hex() for f in bench.flush()] == ["270001000000"]
    bench.node.set(0x6064, 0, 1)
    assert bench.flush() == []
    bench.node.trigger(0x6064)
    assert len(bench.flush()) == 1
    bench.node.trigger(0x2103)
    assert bench.flush() == []


def test_an_object_written_by_sdo_or_rpdo_is_a_change_too() -> None:
    bench = Bench()
    bench.start()
    remap(bench, 0x1801, (number_of("u8"), 0, 8))
    remap(bench, 0x1401, (number_of("u8"), 0, 8))
    bench.sent.clear()
    bench.write(number_of("u8"), 0, 5)
    assert Frame(TPDO2, b"\5") in bench.sent
    assert bench.give(RPDO2, b"\6") == [Frame(TPDO2, b"\6")]


def test_the_application_may_decide_what_is_an_event() -> None:
    bench = Bench()
    seen: list[tuple[bytes | None, bytes]] = []

    def far(old: bytes | None, new: bytes) -> bool:
        seen.append((old, new))
        if old is None:
            return False
        return abs(int.from_bytes(new, "little") - int.from_bytes(old, "little")) > 10

    bench.node.on_change(0x6064, 0, far)
    bench.node.on_change(0x6041, 0, lambda old, new: False)
    assert bench.start() == []
    for value in (5, 10, 11, 20, 22):
        bench.node.set(0x6064, 0, value)
        bench.flush()
    assert [f.data[2] for f in bench.sent if f.can_id == TPDO1] == [11, 22]
    assert seen[0] == (None, bytes(4))


def test_the_newest_value_waits_for_the_inhibit_time() -> None:
    bench = Bench()
    bench.write(0x1800, 1, INVALID)
    bench.write(0x1800, 3, 100)
    bench.write(0x1800, 1, TPDO1)
    bench.start()
    for value in (1, 2, 3):
        bench.node.set(0x6064, 0, value)
        assert bench.flush() == []
    assert bench.run(9.9) == []
    assert [f.data[2] for f in bench.run(0.1)] == [3]
    assert bench.node.pdos.overwritten == 2


def test_the_event_timer_repeats_with_the_values_of_the_moment() -> None:
    bench = Bench()
    bench.write(0x1800, 5, 20)
    bench.start()
    moments = iter(range(100))
    bench.node.on_read(0x6064, 0, lambda: next(moments))
    frames = bench.run(60)
    assert len(frames) == 3
    assert len({frame.data for frame in frames}) == 3
    bench.write(0x1800, 5, 0)
    bench.run(0)
    assert bench.run(1000) == []


@pytest.mark.parametrize(("kind", "sent"), [(1, 12), (2, 6), (3, 4), (240, 0)])
def test_every_nth_sync(kind: int, sent: int) -> None:
    bench = Bench()
    bench.write(0x1800, 2, kind)
    bench.start()
    bench.node.set(0x6064, 0, 1)
    assert bench.flush() == []
    frames = [f for _ in range(12) for f in bench.give(0x80)]
    assert [f.can_id for f in frames] == [TPDO1] * sent


def test_acyclic_synchronous() -> None:
    bench = Bench()
    bench.write(0x1800, 2, 0)
    assert bench.start() == []
    assert len(bench.give(0x80)) == 1
    assert bench.give(0x80) == []
    bench.node.set(0x6064, 0, 1)
    assert bench.flush() == []
    assert [f.data[2] for f in bench.give(0x80)] == [1]


def test_sync_start() -> None:
    bench = Bench()
    bench.write(0x1019, 0, 10)
    bench.write(0x1800, 1, INVALID)
    bench.write(0x1800, 2, 2)
    bench.write(0x1800, 6, 5)
    bench.write(0x1800, 1, TPDO1)
    bench.start()
    sent = [n for n in range(1, 11) if bench.give(0x80, bytes((n,)))]
    assert sent == [5, 7, 9]


@pytest.mark.parametrize(
    ("kind", "before_sync", "after_sync"), [(252, 0, 1), (253, 1, 1), (255, 1, 1)]
)
def test_remote_frames(kind: int, before_sync: int, after_sync: int) -> None:
    bench = Bench()
    bench.write(0x1800, 2, kind)
    bench.start()
    bench.sent.clear()
    assert len(bench.give(TPDO1, remote=True)) == before_sync
    bench.give(0x80)
    assert len(bench.give(TPDO1, remote=True)) == after_sync


def test_tpdos_without_remote_frames() -> None:
    bench = Bench()
    bench.write(0x1800, 1, INVALID)
    bench.write(0x1800, 1, 1 << 30 | TPDO1)
    bench.start()
    assert bench.give(TPDO1, remote=True) == []


def test_leaving_operational_forgets_what_waits() -> None:
    bench = Bench()
    bench.write(0x1800, 2, 0)
    bench.start()
    bench.node.set(0x6064, 0, 1)
    bench.flush()
    bench.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    assert bench.give(0x80) == []
    assert bench.node.deadline is None


def test_reset_brings_the_default_mapping_back() -> None:
    bench = Bench()
    remap(bench, 0x1400, (number_of("u8"), 0, 8))
    bench.command(NmtCommand.RESET_COMMUNICATION)
    assert bench.read(0x1600, 0) == b"\2"
    assert bench.read(0x1600, 1) == entry_of(0x6040, 0, 16).to_bytes(4, "little")
    bench.start()
    bench.give(RPDO1, bytes.fromhex("0f0001000000"))
    assert bench.node.get(0x6040) == 15


def test_a_reserved_transmission_type_makes_the_pdo_invalid() -> None:
    odd = replace(pdo("tpdo", 1, (0x6064, 0, 32)), transmission_type=245)
    bench = Bench(DeviceNode(with_pdos(odd), NODE_ID))
    assert bench.start() == []


@pytest.mark.parametrize(
    ("number", "stated", "wanted"),
    [
        (1, None, 0x185),
        (2, 0, 0x285),
        (2, 0x40000000, 0x40000285),
        (5, None, INVALID),
        (1, 0x585, INVALID | 0x585),
        (1, 0x7F, INVALID | 0x7F),
    ],
)
def test_cob_ids_that_a_description_does_not_state_or_cannot_have(
    number: int, stated: int | None, wanted: int
) -> None:
    base = 0x1800 + number - 1
    odd = replace(pdo("tpdo", number, (0x6064, 0, 32)), cob_id=stated, relative=False)
    objects = (*COMMUNICATION, *pdo_objects(base, 1), *APPLICATION)
    device = replace(DEVICE, objects=objects, pdos=(odd,))
    bench = Bench(DeviceNode(device, NODE_ID))
    sent = [] if wanted & INVALID else [wanted & 0x7FF]
    assert [frame.can_id for frame in bench.start()] == sent
    assert bench.read(base, 1) == wanted.to_bytes(4, "little")


# Every kind, every width


def bits_of(kind: Kind, octets: str) -> int:
    return KIND_BITS.get(kind) or 8 * len(bytes.fromhex(octets)) or 8


BY_PDO = [
    (kind, value, octets, shift)
    for kind, value, octets in BOUNDARIES
    for shift in (0, 1, 7)
    if shift + bits_of(kind, octets) <= 64
]


@pytest.mark.parametrize(("kind", "value", "octets", "shift"), BY_PDO)
def test_boundary_values_by_pdo_both_ways(
    kind: Kind, value: ObjectValue, octets: str, shift: int
) -> None:
    bits = bits_of(kind, octets)
    objects = (*DEVICE.objects, var(SPARE, 0, "bool", mappable=True))
    bench = Bench(DeviceNode(replace(DEVICE, objects=objects), NODE_ID))
    gap = [(SPARE, 0, 1)] * shift
    entry = (number_of(kind), 0, bits)
    remap(bench, 0x1801, *gap, entry)
    remap(bench, 0x1401, *gap, entry)
    bench.start()
    bench.sent.clear()
    bench.node.set(entry[0], 0, value)
    bench.node.trigger(entry[0])
    (frame,) = bench.flush()
    raw = int.from_bytes(bytes.fromhex(octets), "little") << shift
    assert frame == Frame(TPDO2, raw.to_bytes((shift + bits + 7) // 8, "little"))
    bench.node.set(entry[0], 0, values.zero(kind))
    bench.give(RPDO2, frame.data)
    assert bench.node.get(entry[0]) == value


_FIELDS = [(kind, KIND_BITS[kind]) for kind in KINDS if kind in KIND_BITS]


class Bits:
    """Data as a string of bits, bit 0 of octet 0 first: an independent implementation on text."""

    def __init__(self, text: str = "") -> None:
        self.text = text

    @classmethod
    def of(cls, data: bytes) -> Bits:
        return cls("".join(f"{octet:08b}"[::-1] for octet in data))

    def add(self, octets: bytes, bits: int) -> None:
        self.text += Bits.of(octets).text[:bits].ljust(bits, "0")

    def data(self) -> bytes:
        padded = self.text + "0" * (-len(self.text) % 8)
        parts = [padded[n : n + 8] for n in range(0, len(padded), 8)]
        return bytes(int(part[::-1], 2) for part in parts)


@st.composite
def mappings(draw: st.DrawFn) -> list[tuple[Kind | None, int]]:
    fields: list[tuple[Kind | None, int]] = []
    left = 64
    while left:
        choices: list[tuple[Any, int]] = [f for f in _FIELDS if f[1] <= left]
        choices += [(None, gap) for gap in (1, 3, 8, 16) if gap <= left]
        kind, bits = draw(st.sampled_from(choices))
        fields.append((kind, bits))
        left -= bits
        if draw(st.integers(0, 4)) == 0:
            break
    return fields


@settings(max_examples=400, deadline=None)
@given(mappings(), st.data())
def test_packing_against_a_model_of_single_bits(
    fields: list[tuple[Kind | None, int]], data: st.DataObject
) -> None:
    octets: dict[ObjectNumber, bytes] = {}
    model = Bits()
    mapped = []
    for place, (kind, bits) in enumerate(fields):
        if kind is None:
            mapped.append(MappedField(None, "octets", bits))
            model.add(b"", bits)
            continue
        number = place, 0
        size = (bits + 7) // 8
        value = data.draw(st.binary(min_size=size, max_size=size))
        octets[number] = value if kind != "bool" else bytes((value[0] & 1,))
        mapped.append(MappedField(number, kind, bits))
        model.add(octets[number], bits)
    mapping = Mapping(mapped)
    packed = mapping.pack(octets.__getitem__)
    assert packed == model.data()
    assert dict(mapping.unpack(packed + b"\xff")) == octets


@settings(deadline=None)
@given(st.binary(max_size=8))
def test_unpacking_against_the_model(data: bytes) -> None:
    widths = [3, 5, 8, 13, 16, 19]
    fields, at = [], 0
    text = Bits.of(data).text
    for place, bits in enumerate(widths):
        if at + bits > len(text):
            break
        fields.append((place, bits, at))
        at += bits
    mapping = Mapping([MappedField((p, 0), "u32", bits) for p, bits, _ in fields])
    for (place, bits, first), (number, octets) in zip(
        fields, mapping.unpack(data), strict=True
    ):
        assert number == (place, 0)
        assert octets is not None
        assert int.from_bytes(octets, "little") == int(
            text[first : first + bits][::-1] or "0", 2
        )


def test_values_narrower_fields_cannot_hold_come_as_none() -> None:
    mapping = Mapping([MappedField((1, 0), "u8", 16), MappedField((2, 0), "u8", 8)])
    assert list(mapping.unpack(b"\0\1\7")) == [((1, 0), None), ((2, 0), b"\7")]


def test_deadlines_are_the_earliest_of_all() -> None:
    bench = Bench()
    bench.write(0x1800, 5, 50)
    bench.write(0x1400, 5, 30)
    bench.start()
    assert bench.node.deadline == bench.now + 50 * MILLISECOND
    bench.give(RPDO1, bytes(6))
    assert bench.node.deadline == bench.now + 30 * MILLISECOND


def test_an_object_in_two_tpdos_is_sent_by_both() -> None:
    bench = Bench()
    bench.start()
    remap(bench, 0x1801, (0x6064, 0, 32))
    bench.sent.clear()
    bench.node.set(0x6064, 0, 9)
    assert sorted(f.can_id for f in bench.flush()) == [TPDO1, TPDO2]


def test_variables_need_no_sub_index_0() -> None:
    objects = (*DEVICE.objects, var(0x2200, 3, "u8", "rw", 4, mappable=True))
    bench = Bench(DeviceNode(replace(DEVICE, objects=objects), NODE_ID))
    bench.start()
    remap(bench, 0x1801, (0x2200, 3, 8))
    assert Frame(TPDO2, b"\4") in bench.sent
