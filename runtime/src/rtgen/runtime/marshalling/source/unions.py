"""Generates the source text of the codecs of unions."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from rtgen.runtime.marshalling.descriptors import BranchDescriptor, UnionDescriptor
from rtgen.runtime.marshalling.dynamic.initial import initial_value
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.marshalling.layouts.layout import (
    ANYWHERE,
    Position,
    steps_of,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    Form,
)
from rtgen.runtime.marshalling.layouts.trees import (
    DISCRIMINATOR,
    has_list,
    is_delimited,
    tree_of,
    union_members,
)
from rtgen.runtime.marshalling.source.copier import Copier
from rtgen.runtime.marshalling.source.decoder import Decoder
from rtgen.runtime.marshalling.source.encoder import Encoder
from rtgen.runtime.marshalling.source.references import References

_PATH = (DISCRIMINATOR,)


def encode(
    descriptor: UnionDescriptor, encoder: Encoder, refer: References
) -> list[str]:
    """Return the body of a function that appends a union to a buffer."""
    switch = _switch(descriptor, refer.format)
    listed = has_list(descriptor, refer.format)
    members = dict(union_members(descriptor, refer.format)) if listed else {}
    body = encoder.body
    chosen = "value.discriminator"
    if switch.form in (Form.BOOLEAN, Form.ENUMERATOR):
        chosen = encoder.convert.packed(switch, chosen)
    body.add(f"discriminator = {chosen}")
    delimited = is_delimited(descriptor, refer.format)
    if delimited:
        encoder.begin_delimited("start")
    encoder.bind(_PATH, "discriminator")
    encoder.steps(steps_of(members.get(DISCRIMINATOR, switch), ANYWHERE), _PATH)
    body.add("inner = value.value")
    for head, branch in choices(descriptor, "discriminator"):
        body.block(head)
        body.choose_here()
        node = members.get(branch.attribute) or tree_of(branch.type, refer.format)
        steps = steps_of(node, ANYWHERE if listed else _position_after(switch))
        path = (branch.attribute,)
        encoder.bind(path, "inner")
        encoder.steps(steps, path)
        if not steps:
            body.add("pass")
        body.end()
    if not _complete(descriptor):
        body.block("elif inner is not None:")
        body.add('raise ValueError("no branch is selected")')
        body.end()
    if delimited:
        body.choose_here()
        encoder.put_length("start")
    elif listed:
        body.choose_here()
        encoder.end_list()
    return body.lines


def decode(
    descriptor: UnionDescriptor, decoder: Decoder, refer: References
) -> list[str]:
    """Return the body of a function that reads a union at an offset."""
    delimited = is_delimited(descriptor, refer.format)
    if delimited:
        decoder.take_length("end")
    if has_list(descriptor, refer.format):
        return _decode_list(descriptor, decoder, refer, "end" if delimited else None)
    evolving = delimited and refer.evolving
    switch = _switch(descriptor, refer.format)
    body = decoder.body
    if evolving:
        decoder.enclose()
    decoder.steps(steps_of(switch, ANYWHERE), _PATH)
    body.add(f"selected = {decoder.value(switch, _PATH)}")
    for head, branch in choices(descriptor, "selected"):
        body.block(head)
        body.choose_here()
        if evolving:
            body.block("if offset >= end:")
            body.add(f"value = {_initial(branch, refer)}")
            body.end()
            body.block("else:")
        node = tree_of(branch.type, refer.format)
        path = (branch.attribute,)
        decoder.steps(steps_of(node, _position_after(switch)), path)
        body.add(f"value = {decoder.value(node, path)}")
        if evolving:
            body.end()
        body.end()
    _no_value(descriptor, decoder)
    if delimited and not evolving:
        decoder.refuse("offset != end")
    end = "end" if evolving else "offset"
    body.add(f"return {refer.made(descriptor)}(selected, value), {end}")
    return body.lines


def _position_after(switch: Atom) -> Position:
    """Return what is known of the offset after a discriminator."""
    return ANYWHERE.aligned(switch.align).after(switch.size)


def _decode_list(
    descriptor: UnionDescriptor, decoder: Decoder, refer: References, end: str | None
) -> list[str]:
    """Return the body for a mutable union: discriminator and value in a list of members."""
    body = decoder.body
    decoder.listed(union_members(descriptor, refer.format), (), end)
    found = decoder.found(())
    body.add(f"selected = {found}[{DISCRIMINATOR!r}]")
    for head, branch in choices(descriptor, "selected"):
        body.block(head)
        body.block(f"if {branch.attribute!r} in {found}:")
        body.add(f"value = {found}[{branch.attribute!r}]")
        body.end()
        body.block("else:")
        body.add(f"value = {_initial(branch, refer)}")
        body.end()
        body.end()
    _no_value(descriptor, decoder)
    body.add(f"return {refer.made(descriptor)}(selected, value), offset")
    return body.lines


def _initial(branch: BranchDescriptor, refer: References) -> str:
    arguments = refer.descriptor(branch.type)
    if branch.initial is not None:
        arguments += f", {refer.namespace.bind('initial', branch.initial)}"
    return f"{refer.function(initial_value)}({arguments})"


def _no_value(descriptor: UnionDescriptor, decoder: Decoder) -> None:
    """Return the value if the discriminator selects no branch."""
    if not _complete(descriptor):
        decoder.body.block("else:")
        decoder.body.add("value = None")
        decoder.body.end()


def copy(
    descriptor: UnionDescriptor, copier: Copier, refer: References, format_: Format
) -> list[str]:
    """Return the body of `_snapshot_`, from the branches' trees in a format."""
    class_ = refer.made(descriptor)
    body = copier.body
    body.add("inner = self.value")
    body.add("selected = self.discriminator")
    copied = []
    for head, branch in choices(descriptor, "selected"):
        body.block(head)
        copied.append(copier.copy(tree_of(branch.type, format_), "inner", ("inner",)))
        body.add("pass" if copied[-1] == "inner" else f"inner = {copied[-1]}")
        body.end()
    if all(text == "inner" for text in copied):
        return [f"return {class_}(self.discriminator, self.value)"]
    return [*body.lines, f"return {class_}(selected, inner)"]


def _switch(descriptor: UnionDescriptor, format_: Format) -> Atom:
    switch = tree_of(descriptor.switch, format_)
    assert isinstance(switch, Atom)
    return switch


def _complete(descriptor: UnionDescriptor) -> bool:
    """Return whether a `default` label covers every discriminator without a branch."""
    return any(branch.default for branch in descriptor.branches)


def choices(
    descriptor: UnionDescriptor, variable: str
) -> Iterator[tuple[str, BranchDescriptor]]:
    """Yield the condition of each branch; the default one is last."""
    word = "if"
    for branch in sorted(descriptor.branches, key=lambda branch: branch.default):
        labels = [repr(x.value if isinstance(x, Enum) else x) for x in branch.labels]
        if branch.default:
            yield ("else:" if word == "elif" else "if True:"), branch
        elif len(labels) == 1:
            yield f"{word} {variable} == {labels[0]}:", branch
        else:
            yield f"{word} {variable} in ({', '.join(labels)}):", branch
        word = "elif"
