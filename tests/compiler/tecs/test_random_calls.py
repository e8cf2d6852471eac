"""Random calls of random signatures from generated clients to generated servers, over TCP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from typing import Any

import pytest
from patience import until
from random_signatures import Call, plain, sample
from seeds import budget, seed
from services import Generated

from rtgen.runtime.opaque_rpc import (
    Order,
    ReplyOrder,
    TcpChannel,
    TcpServer,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.values import is_rpc_error
from rtgen.tools.rpc.codecs import Function, Service

ORDERS: tuple[Order, ...] = ("network", "little", "big")
REPLIES: tuple[ReplyOrder, ...] = ("tecsgen", "paper")
LONG = 20.0
LIMIT = 1 << 20


class Answers:
    """The answers of a target, as prepared by the test; records its arguments."""

    def __init__(self) -> None:
        self.called: list[tuple[str, tuple[object, ...]]] = []
        self.result: object = None

    def wait_for(self, calls: int) -> None:
        """Wait until this many calls were executed: oneway functions have no reply."""
        until(lambda: len(self.called) >= calls)

    def target(self, generated: Generated) -> Any:
        """Return a target with this implementation."""
        methods = {
            method: self._method(name) for name, method in generated.methods.items()
        }
        return type("Target", (generated.target,), methods)()

    def _method(self, name: str) -> Callable[..., object]:
        def method(_: object, *arguments: object) -> object:
            self.called.append((name, arguments))
            return self.result

        return method


def handed_back(function: Function, returned: object, outs: Sequence[object]) -> object:
    """Return the result of a method: the return value, then the outs; a single value bare."""
    values = [*([] if function.layout.is_void else [returned]), *outs]
    return None if not values else values[0] if len(values) == 1 else tuple(values)


def expected(function: Function, call: Call, reply: ReplyOrder) -> object:
    """Return the result of the caller: after an E_RPC inouts unchanged, outs zero or NULL."""
    layout = function.layout
    outs: list[object] = [call.outs[item.name] for item in layout.outs]
    skipped = layout.leaves_out and is_rpc_error(call.returned)
    if skipped and reply == "tecsgen":
        zeros = function.zeros()[1]
        outs = [
            call.args[item.name] if item.inward else None if item.nullable else zero
            for item, zero in zip(layout.outs, zeros, strict=True)
        ]
    return handed_back(function, call.returned, outs)


def run_calls(random: Random, calls: int) -> int:
    """Call each function of a random signature; return the number of calls."""
    order, reply = random.choice(ORDERS), random.choice(REPLIES)
    found = sample(random)
    client, server = (
        Service(found.unit, found.signature, make_tdr(order), reply) for _ in "cs"
    )
    generated, board = Generated(client), Generated(server)
    answers = Answers()
    service = board.unmarshaller(answers.target(board), server.codec)
    made: list[tuple[str, tuple[object, ...]]] = []
    with TcpServer(service, timeout=LONG, allocator_size=LIMIT) as listening:
        channel = TcpChannel(*listening.address, timeout=LONG)
        proxy = generated.proxy(channel, client.codec)
        for _ in range(calls):
            for name, function in client.functions.items():
                layout = function.layout
                call = found.call(random, layout.function, client.types)
                arguments = tuple(call.args[item.name] for item in layout.arguments)
                outs = [call.outs[item.name] for item in layout.outs]
                # The classes of structs differ at both ends; codecs use their members.
                answers.result = handed_back(function, call.returned, outs)
                made.append((name, arguments))
                result = getattr(proxy, generated.methods[name])(*arguments)
                if function.oneway:
                    assert result == (None if layout.is_void else 0)
                else:
                    assert result == expected(function, call, reply)
        answers.wait_for(len(made))
        channel.close()
    assert [name for name, _ in answers.called] == [name for name, _ in made]
    assert plain([values for _, values in answers.called]) == plain(
        [values for _, values in made]
    )
    return len(made)


def test_some_calls() -> None:
    random = Random(1)
    assert sum(run_calls(random, 5) for _ in range(10)) == 150


@pytest.mark.slow
def test_many_calls() -> None:
    random = Random(seed())
    made = 0
    while made < budget(20_000):
        made += run_calls(random, 500)
