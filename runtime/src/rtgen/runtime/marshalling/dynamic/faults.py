"""Errors of compiled codecs of classic CDR, which are located only after a failure."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.errors import FAILURES, Buffer, CdrError, Fault
from rtgen.runtime.marshalling.layouts.formats import Format

_TOO_DEEP = "the value contains itself, or is nested too deeply"


def encoding_error(descriptor: Any, value: object, failure: Exception) -> CdrError:
    """Return the first error of a value that could not be encoded."""
    from rtgen.runtime.marshalling.dynamic.writer import Output, Writer

    try:
        Writer(Output(), True, walking=True).value(descriptor, value)
    except FAILURES as found:
        failure = found
    return _error(descriptor, failure)


def decoding_error(
    descriptor: Any, data: Buffer, little_endian: bool, failure: Exception
) -> CdrError:
    """Return the first error of octets that could not be decoded."""
    from rtgen.runtime.marshalling.dynamic.octet_reader import Input
    from rtgen.runtime.marshalling.dynamic.reader import Reader

    try:
        octets = Input(data)
    except TypeError:
        return _no_octets(descriptor, data)
    try:
        reader = Reader(octets, little_endian, walking=True)
        reader.value(descriptor)
        reader.end()
    except FAILURES as found:
        failure = found
    return _error(descriptor, failure)


def body_error(
    descriptor: Any,
    data: Buffer,
    format_: Format,
    little_endian: bool,
    failure: Exception,
    *,
    exact: bool = True,
) -> CdrError:
    """Return the error for a body whose decoding failed; located along the layout.

    Not `exact`: octets after the value are no error.
    """
    from rtgen.runtime.marshalling.dynamic.fault_search import fault_in_body

    try:
        octets = bytes(memoryview(data))
    except TypeError:
        return _no_octets(descriptor, data)
    if isinstance(failure, RecursionError):
        return CdrError(_name(descriptor), "the value is nested too deeply")
    fault = fault_in_body(descriptor, octets, format_, little_endian, exact=exact)
    return (fault or Fault(str(failure))).error(_name(descriptor))


def prefix_error(
    descriptor: Any,
    data: Buffer,
    format_: Format,
    little_endian: bool,
    failure: Exception,
) -> CdrError:
    """Return the error for octets that do not begin with a value."""
    return body_error(descriptor, data, format_, little_endian, failure, exact=False)


def _name(descriptor: Any) -> str:
    """Return the unscoped name of a type."""
    return str(descriptor.name).rpartition("::")[2]


def _error(descriptor: Any, failure: Exception) -> CdrError:
    if isinstance(failure, Fault):
        return failure.error(_name(descriptor))
    text = str(failure) or type(failure).__name__
    is_deep = isinstance(failure, RecursionError)
    return CdrError(_name(descriptor), _TOO_DEEP if is_deep else text)


def _no_octets(descriptor: Any, data: object) -> CdrError:
    message = f"octets are needed, not {type(data).__name__}"
    return CdrError(_name(descriptor), message)
