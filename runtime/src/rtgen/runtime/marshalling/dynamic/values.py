"""Marshals whole values by their descriptors."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from rtgen.runtime.marshalling.dynamic.faults import decoding_error, encoding_error
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.errors import FAILURES, Buffer


def encoded(descriptor: Any, value: object, little_endian: bool) -> bytes:
    """Encode a value by its descriptor. Raises CdrError."""
    out = Output()
    try:
        Writer(out, little_endian).value(descriptor, value)
    except FAILURES as failure:
        raise encoding_error(descriptor, value, failure) from failure
    return bytes(out)


def deep_copy(value: Any) -> Any:
    """Return a deep copy. Raises CdrError if the value holds a view and cannot be encoded."""
    try:
        return deepcopy(value)
    except TypeError:  # Python cannot copy views of memory; a decoded value has none
        return type(value).from_cdr(value.to_cdr())


def decoded(descriptor: Any, data: Buffer, little_endian: bool) -> Any:
    """Decode a value by its descriptor. Raises CdrError."""
    try:
        reader = Reader(data, little_endian)
        value = reader.value(descriptor)
        reader.end()
    except FAILURES as failure:
        raise decoding_error(descriptor, data, little_endian, failure) from failure
    return value
