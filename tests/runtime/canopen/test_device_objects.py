"""The object dictionary over SDO: values of every kind, access, lengths, limits, hooks."""

from __future__ import annotations

import pytest
from device_bench import DEVICE, KINDS, NODE_ID, Bench, number_of, var
from hypothesis import given, settings
from hypothesis import strategies as st
from test_object_values import BOUNDARIES

from rtgen.facts.canopen import KIND_BITS, SIGNED_KINDS, UNSIGNED_KINDS
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import DeviceDescription, Kind, ObjectValue
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.values import ObjectValueError
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import SdoAbort


def refused(bench: Bench, index: int, subindex: int = 0) -> int:
    """Return the abort code of a read."""
    with pytest.raises(SdoAbort) as caught:
        bench.read(index, subindex)
    return caught.value.code


@pytest.mark.parametrize(("kind", "value", "octets"), BOUNDARIES)
def test_boundary_values_both_ways(kind: Kind, value: ObjectValue, octets: str) -> None:
    bench, index = Bench(), number_of(kind)
    bench.node.set(index, 0, value)
    assert bench.read(index).hex() == octets
    bench.node.set(index, 0, values.zero(kind))
    bench.write(index, 0, bytes.fromhex(octets))
    assert bench.node.get(index) == value


@pytest.mark.parametrize("kind", KIND_BITS)
def test_lengths_are_checked(kind: Kind) -> None:
    bench, index, size = Bench(), number_of(kind), values.size(kind)
    assert size is not None
    assert bench.refusal(index, 0, bytes(size + 1)) == sdo.LENGTH_TOO_HIGH
    wanted = sdo.LENGTH_TOO_LOW
    assert bench.refusal(index, 0, bytes(size - 1)) == wanted
    assert bench.node.get(index) == values.zero(kind)


@pytest.mark.parametrize(
    ("index", "subindex", "read", "write"),
    [
        (0x2100, 0, 0, sdo.READ_ONLY),
        (0x2101, 0, sdo.WRITE_ONLY, 0),
        (0x2102, 0, 0, sdo.READ_ONLY),
        (0x2105, 0, 0, 0),
        (0x2106, 0, 0, 0),
        (0x2100, 1, sdo.NO_SUBINDEX, sdo.NO_SUBINDEX),
        (0x3000, 0, sdo.NO_OBJECT, sdo.NO_OBJECT),
    ],
)
def test_access(index: int, subindex: int, read: int, write: int) -> None:
    bench = Bench()
    assert (refused(bench, index, subindex) if read else 0) == read
    assert bench.refusal(index, subindex, b"\1\0") == write


@pytest.mark.parametrize(
    ("index", "octets", "code"),
    [
        (0x2103, (-100).to_bytes(2, "little", signed=True), 0),
        (0x2103, (100).to_bytes(2, "little"), 0),
        (0x2103, (101).to_bytes(2, "little"), sdo.VALUE_TOO_HIGH),
        (0x2103, (-101).to_bytes(2, "little", signed=True), sdo.VALUE_TOO_LOW),
        (0x2104, values.encode("r32", 1.5), 0),
        (0x2104, values.encode("r32", 1.75), sdo.VALUE_TOO_HIGH),
        (0x2104, values.encode("r32", -1.75), sdo.VALUE_TOO_LOW),
    ],
)
def test_limits(index: int, octets: bytes, code: int) -> None:
    bench = Bench()
    assert bench.refusal(index, 0, octets) == code
    assert (bench.read(index) == octets) == (code == 0)
    if code:
        value = values.decode(DEVICE.by_number[index, 0].kind, octets)
        with pytest.raises(ObjectValueError):
            bench.node.set(index, 0, value)


@pytest.mark.parametrize("size", [0, 1, 4, 5, 7, 8, 889, 890, 5000])
def test_long_values_in_segments_and_blocks(size: int) -> None:
    bench, index = Bench(), number_of("octets")
    value = bytes(n % 251 for n in range(size))
    bench.write(index, 0, value)
    assert bench.read(index) == value
    assert bench.read(index, block=True) == value
    bench.node.set(index, 0, value[::-1])
    assert bench.read(index) == value[::-1]


def test_the_identity_comes_from_the_description_where_objects_have_none() -> None:
    bench = Bench()
    identity = [
        int.from_bytes(bench.read(0x1018, sub), "little") for sub in range(1, 5)
    ]
    assert identity == [0x00FFFF01, 0x4242, 0x00010002, 99]


def test_node_dependent_defaults() -> None:
    assert Bench().read(0x1014) == b"\x85\0\0\0"


def test_a_default_that_an_object_cannot_have_counts_as_none() -> None:
    objects = (var(0x2000, 0, "u8", "rw", 300), var(0x2001, 0, "i16", "rw", "x"))
    node = DeviceNode(DeviceDescription("Sloppy", objects, ()), NODE_ID)
    assert node.get(0x2000) == node.get(0x2001) == 0


def test_a_write_hook_sees_the_value_and_may_refuse_it() -> None:
    bench = Bench()
    seen: list[ObjectValue] = []

    def hook(value: ObjectValue) -> None:
        seen.append(value)
        if value == 13:
            raise SdoAbort(sdo.LOCAL_CONTROL)
        if value == 14:
            raise ZeroDivisionError("a mistake of the application")

    bench.node.on_write(0x2103, 0, hook)
    assert bench.refusal(0x2103, 0, 12) == 0
    assert bench.refusal(0x2103, 0, 13) == sdo.LOCAL_CONTROL
    assert bench.refusal(0x2103, 0, 14) == sdo.GENERAL_ERROR
    assert bench.refusal(0x2103, 0, 101) == sdo.VALUE_TOO_HIGH
    assert seen == [12, 13, 14]
    assert bench.node.get(0x2103) == 12
    bench.node.set(0x2103, 0, 13)
    assert seen == [12, 13, 14]


def test_a_read_hook_gives_the_value() -> None:
    bench = Bench()
    answers: list[ObjectValue | Exception] = [
        5,
        70000,
        SdoAbort(0x08000024),
        ZeroDivisionError("a mistake of the application"),
    ]

    def hook() -> ObjectValue:
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    bench.node.on_read(0x2100, 0, hook)
    assert bench.read(0x2100) == b"\5\0"
    assert refused(bench, 0x2100) == sdo.VALUE_TOO_HIGH
    assert refused(bench, 0x2100) == 0x08000024
    assert refused(bench, 0x2100) == sdo.GENERAL_ERROR


def test_hooks_and_values_of_objects_that_are_not_there() -> None:
    node = Bench().node
    with pytest.raises(KeyError, match="3000h:01"):
        node.on_write(0x3000, 1, lambda value: None)
    with pytest.raises(KeyError):
        node.on_read(0x3000, 1, lambda: 0)
    with pytest.raises(KeyError):
        node.get(0x3000)
    with pytest.raises(KeyError):
        node.set(0x3000, 0, 1)


@pytest.mark.sampled(0)
@settings(max_examples=300, deadline=None)
@given(st.data())
def test_every_value_that_sdo_takes_is_read_back(data: st.DataObject) -> None:
    bench = Bench()
    kind = data.draw(st.sampled_from(KINDS))
    size = values.size(kind)
    octets = data.draw(
        st.binary(min_size=size, max_size=size) if size else st.binary(max_size=30)
    )
    index = number_of(kind)
    code = bench.refusal(index, 0, octets)
    if code:
        assert kind == "wstring"
    else:
        assert bench.read(index) == octets
        if kind in (*SIGNED_KINDS, *UNSIGNED_KINDS, "char", "octets"):
            assert values.encode(kind, bench.node.get(index)) == octets
