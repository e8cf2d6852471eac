"""The classes of a codec module: one for the messages of a function, one for a struct.

The bases are `Messages` and `RecordCodec` of `rtgen.runtime.opaque_rpc.codecs`, which documents
the methods.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rtgen.compiler.backends.kit.python_text import tuple_of
from rtgen.compiler.backends.kit.quoting.python import (
    Python,
    docstring,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.codec_parts import (
    Attributes,
    Environment,
    Scope,
    record_class,
)
from rtgen.compiler.backends.tecs.decoding import Decoder
from rtgen.compiler.backends.tecs.encoding import Encoder
from rtgen.compiler.backends.tecs.function_text import result_text, target_types
from rtgen.compiler.layouts.tdr import (
    Field,
    FunctionLayout,
    Item,
    Nothing,
    Record,
    Role,
    Run,
    Step,
)
from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.compiler.model.tecs import TecsDirection
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.tecs.python import (
    annotation,
    argument_annotation,
    item_annotation,
    member_name,
    struct_class,
    zero,
)
from rtgen.compiler.typemap.tecs.texts import function_text

_EOP = {True: "EOP_NOTHING_FOLLOWS", False: "EOP_REPLY_FOLLOWS"}


class Method(msgspec.Struct, frozen=True):
    """A method: its statements, and the exception that replaces `FAILURES` in them, if any."""

    name: str
    parameters: tuple[Python, ...]
    result: str
    body: tuple[str, ...]
    failure: str = ""


class CodecClass(msgspec.Struct, frozen=True):
    """A class of a codec module; `records` are the classes of structs that it uses.

    `facts` are attributes of the class, `attributes` the statements that define those of instances.
    """

    name: str
    base: Python
    docstring: Python
    parameters: tuple[Python, ...]
    attributes: tuple[str, ...]
    methods: tuple[Method, ...]
    records: tuple[str, ...]
    facts: tuple[tuple[str, str], ...] = ()

    @property
    def arguments(self) -> list[str]:
        """The parameters of the constructor by their names."""
        return [text.partition(":")[0] for text in self.parameters[1:]]

    @property
    def needs_tdr(self) -> bool:
        """Whether an attribute depends on the representation."""
        return any("tdr" in statement for statement in self.attributes)

    @property
    def text(self) -> str:
        """The text of the class."""
        return render("tecs/codec_class.py.j2", **{"class": self}).rstrip("\n")


def _method(
    name: str,
    parameters: Sequence[str],
    result: str,
    body: Sequence[str],
    failure: str = "",
) -> Method:
    texts = tuple(map(Python, ("self", *parameters)))
    return Method(name, texts, result, tuple(body), failure)


def record_codec(record: Record, structs: Sequence[str]) -> CodecClass:
    """Return the writer and reader of a struct whose size depends on values."""
    attributes = Attributes(structs)
    name = struct_class(record.struct.name)
    paths = {i.name: f"value.{member_name(i.name)}" for i in record.items}
    scope = Scope(record.items, attributes.classes)
    encoder = Encoder(
        attributes,
        scope,
        Environment(scope, record.items, paths),
        lambda item: paths[item.name],
        lambda item: "",
        {},
    )
    write = encoder.body(record.steps)
    scope = Scope(record.items, attributes.classes)
    environment = Environment(scope, record.items)
    decoder = Decoder(attributes, scope, environment, lambda item: None, {})
    lines = decoder.body(record.steps)
    values = ", ".join(_value(scope, item) for item in record.items)
    body = [*lines, f"return {name}({values})"]
    return CodecClass(
        record_class(name),
        Python("RecordCodec"),
        docstring(f"`struct {record.struct.scoped}`.", 4),
        (Python("self"), Python("codec: Codec")),
        tuple(attributes.statements()),
        (
            _method("write", [f"value: {name}"], "bytes", write),
            _method(
                "read",
                ["more: More", "budget: ByteBudget"],
                name,
                body,
                _size_error(environment, string_literal(name)),
            ),
        ),
        tuple(attributes.records),
    )


def _value(scope: Scope, item: Item) -> str:
    return "None" if isinstance(item.node, Nothing) else scope.of(item)


def _size_error(environment: Environment, name: str) -> str:
    """Return the exception for those of size expressions; none if these cannot fail."""
    return f"size_error({name}, failure)" if environment.is_guarded else ""


class FunctionCodec:
    """The class of one function's messages."""

    def __init__(
        self, layout: FunctionLayout, structs: Sequence[str], order: str
    ) -> None:
        self._layout = layout
        self._attributes = Attributes(structs)
        self._reply = layout.reply if order == "tecsgen" else layout.paper
        self._leaves_out = layout.leaves_out and order == "tecsgen"
        self._eop = _EOP[layout.function.oneway]
        self._constant = ""
        self._first = ""

    def codec_class(self) -> CodecClass:
        """Return the class; its text contains neither the function's name nor its id."""
        layout = self._layout
        methods = [self._encode_request(), self._read_request()]
        if self._reply is not None:
            methods.append(self._encode_reply(self._reply))
            methods.append(self._read_reply(self._reply))
        methods += self._unset()
        attributes = [*self._attributes.statements(), self._constant, self._first]
        parameters = ("self", "codec: Codec", "name: str", "number: int")
        base = f"Messages[[{', '.join(target_types(layout))}], {result_text(layout)}]"
        pascal = "".join(p[:1].upper() + p[1:] for p in layout.function.name.split("_"))
        return CodecClass(
            identifier(f"{pascal}Messages"),
            Python(base),
            docstring(f"`{function_text(layout.function, '')}`.", 4),
            tuple(map(Python, parameters)),
            tuple(filter(None, attributes)),
            tuple(methods),
            tuple(self._attributes.records),
            tuple(self._facts()),
        )

    def _facts(self) -> Iterator[tuple[str, str]]:
        """Yield the class attributes that differ from the base's."""
        layout = self._layout
        kept = [str(layout.arguments.index(item)) for item in layout.kept]
        if kept:
            yield "kept", tuple_of(kept).flat
        results = len(layout.outs) + (not layout.is_void)
        if results:
            yield "results", str(results)
        if layout.is_void:
            yield "is_void", "True"
        if layout.function.oneway:
            yield "oneway", "True"
        if is_error_code(layout.function.returns):
            yield "error_code", "True"

    def _unset(self) -> list[Method]:
        """Return the values of the outs after a failed call that raises no exception."""
        layout = self._layout
        if not layout.outs or not is_error_code(layout.function.returns):
            return []
        scope = Scope(layout.items, self._attributes.classes)
        values = [
            (
                scope.of(item)
                if item.inward
                else "None" if item.nullable else zero(item.node)
            )
            for item in layout.outs
        ]
        parameters = [
            f"{scope.of(i)}: {t}"
            for i, t in zip(layout.arguments, target_types(layout), strict=True)
        ]
        types = _tuple_type([item_annotation(item) for item in layout.outs])
        return [
            _method("unset", parameters, types, [f"return {tuple_of(values).flat}"])
        ]

    def _encode_request(self) -> Method:
        layout = self._layout
        scope = Scope(layout.items, self._attributes.classes)
        encoder = Encoder(
            self._attributes,
            scope,
            Environment(scope, layout.items),
            scope.of,
            lambda item: f"{scope.of(item)} is not None",
            {Role.SOP: "SOP_REQUEST", Role.ID: "self.id", Role.EOP: self._eop},
        )
        body = encoder.body(layout.request)
        parameters = [
            f"{scope.of(i)}: {argument_annotation(i)}" for i in layout.arguments
        ]
        values = {i.name: scope.of(i) for i in layout.arguments}
        name = "encode_request"
        if layout.arguments:
            return _method(name, parameters, "bytes", body, _argument_error(values))
        self._constant = f"self._request = {body[-1].removeprefix('return ')}"
        return _method(name, [], "bytes", ["return self._request"])

    def _read_request(self) -> Method:
        layout = self._layout
        scope = Scope(layout.items, self._attributes.classes)
        environment = Environment(scope, layout.items)
        decoder = Decoder(
            self._attributes,
            scope,
            environment,
            lambda item: None,
            {Role.EOP: self._eop},
        )
        lines = decoder.body(_without(layout.request, (Role.SOP, Role.ID)))
        budget = (
            ["budget = ByteBudget(self.request_limit)"] if decoder.needs_budget else []
        )
        values = [
            f"not {decoder.flag(item)}" if item.asked else _value(scope, item)
            for item in layout.arguments
        ]
        types = [
            "bool" if item.asked else item_annotation(item) for item in layout.arguments
        ]
        body = [*budget, *lines, f"return {tuple_of(values).flat}"]
        return _method(
            "read_request",
            ["more: More"],
            _tuple_type(types),
            body,
            _size_error(environment, "self.function"),
        )

    def _reply_scope(self) -> tuple[Scope, dict[str, str], Environment]:
        """Return the scope of a reply, the names of the kept values, the environment of sizes."""
        layout = self._layout
        scope = Scope([*layout.items, layout.returned], self._attributes.classes)
        kept = {
            item.name: (
                scope.new(f"given_{item.name}") if item.outward else scope.of(item)
            )
            for item in layout.kept
        }
        given = {
            item.name: kept.get(item.name, scope.of(item))
            for item in layout.arguments
            if item.inward
        }
        return scope, kept, Environment(scope, layout.items, given=given)

    def _kept_parameters(self, kept: dict[str, str]) -> list[str]:
        return [
            f"{kept[item.name]}: {argument_annotation(item)}"
            for item in self._layout.kept
        ]

    def _condition(self, item: Item, scope: Scope, kept: dict[str, str]) -> str:
        if item.direction is TecsDirection.RECEIVE:
            return f"{scope.of(item)} is not None"
        given = kept.get(item.name, "")
        return given if item.asked else f"{given} is not None"

    def _encode_reply(self, steps: Sequence[Step]) -> Method:
        layout = self._layout
        scope, kept, environment = self._reply_scope()
        constants = {Role.SOP: "SOP_REPLY", Role.EOP: _EOP[True]}
        encoder = Encoder(
            self._attributes,
            scope,
            environment,
            scope.of,
            lambda item: self._condition(item, scope, kept),
            constants,
        )
        results = [] if layout.is_void else [layout.returned]
        # The names of the kept values in error messages.
        values = {name: value for name, value in kept.items() if name == value}
        values |= {i.name or "return": scope.of(i) for i in [*results, *layout.outs]}
        parameters = self._kept_parameters(kept)
        parameters += [
            f"{scope.of(i)}: {item_annotation(i, given=True)}"
            for i in [*results, *layout.outs]
        ]
        tried: list[str] = []
        if self._leaves_out:
            run = Run((Field(Role.SOP), Field(Role.VALUE, layout.returned)))
            alone = self._attributes.run([*run.kinds, *Field(Role.EOP).kinds])
            tried.append("if is_rpc_error(returned):")
            tried.append(f"    return {alone}.pack(SOP_REPLY, returned, {_EOP[True]})")
        tried += encoder.body(steps)
        failure = _argument_error(values)
        return _method("encode_reply", parameters, "bytes", tried, failure)

    def _read_reply(self, steps: Sequence[Step]) -> Method:
        layout = self._layout
        scope, kept, environment = self._reply_scope()
        decoder = Decoder(
            self._attributes,
            scope,
            environment,
            lambda item: (
                None
                if item.direction is TecsDirection.RECEIVE
                else self._condition(item, scope, kept)
            ),
            {
                Role.SOP: "SOP_REPLY",
                Role.EOP: _EOP[True],
            },
        )
        lines: list[str] = []
        first: str | None = "first"
        if self._leaves_out:
            start, steps = _split(steps)
            lines += decoder.body([start], first)
            lines.append("if is_rpc_error(returned):")
            end = decoder.body([Run((Field(Role.EOP),))])
            lines += [f"    {line}" for line in [*end, "return returned, None"]]
            first = None
        else:
            start = _first_run(steps)
        size = decoder.run_size(start)
        lines += decoder.body(steps, first)
        budget = (
            ["budget = ByteBudget(self.reply_limit)"] if decoder.needs_budget else []
        )
        outs = tuple_of([_value(scope, item) for item in layout.outs]).flat
        returned = "None" if layout.is_void else "returned"
        body = [*budget, *lines, f"return {returned}, {outs}"]
        failure = _size_error(environment, "self.function")
        types = _tuple_type([item_annotation(item) for item in layout.outs])
        result = f"tuple[{annotation(layout.returned.node)}, {types}]"
        if self._leaves_out:
            result = f"{result[:-1]} | None]"
        parameters = ["first: bytes", "more: More", *self._kept_parameters(kept)]
        self._first = f"self.first = {size}"
        return _method("read_reply", parameters, result, body, failure)


def _argument_error(values: Mapping[str, str]) -> str:
    """Return the exception for a value that cannot be sent."""
    shown = ", ".join(f"{string_literal(k)}: {v}" for k, v in values.items())
    return f"argument_error(self.function, failure, {{{shown}}})"


def _first_run(steps: Sequence[Step]) -> Run:
    run = steps[0]
    assert isinstance(run, Run)
    return run


def _without(steps: Sequence[Step], roles: tuple[Role, ...]) -> list[Step]:
    """Return the steps without fields of these roles, which are in the first run."""
    run = _first_run(steps)
    fields = tuple(field for field in run.fields if field.role not in roles)
    return [*([Run(fields)] if fields else []), *steps[1:]]


def _split(steps: Sequence[Step]) -> tuple[Run, list[Step]]:
    """Return the steps of SOP and return value, and the other steps."""
    run = _first_run(steps)
    rest = run.fields[2:]
    return Run(run.fields[:2]), [*([Run(rest)] if rest else []), *steps[1:]]


def _tuple_type(types: Sequence[str]) -> str:
    return f"tuple[{', '.join(types) or '()'}]"
