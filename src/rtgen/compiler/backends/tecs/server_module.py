"""The module `<name>_server.py`: the target to be implemented, and its unmarshaller."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.service_text import ServiceText, standard_imports


def server_module(
    text: ServiceText, options: Options, origin: Sequence[str]
) -> PythonModule:
    """The module of a service."""
    functions = [text.method(f, documented=True) for f in text.layout.functions]
    body = render(
        "tecs/server.py.j2",
        target=f"{text.name}Target",
        unmarshaller=f"{text.name}Unmarshaller",
        codec=text.codec,
        make_codec=text.make_codec,
        signature=text.signature,
        functions=functions,
    )
    runtime = ["Dispatcher", *["make_tdr"] * text.makes_tdr]
    return python_module(
        f"{text.server_module.replace('.', '/')}.py",
        options,
        origin,
        f"`{text.signature}`: the board's side in Python.",
        imports=[
            *imports_from("abc", ["ABC", "abstractmethod"]),
            *standard_imports(functions),
            *imports_from("rtgen.runtime.opaque_rpc", runtime),
            *imports_from(text.codec_module, [text.codec]),
            *imports_from(f"{text.package}._types", text.structs),
        ],
        body=body,
    )
