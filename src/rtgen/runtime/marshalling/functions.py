"""The source text (head and body) of each function compiled for a type."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, TypeAlias

from rtgen.runtime.cdr import FAILURES, decoding_error, encoding_error
from rtgen.runtime.descriptors import AliasDescriptor, UnionDescriptor
from rtgen.runtime.marshalling import unions
from rtgen.runtime.marshalling.copier import Copier
from rtgen.runtime.marshalling.decoder import Decoder
from rtgen.runtime.marshalling.encoder import Encoder
from rtgen.runtime.marshalling.layout import (
    ANYWHERE,
    ORIGIN,
    Delimited,
    Node,
    Run,
    steps_of,
)
from rtgen.runtime.marshalling.references import References
from rtgen.runtime.marshalling.trees import body_of, has_headers, is_dynamic, tree_of

Function: TypeAlias = tuple[str, list[str]]
"""The head of a function and the lines of its body."""


def _encode(descriptor: Any, refer: References) -> Function:
    """The whole body of a value."""
    name = "value" if isinstance(descriptor, AliasDescriptor) else "self"
    lines = _encoding(descriptor, refer, name)
    failure = (
        f"{refer.function(encoding_error)}({refer.descriptor(descriptor)}, {name}, "
    )
    head = f"def to_cdr({name}, little_endian=True):"
    return head, _guarded(refer, lines, f"raise {failure}failure) from failure")


def _decode(descriptor: Any, refer: References) -> Function:
    """The value of a whole body."""
    lines = _decoding(descriptor, refer)
    head = "def from_cdr(cls, data, little_endian=True):"
    version = refer.format.version
    if version:
        from rtgen.runtime.xcdr import decode_in_steps

        again = (
            f"{refer.function(decode_in_steps)}(cls, data, {version}, little_endian)"
        )
        return head, _guarded(refer, lines, f"return {again}")
    failure = (
        f"{refer.function(decoding_error)}({refer.descriptor(descriptor)}, data, "
        "little_endian, failure)"
    )
    return head, _guarded(refer, lines, f"raise {failure} from failure")


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
        from rtgen.runtime.cdr_writer import Output

        out = refer.function(Output)
    if isinstance(descriptor, UnionDescriptor):
        lines = [f"{refer.writer(descriptor)}({name}, out, little_endian)"]
    else:
        encoder = Encoder(refer)
        steps = steps_of(_node(descriptor, refer), ORIGIN)
        if not steps:
            return ['return b""']
        if len(steps) == 1 and isinstance(steps[0], Run):
            return encoder.whole(steps[0], name)
        lines = encoder.parts(steps, name)
    return [f"out = {out}()", *lines, "return bytes(out)"]


def _decoding(descriptor: Any, refer: References) -> list[str]:
    first = []
    if is_dynamic(descriptor):
        from rtgen.runtime.cdr_reader import Input

        first = [f"data = {refer.function(Input)}(data)"]
    if isinstance(descriptor, UnionDescriptor):
        made = refer.made(descriptor)
        return [
            *first,
            f"value, offset = {refer.reader(descriptor)}(data, 0, little_endian)",
            "if offset != len(data):",
            '    raise ValueError("octets too many")',
            f"same = cls is {made}",
            "return value if same else cls(value.discriminator, value.value)",
        ]
    decoder = Decoder(refer)
    node = _node(descriptor, refer)
    steps = steps_of(node, ORIGIN)
    if len(steps) == 1 and isinstance(steps[0], Run) and _is_fixed(steps[0]):
        return decoder.fixed(steps[0], node)
    return [*first, *decoder.whole(steps, node)]


def _node(descriptor: Any, refer: References) -> Node:
    """The tree of a type other than a union."""
    if isinstance(descriptor, AliasDescriptor):
        return tree_of(descriptor.target, refer.format)
    body = body_of(descriptor, refer.format)
    extensibility = getattr(descriptor, "extensibility", "final")
    if refer.format.version == 2 and extensibility == "appendable":
        return Delimited(body)
    return body


def _is_fixed(run: Run) -> bool:
    return len(run.sections) == 1 and run.sections[0].settled


def _write(descriptor: Any, refer: References) -> Function:
    """Appends a value to a body."""
    encoder = Encoder(refer)
    if isinstance(descriptor, UnionDescriptor):
        lines = unions.encode(descriptor, encoder, refer)
    else:
        steps = steps_of(_node(descriptor, refer), ANYWHERE)
        lines = encoder.parts(steps, "value")
    return "def write(value, out, little_endian):", lines or ["pass"]


def _read(descriptor: Any, refer: References) -> Function:
    """The value at an offset, and the offset behind it."""
    decoder = Decoder(refer)
    if isinstance(descriptor, UnionDescriptor):
        lines = unions.decode(descriptor, decoder, refer)
    else:
        node = _node(descriptor, refer)
        lines = decoder.parts(steps_of(node, ANYWHERE), node)
    return "def read(data, offset, little_endian):", lines


def _snapshot(descriptor: Any, refer: References) -> Function:
    """A deep copy; immutable values are shared."""
    head = "def _snapshot_(self):"
    if is_dynamic(descriptor) or has_headers(descriptor):
        return head, [f"return {refer.function(deepcopy)}(self)"]
    copier = Copier(refer)
    if isinstance(descriptor, UnionDescriptor):
        return head, unions.copy(descriptor, copier, refer)
    expression = copier.copy(body_of(descriptor, refer.format), "self")
    return head, [*copier.body.lines, f"return {expression}"]


FUNCTIONS: dict[str, Callable[[Any, References], Function]] = {
    "to_cdr": _encode,
    "from_cdr": _decode,
    "write": _write,
    "read": _read,
    "_snapshot_": _snapshot,
}
"""The functions that can be compiled for a type, by kind."""
