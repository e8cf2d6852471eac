"""Base classes of generated codecs: a signature, and the messages and calls of its functions."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import cached_property
from typing import (
    Any,
    ClassVar,
    Concatenate,
    Final,
    Generic,
    Literal,
    ParamSpec,
    TypeAlias,
    TypeVar,
)

from rtgen.runtime.opaque_rpc.channel import Channel, Handler, More
from rtgen.runtime.opaque_rpc.errors import E_MAGIC, E_OK, ProtocolError, RpcError
from rtgen.runtime.opaque_rpc.tdr import (
    EOP_NOTHING_FOLLOWS,
    EOP_REPLY_FOLLOWS,
    NETWORK,
    SOP_REQUEST,
    Tdr,
)

ReplyOrder: TypeAlias = Literal["tecsgen", "paper"]
"""`tecsgen` sends the return value before the outs, `paper` after them."""

REQUEST_LIMIT: Final = 4096
"""Default limit of the octets of arrays and texts in a request, at a server."""

REPLY_LIMIT: Final = 1 << 24
"""Default limit of the octets of arrays and texts in a reply, at a client."""

log = logging.getLogger("rtgen.runtime.opaque_rpc")

_P = ParamSpec("_P")
_R = TypeVar("_R")


def _no_outs(*arguments: Any) -> tuple[()]:
    return ()


class Codec:
    """Base class of the codecs of a signature, for one TDR.

    A generated codec has an attribute for each function. `limit` is the maximum number of octets of
    arrays and texts in a request that is read, `reply_limit` in a reply. `encoding` is that of
    texts of 8-bit units.
    """

    signature: ClassVar[str]
    """The signature in CDL."""
    digest: ClassVar[str] = ""
    """The digest of the signature, also known to the board's half (docs/opaque-rpc.md)."""

    def __init__(
        self,
        tdr: Tdr = NETWORK,
        *,
        encoding: str = "latin-1",
        limit: int = REQUEST_LIMIT,
        reply_limit: int = REPLY_LIMIT,
    ) -> None:
        self.tdr: Final = tdr
        self.encoding: Final = encoding
        self.request_limit: Final = limit
        self.reply_limit: Final = reply_limit
        self.request_sop: Final = tdr.int16(SOP_REQUEST)
        self.awaiting_reply: Final = tdr.int16(EOP_REPLY_FOLLOWS)
        self.nothing_follows: Final = tdr.int16(EOP_NOTHING_FOLLOWS)

    @cached_property
    def functions(self) -> dict[str, Messages[..., Any]]:
        """The functions by attribute, which is also their method in proxy and target."""
        return {n: f for n, f in vars(self).items() if isinstance(f, Messages)}

    def request_head(self, number: int) -> bytes:
        """Return the first bytes of requests of the function with this id: SOP and id."""
        return self.request_sop + self.tdr.int16(number)


class Messages(Generic[_P, _R]):
    """The messages of a function with arguments `_P` and result `_R`, for one codec.

    `name` is the function's name in CDL, `number` its id. Class attributes describe the function:
    `kept` are the arguments (by index) that the reply depends on, `results` the number of results,
    `oneway` and `error_code` (the type is `ER` or `ER_INT`) as declared in CDL.
    """

    kept: ClassVar[tuple[int, ...]] = ()
    results: ClassVar[int] = 0
    is_void: ClassVar[bool] = False
    error_code: ClassVar[bool] = False
    oneway: ClassVar[bool] = False

    encode_request: Callable[..., bytes]
    read_request: Callable[[More], tuple[Any, ...]]
    encode_reply: Callable[..., bytes]
    read_reply: Callable[..., tuple[Any, tuple[Any, ...] | None]]
    first: int = 0

    unset: Callable[..., tuple[Any, ...]] = _no_outs
    """Returns the outs of a failed call, given its arguments: inouts unchanged, others zero."""

    call: Callable[Concatenate[Channel, _P], _R]
    """Call the function over a channel.

    A function of type `ER` or `ER_INT` returns the composite error code if the call fails, and logs
    the reason; others raise RpcError. Raises ArgumentError for a value that cannot be sent.
    """

    def __init__(self, codec: Codec, name: str, number: int) -> None:
        self.name = name
        self.id = number
        self.function = f"{codec.signature}.{name}"
        self.tdr = codec.tdr
        self.request_limit = codec.request_limit
        self.reply_limit = codec.reply_limit
        self.awaiting_reply = codec.awaiting_reply
        self.nothing_follows = codec.nothing_follows
        call: Any = self._call_code if self.error_code else self._call_value
        if self.oneway:
            call = self._send_code if self.error_code else self._send
        self.call = call

    def wrong_mark(
        self, mark: str, expected: int, actual: int | bytes
    ) -> ProtocolError:
        """Return the exception for a wrong start or end of a message.

        `mark` is `SOP` or `EOP`, `actual` the octets of the message there.
        """
        have = self.tdr.int16(actual) if isinstance(actual, int) else actual
        expected_octets = self.tdr.int16(expected).hex(" ")
        return ProtocolError(
            E_MAGIC,
            f"{self.function}: {mark} is {have.hex(' ')}, expected {expected_octets}",
        )

    def _send(self, channel: Channel, /, *arguments: Any) -> Any:
        channel.begin(self.encode_request(*arguments), 0)
        channel.end()

    def _send_code(self, channel: Channel, /, *arguments: Any) -> Any:
        request = self.encode_request(*arguments)
        try:
            channel.begin(request, 0)
            channel.end()
        except RpcError as error:
            return self._failed(error, channel)
        return E_OK

    def _kept_of(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the arguments that the reply depends on."""
        kept = self.kept
        if len(kept) == 1:
            return (arguments[kept[0]],)
        return tuple([arguments[index] for index in kept])

    # The exchange is written out twice, since another call would cost a tenth of its time.

    def _call_code(self, channel: Channel, /, *arguments: Any) -> Any:
        request = self.encode_request(*arguments)
        try:
            head = channel.begin(request, self.first)
            try:
                returned, outs = self.read_reply(
                    head, channel.more, *(self.kept and self._kept_of(arguments))
                )
            except BaseException:
                channel.reset()
                raise
            channel.end()
        except RpcError as error:
            returned, outs = self._failed(error, channel), None
        if self.results == 1:
            return returned
        return returned, *(self.unset(*arguments) if outs is None else outs)

    def _call_value(self, channel: Channel, /, *arguments: Any) -> Any:
        request = self.encode_request(*arguments)
        head = channel.begin(request, self.first)
        try:
            returned, outs = self.read_reply(
                head, channel.more, *(self.kept and self._kept_of(arguments))
            )
        except BaseException:
            channel.reset()
            raise
        channel.end()
        if not self.is_void:
            return (returned, *outs) if outs else returned
        if outs:
            return outs if len(outs) > 1 else outs[0]
        return None

    def results_of(self, channel: Channel, /, *arguments: Any) -> tuple[Any, ...]:
        """Call the function over a channel; return what it returned, then its outs.

        Outs are missing if it returned an error without them. Raises RpcError for each call that
        fails, also of a function of type `ER` or `ER_INT`; ArgumentError.
        """
        if self.oneway:
            self._send(channel, *arguments)
            return (E_OK,) if self.error_code else ()
        result = self._call_value(channel, *arguments)
        if not self.results:
            return ()
        return result if isinstance(result, tuple) and self.results > 1 else (result,)

    def _failed(self, error: RpcError, channel: Channel) -> int:
        """Return the error code; the reason is only logged."""
        log.warning("%s at %s: %s", self.function, channel, error)
        return error.code

    def handler(self, target: Callable[_P, _R]) -> Handler:
        """Return the handler that serves requests of the function by calling `target`."""
        read, kept, results = self.read_request, self.kept, self.results
        function: Callable[..., Any] = target

        def handle_oneway(more: More) -> None:
            function(*read(more))

        if self.oneway:
            return handle_oneway
        encode = self.encode_reply

        def handle_plain(more: More) -> bytes:
            return encode(function(*read(more)))

        def handle_several(more: More) -> bytes:
            return encode(*function(*read(more)))

        def handle(more: More) -> bytes:
            arguments = read(more)
            result = function(*arguments)
            values = (result,) if results == 1 else result or ()
            return encode(*self._kept_of(arguments), *values)

        if kept or results == 0:
            return handle
        return handle_plain if results == 1 else handle_several


class RecordCodec:
    """Base class for structs whose size depends on values."""

    def __init__(self, codec: Codec) -> None:
        self.tdr = codec.tdr
