"""Marshals whole values by their descriptors, and locates errors of compiled codecs."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from rtgen.runtime.marshalling.dynamic.octet_reader import Input
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.errors import FAILURES, Buffer, CdrError, Fault

_TOO_DEEP = "the value contains itself, or is nested too deeply"


def encoded(descriptor: Any, value: object, little_endian: bool) -> bytes:
    """Encode a value by its descriptor. Raises CdrError."""
    out = Output()
    try:
        Writer(out, little_endian).value(descriptor, value)
    except FAILURES as failure:
        name = _root(descriptor)
        raise fault_in_value(descriptor, name, value, failure) from failure
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
        name = _root(descriptor)
        raise fault_in_octets(
            descriptor, name, data, little_endian, failure
        ) from failure
    return value


def fault_in_value(
    descriptor: Any, root: str, value: object, failure: Exception
) -> CdrError:
    """Return the first error of a value that could not be encoded; its path starts at `root`."""
    try:
        Writer(Output(), True, walking=True).value(descriptor, value)
    except FAILURES as found:
        failure = found
    return _error(root, failure)


def fault_in_octets(
    descriptor: Any, root: str, data: Buffer, little_endian: bool, failure: Exception
) -> CdrError:
    """Return the first error of octets that could not be decoded; its path starts at `root`."""
    try:
        octets = Input(data)
    except TypeError:
        return CdrError(root, f"octets are needed, not {type(data).__name__}")
    try:
        reader = Reader(octets, little_endian, walking=True)
        reader.value(descriptor)
        reader.end()
    except FAILURES as found:
        failure = found
    return _error(root, failure)


def _root(descriptor: Any) -> str:
    return str(descriptor.name).rpartition("::")[2]


def _error(root: str, failure: Exception) -> CdrError:
    if isinstance(failure, Fault):
        return failure.error(root)
    if isinstance(failure, RecursionError):
        return CdrError(root, _TOO_DEEP)
    return CdrError(root, str(failure) or type(failure).__name__)
