"""The codec module of a signature: requests and replies, both directions."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from rtgen.backends.python_text import fit_text, string_literal
from rtgen.backends.rendering import render
from rtgen.backends.tecs.codec_parts import (
    Attributes,
    Environment,
    Scope,
)
from rtgen.backends.tecs.decoding import Decoder
from rtgen.backends.tecs.encoding import Encoder
from rtgen.layouts.tdr import (
    Field,
    FunctionLayout,
    Item,
    Nothing,
    Record,
    Role,
    Run,
    SignatureLayout,
    Step,
)
from rtgen.layouts.tdr_messages import layout_of
from rtgen.model.tecs import Signature, TecsDirection, TecsUnit
from rtgen.typemap.tecs_python import (
    CODEC_NAMES,
    TDR_NAMES,
    annotation,
    argument_annotation,
    codec_class,
    item_annotation,
    member_name,
    struct_class,
)

_EOP = {True: "EOP_NOTHING_FOLLOWS", False: "EOP_REPLY_FOLLOWS"}


def codec_text(unit: TecsUnit, signature: Signature, header: str) -> str:
    """The module `<name>_codec.py`; `header` is its comment.

    It imports the structs' classes from `_types` beside it. Raises TransferError.
    """
    layout = layout_of(unit, signature)
    classes = [struct_class(record.struct.name) for record in layout.records]
    attributes = Attributes(classes)
    records = [
        method
        for record in layout.records
        if not record.fixed
        for method in _record_methods(record, attributes)
    ]
    functions = [_Function(f, layout, attributes) for f in layout.functions]
    methods = [method for f in functions for method in f.methods()]
    ids = ", ".join(
        f"{string_literal(f.function.name)}: {f.function.id}" for f in layout.functions
    )
    constants = [f.constant for f in functions if f.constant]
    firsts = [f.first for f in functions if f.first]
    body = render(
        "tecs/codec.py.j2",
        name=codec_class(signature),
        scoped=signature.scoped,
        scoped_literal=string_literal(signature.scoped),
        ids=ids,
        statements=[*attributes.statements(), *constants, *firsts],
        methods=[*methods, *records],
    )
    return fit_text(header + _head(signature, classes, body) + body)


def _head(signature: Signature, classes: Sequence[str], body: str) -> str:
    imports = [
        ("rtgen.runtime.opaque_rpc.codecs", _used(CODEC_NAMES, body)),
        ("rtgen.runtime.opaque_rpc.tdr", _used(TDR_NAMES, body)),
        ("._types", _used(classes, body)),
    ]
    lines = [f'"""The messages of `{signature.scoped}`."""', ""]
    lines += ["from __future__ import annotations", ""]
    abstract = _used(("Mapping", "Sequence"), body)
    lines.append(f"from collections.abc import {', '.join(abstract)}")
    lines += ["from typing import ClassVar", ""]
    for module, names in imports:
        if module == "._types" and names:
            lines.append("")
        if names:
            lines.append(f"from {module} import {', '.join(names)}")
    return "\n".join([*lines, "", "", ""])


def _used(names: Iterable[str], text: str) -> list[str]:
    words = set(re.findall(r"\w+", text))
    return sorted(name for name in names if name in words)


def _method(name: str, parameters: Sequence[str], result: str, body: list[str]) -> str:
    lines = [f"def {name}({', '.join(['self', *parameters])}) -> {result}:"]
    return "\n".join(f"    {line}" for line in [*lines, *(f"    {b}" for b in body)])


def _record_methods(record: Record, attributes: Attributes) -> list[str]:
    """What writes and what reads a struct whose size depends on values."""
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
    names = {item.name: scope.of(item) for item in record.items}
    environment = Environment(scope, record.items, names)
    decoder = Decoder(attributes, scope, environment, lambda item: None, {})
    lines = decoder.body(record.steps)
    values = ", ".join(_value(scope, item) for item in record.items)
    read = _guarded([*lines, f"return {name}({values})"], environment, name)
    return [
        _method(f"_write_{name}", [f"value: {name}"], "bytes", write),
        _method(f"_read_{name}", ["more: More", "room: Room"], name, read),
    ]


def _value(scope: Scope, item: Item) -> str:
    return "None" if isinstance(item.node, Nothing) else scope.of(item)


def _guarded(lines: list[str], environment: Environment, name: str) -> list[str]:
    """The statements, with what a size's expression may raise made a ProtocolError."""
    if not environment.is_guarded:
        return lines
    return [
        "try:",
        *(f"    {line}" for line in lines),
        "except FAILURES as failure:",
        f"    raise size_error({string_literal(name)}, failure) from failure",
    ]


class _Function:
    """The methods of one function."""

    def __init__(
        self, layout: FunctionLayout, signature: SignatureLayout, attributes: Attributes
    ) -> None:
        self._layout = layout
        self._attributes = attributes
        function = layout.function
        self._name = function.name
        self._shown = string_literal(f"{signature.signature.scoped}.{function.name}")
        self._eop = _EOP[function.oneway]
        self.constant = ""
        self.first = ""

    def methods(self) -> list[str]:
        """All of them."""
        methods = [self._encode_request(), self._read_request()]
        layout = self._layout
        if layout.reply is None or layout.paper is None:
            return methods
        has_paper = bool(layout.outs) and not layout.is_void
        methods += self._encode_reply(layout.reply, has_paper)
        methods += self._read_reply(layout.reply, has_paper)
        if has_paper:
            methods += self._encode_reply(layout.paper, False, "_in_paper_order")
            methods += self._read_reply(layout.paper, False, "_in_paper_order")
        return methods

    def _constants(self) -> dict[Role, str]:
        id_ = str(self._layout.function.id)
        return {Role.SOP: "SOP_REQUEST", Role.ID: id_, Role.EOP: self._eop}

    def _encode_request(self) -> str:
        layout = self._layout
        scope = Scope(layout.items, self._attributes.classes)
        names = {item.name: scope.of(item) for item in layout.items}
        encoder = Encoder(
            self._attributes,
            scope,
            Environment(scope, layout.items, names),
            scope.of,
            lambda item: f"{scope.of(item)} is not None",
            self._constants(),
        )
        body = encoder.body(layout.request)
        parameters = [
            f"{scope.of(i)}: {argument_annotation(i)}" for i in layout.arguments
        ]
        values = {i.name: scope.of(i) for i in layout.arguments}
        name = f"encode_{self._name}_request"
        if layout.arguments:
            return _method(name, parameters, "bytes", self._tried(body, values))
        attribute = f"self._request{layout.function.id}"
        self.constant = f"{attribute} = {body[-1].removeprefix('return ')}"
        return _method(name, [], "bytes", [f"return {attribute}"])

    def _tried(self, body: list[str], values: dict[str, str]) -> list[str]:
        shown = ", ".join(f"{string_literal(k)}: {v}" for k, v in values.items())
        error = f"argument_error({self._shown}, failure, {{{shown}}})"
        return [
            "try:",
            *(f"    {line}" for line in body),
            "except FAILURES as failure:",
            f"    raise {error} from failure",
        ]

    def _read_request(self) -> str:
        layout = self._layout
        scope = Scope(layout.items, self._attributes.classes)
        names = {item.name: scope.of(item) for item in layout.items}
        environment = Environment(scope, layout.items, names)
        decoder = Decoder(
            self._attributes,
            scope,
            environment,
            lambda item: None,
            {Role.EOP: (self._eop, self._complaint("EOP"))},
        )
        lines = decoder.body(_without(layout.request, (Role.SOP, Role.ID)))
        room = ["room = Room(self.limit)"] if decoder.needs_room else []
        values = [
            f"not {decoder.flag(item)}" if item.asked else _value(scope, item)
            for item in layout.arguments
        ]
        types = [
            "bool" if item.asked else item_annotation(item) for item in layout.arguments
        ]
        body = [*room, *lines, f"return {_tuple(values)}"]
        return _method(
            f"read_{self._name}_request",
            ["more: More"],
            _tuple_type(types),
            _guarded(body, environment, self._shown[1:-1]),
        )

    def _complaint(self, magic: str) -> str:
        return f'raise magic_error({self._shown}, "no {magic}")'

    def _reply_scope(self) -> tuple[Scope, dict[str, str], Environment]:
        """The scope of a reply, the names of what is kept, the environment of sizes."""
        layout = self._layout
        scope = Scope([*layout.items, layout.returned], self._attributes.classes)
        kept = {
            item.name: (
                scope.new(f"given_{item.name}") if item.outward else scope.of(item)
            )
            for item in layout.kept
        }
        values = {item.name: scope.of(item) for item in layout.items}
        given = {
            item.name: kept.get(item.name, scope.of(item))
            for item in layout.arguments
            if item.inward
        }
        return scope, kept, Environment(scope, layout.items, values, given)

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

    def _encode_reply(
        self, steps: Sequence[Step], has_paper: bool, ending: str = ""
    ) -> list[str]:
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
        values = dict(kept_values(kept))
        values |= {i.name or "return": scope.of(i) for i in [*results, *layout.outs]}
        names = [*kept.values(), *(scope.of(i) for i in [*results, *layout.outs])]
        parameters = self._kept_parameters(kept)
        parameters += [
            f"{scope.of(i)}: {item_annotation(i, given=True)}"
            for i in [*results, *layout.outs]
        ]
        body: list[str] = []
        if has_paper:
            body.append("if self._paper:")
            other = f"self._encode_{self._name}_reply_in_paper_order"
            body.append(f"    return {other}({', '.join(names)})")
        tried: list[str] = []
        if layout.leaves_out and not ending:
            run = Run((Field(Role.SOP), Field(Role.VALUE, layout.returned)))
            alone = self._attributes.run([*run.kinds, *Field(Role.EOP).kinds])
            tried.append("if is_rpc_error(returned):")
            tried.append(f"    return {alone}.pack(SOP_REPLY, returned, {_EOP[True]})")
        tried += encoder.body(steps)
        name = f"{'_' if ending else ''}encode_{self._name}_reply{ending}"
        return [_method(name, parameters, "bytes", body + self._tried(tried, values))]

    def _read_reply(
        self, steps: Sequence[Step], has_paper: bool, ending: str = ""
    ) -> list[str]:
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
                Role.SOP: ("SOP_REPLY", self._complaint("SOP")),
                Role.EOP: (_EOP[True], self._complaint("EOP")),
            },
        )
        lines: list[str] = []
        first: str | None = "first"
        leaves_out = layout.leaves_out and not ending
        if leaves_out:
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
        room = ["room = Room(self.reply_limit)"] if decoder.needs_room else []
        outs = _tuple([_value(scope, item) for item in layout.outs])
        returned = "None" if layout.is_void else "returned"
        body = [*room, *lines, f"return {returned}, {outs}"]
        body = _guarded(body, environment, self._shown[1:-1])
        types = _tuple_type([item_annotation(item) for item in layout.outs])
        result = f"tuple[{annotation(layout.returned.node)}, {types}]"
        if layout.leaves_out:
            result = f"{result[:-1]} | None]"
        if has_paper:
            other = f"self._read_{self._name}_reply_in_paper_order"
            names = ", ".join(["first", "more", *kept.values()])
            body = ["if self._paper:", f"    return {other}({names})", *body]
        parameters = ["first: bytes", "more: More", *self._kept_parameters(kept)]
        self._set_first(size, ending)
        name = f"{'_' if ending else ''}read_{self._name}_reply{ending}"
        return [_method(name, parameters, result, body)]

    def _set_first(self, size: str, ending: str) -> None:
        if not ending:
            self.first = f"self.{self._name}_first = {size}"
        elif not self.first.endswith(f" {size}"):
            usual = self.first.rpartition(" = ")[2]
            choice = f"{size} if self._paper else {usual}"
            self.first = f"self.{self._name}_first = {choice}"


def kept_values(kept: dict[str, str]) -> Iterable[tuple[str, str]]:
    """The kept values by the name that an error shows."""
    return ((name, value) for name, value in kept.items() if name == value)


def _first_run(steps: Sequence[Step]) -> Run:
    run = steps[0]
    assert isinstance(run, Run)
    return run


def _without(steps: Sequence[Step], roles: tuple[Role, ...]) -> list[Step]:
    """The steps without fields of these roles, which stand in the first run."""
    run = _first_run(steps)
    fields = tuple(field for field in run.fields if field.role not in roles)
    return [*([Run(fields)] if fields else []), *steps[1:]]


def _split(steps: Sequence[Step]) -> tuple[Run, list[Step]]:
    """SOP and return value, and the rest."""
    run = _first_run(steps)
    rest = run.fields[2:]
    return Run(run.fields[:2]), [*([Run(rest)] if rest else []), *steps[1:]]


def _tuple(values: Sequence[str]) -> str:
    comma = "," if len(values) == 1 else ""
    return f"({', '.join(values)}{comma})"


def _tuple_type(types: Sequence[str]) -> str:
    return f"tuple[{', '.join(types) or '()'}]"
