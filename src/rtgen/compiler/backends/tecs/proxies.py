"""Proxies: the functions of CDL as calls over a channel."""

from __future__ import annotations

from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.service_text import ServiceText


def proxy_class(text: ServiceText) -> str:
    """Return the class `<Name>Proxy`, which calls the functions of a board."""
    return render(
        "tecs/proxy.py.j2",
        proxy=f"{text.name}Proxy",
        target=f"{text.name}Target",
        codec=text.codec,
        make_codec=text.make_codec,
        signature=text.signature,
        functions=[text.method(f, call=True) for f in text.layout.functions],
    )
