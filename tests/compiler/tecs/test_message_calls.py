"""Calls in one process: results, failures and broken streams for callers and servers."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import pytest

from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.model.tecs import Signature
from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_ID,
    E_MAGIC,
    E_NOMEM,
    E_TMOUT,
    ArgumentError,
    ChannelError,
    Codec,
    ExchangeChannel,
    PacketServer,
    ProtocolError,
    SharedUnmarshaller,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.channel import Handlers
from rtgen.runtime.opaque_rpc.messages import (
    Dispatcher,
    MessageReader,
    PacketReader,
    serve,
    serve_message,
)
from rtgen.tools.rpc.codecs import Service

SIGNATURE = """signature sCalls {
  ER code([in] int32_t v);
  ER code_out([in] int32_t v, [out] int16_t *a);
  ER fill([out,size_is(n)] uint8_t *data, [in] int8_t n);
  ER move([inout] int16_t *a, [out] int8_t *b);
  int32_t twice([in] int32_t v);
  int32_t both([in] int32_t v, [out] int16_t *a);
  void nothing(void);
  void read([out] int16_t *a);
  void pair([out] int16_t *a, [out] int8_t *b);
  int32_t some([out,size_is(n)] uint8_t *data, [in] int8_t n);
  [oneway] void note([in] int32_t v);
  [oneway] ER hint([in] int32_t v);
  ER pay([in] int32_t v, [in] int32_t w);
  void load([out,size_is(n)] uint8_t *data, [in] int8_t n);
};"""


class Target:
    def __init__(self) -> None:
        self.seen: list[Any] = []

    def code(self, v: int) -> int:
        return v

    def code_out(self, v: int) -> tuple[int, int]:
        return v, 7

    def fill(self, n: int) -> tuple[int, bytes]:
        return 0, bytes(range(n))

    def move(self, a: int) -> tuple[int, int, int]:
        return 0, a + 1, 5

    def twice(self, v: int) -> int:
        return 2 * v

    def both(self, v: int) -> tuple[int, int]:
        return v, v + 1

    def nothing(self) -> None:
        self.seen.append("nothing")

    def read(self) -> int:
        return 3

    def pair(self) -> tuple[int, int]:
        return 3, 4

    def some(self, n: int) -> tuple[int, bytes]:
        return n, b"x" * n

    def note(self, v: int) -> None:
        self.seen.append(v)

    def hint(self, v: int) -> None:
        self.seen.append(v)

    def pay(self, v: int, w: int) -> int:
        return v + w

    def load(self, n: int) -> bytes:
        return b"y" * n


def codec() -> Codec:
    """Return a new codec: a cached one would hide mutants of its construction."""
    unit, _ = read_text(SIGNATURE, "calls.cdl")
    signature = next(d for d in unit.declarations if isinstance(d, Signature))
    return Service(unit, signature, make_tdr()).codec


def call(name: str) -> Callable[..., Any]:
    return next(f.call for f in codec().functions.values() if f.name == name)


def test_results_have_the_form_of_the_signature() -> None:
    target = Target()
    channel = ExchangeChannel(PacketServer(Dispatcher(target, codec())))
    assert call("code")(channel, -17) == -17
    assert call("code_out")(channel, 0) == (0, 7)
    assert call("fill")(channel, 3) == (0, b"\0\1\2")
    assert call("move")(channel, 8) == (0, 9, 5)
    assert call("twice")(channel, 21) == 42
    assert call("both")(channel, 1) == (1, 2)
    assert call("nothing")(channel) is None
    assert call("read")(channel) == 3
    assert call("pair")(channel) == (3, 4)
    assert call("some")(channel, 2) == (2, b"xx")
    assert call("load")(channel, 3) == b"yyy"
    assert call("note")(channel, 5) is None
    assert call("hint")(channel, 6) == 0
    assert target.seen == ["nothing", 5, 6]


def test_a_target_has_to_have_each_function() -> None:
    class Part(Target):
        pair: Any = None
        twice: Any = 5

    with pytest.raises(TypeError, match=r"^Part does not define twice, pair$"):
        Dispatcher(Part(), codec())
    with pytest.raises(TypeError, match=r"^object does not define code, code_out, "):
        Dispatcher(object(), codec())
    made = Dispatcher(target := Target(), used := codec())
    assert (made.target, made.codec) == (target, used)


class Scripted:
    """A channel that replies with given octets, and records its use."""

    def __init__(self, reply: bytes = b"", fails: bool = False) -> None:
        self.reply = reply
        self.fails = fails
        self.done: list[str | bytes] = []

    def __str__(self) -> str:
        return "line 7"

    def begin(self, request: bytes, first: int) -> bytes:
        self.done.append(request)
        if self.fails:
            raise ChannelError(E_TMOUT, "no reply")
        return self.more(first)

    def more(self, n: int) -> bytes:
        if len(self.reply) < n:
            raise ChannelError(E_BOVR, "the reply ended")
        data, self.reply = self.reply[:n], self.reply[n:]
        return data

    def end(self) -> None:
        self.done.append("end")

    def reset(self) -> None:
        self.done.append("reset")


REPLY = bytes.fromhex("561e 00000000 0007 6d5e")
TIMEOUT_CODE = ChannelError(E_TMOUT, "").code


def test_a_call_ends_with_its_reply() -> None:
    channel = Scripted(REPLY)
    assert call("code_out")(channel, 1) == (0, 7)
    request = bytes.fromhex("672a 0002 00000001 5a3c")
    assert channel.done == [request, "end"]
    channel = Scripted(bytes.fromhex("561e 00000004 6d5e"))
    assert call("twice")(channel, 2) == 4
    assert channel.done[1:] == ["end"]
    channel = Scripted()
    call("note")(channel, 2)
    call("hint")(channel, 2)
    assert channel.done[1::2] == ["end", "end"]
    assert codec().functions["hint"].first == 0, "oneway: no reply is waited for"


@pytest.mark.parametrize(
    ("name", "arguments", "outs"),
    [("code_out", (1,), (0,)), ("fill", (2,), (b"",)), ("move", (9,), (9, 0))],
)
def test_a_call_that_fails_returns_its_code_and_logs_why(
    name: str,
    arguments: tuple[int, ...],
    outs: tuple[Any, ...],
    caplog: pytest.LogCaptureFixture,
) -> None:
    channel = Scripted(fails=True)
    assert call(name)(channel, *arguments) == (TIMEOUT_CODE, *outs)
    assert len(channel.done) == 1, "a channel whose begin failed is free"
    (record,) = caplog.records
    assert record.name == "rtgen.runtime.opaque_rpc"
    assert record.levelno == logging.WARNING
    said = record.getMessage()
    assert said.startswith(f"sCalls.{name} at line 7: ")
    assert said.endswith("no reply (E_TMOUT)")


def test_a_wrong_reply_resets_the_channel() -> None:
    channel = Scripted(b"\0\0" + REPLY[2:])
    assert call("code_out")(channel, 1) == (ProtocolError(E_MAGIC, "").code, 0)
    assert channel.done[1:] == ["reset"]
    channel = Scripted(bytes.fromhex("561e 00000004 6d5f"))
    with pytest.raises(
        ProtocolError, match=r"sCalls\.twice: EOP is 6d 5f, expected 6d 5e"
    ) as caught:
        call("twice")(channel, 2)
    assert caught.value.sub == E_MAGIC
    assert channel.done[1:] == ["reset"]
    channel = Scripted(bytes.fromhex("561e 00000001 61 6d5f"))
    with pytest.raises(
        ProtocolError, match=r"sCalls\.some: EOP is 6d 5f, expected 6d 5e"
    ):
        call("some")(channel, 1)


def test_a_oneway_call_that_fails(caplog: pytest.LogCaptureFixture) -> None:
    assert call("hint")(Scripted(fails=True), 1) == TIMEOUT_CODE
    assert caplog.messages == ["sCalls.hint at line 7: no reply (E_TMOUT)"]
    with pytest.raises(ChannelError, match="no reply"):
        call("note")(Scripted(fails=True), 1)


def test_values_that_cannot_be_sent_are_named() -> None:
    channel = Scripted()
    text = "a" * 100
    with pytest.raises(ArgumentError) as caught:
        call("code")(channel, text)
    said = str(caught.value)
    assert said.startswith(f"sCalls.code(v='{'a' * 56}...): ")
    assert not said.endswith(": None")
    assert "out of range" not in said
    with pytest.raises(ArgumentError, match=r"^sCalls\.pay\(v=1, w='x'\): "):
        call("pay")(channel, 1, "x")
    for length, shown in ((58, f"'{'a' * 58}'"), (59, f"'{'a' * 56}...")):
        with pytest.raises(ArgumentError) as caught:
            call("code")(channel, "a" * length)
        assert str(caught.value).startswith(f"sCalls.code(v={shown}): ")
    with pytest.raises(ArgumentError, match=r"^sCalls\.fill\(n=300\): 300 is out of"):
        call("fill")(channel, 300)
    assert channel.done == []


class Stream(MessageReader):
    """Requests in pieces, as they arrive."""

    def __init__(self, *pieces: bytes, limit: int | None = None) -> None:
        super().__init__(limit)
        self._pieces = list(pieces)

    def _wait(self) -> bytes:
        return self._receive(1)

    def _receive(self, size: int) -> bytes:
        return self._pieces.pop(0) if self._pieces else b""


def echo(size: int) -> Handlers:
    """Return handlers of one function that returns all octets of its request but the last two."""
    return {b"abcd": lambda more: b"<" + more(size)[:-2] + more(1) + b">"}


MESSAGE = b"abcd0123456789-"
ECHOED = b"<01234567->"


@pytest.mark.parametrize("size", range(1, 3 * len(MESSAGE)))
def test_requests_arrive_in_any_pieces(size: int) -> None:
    data = 3 * MESSAGE
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    sent: list[bytes] = []
    Stream(*pieces).serve(echo(10), sent.append)
    assert sent == 3 * [ECHOED]
    sent.clear()
    Stream(*pieces, limit=len(MESSAGE)).serve(echo(10), sent.append)
    assert sent == 3 * [ECHOED], "each request may have the limit"


@pytest.mark.parametrize("size", [1, 4, 5, 14, 15, 30])
def test_a_request_over_the_limit_is_refused(size: int) -> None:
    data = 2 * MESSAGE
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    for limit in (8, len(MESSAGE) - 1):
        reader = Stream(*pieces, limit=limit)
        with pytest.raises(
            ProtocolError, match=rf"larger than {limit} bytes \(PPAllocatorSize\)"
        ) as caught:
            serve_message(reader, echo(10))
        assert caught.value.sub == E_NOMEM

    class OnlyEcho:
        handlers = echo(10)

    assert PacketServer(OnlyEcho(), len(MESSAGE))(MESSAGE) == ECHOED
    with pytest.raises(ChannelError, match=r"^the server closed the connection "):
        PacketServer(OnlyEcho(), len(MESSAGE) - 1)(MESSAGE)
    assert serve_message(PacketReader(MESSAGE, len(MESSAGE)), echo(10)) == ECHOED
    with pytest.raises(ProtocolError):
        serve_message(PacketReader(MESSAGE, len(MESSAGE) - 1), echo(10))


@pytest.mark.parametrize(
    ("data", "error", "code", "reason"),
    [
        (
            MESSAGE[:-1],
            ChannelError,
            E_BOVR,
            "the stream ended inside a request (E_BOVR)",
        ),
        (b"ab", ChannelError, E_BOVR, "the stream ended inside a request (E_BOVR)"),
        (b"abce01", ProtocolError, E_ID, "unknown function id: 63 65 (E_ID)"),
        (b"b", ProtocolError, E_MAGIC, "no start of a request: 62 (E_MAGIC)"),
        (
            b"aabc",
            ProtocolError,
            E_MAGIC,
            "no start of a request: 61 61 62 63 (E_MAGIC)",
        ),
    ],
)
def test_broken_requests_say_why(
    data: bytes,
    error: type[ChannelError] | type[ProtocolError],
    code: int,
    reason: str,
    caplog: pytest.LogCaptureFixture,
) -> None:
    with pytest.raises(error) as caught:
        serve_message(PacketReader(data), echo(10))
    assert caught.value.sub == code
    assert str(caught.value).endswith(reason)

    class OnlyEcho:
        handlers = echo(10)

    assert not serve(OnlyEcho(), PacketReader(data), [].append, "board 3")
    (said,) = caplog.messages
    assert said.startswith("connection with board 3 given up: ")
    assert said.endswith(reason)
    with pytest.raises(
        ChannelError, match="the server closed the connection"
    ) as closed:
        PacketServer(OnlyEcho())(data)
    assert closed.value.sub == E_BOVR
    assert caplog.messages[1].startswith("connection with a client given up: ")


def test_a_target_that_fails_leaves_the_call_without_reply(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Failing(Target):
        def twice(self, v: int) -> int:
            raise KeyError("no motor")

    failing = Dispatcher(Failing(), codec())
    channel = ExchangeChannel(PacketServer(failing))
    with pytest.raises(ChannelError):
        call("twice")(channel, 1)
    record = caplog.records[0]
    assert (record.name, record.levelno) == ("rtgen.runtime.opaque_rpc", logging.ERROR)
    wanted = "a call from a client failed and has no reply: KeyError: 'no motor'"
    assert record.getMessage() == wanted
    request = bytes.fromhex("672a 0005 00000001 5a3c")
    assert not serve(failing, PacketReader(request), [].append)
    assert record.exc_info is not None
    assert isinstance(record.exc_info[1], KeyError)

    class Stopped(Target):
        def twice(self, v: int) -> int:
            raise KeyboardInterrupt

    channel = ExchangeChannel(PacketServer(Dispatcher(Stopped(), codec())))
    with pytest.raises(KeyboardInterrupt):
        call("twice")(channel, 1)


@pytest.mark.parametrize("order", ["little", "big"])
def test_a_shared_connection_goes_on_behind_what_is_no_exchange(
    order: Any, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)

    class First:
        handlers = echo(3)

    class Second:
        handlers = echo(10)

    def number(value: int) -> bytes:
        return (value & 0xFFFF).to_bytes(2, order)

    begin, end = number(0x3141), number(0x2718)
    shared = SharedUnmarshaller([First(), Second()], order)
    assert shared.starts == {begin}
    whole = begin + number(1) + MESSAGE + end
    for bad, reason in (
        (number(0x1234), "0x1234 in place of 0x3141 of a shared channel (E_MAGIC)"),
        (begin + number(2), "unknown sub-channel 2 (E_ID)"),
        (begin + number(-1), "unknown sub-channel -1 (E_ID)"),
        (begin + number(1) + b"abce", "unknown function id: 63 65 (E_ID)"),
        (whole[:-2] + begin, "0x3141 in place of 0x2718 of a shared channel (E_MAGIC)"),
    ):
        caplog.clear()
        sent: list[bytes] = []
        assert serve(shared, PacketReader(bad + whole), sent.append)
        assert sent[-1:] == [ECHOED]
        (said,) = caplog.messages
        assert said.startswith("ignored: ")
        assert said.endswith(reason)
