"""Random signatures and values: the codec's bytes equal those of a plain writer, and read back.

Cut or altered messages end in an RpcError and request no more memory than allowed.
"""

from __future__ import annotations

from contextlib import suppress
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from random_signatures import Call, Sample, sample
from reference_wire import Wire

from rtgen.runtime.opaque_rpc import (
    REQUEST_LIMIT,
    Order,
    ReplyOrder,
    RpcError,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.values import is_rpc_error
from rtgen.tools.rpc.codecs import Function, Reader, Service

DRAWN = settings(
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
CALLS = 6


class Limited(Reader):
    """A reader that records the largest request."""

    asked = 0

    def more(self, n: int) -> bytes:
        self.asked = max(self.asked, n)
        return super().more(n)


def made(
    random: Random, order: Order, reply: ReplyOrder
) -> tuple[Sample, Service, Wire]:
    found = sample(random)
    service = Service(found.unit, found.signature, make_tdr(order), reply)
    return found, service, Wire(found.unit, order)


def arguments(function: Function, call: Call) -> tuple[Any, ...]:
    return tuple(call.args[item.name] for item in function.layout.arguments)


def outs(function: Function, call: Call) -> tuple[Any, ...]:
    return tuple(call.outs[item.name] for item in function.layout.outs)


ORDERS = st.sampled_from(("network", "little", "big"))
REPLIES = st.sampled_from(("tecsgen", "paper"))
RANDOMS = st.integers(0, 1 << 32).map(Random)


@pytest.mark.sampled(0)
@settings(DRAWN, max_examples=60)
@given(random=RANDOMS, order=ORDERS, reply=REPLIES)
def test_messages_are_those_of_a_plain_writer_and_read_back(
    random: Random, order: Order, reply: ReplyOrder
) -> None:
    found, service, wire = made(random, order, reply)
    for function in service.functions.values():
        for _ in range(CALLS):
            check(found, service, wire, function, random, reply)


def check(
    found: Sample,
    service: Service,
    wire: Wire,
    function: Function,
    random: Random,
    reply: ReplyOrder,
) -> None:
    declared = function.layout.function
    call = found.call(random, declared, service.types)
    values = arguments(function, call)
    request = function.encode_request(values)
    assert request == wire.request(declared, call.args)
    assert function.decode_request(request) == values
    text = function.arguments_to_json(values)
    assert function.arguments_from_json(text) == values
    if function.oneway:
        return
    kept, results = function.kept(values), outs(function, call)
    data = function.encode_reply(kept, call.returned, results)
    paper = reply == "paper"
    expected = wire.reply(declared, call.args, call.returned, call.outs, paper)
    assert data == expected
    returned, read = function.decode_reply(data, kept)
    assert returned == call.returned
    skipped = function.layout.leaves_out and is_rpc_error(call.returned) and not paper
    assert read == (None if skipped else results)
    shown = function.result_to_json(returned, read)
    if not skipped:
        assert function.result_from_json(shown) == (returned, results)


@settings(DRAWN, max_examples=25)
@given(random=RANDOMS, order=ORDERS, reply=REPLIES)
def test_wrong_messages_end_in_rpc_errors(
    random: Random, order: Order, reply: ReplyOrder
) -> None:
    found, service, _ = made(random, order, reply)
    for function in service.functions.values():
        call = found.call(random, function.layout.function, service.types)
        values = arguments(function, call)
        request = function.encode_request(values)
        for wrong in wrong_ones(request, random):
            reader = Limited(wrong)
            reads(function, reader)
            assert reader.asked <= REQUEST_LIMIT + 1000
        if not function.oneway:
            kept = function.kept(values)
            data = function.encode_reply(kept, call.returned, outs(function, call))
            for wrong in wrong_ones(data, random):
                decodes(function, wrong, kept)


def wrong_ones(data: bytes, random: Random) -> list[bytes]:
    """Return the message cut at each place, and altered in many ways."""
    places = range(len(data)) if len(data) < 60 else random.sample(range(len(data)), 60)
    found = [data[:at] for at in places]
    for at in places:
        for octet in (0, 0xFF, 0x80, data[at] ^ 1 << random.randint(0, 7)):
            found.append(data[:at] + bytes((octet,)) + data[at + 1 :])
    return found


def reads(function: Function, reader: Reader) -> None:
    with suppress(RpcError):
        reader.more(4)
        function.read_request(reader.more)


def decodes(function: Function, data: bytes, kept: tuple[object, ...]) -> None:
    with suppress(RpcError):
        function.decode_reply(data, kept)
