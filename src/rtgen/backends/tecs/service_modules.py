"""The Python modules of a service: marshaller with proxy, server, and the views of its structs."""

from __future__ import annotations

import builtins
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rtgen.backends.components.base_module import class_names
from rtgen.backends.components.imports import Imports, import_from
from rtgen.backends.components.members import attributes_of
from rtgen.backends.python_text import WIDTH, docstring, fit_text, string_literal
from rtgen.backends.rendering import render
from rtgen.backends.tecs.idl_model import IdlService, IdlSide
from rtgen.backends.tecs.options import RtcOptions
from rtgen.backends.tecs.views import (
    struct_views,
    to_codec,
    to_idl,
    used_structs,
)
from rtgen.layouts.tdr import (
    FunctionLayout,
    Item,
    Record,
    SignatureLayout,
)
from rtgen.model import (
    VOID,
    Component,
    Direction,
    Model,
    Operation,
    Primitive,
    PrimitiveType,
    Struct,
)
from rtgen.model.tecs import TecsFunction
from rtgen.typemap.idl_python import PythonNames, distinct
from rtgen.typemap.python_names import identifier, module_name
from rtgen.typemap.tecs_python import (
    annotation,
    argument_annotation,
    codec_class,
    codec_module,
    item_annotation,
    struct_class,
    zero,
)

_LOCALS = frozenset(
    {
        *("self", "channel", "codec", "error", "first", "more", "outs", "request"),
        *(
            "reply",
            "result",
            "results",
            "returned",
            "call",
            "send",
            "E_OK",
            "Any",
            "AnyValue",
            "target",
        ),
        *dir(builtins),
    }
)
_ANY = PrimitiveType(Primitive.ANY)


@dataclass(frozen=True, slots=True)
class _Function:
    """A method; `id`, `handler` and `gives` count for servers."""

    name: str
    parameters: str
    result: str
    docstring: str = ""
    body: tuple[str, ...] = ()
    id: int = 0
    handler: str = ""
    gives: str = ""


class ServiceModules:
    """Writes the modules of one service; the model holds the IDL side of its package."""

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        side: IdlSide,
        idl: IdlService,
        layout: SignatureLayout,
        header: str,
    ) -> None:
        self._model = model
        self._names = names
        self._side = side
        self._idl = idl
        self._layout = layout
        self._header = header
        service = idl.service
        self._name = identifier(service.name)
        self._codec = codec_class(service.signature)
        self._signature = service.signature.scoped
        self._make_codec = f"{self._codec}({_codec_arguments(service.options)})"
        self._makes_tdr = "make_tdr" in self._make_codec
        self._methods = distinct(
            (f.function.name for f in layout.functions),
            {"self", "channel", "codec", "handlers", "target"},
        )

    # The marshaller.

    def marshaller(self) -> str:
        """The text of `<name>_marshaller.py`."""
        name = self._name
        structs = self._struct_classes()
        component = self._component(f"{self._idl.service.name}Marshaller")
        base, _ = class_names(component)
        servant = f"_{name}Servant"
        taken = {
            *structs,
            *_LOCALS,
            *(f"{name}Proxy", servant, f"{name}Marshaller", base, self._codec),
            *("RTC_OK", "ReturnCode_t", "CommunicationChannel", "Channel", "RpcError"),
            *("Sequence", "make_tdr"),
        }
        imports = Imports(self._model, self._names, ".", taken)
        interface = imports.type_name(self._idl.interface.name)
        operations = [
            self._operation(imports, function, operation)
            for function, operation in zip(
                self._layout.functions, self._idl.interface.operations, strict=True
            )
        ]
        functions = [
            self._proxy_method(function) for function in self._layout.functions
        ]
        calls = {
            word
            for function in functions
            for word in ("call", "send", "RpcError", "E_OK")
            if any(_uses(line, word) for line in function.body)
        }
        views = self._views_used(self._layout.functions)
        attributes = attributes_of(component)
        lines = [
            *imports.lines(),
            import_from("..opaque_rpc_communication", ["CommunicationChannel"]),
            import_from("._types", structs) if structs else "",
            import_from("._views", views) if views else "",
            import_from(f".components.{module_name(component.name[-1])}", [base]),
            import_from(f".{codec_module(self._idl.service.signature)}", [self._codec]),
        ]
        runtime = {"Channel", *calls, *(["make_tdr"] if self._makes_tdr else [])}
        values = [line for line in imports.lines() if "rtgen.runtime.values" in line]
        text = render(
            "tecs/marshaller.py.j2",
            header=self._header,
            docstring=docstring(f"`{self._signature}`: calls of a TECS board.", 0),
            standard=_standard(functions),
            runtime=[
                import_from("rtgen.runtime", ["RTC_OK", "ReturnCode_t"]),
                import_from("rtgen.runtime.opaque_rpc", runtime),
                *values,
            ],
            imports=sorted(
                line for line in dict.fromkeys(lines) if line and line not in values
            ),
            proxy=f"{name}Proxy",
            codec=self._codec,
            make_codec=self._make_codec,
            signature=self._signature,
            functions=functions,
            servant=servant,
            interface=interface,
            interface_name="::".join(self._idl.interface.name),
            operations=operations,
            marshaller=f"{name}Marshaller",
            base=base,
            class_docstring=docstring(component.doc, 4),
            provider=attributes.ports[0][1],
            consumer=attributes.ports[1][1],
        )
        return fit_text(text)

    def _proxy_method(self, layout: FunctionLayout) -> _Function:
        function = layout.function
        names = self._parameter_names(layout)
        codec = "self.codec" if layout.reply is None else "codec"
        encode = f"{codec}.encode_{function.name}_request"
        request = f"{encode}({', '.join(names[i.name] for i in layout.arguments)})"
        body = (
            _oneway(layout, request)
            if layout.reply is None
            else self._two_way(layout, request, names)
        )
        return _Function(
            self._methods[function.name],
            _parameters(layout, names),
            _result(layout),
            docstring(f"`{_shown(function)}`.", 8),
            tuple(body),
        )

    def _two_way(
        self, layout: FunctionLayout, request: str, names: dict[str, str]
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
        if not _is_code(layout.function):
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
        yield "    " + _returning(["error.code", *failed], 12)
        if outs:
            yield "returned, outs = reply"
            yield "if outs is None:"
            yield "    " + _returning(["returned", *failed], 12)
            yield "return returned, *outs"
        else:
            yield "return reply[0]"

    # The servant of the service port.

    def _operation(
        self, imports: Imports, layout: FunctionLayout, operation: Operation
    ) -> _Function:
        annotate = imports.mapping.annotation
        names = distinct((p.name for p in operation.parameters), _LOCALS)
        pairs = list(zip(layout.items, operation.parameters, strict=True))
        given = [
            f"{names[p.name]}: {annotate(p.type)}"
            for p in operation.parameters
            if p.direction is not Direction.OUT
        ]
        results = [] if operation.returns == VOID else [annotate(operation.returns)]
        results += [
            annotate(p.type)
            for p in operation.parameters
            if p.direction is not Direction.IN
        ]
        body: list[str] = []
        arguments = []
        for item, parameter in pairs:
            if item.asked:
                arguments.append("True")
            elif item.inward:
                name = names[parameter.name]
                value = f"{name}.value" if parameter.type == _ANY else name
                arguments.append(_local(body, to_codec(item, value), f"{name}_in"))
        method = self._methods[layout.function.name]
        call = f"self._proxy.{method}({', '.join(arguments)})"
        results_of = [(layout.returned, "returned")] if not layout.is_void else []
        results_of += [
            (item, f"{names[parameter.name]}_out")
            for item, parameter in pairs
            if item.outward
        ]
        converted = []
        types = dict(zip(layout.items, operation.parameters, strict=True))
        after: list[str] = []
        for item, name in results_of:
            value = to_idl(item, name)
            if item in types and types[item].type == _ANY:
                value = self._any(imports, item, value)
            converted.append(_local(after, value, f"{name}_idl"))
        names_of = [name for _, name in results_of]
        if not names_of:
            body.append(call)
        elif converted == names_of:
            body.append(f"return {call}")
        else:
            body += [f"{', '.join(names_of)} = {call}", *after]
            body.append(_returning(converted, 8))
        return _Function(
            self._names.operations(self._idl.interface)[operation.name],
            ", ".join(["self", *given]),
            _tuple_type(results),
            body=tuple(body),
        )

    def _any(self, imports: Imports, item: Item, value: str) -> str:
        """An array in an `any`, by the typedef that the interface has for it."""
        name = self._idl.arrays[item.span]
        module, class_name = (
            self._names.implementation(name)[0],
            self._names.companion(name, "Codec"),
        )
        codec = imports.spell(f".{module}", class_name)
        any_value = imports.spell("rtgen.runtime.values", "AnyValue")
        return f"{any_value}({codec}._descriptor_, {value})"

    # The server.

    def server(self) -> str:
        """The text of `<name>_server.py`."""
        name = self._name
        structs = self._struct_classes()
        functions = [self._served(function) for function in self._layout.functions]
        lines = [
            import_from(f".{codec_module(self._idl.service.signature)}", [self._codec]),
            import_from("._types", structs) if structs else "",
        ]
        text = render(
            "tecs/server.py.j2",
            header=self._header,
            docstring=docstring(f"`{self._signature}`: the board's side in Python.", 0),
            standard=_standard(functions),
            runtime=", make_tdr" if self._makes_tdr else "",
            imports=sorted(filter(None, lines)),
            target=f"{name}Target",
            unmarshaller=f"{name}Unmarshaller",
            codec=self._codec,
            make_codec=self._make_codec,
            signature=self._signature,
            functions=functions,
        )
        return fit_text(text)

    def _served(self, layout: FunctionLayout) -> _Function:
        function = layout.function
        names = self._parameter_names(layout)
        return _Function(
            self._methods[function.name],
            _parameters(layout, names),
            _result(layout),
            docstring(f"`{_shown(function)}`.", 8),
            tuple(self._handler(layout, names)),
            function.id,
            f"_handle_{layout.function.name}",
            "None" if layout.reply is None else "bytes",
        )

    def _handler(self, layout: FunctionLayout, names: dict[str, str]) -> Iterator[str]:
        method = layout.function.name
        read = f"self.codec.read_{method}_request(more)"
        arguments = [names[item.name] for item in layout.arguments]
        target = f"self.target.{self._methods[layout.function.name]}"
        plain = [a for a in arguments if a not in {names[i.name] for i in layout.kept}]
        if not arguments:
            yield read
            call = f"{target}()"
        elif len(plain) == len(arguments):
            call = f"{target}(*{read})"
        else:
            targets = ", ".join(arguments)
            yield (
                f"({targets},) = {read}"
                if len(arguments) == 1
                else f"{targets} = {read}"
            )
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

    # What both need.

    def _component(self, name: str) -> Component:
        found = self._model.find((name,))
        assert isinstance(found, Component)
        return found

    def _parameter_names(self, layout: FunctionLayout) -> dict[str, str]:
        return distinct((item.name for item in layout.items), _LOCALS)

    def _struct_classes(self) -> list[str]:
        """The classes that annotations and zeros name."""
        found = {
            struct_class(record.struct.name)
            for function in self._layout.functions
            for item in (*function.items, function.returned)
            for record in used_structs(item.node)
        }
        return sorted(found)

    def _views_used(self, functions: Sequence[FunctionLayout]) -> list[str]:
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


def views_module(
    side: IdlSide,
    names: PythonNames,
    records: Sequence[Record],
    header: str,
) -> str:
    """The text of `_views.py`, for all structs of a package."""
    imports = Imports(side.model, names, ".", {"_types", "value"})
    structs = []
    for record in records:
        scoped = side.structs[record.struct.name]
        declaration = side.model.find(scoped)
        assert isinstance(declaration, Struct)
        members = names.members(declaration)
        structs.append(
            struct_views(
                record,
                imports.type_name(scoped),
                tuple(members[member.name] for member in declaration.members),
            )
        )
    lines = ["from . import _types", *imports.lines()]
    text = render(
        "tecs/views.py.j2", header=header, imports=sorted(lines), structs=structs
    )
    return fit_text(text)


def _codec_arguments(options: RtcOptions) -> str:
    """What the codec is made with where it is not the default."""
    widths = {
        "short_bits": None if options.short_bits == 16 else options.short_bits,
        "int_bits": None if options.int_bits == 32 else options.int_bits,
        "long_bits": options.long_bits,
        "intptr_bits": options.intptr_bits,
    }
    told = [f"{name}={bits}" for name, bits in widths.items() if bits is not None]
    arguments = []
    if told or options.tdr != "network":
        order = string_literal(options.tdr)
        arguments.append(f"make_tdr({', '.join([order, *told])})")
    if options.reply != "tecsgen":
        arguments.append(f"reply={string_literal(options.reply)}")
    if options.encoding != "latin-1":
        arguments.append(f"encoding={string_literal(options.encoding)}")
    if options.limit != 4096:
        arguments.append(f"limit={options.limit}")
    return ", ".join(arguments)


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


def _is_code(function: TecsFunction) -> bool:
    """Whether a failure is told by the return value: its type is `ER` or `ER_INT` as written."""
    return str(function.returns) in ("ER", "ER_INT")


def _unset(item: Item, names: dict[str, str]) -> str:
    """What a parameter is handed back as when the call failed."""
    if item.inward:
        return names[item.name]
    return "None" if item.nullable else zero(item.node)


def _parameters(layout: FunctionLayout, names: dict[str, str]) -> str:
    given = [
        (
            f"{names[i.name]}: {item_annotation(i) if i.outward else argument_annotation(i)}"
            if not i.asked
            else f"{names[i.name]}: bool"
        )
        for i in layout.arguments
    ]
    return ", ".join(["self", *given])


def _result(layout: FunctionLayout) -> str:
    results = [] if layout.is_void else [annotation(layout.returned.node)]
    results += [item_annotation(item) for item in layout.outs]
    return _tuple_type(results)


def _tuple_type(types: Sequence[str]) -> str:
    if len(types) > 1:
        return f"tuple[{', '.join(types)}]"
    return types[0] if types else "None"


def _returning(values: Sequence[str], indent: int) -> str:
    """A return statement; a tuple that needs several lines is in brackets."""
    text = f"return {', '.join(values)}"
    if indent + len(text) <= WIDTH or len(values) == 1:
        return text
    return f"return ({', '.join(values)})"


def _local(body: list[str], value: str, name: str) -> str:
    """The value; one that is a choice gets a name of its own first."""
    if " if " not in value:
        return value
    body.append(f"{name} = {value}")
    return name


def _standard(functions: Sequence[_Function]) -> list[str]:
    texts = (f.parameters for f in functions)
    needs = any("Sequence[" in text for text in texts)
    return [import_from("collections.abc", ["Sequence"])] if needs else []


def _uses(line: str, word: str) -> bool:
    return f"{word}(" in line or f"{word} " in line or line.endswith(word)


def _shown(function: TecsFunction) -> str:
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
