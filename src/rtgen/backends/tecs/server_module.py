"""The module `<name>_server.py`: the target to be implemented, and its unmarshaller."""

from __future__ import annotations

from rtgen.backends.components.imports import import_from
from rtgen.backends.kit.python_text import fit_text
from rtgen.backends.kit.quoting.python import docstring
from rtgen.backends.kit.rendering import render
from rtgen.backends.tecs.service_text import ServiceText, standard_imports


def server_module(text: ServiceText) -> str:
    """The module of a service."""
    functions = [text.method(f, documented=True) for f in text.layout.functions]
    lines = [
        import_from(text.codec_module, [text.codec]),
        import_from("._types", text.structs) if text.structs else "",
    ]
    rendered = render(
        "tecs/server.py.j2",
        header=text.header,
        docstring=docstring(f"`{text.signature}`: the board's side in Python.", 0),
        standard=standard_imports(functions),
        runtime=", make_tdr" if text.makes_tdr else "",
        imports=sorted(filter(None, lines)),
        target=f"{text.name}Target",
        unmarshaller=f"{text.name}Unmarshaller",
        codec=text.codec,
        make_codec=text.make_codec,
        signature=text.signature,
        functions=functions,
    )
    return fit_text(rendered)
