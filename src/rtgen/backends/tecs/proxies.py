"""The methods of proxies: a function of CDL as a call of a channel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.backends.rendering import render
from rtgen.backends.tecs.service_text import Method, ServiceText, returning
from rtgen.layouts.tdr import FunctionLayout, Item
from rtgen.layouts.tdr_messages import is_error_code
from rtgen.typemap.tecs_python import zero


def proxy_class(text: ServiceText) -> str:
    """The class `<Name>Proxy`, which calls the functions of a board."""
    return render(
        "tecs/proxy.py.j2",
        proxy=f"{text.name}Proxy",
        codec=text.codec,
        make_codec=text.make_codec,
        signature=text.signature,
        functions=[proxy_method(text, layout) for layout in text.layout.functions],
    )


def proxy_method(text: ServiceText, layout: FunctionLayout) -> Method:
    """The method that sends the request of a function and reads its reply."""
    names = text.parameters(layout)
    codec = "self.codec" if layout.reply is None else "codec"
    arguments = ", ".join(names[item.name] for item in layout.arguments)
    request = f"{codec}.encode_{layout.function.name}_request({arguments})"
    body = (
        _oneway(layout, request)
        if layout.reply is None
        else _two_way(layout, request, names)
    )
    return text.method(layout, list(body))


def _exchange(layout: FunctionLayout, names: dict[str, str]) -> Iterator[str]:
    """Sends the request and reads its reply; spelled out, since it is faster than a function."""
    method = layout.function.name
    given = ["head", "channel.more", *(names[item.name] for item in layout.kept)]
    read = f"codec.read_{method}_reply({', '.join(given)})"
    if layout.outs:
        result = "_, outs = " if layout.is_void else "returned, outs = "
    else:
        result = "" if layout.is_void else "returned, _ = "
    yield f"head = channel.begin(request, codec.{method}_first)"
    yield "try:"
    yield f"    {result}{read}"
    yield "except BaseException:"
    yield "    channel.reset()"
    yield "    raise"
    yield "channel.end()"


def _two_way(
    layout: FunctionLayout, request: str, names: dict[str, str]
) -> Iterator[str]:
    outs = layout.outs
    exchange = _exchange(layout, names)
    yield "codec = self.codec"
    yield "channel = self.channel"
    yield f"request = {request}"
    if not is_error_code(layout.function.returns):
        yield from exchange
        if outs and layout.is_void:
            yield "return outs" if len(outs) > 1 else "return outs[0]"
        elif outs:
            yield "return returned, *outs"
        elif not layout.is_void:
            yield "return returned"
        return
    failed = [_unset(item, names) for item in outs]
    yield "try:"
    yield from (f"    {line}" for line in exchange)
    yield "except RpcError as error:"
    yield "    " + returning(["error.code", *failed], 12)
    if outs:
        yield "if outs is None:"
        yield "    " + returning(["returned", *failed], 12)
        yield "return returned, *outs"
    else:
        yield "return returned"


def _oneway(layout: FunctionLayout, request: str) -> Iterator[str]:
    yield f"request = {request}"
    if layout.is_void:
        yield "send(self.channel, request)"
        return
    yield "try:"
    yield "    send(self.channel, request)"
    yield "except RpcError as error:"
    yield "    return error.code"
    yield "return E_OK"


def _unset(item: Item, names: dict[str, str]) -> str:
    """What a parameter is handed back as when the call failed."""
    if item.inward:
        return names[item.name]
    return "None" if item.nullable else zero(item.node)


def names_used(layouts: Iterable[FunctionLayout]) -> set[str]:
    """What the methods use of `rtgen.runtime.opaque_rpc`."""
    used = set()
    for layout in layouts:
        if layout.reply is None:
            used.add("send")
        oneway_code = layout.reply is None and not layout.is_void
        if oneway_code:
            used.add("E_OK")
        if oneway_code or (
            layout.reply is not None and is_error_code(layout.function.returns)
        ):
            used.add("RpcError")
    return used
