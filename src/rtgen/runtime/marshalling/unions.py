"""The source text of the codecs of unions."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from rtgen.runtime.descriptors import BranchDescriptor, UnionDescriptor
from rtgen.runtime.marshalling.copier import Copier
from rtgen.runtime.marshalling.decoder import Decoder
from rtgen.runtime.marshalling.encoder import Encoder
from rtgen.runtime.marshalling.layout import ANYWHERE, Atom, Form, steps_of
from rtgen.runtime.marshalling.references import References
from rtgen.runtime.marshalling.trees import tree_of

_DISCRIMINATOR = ("discriminator",)


def encode(
    descriptor: UnionDescriptor, encoder: Encoder, refer: References
) -> list[str]:
    """The body of a function that appends a union to a buffer."""
    switch = _switch(descriptor)
    body = encoder.body
    chosen = "value.discriminator"
    if switch.form in (Form.BOOLEAN, Form.ENUMERATOR):
        chosen = encoder.convert.packed(switch, chosen)
    body.add(f"discriminator = {chosen}")
    encoder.bind(_DISCRIMINATOR, "discriminator")
    encoder.steps(steps_of(switch, ANYWHERE), _DISCRIMINATOR)
    body.add("inner = value.value")
    for head, branch in _choices(descriptor, "discriminator"):
        body.block(head)
        body.choose_here()
        steps = steps_of(tree_of(branch.type), ANYWHERE)
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
    return body.lines


def decode(
    descriptor: UnionDescriptor, decoder: Decoder, refer: References
) -> list[str]:
    """The body of a function that reads a union at an offset."""
    switch = _switch(descriptor)
    made = refer.made(descriptor)
    body = decoder.body
    decoder.steps(steps_of(switch, ANYWHERE), _DISCRIMINATOR)
    body.add(f"selected = {decoder.value(switch, _DISCRIMINATOR)}")
    for head, branch in _choices(descriptor, "selected"):
        body.block(head)
        body.choose_here()
        node = tree_of(branch.type)
        path = (branch.attribute,)
        decoder.steps(steps_of(node, ANYWHERE), path)
        body.add(f"return {made}(selected, {decoder.value(node, path)}), offset")
        body.end()
    if not _complete(descriptor):
        body.add(f"return {made}(selected, None), offset")
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
        copied.append(copier.copy(tree_of(branch.type), "inner", ("inner",)))
        body.add("pass" if copied[-1] == "inner" else f"inner = {copied[-1]}")
        body.end()
    if all(text == "inner" for text in copied):
        return [f"return {made}(self.discriminator, self.value)"]
    return [*body.lines, f"return {made}(selected, inner)"]


def _switch(descriptor: UnionDescriptor) -> Atom:
    switch = tree_of(descriptor.switch)
    assert isinstance(switch, Atom)
    return switch


def _complete(descriptor: UnionDescriptor) -> bool:
    """Whether every discriminator has a branch by `default`."""
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
