"""Source text (head and body) of each function compiled for a type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from rtgen.runtime.marshalling.descriptors import (
    ExceptionDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.dynamic.faults import (
    body_error,
    decoding_error,
    encoding_error,
    prefix_error,
)
from rtgen.runtime.marshalling.errors import FAILURES
from rtgen.runtime.marshalling.layouts.envelopes import framed, identifier
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.marshalling.layouts.layout import (
    ANYWHERE,
    ORIGIN,
    Run,
    single,
    steps_of,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Delimited,
    Group,
    Node,
)
from rtgen.runtime.marshalling.layouts.trees import (
    body_of,
    has_headers,
    is_delimited,
    is_dynamic,
    tree_of,
)
from rtgen.runtime.marshalling.source import unions
from rtgen.runtime.marshalling.source.copier import Copier
from rtgen.runtime.marshalling.source.decoder import Decoder
from rtgen.runtime.marshalling.source.encoder import Encoder
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.repeated import is_repeatable

Function: TypeAlias = tuple[str, list[str]]
"""Head of a function, and the lines of its body."""


def _encode(descriptor: Any, refer: References) -> Function:
    """Return the function that encodes a whole body."""
    members = StructDescriptor | ExceptionDescriptor | UnionDescriptor
    name = "self" if isinstance(descriptor, members) else "value"
    lines = _encoding(descriptor, refer, name)
    head = f"def to_cdr({name}, little_endian=True):"
    return head, _raising(refer, descriptor, lines, name)


def _envelop(descriptor: Any, refer: References) -> Function:
    """Return the function that encodes a payload: encapsulation header, body, padding."""
    head = "def to_payload(value, little_endian=True):"
    number = identifier(descriptor, refer.format.version, False)
    run = None
    if not isinstance(descriptor, UnionDescriptor):
        run = single(steps_of(_node(descriptor, refer), ORIGIN))
    if run is not None:
        lines = Encoder(refer).whole(run, "value", number)
        return head, _raising(refer, descriptor, lines, "value")
    encode = refer.compiled("to_cdr", descriptor)
    frame = refer.function(framed)
    return head, [
        f"return {frame}({number} | little_endian, {encode}(value, little_endian))"
    ]


def _raising(
    refer: References, descriptor: Any, lines: list[str], name: str
) -> list[str]:
    """Return the lines with CdrError raised for a value that cannot be packed."""
    failure = (
        f"{refer.function(encoding_error)}({refer.descriptor(descriptor)}, {name}, "
    )
    return _guarded(refer, lines, f"raise {failure}failure) from failure")


def _decode(descriptor: Any, refer: References) -> Function:
    """Return the function that decodes a whole body."""
    decoder = Decoder(refer)
    lines = _decoding(descriptor, decoder, refer)
    head = "def from_cdr(cls, data, little_endian=True):"
    if refer.format.version:
        again = refer.function(refer.decoded_again)
        format_ = refer.namespace.bind("format_", refer.format)
        whole = "whole" if decoder.cut else "data"
        first = ["whole = data"] if decoder.cut else []
        value = f"{again}(cls, {whole}, {format_}, little_endian, failure)"
        return head, _guarded(refer, [*first, *lines], f"return {value}")
    described = refer.descriptor(descriptor)
    if refer.format.ros2:
        format_ = refer.namespace.bind("format_", refer.format)
        error = refer.function(body_error)
        failure = f"{error}({described}, data, {format_}, little_endian, failure)"
    else:
        error = refer.function(decoding_error)
        failure = f"{error}({described}, data, little_endian, failure)"
    return head, _guarded(refer, lines, f"raise {failure} from failure")


def _decode_prefix(descriptor: Any, refer: References) -> Function:
    """Return the function that decodes a struct at the start of a body; the rest is ignored."""
    decoder = Decoder(refer)
    lines = _decoding(descriptor, decoder, refer, exact=False)
    format_ = refer.namespace.bind("format_", refer.format)
    failure = (
        f"{refer.function(prefix_error)}({refer.descriptor(descriptor)}, data, "
        f"{format_}, little_endian, failure)"
    )
    head = "def from_prefix(cls, data, little_endian=True):"
    return head, _guarded(refer, lines, f"raise {failure} from failure")


def _decode_evolved(descriptor: Any, refer: References) -> Function:
    """Return the function that decodes a body of any version of the appendable types in it."""
    refer.evolving = True
    head = "def from_evolved(cls, data, little_endian):"
    extensibility = getattr(descriptor, "extensibility", "")
    if isinstance(descriptor, StructDescriptor) and extensibility == "appendable":
        decoder = Decoder(refer)
        end = "len(data)"
        decoder.body.add("offset = 0")
        if refer.format.version == 2:
            end = "end"
            decoder.take_length(end)
            decoder.refuse("end != len(data)", "octets too many")
        decoder.evolving(_group(descriptor, refer), end)
        return head, [*decoder.body.lines, "return cls(*values)"]
    return head, _decoding(descriptor, Decoder(refer), refer)


def _group(descriptor: Any, refer: References) -> Group:
    body = body_of(descriptor, refer.format)
    assert isinstance(body, Group)
    return body


def _guarded(refer: References, lines: list[str], reaction: str) -> list[str]:
    failures = refer.namespace.bind("FAILURES", FAILURES)
    return [
        '"""Compiled by rtgen.runtime.marshalling at first use."""',
        "try:",
        *(f"    {line}" for line in lines),
        f"except {failures} as failure:",
        f"    {reaction}",
    ]


def _encoding(descriptor: Any, refer: References, name: str) -> list[str]:
    out = "bytearray"
    if is_dynamic(descriptor):
        from rtgen.runtime.marshalling.dynamic.writer import Output

        out = refer.function(Output)
    if isinstance(descriptor, UnionDescriptor):
        lines = [f"{refer.writer(descriptor)}({name}, out, little_endian)"]
    else:
        encoder = Encoder(refer)
        steps = steps_of(_node(descriptor, refer), ORIGIN)
        if not steps:
            return ['return b""']
        run = single(steps)
        if run is not None:
            return encoder.whole(run, name)
        lines = encoder.parts(steps, name)
    begin, (*lines, last) = f"out = {out}()", lines
    if out == "bytearray" and last.startswith("out += "):
        return [
            begin,
            *lines,
            f'return b"".join((out, {last.removeprefix("out += ")}))',
        ]
    return [begin, *lines, last, "return bytes(out)"]


def _decoding(
    descriptor: Any, decoder: Decoder, refer: References, *, exact: bool = True
) -> list[str]:
    first = []
    if is_dynamic(descriptor):
        from rtgen.runtime.marshalling.dynamic.octet_reader import Input

        first = [f"data = {refer.function(Input)}(data)"]
    if isinstance(descriptor, UnionDescriptor):
        class_ = refer.made(descriptor)
        return [
            *first,
            f"value, offset = {refer.reader(descriptor)}(data, 0, little_endian)",
            "if offset != len(data):",
            '    raise ValueError("octets too many")',
            f"same = cls is {class_}",
            "return value if same else cls(value.discriminator, value.value)",
        ]
    node = _node(descriptor, refer)
    steps = steps_of(node, ORIGIN)
    if len(steps) == 1 and isinstance(steps[0], Run) and _is_fixed(steps[0]):
        return decoder.fixed(steps[0], node, exact=exact)
    lines = [*first, *decoder.whole(steps, node, exact=exact)]
    if not first and is_repeatable(steps):
        return decoder.repeated(lines, steps[0], str(descriptor.name))
    return lines


def _node(descriptor: Any, refer: References) -> Node:
    """Return the tree of a type other than a union."""
    if not isinstance(descriptor, StructDescriptor | ExceptionDescriptor):
        return tree_of(descriptor, refer.format)
    body = body_of(descriptor, refer.format)
    return Delimited(body) if is_delimited(descriptor, refer.format) else body


def _is_fixed(run: Run) -> bool:
    return len(run.sections) == 1 and run.sections[0].settled


def _write(descriptor: Any, refer: References) -> Function:
    """Return the function that appends a value to a body."""
    encoder = Encoder(refer)
    if isinstance(descriptor, UnionDescriptor):
        lines = unions.encode(descriptor, encoder, refer)
    else:
        steps = steps_of(_node(descriptor, refer), ANYWHERE)
        lines = encoder.parts(steps, "value")
    return "def write(value, out, little_endian):", lines or ["pass"]


def _read(descriptor: Any, refer: References) -> Function:
    """Return the function that reads a value at an offset, and the next offset."""
    decoder = Decoder(refer)
    if isinstance(descriptor, UnionDescriptor):
        lines = unions.decode(descriptor, decoder, refer)
    else:
        node = _node(descriptor, refer)
        lines = decoder.parts(steps_of(node, ANYWHERE), node)
    return "def read(data, offset, little_endian):", lines


def _evolve(descriptor: Any, refer: References) -> Function:
    """Return the function that reads a value of any version of the appendable types in it."""
    refer.evolving = True
    head = "def evolve(data, offset, little_endian):"
    if isinstance(descriptor, UnionDescriptor) or not (
        is_delimited(descriptor, refer.format)
        and descriptor.extensibility == "appendable"
    ):
        return head, _read(descriptor, refer)[1]
    decoder = Decoder(refer)
    decoder.take_length("end")
    decoder.enclose()
    decoder.evolving(_group(descriptor, refer), "end")
    return head, [
        *decoder.body.lines,
        f"return {refer.made(descriptor)}(*values), end",
    ]


def _snapshot(descriptor: Any, refer: References) -> Function:
    """Return the function that makes a deep copy; immutable values are shared."""
    head = "def _snapshot_(self):"
    if is_dynamic(descriptor):
        from rtgen.runtime.marshalling.dynamic.values import deep_copy

        return head, [f"return {refer.function(deep_copy)}(self)"]
    headed = has_headers(descriptor)
    # Classic CDR has no optional members.
    format_ = Format(2) if headed else refer.format
    copier = Copier(refer, unset=headed)
    if isinstance(descriptor, UnionDescriptor):
        return head, unions.copy(descriptor, copier, refer, format_)
    expression = copier.copy(body_of(descriptor, format_), "self")
    return head, [*copier.body.lines, f"return {expression}"]


FUNCTIONS: dict[str, Callable[[Any, References], Function]] = {
    "to_cdr": _encode,
    "to_payload": _envelop,
    "from_cdr": _decode,
    "from_evolved": _decode_evolved,
    "from_prefix": _decode_prefix,
    "write": _write,
    "read": _read,
    "evolve": _evolve,
    "_snapshot_": _snapshot,
}
"""The functions that can be compiled for a type, by kind."""
