"""The source text of the codecs of unions."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from rtgen.runtime.descriptors import BranchDescriptor, UnionDescriptor
from rtgen.runtime.marshalling.copier import Copier
from rtgen.runtime.marshalling.decoder import Decoder
from rtgen.runtime.marshalling.encoder import Encoder
from rtgen.runtime.marshalling.formats import Format, NotCompiledError
from rtgen.runtime.marshalling.layout import ANYWHERE, Atom, Form, steps_of
from rtgen.runtime.marshalling.references import References
from rtgen.runtime.marshalling.trees import tree_of

_DISCRIMINATOR = ("discriminator",)


def encode(
    descriptor: UnionDescriptor, encoder: Encoder, refer: References
) -> list[str]:
    """The body of a function that appends a union to a buffer."""
    switch = _switch(descriptor, refer.format)
    body = encoder.body
    chosen = "value.discriminator"
    if switch.form in (Form.BOOLEAN, Form.ENUMERATOR):
        chosen = encoder.convert.packed(switch, chosen)
    body.add(f"discriminator = {chosen}")
    delimited = _is_delimited(descriptor, refer.format)
    if delimited:
        body.add('out += bytes(-len(out) & 3) + b"\\0\\0\\0\\0"')
        body.add("start = len(out)")
    encoder.bind(_DISCRIMINATOR, "discriminator")
    encoder.steps(steps_of(switch, ANYWHERE), _DISCRIMINATOR)
    body.add("inner = value.value")
    for head, branch in _choices(descriptor, "discriminator"):
        body.block(head)
        body.choose_here()
        steps = steps_of(tree_of(branch.type, refer.format), ANYWHERE)
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
    return body.lines


def decode(
    descriptor: UnionDescriptor, decoder: Decoder, refer: References
) -> list[str]:
    """The body of a function that reads a union at an offset."""
    switch = _switch(descriptor, refer.format)
    made = refer.made(descriptor)
    body = decoder.body
    if _is_delimited(descriptor, refer.format):
        decoder.take_length("end")
    decoder.steps(steps_of(switch, ANYWHERE), _DISCRIMINATOR)
    body.add(f"selected = {decoder.value(switch, _DISCRIMINATOR)}")
    for head, branch in _choices(descriptor, "selected"):
        body.block(head)
        body.choose_here()
        node = tree_of(branch.type, refer.format)
        path = (branch.attribute,)
        decoder.steps(steps_of(node, ANYWHERE), path)
        body.add(f"value = {decoder.value(node, path)}")
        body.end()
    if not _complete(descriptor):
        body.block("else:")
        body.add("value = None")
        body.end()
    if _is_delimited(descriptor, refer.format):
        decoder.refuse("offset != end")
    body.add(f"return {made}(selected, value), offset")
    return body.lines


def copy(descriptor: UnionDescriptor, copier: Copier, refer: References) -> list[str]:
    """The body of `_snapshot_`."""
    made = refer.made(descriptor)
    body = copier.body
    body.add("inner = self.value")
    body.add("selected = self.discriminator")
    copied = []
    for head, branch in _choices(descriptor, "selected"):
        body.block(head)
        copied.append(
            copier.copy(tree_of(branch.type, refer.format), "inner", ("inner",))
        )
        body.add("pass" if copied[-1] == "inner" else f"inner = {copied[-1]}")
        body.end()
    if all(text == "inner" for text in copied):
        return [f"return {made}(self.discriminator, self.value)"]
    return [*body.lines, f"return {made}(selected, inner)"]


def _switch(descriptor: UnionDescriptor, format_: Format) -> Atom:
    switch = tree_of(descriptor.switch, format_)
    assert isinstance(switch, Atom)
    return switch


def _is_delimited(descriptor: UnionDescriptor, format_: Format) -> bool:
    """Whether a DHEADER precedes the union. Raises NotCompiledError for a parameter list."""
    if format_.version and descriptor.extensibility == "mutable":
        raise NotCompiledError("a parameter list")
    return format_.version == 2 and descriptor.extensibility == "appendable"


def _complete(descriptor: UnionDescriptor) -> bool:
    """Whether a `default` label covers every discriminator without a branch."""
    return any(branch.default for branch in descriptor.branches)


def _choices(
    descriptor: UnionDescriptor, variable: str
) -> Iterator[tuple[str, BranchDescriptor]]:
    """The condition of each branch; the default one is last."""
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
