"""A hand-written peer of TECS OpaqueRPC, of sockets and `struct` alone, without rtgen.

Each function of the recorded signatures is a generator of the steps of its request, then, after
`yield`, of its reply. The same steps write at one end and read at the other. Values are those of
the recordings: characters are numbers, texts Python's.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Iterator
from typing import Any

Values = dict[str, Any]
Steps = Callable[["Message", Values, Values], Iterator[None]]

E_RPC = 0xBC
FUNCTIONS: dict[str, dict[int, Steps]] = {}
ONEWAY: set[Steps] = set()


def of(
    signature: str, number: int, *, oneway: bool = False
) -> Callable[[Steps], Steps]:
    """Register a function under its signature and id."""

    def file(steps: Steps) -> Steps:
        FUNCTIONS.setdefault(signature, {})[number] = steps
        if oneway:
            ONEWAY.add(steps)
        return steps

    return file


class Message:
    """Message on a connection, being written or read; `data` are its bytes."""

    def __init__(self, link: socket.socket, native: bool, sending: bool) -> None:
        self._link = link
        self._order = "<" if native else ">"
        self.native = native
        self.sending = sending
        self.data = b""

    def turn(self) -> bytes:
        """End a message and send the written data; the next one goes the other way."""
        data, self.data = self.data, b""
        if self.sending:
            self._link.sendall(data)
        self.sending = not self.sending
        return data

    def value(self, kind: str, value: Any = None) -> Any:
        """Return a number; `l` and `L` are C's long, whose width depends on the machine."""
        if kind in "lL" and self.native:
            kind = "q" if kind == "l" else "Q"
        form = self._order + kind
        if self.sending:
            self.data += struct.pack(form, value)
            return value
        data = b""
        while missing := struct.calcsize(form) - len(data):
            piece = self._link.recv(missing)
            if not piece:
                raise EOFError(f"the connection ended after {self.data.hex(' ')}")
            data += piece
        self.data += data
        return struct.unpack(form, data)[0]

    def magic(self, wanted: int) -> None:
        found = self.value("H", wanted)
        assert found == wanted, f"{found:04x} in place of {wanted:04x}"

    def field(self, kind: str, values: Values, *names: str) -> None:
        for name in names:
            values[name] = self.value(kind, values.get(name))

    def array(self, kind: str, values: Values, name: str, count: int) -> None:
        given = values[name] if self.sending else [None] * count
        values[name] = [self.value(kind, given[i]) for i in range(count)]

    def text(
        self, values: Values, name: str, room: int | None = None, kind: str = "B"
    ) -> None:
        units = [*map(ord, values[name]), 0, 0] if self.sending else []
        length = len(units) - 2
        if room is None:
            count = self.value("i", length + 1)
        else:
            filled = min(length, room - 1) + 1
            count = self.value("i", filled if filled == room else filled + 1)
        found = [self.value(kind, u) for u in (units or [None] * count)[:count]]
        end = found.index(0) if 0 in found else count
        values[name] = "".join(map(chr, found[:end]))

    def absent(self, is_null: bool) -> bool:
        """Return the flag of a nullable value."""
        return bool(self.value("b", int(is_null)))

    def code(self, values: Values) -> bool:
        """Return the value of an `ER` function, and whether outs follow."""
        self.field("i", values, "return")
        return values["return"] & 0xFF != E_RPC

    def struct(self, values: Values, name: str, *members: tuple[str, str]) -> None:
        found = values.setdefault(name, {})
        for kind, member in members:
            self.field(kind, found, member)

    def point(self, values: Values, name: str) -> None:
        self.struct(values, name, ("h", "x"), ("i", "y"))

    def points(self, values: Values, name: str, count: int) -> None:
        given = values[name] if self.sending else [{} for _ in range(count)]
        for each in given:
            self.struct({"": each}, "", ("h", "x"), ("i", "y"))
        values[name] = given

    def rectangle(self, values: Values, name: str) -> None:
        found = values.setdefault(name, {})
        self.point(found, "a")
        self.point(found, "b")
        self.array("B", found, "tag", 3)
        self.field("?", found, "on")


# sServer


@of("sServer", 1)
def func1(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "indata")
    yield
    m.code(o)


@of("sServer", 2)
def func2(m: Message, a: Values, o: Values) -> Iterator[None]:
    yield
    if m.code(o):
        m.field("B", o, "outdata")


@of("sServer", 3)
def func3(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("q", a, "indata")
    m.field("I", a, "iodata")
    yield
    if m.code(o):
        m.field("I", o, "iodata")


# sScalar


def scalar(kind: str) -> Steps:
    def steps(m: Message, a: Values, o: Values) -> Iterator[None]:
        m.field(kind, a, "v")
        yield
        m.field(kind, o, "return", "o")

    return steps


for number, kind in enumerate("bhiqBHIQbBiIhHlLl?Bfd", 1):
    of("sScalar", number)(scalar(kind))


@of("sScalar", 22)
def mix(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("B", a, "a")
    m.field("q", a, "c")
    m.field("H", a, "d")
    m.field("?", a, "e")
    yield
    if m.code(o):
        m.field("h", o, "b")
        m.field("H", o, "d")
        m.field("d", o, "f")


# sText


@of("sText", 1)
def count(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "s")
    yield
    m.field("i", o, "return")


@of("sText", 2)
def put(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "s", 16)
    yield
    if m.code(o):
        m.field("i", o, "seen")


@of("sText", 3)
def get(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "cap")
    yield
    if m.code(o):
        m.text(o, "s", a["cap"])


@of("sText", 4)
def swap(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "s", 24)
    yield
    if m.code(o):
        m.text(o, "s", 24)


@of("sText", 5)
def wide(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "w", None, "H")
    yield
    if m.code(o):
        m.text(o, "back", 8, "H")


@of("sText", 6)
def names(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "n")
    texts = [{"": text} for text in a.get("list", [""] * a["n"])]
    for each in texts:
        m.text(each, "", 12)
    a["list"] = [each[""] for each in texts]
    yield
    if m.code(o):
        m.field("i", o, "total")


@of("sText", 7)
def both(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "a")
    m.field("h", a, "k")
    m.text(a, "b", 10)
    yield
    if m.code(o):
        m.text(o, "joined", 32)


# sVec: measures travel before the measured data


@of("sVec", 1)
def total(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "n")
    m.array("i", a, "v", a["n"])
    yield
    if m.code(o):
        m.field("q", o, "total")


@of("sVec", 2)
def fill(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("h", a, "n")
    m.field("H", a, "start")
    yield
    if m.code(o):
        m.array("H", o, "v", a["n"])


@of("sVec", 3)
def some(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "max", "len")
    yield
    if m.code(o):
        m.field("i", o, "len")
        m.array("i", o, "v", o["len"])


@of("sVec", 4)
def lead(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "max")
    yield
    if m.code(o):
        m.field("i", o, "len")
        m.array("i", o, "v", o["len"])


@of("sVec", 5)
def part(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "max", "n")
    m.array("B", a, "v", a["n"])
    yield
    if m.code(o):
        m.field("B", o, "x")


@of("sVec", 6)
def twice(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("I", a, "n")
    m.array("d", a, "v", a["n"])
    yield
    if m.code(o):
        m.array("d", o, "v", a["n"])


@of("sVec", 7)
def grow(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "cap", "len")
    m.array("B", a, "v", a["len"])
    yield
    if m.code(o):
        m.field("i", o, "len")
        m.array("B", o, "v", o["len"])


@of("sVec", 8)
def lim(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "n")
    m.array("h", a, "v", a["n"])
    yield
    m.code(o)


@of("sVec", 9)
def flags(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.array("?", a, "v", 3)
    yield
    if m.code(o):
        m.array("?", o, "o", 3)


# sShape


@of("sShape", 1)
def area(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.rectangle(a, "r")
    yield
    m.field("q", o, "return")


@of("sShape", 2)
def move(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.point(a, "p")
    m.point(a, "by")
    yield
    if m.code(o):
        m.point(o, "p")


@of("sShape", 3)
def corners(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("h", a, "k")
    yield
    if m.code(o):
        m.rectangle(o, "r")


@of("sShape", 4)
def byval(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.point(a, "p")
    yield
    if m.code(o):
        m.field("i", o, "s")


@of("sShape", 5)
def many(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "n")
    m.points(a, "ps", a["n"])
    yield
    if m.code(o):
        m.point(o, "c")


@of("sShape", 6)
def make(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("h", a, "x")
    m.field("i", a, "y")
    yield
    m.point(o, "return")


@of("sShape", 7)
def blob(m: Message, a: Values, o: Values) -> Iterator[None]:
    b = a.setdefault("b", {})
    m.field("i", b, "len")
    m.field("B", b, "kind")
    m.array("B", b, "data", b["len"])
    yield
    if m.code(o):
        m.field("i", o, "s")


@of("sShape", 8)
def fixed(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.array("h", a, "row", 3)
    yield
    if m.code(o):
        m.field("i", o, "s")


@of("sShape", 9)
def grid(m: Message, a: Values, o: Values) -> Iterator[None]:
    rows = [{"": row} for row in a.get("g", [None, None])]
    for row in rows:
        m.array("b", row, "", 3)
    a["g"] = [row[""] for row in rows]
    yield
    if m.code(o):
        m.field("i", o, "s")


@of("sShape", 10)
def spread(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "n")
    yield
    if m.code(o):
        m.points(o, "ps", a["n"])


# sMisc


@of("sMisc", 1)
def tick(m: Message, a: Values, o: Values) -> Iterator[None]:
    yield


@of("sMisc", 2)
def note(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "a")
    yield


@of("sMisc", 3)
def counter(m: Message, a: Values, o: Values) -> Iterator[None]:
    yield
    m.field("I", o, "return")


@of("sMisc", 4, oneway=True)
def fire(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "v")
    yield


@of("sMisc", 5, oneway=True)
def fire2(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.text(a, "s")
    m.field("B", a, "k")
    yield


def maybe(m: Message, kind: str, values: Values, name: str) -> None:
    if m.absent(values.get(name) is None):
        values[name] = None
    else:
        m.field(kind, values, name)


def wanted(m: Message, values: Values, name: str) -> None:
    """Add the caller's part of a nullable out: null, or room for it."""
    is_null = m.absent(values.get(name) is None)
    values[name] = None if is_null else {"want": True}


def given(m: Message, kind: str, a: Values, o: Values, name: str) -> None:
    """Add a value that returns without a flag, if the request was not null."""
    if a[name] is None:
        o[name] = None
    else:
        m.field(kind, o, name)


@of("sMisc", 6)
def opt(m: Message, a: Values, o: Values) -> Iterator[None]:
    maybe(m, "i", a, "p")
    maybe(m, "h", a, "r")
    m.field("b", a, "last")
    wanted(m, a, "q")
    yield
    if m.code(o):
        given(m, "i", a, o, "q")
        given(m, "h", a, o, "r")


@of("sMisc", 7)
def optstr(m: Message, a: Values, o: Values) -> Iterator[None]:
    if m.absent(a.get("s") is None):
        a["s"] = None
    else:
        m.text(a, "s")
    yield
    if m.code(o):
        m.field("b", o, "isnull")


@of("sMisc", 8)
def two(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("h", a, "b")
    wanted(m, a, "a")
    wanted(m, a, "c")
    yield
    if m.code(o):
        given(m, "b", a, o, "a")
        given(m, "i", a, o, "c")


@of("sMisc", 9)
def fail(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "code", "o")
    yield
    if m.code(o):
        m.field("i", o, "o")
        m.field("h", o, "p")


@of("sMisc", 10)
def outonly(m: Message, a: Values, o: Values) -> Iterator[None]:
    yield
    m.field("i", o, "o")


@of("sMisc", 11)
def minus(m: Message, a: Values, o: Values) -> Iterator[None]:
    m.field("i", a, "code")
    yield
    m.field("i", o, "return")
    m.field("h", o, "o")


def call(
    link: socket.socket, signature: str, number: int, args: Values, native: bool
) -> tuple[bytes, bytes, Values]:
    """Call a server; return request, reply, and the returned values, `return` among them."""
    steps = FUNCTIONS[signature][number]
    message = Message(link, native, sending=True)
    outs: Values = {}
    run = steps(message, args, outs)
    message.magic(0x672A)
    message.value("h", number)
    next(run)
    message.magic(0x6D5E if steps in ONEWAY else 0x5A3C)
    request = message.turn()
    if steps in ONEWAY:
        return request, b"", outs
    message.magic(0x561E)
    next(run, None)
    message.magic(0x6D5E)
    return request, message.turn(), outs


def serve(
    link: socket.socket, signature: str, results: Values, native: bool
) -> tuple[bytes, bytes, int, Values]:
    """Serve one call with these results; return request, reply, id, and arguments."""
    message = Message(link, native, sending=False)
    message.magic(0x672A)
    number = message.value("h")
    steps = FUNCTIONS[signature][number]
    args: Values = {}
    run = steps(message, args, results)
    next(run)
    message.magic(0x6D5E if steps in ONEWAY else 0x5A3C)
    request = message.turn()
    if steps in ONEWAY:
        return request, b"", number, args
    message.magic(0x561E)
    next(run, None)
    message.magic(0x6D5E)
    return request, message.turn(), number, args
