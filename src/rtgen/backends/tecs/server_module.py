"""The module `<name>_server.py`: the target to be implemented, and what unmarshals for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rtgen.backends.components.imports import import_from
from rtgen.backends.python_text import docstring, fit_text
from rtgen.backends.rendering import render
from rtgen.backends.tecs.service_text import ServiceText, standard_imports
from rtgen.layouts.tdr import FunctionLayout


@dataclass(frozen=True, slots=True)
class _Handler:
    """What handles the requests of one function."""

    id: int
    name: str
    result: str
    body: tuple[str, ...]


def server_module(text: ServiceText) -> str:
    """The module of a service."""
    structs = text.struct_classes()
    functions = [text.method(layout, ()) for layout in text.layout.functions]
    lines = [
        import_from(text.codec_module, [text.codec]),
        import_from("._types", structs) if structs else "",
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
        handlers=[_handling(text, layout) for layout in text.layout.functions],
    )
    return fit_text(rendered)


def _handling(text: ServiceText, layout: FunctionLayout) -> _Handler:
    return _Handler(
        layout.function.id,
        f"_handle_{layout.function.name}",
        "None" if layout.reply is None else "bytes",
        tuple(_handler(text, layout)),
    )


def _handler(text: ServiceText, layout: FunctionLayout) -> Iterator[str]:
    method = layout.function.name
    names = text.parameters(layout)
    read = f"self.codec.read_{method}_request(more)"
    arguments = [names[item.name] for item in layout.arguments]
    target = f"self.target.{text.methods[method]}"
    plain = [a for a in arguments if a not in {names[i.name] for i in layout.kept}]
    if not arguments:
        yield read
        call = f"{target}()"
    elif len(plain) == len(arguments):
        call = f"{target}(*{read})"
    else:
        targets = ", ".join(arguments)
        one = len(arguments) == 1
        yield f"({targets},) = {read}" if one else f"{targets} = {read}"
        call = f"{target}({', '.join(arguments)})"
    if layout.reply is None:
        yield call
        return
    kept = [names[item.name] for item in layout.kept]
    results = len(layout.outs) + (not layout.is_void)
    encode = f"self.codec.encode_{method}_reply"
    if results == 0:
        yield call
        yield f"return {encode}({', '.join(kept)})"
        return
    star = "*" if results > 1 else ""
    yield f"results = {call}" if results > 1 else f"result = {call}"
    handed = [*kept, f"{star}results" if results > 1 else "result"]
    yield f"return {encode}({', '.join(handed)})"
