"""Errors of compiled codecs of classic CDR, which are located only after a failure."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.errors import Buffer, CdrError


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


def _name(descriptor: Any) -> str:
    """Return the unscoped name of a type."""
    return str(descriptor.name).rpartition("::")[2]
