"""The generated client and server of a signature, loaded from memory with its codec."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.server_module import server_module
from rtgen.compiler.backends.tecs.service_text import ServiceText
from rtgen.compiler.lowering.tecs.options import RtcOptions
from rtgen.compiler.lowering.tecs.plan import Service as Planned
from rtgen.tools.rpc.codecs import Service

PROXY_HEAD = """from __future__ import annotations
from rtgen.runtime.opaque_rpc import Channel
from {codec} import {class_}
from .random_server import RandomTarget
from ._types import *
"""


class Generated:
    """The classes of `<name>_marshaller.py` and `<name>_server.py` for a service.

    The proxy stands alone, so types that IDL cannot express are included.
    """

    def __init__(self, service: Service) -> None:
        planned = Planned(service.signature, "Random", "random", RtcOptions())
        package = service.types.__package__ or ""
        text = ServiceText(planned, service.layout, package)
        head = PROXY_HEAD.format(codec=text.codec_module, class_=text.codec)
        self.methods = text.methods
        made = server_module(text, Options(package, "", "0"), ["random.cdl"])
        server = _module(package, "random_server", made.text)
        proxy = render("tecs/proxy.py.j2", **text.proxy_values())
        proxies = _module(package, "random_proxy", head + proxy)
        self.proxy: Any = proxies.RandomProxy
        self.target: Any = server.RandomTarget
        self.unmarshaller: Any = server.RandomUnmarshaller


def _module(package: str, name: str, text: str) -> ModuleType:
    module = sys.modules[f"{package}.{name}"] = ModuleType(f"{package}.{name}")
    module.__package__ = package
    exec(compile(text, f"<{package}.{name}>", "exec"), module.__dict__)
    return module
