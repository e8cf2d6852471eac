"""Sequences and arrays of octets are encoded from buffers, and copied to `bytes`."""

from __future__ import annotations

import ctypes
import json
import mmap
from array import array
from collections.abc import Callable
from typing import Any

import emitted
import numpy
import pytest

from rtgen.runtime import RTC_OK, Component, ComponentProfile, ReturnCode_t, System
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.system.json_printers import json_printer
from rtgen.runtime.values import AnyValue

IDL = """
module o {
    typedef sequence<octet> Octets;
    struct Image {
        long id; sequence<octet> pixels; octet mac[4]; uint8 table[2][4]; sequence<octet, 5> few;
    };
    @mutable struct Loose {
        @optional sequence<uint8> pixels; map<long, Octets> named; sequence<Octets> rows;
    };
    union Choice switch (long) { case 1: sequence<octet> pixels; case 2: octet mac[4]; };
    struct Held { Image taken; any thing; };
    exception Failed { sequence<octet> pixels; };
};
"""
CONTENT = b"\0\x7f\xffz"


def mapped() -> mmap.mmap:
    made = mmap.mmap(-1, len(CONTENT))
    made.write(CONTENT)
    return made


BUFFERS: list[Callable[[], Any]] = [
    lambda: CONTENT,
    lambda: bytearray(CONTENT),
    lambda: memoryview(bytearray(CONTENT)),
    lambda: memoryview(bytes(b for octet in CONTENT for b in (octet, 0)))[::2],
    lambda: memoryview(CONTENT).cast("c"),
    lambda: array("B", CONTENT),
    lambda: numpy.frombuffer(CONTENT, "u1").copy(),
    lambda: (ctypes.c_ubyte * 4)(*CONTENT),
    lambda: ctypes.create_string_buffer(CONTENT, 4),
    mapped,
]


@pytest.fixture(scope="module")
def o(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("octets"), IDL).o


@pytest.mark.parametrize("make", BUFFERS)
@pytest.mark.parametrize("way", ["cdr", "xcdr1", "xcdr2"])
def test_buffers_have_the_octets_of_bytes(
    o: Any, make: Callable[[], Any], way: str
) -> None:
    given, rows = make(), [CONTENT, CONTENT]
    values = [
        o.Image(1, given, given, [given] * 2, given),
        o.Choice.of_pixels(given),
        o.Choice.of_mac(given),
    ]
    wanted = [
        o.Image(1, CONTENT, CONTENT, rows, CONTENT),
        o.Choice.of_pixels(CONTENT),
        o.Choice.of_mac(CONTENT),
    ]
    if way != "cdr":
        values.append(o.Loose(given, {3: given}, [given]))
        wanted.append(o.Loose(CONTENT, {3: CONTENT}, [CONTENT]))
    for value, expected in zip(values, wanted, strict=True):
        octets = getattr(expected, f"to_{way}")()
        assert getattr(value, f"to_{way}")() == octets
        assert getattr(type(value), f"from_{way}")(octets) == expected
        assert value._snapshot_() == expected
        assert json_printer(type(value))(value) == json_printer(type(value))(expected)
    assert o.Failed(given).to_cdr() == o.Failed(CONTENT).to_cdr()
    assert o.OctetsCodec.to_cdr(given) == o.OctetsCodec.to_cdr(CONTENT)


@pytest.mark.parametrize("make", BUFFERS)
def test_any_takes_buffers(o: Any, make: Callable[[], Any]) -> None:
    held = o.Held(o.Image(1, make(), make()), AnyValue(o.OctetsCodec, make()))
    made = o.Held.from_cdr(held.to_cdr())
    assert made.taken.pixels == made.thing.value == CONTENT
    copied = held._snapshot_()
    assert copied.to_cdr() == held.to_cdr()


FAULTS: list[tuple[str, Any, str]] = [
    ("pixels", numpy.zeros(3), "a buffer of octets is needed, not of 'd'"),
    ("pixels", numpy.zeros(3, "i1"), "a buffer of octets is needed, not of 'b'"),
    ("pixels", numpy.zeros(3, bool), r"a buffer of octets is needed, not of '\?'"),
    ("pixels", numpy.zeros((2, 2), "u1"), "a buffer of 1 dimension is needed"),
    ("pixels", numpy.uint8(3), "a buffer of 1 dimension is needed"),
    ("pixels", [1, 2], "bytes are needed, not list"),
    ("pixels", 5, "bytes are needed, not int"),
    ("pixels", "text", "bytes are needed, not str"),
    ("few", memoryview(bytes(6)), "6 items, and 5 are the most"),
    ("mac", memoryview(bytes(5)), "5 items instead of 4"),
    ("mac", numpy.zeros(4, "u2"), "a buffer of octets is needed, not of 'H'"),
    ("table", numpy.zeros((2, 3), "u1"), "3 items instead of 4"),
]


@pytest.mark.parametrize(("member", "wrong", "message"), FAULTS)
@pytest.mark.parametrize("way", ["cdr", "xcdr2"])
def test_other_values_are_refused(
    o: Any, way: str, member: str, wrong: Any, message: str
) -> None:
    value = o.Image(mac=bytes(4))
    setattr(value, member, wrong)
    with pytest.raises(CdrError, match=rf"Image\.{member}(\[0\])?: {message}"):
        getattr(value, f"to_{way}")()


class Idle(Component):
    """A component without behaviour."""

    profile = ComponentProfile("Idle")

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return RTC_OK


@pytest.mark.parametrize(
    "make", [lambda: bytearray(CONTENT), lambda: numpy.frombuffer(CONTENT, "u1").copy()]
)
def test_readers_share_no_octets_with_the_writer(
    o: Any, make: Callable[[], Any]
) -> None:
    system = System()
    writer, reader = Idle("writer"), Idle("reader")
    source, target = (
        writer.add_out_port("out", o.Image),
        reader.add_in_port("in", o.Image),
    )
    system.add(writer)
    system.add(reader)
    system.connect(("writer", "out"), ("reader", "in"))
    pixels, mac = make(), make()
    source.write(o.Image(1, pixels, mac, [make(), CONTENT]))
    pixels[0] = mac[0] = 9
    read = target.read()
    assert (read.pixels, read.mac) == (CONTENT, CONTENT)
    assert {type(read.pixels), type(read.mac), *map(type, read.table)} == {bytes}


def test_logs_print_octets_of_buffers(o: Any) -> None:
    value = o.Image(1, ctypes.create_string_buffer(b"ab", 2), bytearray(4))
    printed = json.loads(json_printer(o.Image)(value))
    assert (printed["pixels"], printed["mac"]) == ([97, 98], [0] * 4)
