"""Decodes calls to TECS boards: function and values from the octets of a communication RTC."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, Final

import msgspec

from rtgen.runtime.opaque_rpc.codecs import Codec, Messages
from rtgen.runtime.opaque_rpc.errors import RpcError
from rtgen.runtime.opaque_rpc.messages import HEAD, PacketReader
from rtgen.runtime.opaque_rpc.proxy import ProxyServant
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import BoardCall
from rtgen.ui.protocol import ui

_RETURN: Final = "return"
_MAX_ITEMS: Final = 16
_MAX_TEXT_LENGTH: Final = 200
"""Maximum length of a value's text."""


class Codecs:
    """The codecs of the marshallers that are connected to communication RTCs, by those."""

    def __init__(self, codec_of: Callable[[str], Codec | None]) -> None:
        """`codec_of` returns the codec of an instance; None if it is not a marshaller."""
        self._codec_of = codec_of
        self._codecs: dict[str, Codec | None] = {}

    def of(self, communication: str, joined: Iterable[Collection[str]]) -> Codec | None:
        """Return the codec; `joined` are the instances of connections, as long as it is unknown."""
        if communication not in self._codecs:
            others = (
                each
                for pair in joined
                if communication in pair
                for each in pair
                if each != communication
            )
            codec = next(filter(None, map(self._codec_of, others)), None)
            self._codecs[communication] = codec
        return self._codecs[communication]

    def forget(self) -> None:
        """Look for all of them again: connections have changed."""
        self._codecs.clear()


def codec_of(component: Component) -> Codec | None:
    """Return the codec of a marshaller RTC; None for another component."""
    for provider in component.providers.values():
        if isinstance(provider.servant, ProxyServant):
            return provider.servant.codec
    return None


def is_marshaller(factory: object) -> bool:
    """Return whether a factory is the class of a generated marshaller RTC."""
    module = sys.modules.get(getattr(factory, "__module__", ""))
    return isinstance(factory, type) and any(
        isinstance(each, type)
        and issubclass(each, ProxyServant)
        and each.__module__ == factory.__module__
        for each in vars(module).values()
    )


def described_call(
    made: BoardCall, time: float, codec: Codec | None, round_trip: float | None = None
) -> ui.BoardCall:
    """Describe a call at a time [s], with function and values if its codec is known."""
    call = ui.BoardCall(
        time=time,
        instance=made.instance,
        request=made.request,
        reply=made.reply,
        round_trip=made.duration / SECOND if round_trip is None else round_trip,
        error=made.error,
    )
    if codec is not None:
        _describe(call, codec)
    return call


def _describe(call: ui.BoardCall, codec: Codec) -> None:
    """Add function and values to a call, if the codec can decode its octets."""
    packet = PacketReader(call.request)
    head = packet.head(HEAD)
    for function in codec.functions.values():
        if codec.request_head(function.id) == head:
            break
    else:
        return
    call.function = function.function
    try:
        arguments = function.read_request(packet.more)
        call.request_values = _values(_names(function.encode_request), arguments)
        if call.reply and not function.oneway:
            call.reply_values = _reply(function, call.reply, arguments)
    except RpcError as error:
        call.error = call.error or str(error)


def _reply(
    function: Messages[..., Any], octets: bytes, arguments: Sequence[object]
) -> list[ui.Value]:
    kept = [arguments[i] for i in function.kept]
    packet = PacketReader(octets)
    result, outs = function.read_reply(packet.head(function.first), packet.more, *kept)
    names = _names(function.encode_reply)[len(kept) :]
    if function.is_void:
        return _values(names, outs or ())
    return _values([_RETURN, *names[1:]], [result, *(outs or ())])


def _names(encoder: Any) -> Sequence[str]:
    """Return the names of the parameters of a method."""
    code = encoder.__func__.__code__
    names: Sequence[str] = code.co_varnames[1 : code.co_argcount]
    return names


def _values(names: Sequence[str], values: Sequence[object]) -> list[ui.Value]:
    return [
        ui.Value(name=name.strip("_"), text=_text(value)[:_MAX_TEXT_LENGTH])
        for name, value in zip(names, values, strict=False)
    ]


def _text(value: Any) -> str:
    if isinstance(value, msgspec.Struct):
        names = value.__struct_fields__
        members = (f"{name}: {_text(getattr(value, name))}" for name in names)
        return f"{{{', '.join(members)}}}"
    if isinstance(value, list | tuple):
        more = ", ..." if len(value) > _MAX_ITEMS else ""
        return f"[{', '.join(map(_text, value[:_MAX_ITEMS]))}{more}]"
    if isinstance(value, float):
        return f"{value:.7g}"
    if isinstance(value, bool):
        return str(value).lower()
    return "null" if value is None else str(value)
