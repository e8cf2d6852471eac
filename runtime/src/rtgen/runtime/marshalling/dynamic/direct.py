"""Selects the types inside an `any` or a valuetype that compiled codecs marshal."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.dynamic.checks import LeastSizes
from rtgen.runtime.marshalling.layouts.formats import UnsupportedError
from rtgen.runtime.marshalling.layouts.trees import has_headers, parts


def compiled_class(descriptor: StructDescriptor | UnionDescriptor) -> Any:
    """Return the class whose `_read_` and `_write_` marshal the type; None without one.

    None for a type without a generated class, one that classic CDR cannot represent, and one with
    an array of elements without octets, of which a few octets could claim any number.
    """
    codecs = descriptor.codecs
    if "class" not in codecs:
        codecs["class"] = _compiled_class(descriptor)
    return codecs["class"]


def _compiled_class(descriptor: StructDescriptor | UnionDescriptor) -> Any:
    class_ = descriptor.class_
    if class_ is None:
        return None
    if has_headers(descriptor) or has_empty_elements(descriptor):
        return None
    try:
        return class_ if class_._read_ and class_._write_ else None
    except UnsupportedError:
        return None


def has_empty_elements(descriptor: Descriptor) -> bool:
    """Return whether a type has an array of elements without octets."""
    sizes = LeastSizes()
    return any(
        isinstance(part, ArrayDescriptor) and not sizes.of(part.element)
        for part in parts(descriptor)
    )
