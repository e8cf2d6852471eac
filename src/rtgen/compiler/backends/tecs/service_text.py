"""Common parts of a service's modules: names, methods, the codec."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rtgen.compiler.backends.kit.python_module import Import, imports_from
from rtgen.compiler.backends.kit.python_text import WIDTH
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal
from rtgen.compiler.backends.tecs.function_text import (
    LOCALS,
    function_names,
    parameters_text,
    result_text,
    struct_classes,
)
from rtgen.compiler.layouts.tdr import FunctionLayout, SignatureLayout
from rtgen.compiler.lowering.tecs.options import RtcOptions
from rtgen.compiler.lowering.tecs.plan import Service
from rtgen.compiler.typemap.python.idl_names import distinct
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.tecs.python import codec_class, codec_module
from rtgen.compiler.typemap.tecs.texts import function_text


@dataclass(frozen=True, slots=True)
class Method:
    """A method: parameters with `self`, and the lines of its body."""

    name: str
    parameters: str
    result: str
    docstring: str = ""
    body: tuple[str, ...] = ()


class ServiceText:
    """A service in Python: the names that its modules share."""

    def __init__(self, service: Service, layout: SignatureLayout, package: str) -> None:
        self.layout = layout
        self.package = package
        self.name = identifier(service.name)
        self.signature = service.signature.scoped
        self.codec = codec_class(service.signature)
        self.codec_module = f"{package}.{codec_module(service.signature)}"
        self.server_module = f"{package}.{service.module}_server"
        self.make_codec = f"{self.codec}({_codec_arguments(service.options)})"
        self.makes_tdr = "make_tdr" in self.make_codec
        self.methods = function_names(layout)
        self.structs = struct_classes(layout)
        self._taken = LOCALS.union(self.structs)
        self._parameters: dict[int, dict[str, str]] = {}
        self._heads: dict[int, tuple[str, str]] = {}

    def proxy_values(self) -> dict[str, Any]:
        """Return the values of the template `tecs/proxy.py.j2`."""
        return {
            "proxy": f"{self.name}Proxy",
            "target": f"{self.name}Target",
            "codec": self.codec,
            "make_codec": self.make_codec,
            "signature": self.signature,
            "functions": [self.method(f, call=True) for f in self.layout.functions],
        }

    def method(
        self, layout: FunctionLayout, *, documented: bool = False, call: bool = False
    ) -> Method:
        """A function as a method in CDL's types; `call`: one of the proxy."""
        function = layout.function
        name = self.methods[function.name]
        names = self.parameters(layout)
        if function.id not in self._heads:
            texts = parameters_text(layout, names), result_text(layout)
            self._heads[function.id] = texts
        parameters, result = self._heads[function.id]
        body: tuple[str, ...] = ()
        if call:
            given = ", ".join(
                ["self.channel", *(names[item.name] for item in layout.arguments)]
            )
            verb = "" if result == "None" else "return "
            body = (f"{verb}self.codec.{name}.call({given})",)
        text = docstring(f"`{function_text(function)}`.", 8) if documented else ""
        return Method(name, parameters, result, text, body)

    def parameters(self, layout: FunctionLayout) -> dict[str, str]:
        """The Python names of a function's parameters."""
        number = layout.function.id
        if number not in self._parameters:
            names = distinct((item.name for item in layout.items), self._taken)
            self._parameters[number] = names
        return self._parameters[number]


def _codec_arguments(options: RtcOptions) -> str:
    """The arguments of the codec that differ from their defaults."""
    usual = RtcOptions()
    widths = ("short_bits", "int_bits", "long_bits", "intptr_bits")
    given_widths = [
        f"{name}={getattr(options, name)}"
        for name in widths
        if getattr(options, name) != getattr(usual, name)
    ]
    arguments = []
    if given_widths or options.tdr != usual.tdr:
        order = string_literal(options.tdr)
        arguments.append(f"make_tdr({', '.join([order, *given_widths])})")
    if options.encoding != usual.encoding:
        arguments.append(f"encoding={string_literal(options.encoding)}")
    if options.limit != usual.limit:
        arguments.append(f"limit={options.limit}")
    return ", ".join(arguments)


def returning(values: Sequence[str], indent: int) -> str:
    """A return statement; a tuple that needs several lines is in brackets."""
    text = f"return {', '.join(values)}"
    if indent + len(text) <= WIDTH or len(values) == 1:
        return text
    return f"return ({', '.join(values)})"


def standard_imports(functions: Sequence[Method]) -> list[Import]:
    """Return the imports of the standard library for the parameters."""
    needs = any("Sequence[" in each.parameters for each in functions)
    return imports_from("collections.abc", ["Sequence"] * needs)
