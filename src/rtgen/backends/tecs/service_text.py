"""What the modules of a service have in common: names, signatures of methods, the codec."""

from __future__ import annotations

import builtins
from collections.abc import Sequence
from dataclasses import dataclass

from rtgen.backends.components.imports import import_from
from rtgen.backends.python_text import WIDTH, docstring, string_literal
from rtgen.backends.tecs.options import RtcOptions
from rtgen.backends.tecs.plan import Service
from rtgen.backends.tecs.views import used_structs
from rtgen.layouts.tdr import FunctionLayout, SignatureLayout
from rtgen.model.tecs import TecsFunction
from rtgen.typemap.idl_python import distinct
from rtgen.typemap.python_names import identifier
from rtgen.typemap.tecs_python import (
    annotation,
    argument_annotation,
    codec_class,
    codec_module,
    item_annotation,
    struct_class,
)

LOCALS = frozenset(
    {
        *(
            "_",
            "self",
            "channel",
            "codec",
            "error",
            "head",
            "more",
            "outs",
            "request",
        ),
        *("result", "results", "returned", "target"),
        *("E_OK", "RpcError", "send"),
        *dir(builtins),
    }
)
"""The names that the bodies of methods use, so that no parameter can have them."""

_ANNOTATIONS = frozenset(
    {"Sequence", "bool", "bytes", "float", "int", "list", "str", "tuple"}
)
"""What annotations are written with; a method of such a name would hide it in its class."""


@dataclass(frozen=True, slots=True)
class Method:
    """A method: parameters with `self`, and the lines of its body."""

    name: str
    parameters: str
    result: str
    docstring: str = ""
    body: tuple[str, ...] = ()


class ServiceText:
    """A service in Python: what its modules call things."""

    def __init__(self, service: Service, layout: SignatureLayout, header: str) -> None:
        self.layout = layout
        self.header = header
        self.name = identifier(service.name)
        self.signature = service.signature.scoped
        self.codec = codec_class(service.signature)
        self.codec_module = f".{codec_module(service.signature)}"
        self.make_codec = f"{self.codec}({_codec_arguments(service.options)})"
        self.makes_tdr = "make_tdr" in self.make_codec
        self.methods = distinct(
            (f.function.name for f in layout.functions),
            {
                *("channel", "codec", "handlers", "target"),
                *dir(object),
                *_ANNOTATIONS,
                *self.struct_classes(),
            },
        )

    def method(self, layout: FunctionLayout, body: Sequence[str]) -> Method:
        """A function as a method in CDL's types."""
        function = layout.function
        return Method(
            self.methods[function.name],
            parameters_text(layout, self.parameters(layout)),
            result_text(layout),
            docstring(f"`{shown(function)}`.", 8),
            tuple(body),
        )

    def parameters(self, layout: FunctionLayout) -> dict[str, str]:
        """The Python names of a function's parameters."""
        taken = LOCALS.union(self.struct_classes())
        return distinct((item.name for item in layout.items), taken)

    def struct_classes(self) -> list[str]:
        """The classes that annotations and zeros name."""
        found = {
            struct_class(record.struct.name)
            for function in self.layout.functions
            for item in (*function.items, function.returned)
            for record in used_structs(item.node)
        }
        return sorted(found)


def _codec_arguments(options: RtcOptions) -> str:
    """What the codec is made with where it is not the default."""
    usual = RtcOptions()
    widths = ("short_bits", "int_bits", "long_bits", "intptr_bits")
    told = [
        f"{name}={getattr(options, name)}"
        for name in widths
        if getattr(options, name) != getattr(usual, name)
    ]
    arguments = []
    if told or options.tdr != usual.tdr:
        order = string_literal(options.tdr)
        arguments.append(f"make_tdr({', '.join([order, *told])})")
    if options.reply != usual.reply:
        arguments.append(f"reply={string_literal(options.reply)}")
    if options.encoding != usual.encoding:
        arguments.append(f"encoding={string_literal(options.encoding)}")
    if options.limit != usual.limit:
        arguments.append(f"limit={options.limit}")
    return ", ".join(arguments)


def parameters_text(layout: FunctionLayout, names: dict[str, str]) -> str:
    given = [
        (
            f"{names[i.name]}: {item_annotation(i) if i.outward else argument_annotation(i)}"
            if not i.asked
            else f"{names[i.name]}: bool"
        )
        for i in layout.arguments
    ]
    return ", ".join(["self", *given])


def result_text(layout: FunctionLayout) -> str:
    results = [] if layout.is_void else [annotation(layout.returned.node)]
    results += [item_annotation(item) for item in layout.outs]
    return tuple_type(results)


def tuple_type(types: Sequence[str]) -> str:
    if len(types) > 1:
        return f"tuple[{', '.join(types)}]"
    return types[0] if types else "None"


def returning(values: Sequence[str], indent: int) -> str:
    """A return statement; a tuple that needs several lines is in brackets."""
    text = f"return {', '.join(values)}"
    if indent + len(text) <= WIDTH or len(values) == 1:
        return text
    return f"return ({', '.join(values)})"


def standard_imports(functions: Sequence[Method]) -> list[str]:
    texts = (f.parameters for f in functions)
    needs = any("Sequence[" in text for text in texts)
    return [import_from("collections.abc", ["Sequence"])] if needs else []


def shown(function: TecsFunction) -> str:
    """The function as CDL has it, brackets left out where they say nothing of the value."""
    shown = ", ".join(
        f"[{parameter.direction}] {_declared(parameter.type, parameter.name)}"
        for parameter in function.parameters
    )
    oneway = "[oneway] " if function.oneway else ""
    return f"{oneway}{function.returns} {function.name}({shown or 'void'})"


def _declared(type_: object, name: str) -> str:
    text = str(type_)
    if text.endswith("]") and "[" in text:
        head, bracket, tail = text.partition("[")
        return f"{head} {name}{bracket}{tail}"
    return f"{text[:-1]} *{name}" if text.endswith("*") else f"{text} {name}"
