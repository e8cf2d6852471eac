"""Values of every type of CDL at service ports: the marshaller's are those of the IDL types.

A board answers extreme values, and changed octets; all values of the service ports are checked, in
each form of numbers and with arrays as sequences and as `any`.
"""

from __future__ import annotations

import math
import subprocess
import sys
from array import array
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import product
from random import Random
from typing import Any

import numpy
import pytest
from boards import joined
from seeds import cases

from rtgen.runtime import ACTIVE_STATE, Component, System
from rtgen.runtime.opaque_rpc import (
    ChannelError,
    ExchangeChannel,
    PacketServer,
    RpcError,
)
from rtgen.runtime.values import AnyValue

INTEGERS = {
    "int8_t": 8, "schar_t": 8, "uint8_t": 8, "int16_t": 16, "uint16_t": 16, "int32_t": 32,
    "uint32_t": 32, "int64_t": 64, "uint64_t": 64, "int_t": 32, "long_t": 32,
}  # fmt: skip
"""Integers with their bits on the wire; `schar_t` and `uchar_t` are characters of C."""
TYPES = (*INTEGERS, "char_t", "uchar_t", "float32_t", "double64_t", "bool_t")
COUNT = 3
NUMBERS = {"int16_t": "h", "int32_t": "i", "int64_t": "q", "double64_t": "d"}


def signature(type_: str) -> str:
    """Return a signature with each layout of a type."""
    return f"""
struct tag_{type_} {{
  {type_} one; {type_} row[3]; {type_} grid[2][3]; [size_is(n)] {type_} *some; int32_t n;
}};
signature s_{type_} {{
  {type_} value( [in] {type_} v, [out] {type_} *r );
  ER row( [in] const {type_} v[3], [out,size_is(3)] {type_} *r );
  ER grid( [in] const {type_} v[2][3] );
  ER sized( [in,size_is(n)] const {type_} *v, [in] int32_t n, [out,size_is(n)] {type_} *r );
  ER capped( [in,size_is(n,80)] const {type_} *v, [in] int32_t n, [out,size_is(n,80)] {type_} *r );
  ER counted( [in,size_is(80),count_is(n)] const {type_} *v, [in] int32_t n );
  ER maybe( [inout,nullable] {type_} *v, [out,nullable] {type_} *r );
  ER record( [in] const struct tag_{type_} *v, [out] struct tag_{type_} *r );
  ER texts( [in,string] const char_t *v, [out,string(24)] char_t *r );
}};
"""


def extremes(type_: str) -> list[Any]:
    """Return extreme values of a type, as IDL has them."""
    if type_ in ("char_t", "uchar_t"):
        return ["\0", "\xff", "A", "\x80"]
    if type_ in ("float32_t", "double64_t"):
        return [0.0, -0.0, math.inf, 1.5, 2.0**-149]
    if type_ == "bool_t":
        return [False, True]
    bits = INTEGERS[type_]
    if bits == 8:  # an octet in IDL
        return [0, 255, 127, 128]
    low = 0 if type_.startswith("u") else -1 << bits - 1
    return [low, low + (1 << bits) - 1, 0, 1, 100]


def sequence(type_: str, values: list[Any], form: str) -> Any:
    """Return a sequence as IDL has it, in a form of numbers."""
    if type_ in ("char_t", "uchar_t"):
        return "".join(values)
    if INTEGERS.get(type_) == 8:
        return bytes(values)
    if form == "list" or type_ not in NUMBERS:
        return values
    if form == "array":
        return array(NUMBERS[type_], values)
    return numpy.array(values, numpy.dtype(NUMBERS[type_]))


def plain(values: Any) -> Any:
    """Return a sequence as a list."""
    return list(values.value if isinstance(values, AnyValue) else values)


class Line:
    """The way to the board: `tampering` changes octets of replies."""

    def __init__(self, board: Any) -> None:
        self._exchange = PacketServer(board)
        self.tampering: Random | None = None

    def __call__(self, packet: bytes) -> bytes:
        reply = bytearray(self._exchange(packet))
        chance = self.tampering
        if chance is not None and len(reply) > 4:
            for _ in range(chance.randrange(1, 4)):
                value = chance.choice([0, 1, 2, 127, 128, 255, chance.randrange(256)])
                reply[chance.randrange(2, len(reply))] = value
        return bytes(reply)


class Board:
    """A marshaller's service of a type, called in a system that checks all values."""

    def __init__(self, package: str, type_: str) -> None:
        self.type = type_
        name = f"s_{type_}"
        module = import_module(f"{package}.tecs.cells.{name}_marshaller")
        server = import_module(f"{package}.tecs.cells.{name}_server")
        types = import_module(f"{package}.tecs.cells._views")
        self.interface = getattr(module, name)
        self._record = getattr(types, f"tag_{type_}")
        target: Any = getattr(server, f"{name}Target")

        class Echo(target):  # type: ignore[misc]
            value = staticmethod(lambda v: (v, v))
            row = staticmethod(lambda v: (0, v))
            grid = staticmethod(lambda v: 0)
            sized = staticmethod(lambda v, n: (0, v))
            capped = staticmethod(lambda v, n: (0, v))
            counted = staticmethod(lambda v, n: 0)
            maybe = staticmethod(lambda v, r: (0, v, 0 if r else None))
            record = staticmethod(lambda v: (0, v))
            texts = staticmethod(lambda v: (0, v))

        self.line = Line(getattr(server, f"{name}Unmarshaller")(Echo()))
        proxy = getattr(module, f"{name}Proxy")(ExchangeChannel(self.line))
        self.system = System(check_values="always")
        provider, caller = Component("Provider0"), Component("Caller0")
        for component in (provider, caller):
            self.system.add(component)
        port = provider.add_provider("calls", "calls", self.interface)
        port.set_servant(getattr(module, f"_{name}Servant").of(proxy))
        consumer = caller.add_consumer("calls", "calls", self.interface)
        self.system.connect(("Caller0", "calls"), ("Provider0", "calls"))
        self.system.activate("Provider0")
        limit = 10**9
        self.system.run(limit, until=lambda s: s.state("Provider0") is ACTIVE_STATE)
        self.service = consumer.object

    def given(self, operation: str, values: list[Any], form: str) -> Any:
        """Return a sequence as the parameter `v` of an operation has it."""
        made = sequence(self.type, values, form)
        described = self.interface._descriptor_.operations
        text = next(each for each in described if f" {operation}(" in each)
        if "in any v" not in text:
            return made
        suffix = "80" if operation in ("capped", "counted") else ""
        names = [n for n in vars(self.interface) if n.endswith(f"Seq{suffix}Codec")]
        return AnyValue(getattr(self.interface, names[0])._descriptor_, made)

    def record(self, values: list[Any], form: str) -> Any:
        row = sequence(self.type, values, form)
        return self._record(values[0], row, [row, row], row, len(values))


@pytest.fixture(scope="module")
def packages(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[dict[tuple[str, str], str]]:
    """Return the generated packages by form of numbers and kind of arrays."""
    found, folders = {}, []
    for form, arrays in product(("list", "array", "numpy"), ("sequence", "any")):
        folder = tmp_path_factory.mktemp(f"{form}_{arrays}")
        package = found[form, arrays] = f"cells_{form}_{arrays}"
        text = joined(
            "".join(map(signature, TYPES)),
            *(f"s_{type_}" for type_ in TYPES),
            options=f"array={arrays}",
        )
        (folder / "cells.cdl").write_text(text)
        (folder / "rtgen.toml").write_text(
            f'[sources]\npaths = ["."]\n[output]\npackage = "{package}"\n'
            f'[python]\nnumeric = "{form}"\n'
        )
        command = [sys.executable, "-m", "rtgen", "generate", "--quiet"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        folders.append(str(folder / "generated"))
    sys.path[:0] = folders
    yield found
    for each in folders:
        sys.path.remove(each)


def check(board: Board, form: str) -> None:
    """Call each operation with extreme values, which come back equal."""
    service, values = board.service, extremes(board.type)
    for value in values:
        assert service.value(value) == (value, value)
        one = sequence(board.type, [value], form)
        returned, back, _ = service.maybe(one)
        assert (returned, plain(back)) == (0, plain(one))
    returned, back, _ = service.maybe(sequence(board.type, [], form))
    assert (returned, plain(back)) == (0, [])
    three = (values * COUNT)[:COUNT]
    for some in (three, values, values * 15):
        for operation in ("sized", "capped"):
            given = board.given(operation, some, form)
            returned, back = getattr(service, operation)(given, len(some))
            assert (returned, plain(back)) == (0, plain(given))
        given = board.given("counted", some, form)
        assert service.counted(given, len(some)) == 0
    row = sequence(board.type, three, form)
    returned, back = service.row(row)
    assert (returned, plain(back)) == (0, plain(row))
    assert service.grid([row, row]) == 0
    returned, record = service.record(board.record(three, form))
    assert record == board.record(three, "list")
    for text in ("", "a", "gr\xfc\xdf", "\x01\xff"):
        assert service.texts(text) == (0, text)


@pytest.mark.nightly
@pytest.mark.parametrize("arrays", ["sequence", "any"])
@pytest.mark.parametrize("form", ["list", "array", "numpy"])
def test_every_type(
    packages: dict[tuple[str, str], str], form: str, arrays: str
) -> None:
    for type_ in TYPES:
        check(Board(packages[form, arrays], type_), form)


@pytest.mark.sampled(0)
@pytest.mark.random
@pytest.mark.parametrize("arrays", ["sequence", "any"])
def test_boards_that_answer_wrong_octets(
    packages: dict[tuple[str, str], str], arrays: str
) -> None:
    """A call gives values of its types, or an error of the call."""
    answered = failed = 0
    for seed in cases(3):
        chance = Random(seed)
        for type_ in TYPES:
            board = Board(packages["list", arrays], type_)
            board.line.tampering = chance
            for call in calls(board, chance):
                try:
                    call()
                    answered += 1
                except (RpcError, ChannelError):
                    failed += 1
    assert answered > failed > 0


def calls(board: Board, chance: Random) -> Iterator[Callable[[], object]]:
    service, values = board.service, extremes(board.type)
    for _ in range(10):
        some = [chance.choice(values) for _ in range(COUNT)]
        row = sequence(board.type, some, "list")
        yield lambda: service.value(some[0])  # noqa: B023
        yield lambda: service.maybe(row[:1])  # noqa: B023
        yield lambda: service.row(row)  # noqa: B023
        yield lambda: service.record(board.record(some, "list"))  # noqa: B023
        yield lambda: service.texts("text")
        for operation in ("sized", "capped"):
            given = board.given(operation, some, "list")
            yield lambda: getattr(service, operation)(given, COUNT)  # noqa: B023
