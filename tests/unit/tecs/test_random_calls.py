"""Random calls of random signatures between generated clients and servers, over TCP."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from random_signatures import sample

from rtgen.cli.rpc.codecs import Function, Service
from rtgen.runtime.opaque_rpc import (
    Handler,
    Handlers,
    More,
    Order,
    ReplyOrder,
    TcpChannel,
    TcpServer,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.codecs import is_rpc_error

ORDERS: tuple[Order, ...] = ("network", "little", "big")
REPLIES: tuple[ReplyOrder, ...] = ("tecsgen", "paper")
LONG = 20.0
LIMIT = 1 << 20


class Board:
    """Answers each call with what the test has laid out, and keeps what it was called with."""

    def __init__(self, service: Service) -> None:
        self.called: list[tuple[str, tuple[object, ...]]] = []
        self.result: tuple[object, tuple[object, ...]] = (0, ())
        functions = {f.layout.function.id: f for f in service.functions.values()}
        self.handlers: Handlers = {
            head: self._handler(functions[number])
            for head, number in service.codec.heads.items()
        }

    def _handler(self, function: Function) -> Handler:
        def handle(more: More) -> bytes | None:
            arguments = function.read_request(more)
            self.called.append((function.name, arguments))
            if function.oneway:
                return None
            return function.encode_reply(function.kept(arguments), *self.result)

        return handle


def run_calls(random: Random, calls: int) -> int:
    """Calls each function of a random signature; how many calls were made."""
    order, reply = random.choice(ORDERS), random.choice(REPLIES)
    found = sample(random)
    tdr = make_tdr(order)
    client = Service(found.unit, found.signature, tdr, reply)
    server = Service(found.unit, found.signature, tdr, reply)
    board = Board(server)
    expected: list[tuple[str, tuple[object, ...]]] = []
    with TcpServer(board, timeout=LONG, allocator_size=LIMIT) as listening:
        channel = TcpChannel(*listening.address, timeout=LONG)
        for _ in range(calls):
            for function in client.functions.values():
                call = found.call(random, function.layout.function, client.types)
                layout = function.layout
                arguments = tuple(call.args[i.name] for i in layout.arguments)
                outs = tuple(call.outs[i.name] for i in layout.outs)
                board.result = (call.returned, outs)
                returned, read = exchange(function, channel, arguments)
                expected.append((function.name, arguments))
                if function.oneway:
                    continue
                skipped = layout.leaves_out and is_rpc_error(call.returned)
                assert returned == call.returned
                assert read == (None if skipped and reply == "tecsgen" else outs)
        channel.close()
    assert [name for name, _ in board.called] == [name for name, _ in expected]
    assert [plain(values) for _, values in board.called] == [
        plain(values) for _, values in expected
    ]
    return len(expected)


def exchange(
    function: Function, channel: TcpChannel, arguments: tuple[object, ...]
) -> tuple[object, tuple[object, ...] | None]:
    head = channel.begin(function.encode_request(arguments), function.first)
    result: tuple[object, tuple[object, ...] | None] = (None, ())
    if not function.oneway:
        result = function.read_reply(head, channel.more, function.kept(arguments))
    channel.end()
    return result


def plain(value: Any) -> Any:
    """A value whose structs are tuples: both ends have classes of their own."""
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    slots = getattr(type(value), "__slots__", None)
    if slots is not None and not isinstance(value, int | float | str | bytes):
        return [plain(getattr(value, name)) for name in slots]
    return value


def test_some_calls() -> None:
    random = Random(1)
    assert sum(run_calls(random, 5) for _ in range(10)) == 150


@pytest.mark.slow
def test_a_hundred_thousand_calls() -> None:
    random = Random(2)
    made = 0
    while made < 100_000:
        made += run_calls(random, 500)
