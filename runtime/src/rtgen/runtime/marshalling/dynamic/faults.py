"""Errors of compiled codecs of classic CDR, which are located only after a failure."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.errors import Buffer, CdrError, Fault
from rtgen.runtime.marshalling.layouts.formats import Format


def encoding_error(descriptor: Any, value: object, failure: Exception) -> CdrError:
    """Return the error for a value whose encoding failed."""
    from rtgen.runtime.marshalling.dynamic.values import fault_in_value

    return fault_in_value(descriptor, _name(descriptor), value, failure)


def decoding_error(
    descriptor: Any, data: Buffer, little_endian: bool, failure: Exception
) -> CdrError:
    """Return the error for octets whose decoding failed."""
    from rtgen.runtime.marshalling.dynamic.values import fault_in_octets

    name = _name(descriptor)
    return fault_in_octets(descriptor, name, data, little_endian, failure)


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

    name = _name(descriptor)
    try:
        octets = bytes(memoryview(data))
    except TypeError:
        return CdrError(name, f"octets are needed, not {type(data).__name__}")
    if isinstance(failure, RecursionError):
        return CdrError(name, "the value is nested too deeply")
    fault = fault_in_body(descriptor, octets, format_, little_endian, exact=exact)
    return (fault or Fault(str(failure))).error(name)


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
