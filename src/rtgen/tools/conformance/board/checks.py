"""Checks of a TECS board: a function each, in the order of execution."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Final

from rtgen.compiler.layouts.tdr import Basic, Item, Role, Run, String, references
from rtgen.facts.tdr import Scalar
from rtgen.runtime.opaque_rpc import ArgumentError, ChannelError, RpcError, peer_digest
from rtgen.runtime.opaque_rpc.digest import DIGEST
from rtgen.runtime.opaque_rpc.tdr import SOP_REPLY, SOP_REQUEST, Tdr
from rtgen.tools.conformance.board.arguments import (
    MAX_LENGTH,
    Values,
    arguments,
    ends,
    exceeds,
    lengths,
    longest,
    scalars,
)
from rtgen.tools.conformance.board.board import MAX_ID, BoardUnderTest
from rtgen.tools.conformance.check import ACTUATE, Problems, SkipError, check
from rtgen.tools.rpc.codecs import Function
from rtgen.tools.rpc.values import Json

_CALLS: Final = 100
_CONNECTIONS: Final = 5
_LENGTH: Final = "i"
"""The type of the length of a text."""
_WIRE: Final = "OpaqueRPC as tecsgen 1.7.0 has it"


def _request(function: Function, values: Json) -> bytes:
    return function.encode_request(function.arguments_from_json(values))


def _simplest(board: BoardUnderTest) -> Function:
    """Return the function with the fewest arguments that has a reply. Raises SkipError."""
    two_way = [f for f in board.functions.values() if not f.oneway]
    if not two_way:
        raise SkipError("all functions are oneway")
    return min(two_way, key=lambda f: len(f.layout.arguments))


def _refused(board: BoardUnderTest, octets: bytes, what: str) -> str | None:
    """Return the problem unless a request is rejected: no reply, connection closed."""
    answer = board.raw([octets], count=1)
    return None if answer.closed and not answer.data else f"{what}: {answer}"


@check("connections", "connections are served, one after another", _WIRE)
def connections(board: BoardUnderTest) -> Problems:
    for number in range(1, _CONNECTIONS + 1):
        yield _refused(board, board.unknown_request, f"connection {number}")


@check("digest", "the board was made from this signature", "docs/opaque-rpc.md")
def digest(board: BoardUnderTest) -> Problems:
    """Check that the board has the digest of this signature."""
    channel, codec = board.channel(), board.service.codec
    try:
        reported = peer_digest(channel, codec)
    except ChannelError:
        raise SkipError(
            "the board does not report the digest of its signature"
        ) from None
    finally:
        channel.close()
    same = reported == codec.digest
    yield None if same else f"the digest is {reported}, that of the CDL {codec.digest}"


@check("request.start", "a request with a wrong start is refused", _WIRE)
def wrong_starts(board: BoardUnderTest) -> Problems:
    """Check that a request with an invalid start is rejected."""
    tdr = board.service.codec.tdr
    start, identifier = tdr.int16(SOP_REQUEST), tdr.int16(MAX_ID - 1)
    for wrong in (
        b"\0\0",
        bytes((start[0] ^ 1, start[1])),
        bytes((start[0], start[1] ^ 1)),
        tdr.int16(SOP_REPLY),
    ):
        yield _refused(board, wrong + identifier, f"start {wrong.hex(' ')}")


@check("function.unknown", "unknown functions are refused", _WIRE)
def unknown_functions(board: BoardUnderTest) -> Problems:
    """Check that a function outside of the signature is rejected."""
    codec = board.service.codec
    ids = [f.layout.function.id for f in board.service.functions.values()]
    for number in (0, max(ids, default=0) + 1, MAX_ID - 1, 0xFFFF):
        if number in ids or number == DIGEST:
            continue
        request = codec.request_head(number) + codec.awaiting_reply
        yield _refused(board, request, f"function {number}")


@check(
    "request.cut",
    "a client that disconnects within a request does not block others",
    _WIRE,
)
def cut_requests(board: BoardUnderTest) -> Problems:
    """Check that other clients are served after one disconnects within a request."""
    for function in board.functions.values():
        request = _request(function, arguments(function, Values()))
        # Without its last octet, a request calls nothing.
        for size in sorted({1, 2, 3, 4, len(request) // 2, len(request) - 1}):
            board.leave(request[:size])
            yield _refused(
                board, board.unknown_request, f"after {size} octets of {function.name}"
            )


@check(
    "request.stalled", "a client that stalls within a request is disconnected", _WIRE
)
def stalled_requests(board: BoardUnderTest) -> Problems:
    """Check that a client that falls silent within a request is disconnected in time."""
    if board.stall is None:
        raise SkipError("no bound is stated: --stall")
    for function in board.functions.values():
        request = _request(function, arguments(function, Values()))
        what = f"a client silent within {function.name}"
        with board.stalled(request[:-1]):
            answer = board.raw([board.unknown_request], count=1, within=board.stall)
        served = answer.closed and not answer.data
        yield None if served else f"{what}: another client is not served in time"


@check("call.reply", "each function answers as declared", _WIRE, ACTUATE)
def answers(board: BoardUnderTest) -> Problems:
    """Check that each function replies in its form, without further octets."""
    for function in board.functions.values():
        values = arguments(function, Values())
        problem = board.problem(function, values, "zeros")
        if problem is None and board.address is not None and not function.oneway:
            problem = _surplus(board, function, values)
        yield problem


def _surplus(board: BoardUnderTest, function: Function, request: Json) -> str | None:
    values = function.arguments_from_json(request)
    reply = board.raw([function.encode_request(values)])
    if wrong := _wrong_reply(function, values, reply.data):
        return f"{function.name}: {wrong}"
    return None if not reply.closed else f"{function.name}: the connection is closed"


@check(
    "call.limits", "numbers are accepted at both limits of their types", _WIRE, ACTUATE
)
def limits(board: BoardUnderTest) -> Problems:
    for function in board.functions.values():
        for name, scalar in scalars(function):
            for end in ends(scalar, board.service.codec.tdr):
                values = arguments(function, Values(), {name: end})
                yield board.problem(function, values, f"{name} = {end}")
        if any(not isinstance(i.node, Basic) for i in function.layout.arguments):
            yield from _inner_limits(board, function)


def _inner_limits(board: BoardUnderTest, function: Function) -> Problems:
    """Check that numbers in arrays and structs are accepted at both limits."""
    tdr = board.service.codec.tdr
    for end, what in enumerate(("lowest", "highest")):

        def number(scalar: Scalar, end: int = end) -> Json:
            return ends(scalar, tdr)[end]

        values = Values(number=number, length=min(1, longest(function) or 0))
        yield board.problem(function, arguments(function, values), f"{what} numbers")


def _with_arrays(board: BoardUnderTest) -> Iterator[tuple[Function, int]]:
    for function in board.functions.values():
        most = longest(function)
        if most is not None:
            yield function, most


@check("call.arrays", "arrays are accepted empty and full", _WIRE, ACTUATE)
def arrays(board: BoardUnderTest) -> Problems:
    """Check that arrays are accepted with no element, with one, and with the maximum number."""
    for function, most in _with_arrays(board):
        for length in sorted({0, min(1, most), most}):
            try:
                values = arguments(function, Values(length=length))
            except ArgumentError:
                continue
            yield board.problem(function, values, f"arrays of length {length}")


@check(
    "call.long-arrays",
    "arrays beyond their bound, and negative lengths, are refused",
    _WIRE,
    ACTUATE,
)
def long_arrays(board: BoardUnderTest) -> Problems:
    """Check that arrays beyond the bound of the signature, and negative lengths, are rejected."""
    for function, most in _with_arrays(board):
        for length in (most + 1, -1):
            if exceeds(function, length):
                request = _with_length(function, board.service.codec.tdr, most, length)
                if request is not None:
                    what = f"{function.name}, arrays of length {length}"
                    yield _refused(board, request, what)


def _with_length(function: Function, tdr: Tdr, most: int, length: int) -> bytes | None:
    """Return a request with another length of its arrays; None if it cannot have that length.

    Lengths come first (spec of the wire, "referenced" parameters), and are overwritten.
    """
    request = bytearray(_request(function, arguments(function, Values(length=most))))
    run = function.layout.request[0]
    missing, offset = set(lengths(function)), 0
    for field in run.fields if isinstance(run, Run) else ():
        form = tdr.struct("".join(text * times for text, times in field.kinds))
        name = field.item.name if field.item is not None else ""
        if name in missing and field.role is Role.VALUE:
            missing.remove(name)
            try:
                form.pack_into(request, offset, length)
            except struct.error:
                return None
        offset += form.size
    return None if missing else bytes(request)


@check("call.texts", "texts are accepted empty and full", _WIRE, ACTUATE)
def texts(board: BoardUnderTest) -> Problems:
    """Check that texts are accepted if empty, and if as long as their buffers."""
    for function in board.functions.values():
        if not any(
            i.inward and isinstance(i.node, String) for i in function.layout.items
        ):
            continue
        length = longest(function) or 0
        for full in (False, True):
            values = arguments(function, Values(full=full, length=length))
            yield board.problem(
                function, values, "texts full" if full else "texts empty"
            )


@check("call.long-texts", "texts beyond their buffer are refused", _WIRE, ACTUATE)
def long_texts(board: BoardUnderTest) -> Problems:
    """Check that a text of one unit more than its buffer is rejected."""
    length = board.service.codec.tdr.struct(_LENGTH)
    for function in board.functions.values():
        for item in function.layout.items:
            most = _text_size(function, item)
            if most is None:
                continue
            values = arguments(function, Values(), {item.name: most * "x"})
            whole = length.pack(most) + most * b"x"
            longer = length.pack(most + 1) + (most + 1) * b"x"
            request = _request(function, values).replace(whole, longer)
            what = f"{function.name}, {item.name} of {most + 1} units"
            yield _refused(board, request, what)


def _text_size(function: Function, item: Item) -> int | None:
    """Return the constant size of a parameter that is a text of octets; None for others."""
    node = item.node
    if not isinstance(node, String) or not item.inward or node.is_wide:
        return None
    if node.length is None or any(references(node.length)):
        return None
    size = function.evaluated(node.length, {})
    return size if size <= MAX_LENGTH else None


@check(
    "request.recovery",
    "calls are answered after requests that were refused",
    _WIRE,
    ACTUATE,
)
def recovery(board: BoardUnderTest) -> Problems:
    """Check that a valid call is answered after each kind of request that is rejected."""
    function = _simplest(board)
    values = arguments(function, Values())
    request = _request(function, values)
    start = board.service.codec.tdr.int16(SOP_REQUEST)
    for octets, what in (
        (b"\0\0" + request[2:], "a wrong start"),
        (board.unknown_request, "an unknown function"),
        (request[:-2] + b"\0\0", "a wrong end"),
        (start, "a request that was cut"),
    ):
        if octets is start:
            board.leave(octets)
        else:
            board.raw([octets], count=1)
        yield board.problem(function, values, f"after {what}")


@check("call.null", "nullable parameters accept NULL", _WIRE, ACTUATE)
def nulls(board: BoardUnderTest) -> Problems:
    """Check that nullable parameters are accepted as NULL."""
    for function in board.functions.values():
        if any(item.nullable for item in function.layout.arguments):
            values = arguments(function, Values(null=True))
            yield board.problem(function, values, "NULL")


@check("request.end", "a request with a wrong end is refused", _WIRE, ACTUATE)
def wrong_ends(board: BoardUnderTest) -> Problems:
    """Check that a request with an invalid end is rejected."""
    codec = board.service.codec
    for function in board.functions.values():
        request = _request(function, arguments(function, Values()))
        other = codec.awaiting_reply if function.oneway else codec.nothing_follows
        for end in (b"\0\0", other):
            what = f"{function.name}, end {end.hex(' ')}"
            yield _refused(board, request[: -len(end)] + end, what)


@check("request.segments", "requests are accepted in pieces", _WIRE, ACTUATE)
def segments(board: BoardUnderTest) -> Problems:
    """Check that a request in pieces is accepted, and two requests in one piece."""
    function = _simplest(board)
    request = _request(function, arguments(function, Values()))
    whole = board.raw([request])
    size = len(whole.data)
    for pieces in ([request[:1], request[1:2], request[2:4], request[4:]],):
        answer = board.raw(pieces, count=size)
        same = len(answer.data) == size
        yield None if same else f"{function.name} in {len(pieces)} pieces: {answer}"
    answer = board.raw([request + request], count=2 * size)
    both = size > 0 and len(answer.data) == 2 * size
    yield None if both else f"{function.name}, two requests in one piece: {answer}"


@check("call.order", "requests in one piece are answered in order", _WIRE, ACTUATE)
def order(board: BoardUnderTest) -> Problems:
    """Check that requests of several functions in one piece are answered in their order.

    Replies do not name their functions; they are identified by their ascending lengths.
    """
    problems = []
    for function in board.functions.values():
        if not function.oneway:
            values = function.arguments_from_json(arguments(function, Values()))
            request = function.encode_request(values)
            lengths = {_reply_length(board, function, values) for _ in range(2)}
            if len(lengths) == 1 and (length := lengths.pop()):
                problems.append((length, function, values, request))
    problems.sort(key=lambda each: each[0])
    if len({length for length, *_ in problems}) < 2:
        raise SkipError("no two functions have replies of different, fixed lengths")
    together = b"".join(request for *_, request in problems)
    replies = board.raw([together], count=sum(length for length, *_ in problems)).data
    for length, function, values, _ in problems:
        reply, replies = replies[:length], replies[length:]
        wrong = _wrong_reply(function, values, reply)
        yield f"{function.name} is not answered in its turn: {wrong}" if wrong else None


def _reply_length(
    board: BoardUnderTest, function: Function, values: tuple[object, ...]
) -> int:
    """Return the length of the reply to one request; 0 if it is not a reply of this function."""
    reply = board.raw([function.encode_request(values)]).data
    return 0 if _wrong_reply(function, values, reply) else len(reply)


def _wrong_reply(
    function: Function, values: tuple[object, ...], reply: bytes
) -> str | None:
    try:
        function.decode_reply(reply, function.kept(values))
    except RpcError as error:
        return str(error)
    return None


@check("call.oneway", "oneway calls have no answer", _WIRE, ACTUATE)
def oneway(board: BoardUnderTest) -> Problems:
    """Check that a oneway call has no reply, and the next call has its own."""
    for function in board.functions.values():
        if function.oneway:
            values = arguments(function, Values())
            if board.address is not None:
                answer = board.silent(_request(function, values))
                silent = not answer.data and not answer.closed
                yield None if silent else f"{function.name}: {answer}"
            yield _answered_after(board, function, values)


def _answered_after(
    board: BoardUnderTest, oneway_function: Function, request: Json
) -> str | None:
    """Return a problem unless a call is answered after a oneway call of its connection."""
    function = _simplest(board)
    channel = board.channel()
    try:
        oneway_function.call(channel, oneway_function.arguments_from_json(request))
        values = arguments(function, Values())
        function.call(channel, function.arguments_from_json(values))
    except RpcError as error:
        return f"{function.name} after {oneway_function.name}: {error}"
    finally:
        channel.close()
    return None


@check("call.repeated", "calls are answered one after another", _WIRE, ACTUATE)
def repeated(board: BoardUnderTest) -> Problems:
    """Check that calls over one connection are answered in order, each in time."""
    function = _simplest(board)
    values = function.arguments_from_json(arguments(function, Values()))
    channel = board.channel()
    try:
        for _ in range(_CALLS):
            function.call(channel, values)
            yield None
    finally:
        channel.close()


CHECKS: Final = (
    connections,
    digest,
    wrong_starts,
    unknown_functions,
    cut_requests,
    stalled_requests,
    wrong_ends,
    recovery,
    segments,
    order,
    answers,
    limits,
    arrays,
    long_arrays,
    texts,
    long_texts,
    nulls,
    oneway,
    repeated,
)
