"""The methods of proxies: a function of CDL as a call of a channel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.backends.tecs.service_text import Method, ServiceText, returning
from rtgen.layouts.tdr import FunctionLayout, Item
from rtgen.layouts.tdr_messages import is_error_code
from rtgen.typemap.tecs_python import zero


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


def _two_way(
    layout: FunctionLayout, request: str, names: dict[str, str]
) -> Iterator[str]:
    method = layout.function.name
    arguments = [
        "self.channel",
        "request",
        f"codec.{method}_first",
        f"codec.read_{method}_reply",
        *(names[item.name] for item in layout.kept),
    ]
    call = f"call({', '.join(arguments)})"
    outs = layout.outs
    yield "codec = self.codec"
    yield f"request = {request}"
    if not is_error_code(layout.function.returns):
        yield call if layout.is_void and not outs else f"reply = {call}"
        if outs and layout.is_void:
            yield "return reply[1]" if len(outs) > 1 else "return reply[1][0]"
        elif outs:
            yield "returned, outs = reply"
            yield "return returned, *outs"
        elif not layout.is_void:
            yield "return reply[0]"
        return
    failed = [_unset(item, names) for item in outs]
    yield "try:"
    yield f"    reply = {call}"
    yield "except RpcError as error:"
    yield "    " + returning(["error.code", *failed], 12)
    if outs:
        yield "returned, outs = reply"
        yield "if outs is None:"
        yield "    " + returning(["returned", *failed], 12)
        yield "return returned, *outs"
    else:
        yield "return reply[0]"


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
        used.add("call" if layout.reply is not None else "send")
        oneway_code = layout.reply is None and not layout.is_void
        if oneway_code:
            used.add("E_OK")
        if oneway_code or (
            layout.reply is not None and is_error_code(layout.function.returns)
        ):
            used.add("RpcError")
    return used
