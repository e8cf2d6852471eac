"""Prints the module `<name>_marshaller.py`: proxy, servant, and the RTC around them."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.base_module import class_names
from rtgen.compiler.backends.components.locations import module_path
from rtgen.compiler.backends.components.members import attributes_of
from rtgen.compiler.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.function_text import LOCALS, tuple_type
from rtgen.compiler.backends.tecs.service_text import (
    Method,
    ServiceText,
    returning,
    standard_imports,
)
from rtgen.compiler.backends.tecs.views import to_codec, to_idl, used_structs
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.layouts.tdr import FunctionLayout, Item
from rtgen.compiler.lowering.tecs.communication import RUNTIME as CHANNEL
from rtgen.compiler.lowering.tecs.idl_model import IdlService
from rtgen.compiler.lowering.tecs.rtc_components import MARSHALLER
from rtgen.compiler.model import (
    VOID,
    Component,
    Model,
    Operation,
    Primitive,
    PrimitiveType,
)
from rtgen.compiler.typemap.python.idl import PythonMapping
from rtgen.compiler.typemap.python.idl_names import PythonNames, distinct
from rtgen.compiler.typemap.tecs.python import struct_class

_ANY = PrimitiveType(Primitive.ANY)
_LOCALS = LOCALS | {"returned"}


def marshaller_module(
    text: ServiceText,
    model: Model,
    names: PythonNames,
    idl: IdlService,
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    """The module of a service; the model holds the IDL side of its package."""
    name = text.name
    structs = text.structs
    component = model.find((f"{idl.service.name}{MARSHALLER}",))
    assert isinstance(component, Component)
    servant = f"_{name}Servant"
    scope = Scope(names, names.module(idl.file))
    interface = scope.reference(idl.interface.name)
    servants = _Servant(text, model, names, idl, scope)
    layouts = text.layout.functions
    pairs = list(zip(layouts, idl.interface.operations, strict=True))
    converting = [pair for pair in pairs if servants.converts(*pair)]
    operations = [servants.operation(*pair) for pair in converting]
    called = names.operations(idl.interface)
    renamed = {
        called[operation.name]: text.methods[function.function.name]
        for function, operation in pairs
        if (function, operation) not in converting
        and called[operation.name] != text.methods[function.function.name]
    }
    proxy = text.proxy_values()
    attributes = attributes_of(component)
    used = ["Channel", "CommunicationChannel", "ProxyServant"]
    body = render(
        "tecs/marshaller.py.j2",
        **proxy,
        renamed=_keyword("methods", renamed),
        servant=servant,
        interface=interface,
        interface_name="::".join(idl.interface.name),
        operations=operations,
        rtc=f"{name}{MARSHALLER}",
        rtc_docstring=docstring(component.doc, 4),
        base=class_names(component)[0],
        provider=attributes.ports[0][1],
        consumer=attributes.ports[1][1],
    )
    return python_module(
        module_path(text.package, component),
        options,
        origin,
        f"`{text.signature}`: calls of a TECS board.",
        imports=[
            *standard_imports(proxy["functions"]),
            *imports_from("rtgen.runtime", ["RTC_OK", "ReturnCode_t"]),
            *imports_from(CHANNEL, [*used, *["make_tdr"] * text.makes_tdr]),
            *imports_from(f"{text.package}._types", structs),
            *imports_from(f"{text.package}._views", _views_used(layouts)),
            *imports_from(text.codec_module, [text.codec]),
            *imports_from(text.server_module, [f"{name}Target"]),
            *scope.imports(),
        ],
        body=body,
    )


def _keyword(name: str, values: dict[str, str]) -> str:
    """A keyword argument after others; empty for an empty dict."""
    pairs = [f"{string_literal(k)}: {string_literal(v)}" for k, v in values.items()]
    return f", {name}={{{', '.join(pairs)}}}" if pairs else ""


class _Servant:
    """Writes the operations of the servant of the service port."""

    def __init__(
        self,
        text: ServiceText,
        model: Model,
        names: PythonNames,
        idl: IdlService,
        scope: Scope,
    ) -> None:
        self._methods = text.methods
        self._names = names
        self._idl = idl
        self._scope = scope
        self._mapping = PythonMapping(
            model, scope.reference, scope.spell, servants=True
        )

    def converts(self, layout: FunctionLayout, operation: Operation) -> bool:
        """Whether a value of the function differs between CDL and IDL."""
        results = [] if layout.is_void else [layout.returned]
        return (
            any(p.type == _ANY for p in operation.parameters)
            or any(item.asked for item in layout.items)
            or any(to_codec(i, "value") != "value" for i in layout.items if i.inward)
            or any(
                to_idl(i, "value") != "value"
                for i in [*results, *(i for i in layout.items if i.outward)]
            )
        )

    def operation(self, layout: FunctionLayout, operation: Operation) -> Method:
        """Converts the arguments, calls the proxy, and converts the results."""
        annotate = self._mapping.annotation
        views = _views_used([layout])
        names = distinct((p.name for p in operation.parameters), _LOCALS.union(views))
        pairs = list(zip(layout.items, operation.parameters, strict=True))
        taken = set(names.values())
        body: list[str] = []
        arguments = []
        for item, parameter in pairs:
            if item.asked:
                arguments.append("True")
            elif item.inward:
                name = names[parameter.name]
                value = f"{name}.value" if parameter.type == _ANY else name
                arguments.append(
                    _local(body, to_codec(item, value), f"{name}_in", taken)
                )
        method = self._methods[layout.function.name]
        call = f"self._proxy.{method}({', '.join(arguments)})"
        results: list[str] = []
        converted = []
        types = [] if layout.is_void else [annotate(operation.returns)]
        after: list[str] = []
        if not layout.is_void:
            results.append("returned")
            value = to_idl(layout.returned, "returned")
            converted.append(_local(after, value, "returned_idl", taken))
        for item, parameter in pairs:
            if item.outward:
                types.append(annotate(parameter.type))
                results.append(_free(f"{names[parameter.name]}_out", taken))
                value = to_idl(item, results[-1])
                if parameter.type == _ANY:
                    value = self._any(item, value)
                converted.append(_local(after, value, f"{results[-1]}_idl", taken))
        if not results:
            body.append(call)
        elif converted == results:
            body.append(f"return {call}")
        else:
            body += [f"{', '.join(results)} = {call}", *after]
            body.append(returning(converted, 8))
        given = [f"{names[p.name]}: {annotate(p.type)}" for p in operation.arguments]
        assert layout.is_void == (operation.returns == VOID)
        return Method(
            self._names.operations(self._idl.interface)[operation.name],
            ", ".join(["self", *given]),
            tuple_type(types),
            body=tuple(body),
        )

    def _any(self, item: Item, value: str) -> str:
        """An array in an `any`, with the typedef of the interface for it."""
        codec = self._scope.companion(self._idl.arrays[item.span], "Codec")
        return f"{self._scope.AnyValue}({codec}._descriptor_, {value})"


def _local(body: list[str], value: str, name: str, taken: set[str]) -> str:
    """The value; a conditional expression is assigned to a variable first."""
    if " if " not in value:
        return value
    name = _free(name, taken)
    body.append(f"{name} = {value}")
    return name


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _views_used(functions: Sequence[FunctionLayout]) -> list[str]:
    found = set()
    for function in functions:
        for item in function.items:
            for record in used_structs(item.node):
                name = struct_class(record.struct.name)
                found |= {f"codec_{name}"} if item.inward else set()
                found |= {f"idl_{name}"} if item.outward else set()
        for record in used_structs(function.returned.node):
            found.add(f"idl_{struct_class(record.struct.name)}")
    return sorted(found)
