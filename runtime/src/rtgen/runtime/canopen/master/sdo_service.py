"""The SDO service of generated proxies."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from rtgen.facts.canopen import UNSIGNED_KINDS
from rtgen.runtime.canopen.description import ObjectValue
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.hooks import ProxyHooks
from rtgen.runtime.canopen.pdo import seconds_of, terminated, unscaled
from rtgen.runtime.canopen.wire import sdo


def value_kind(value: ObjectValue, *, unsigned: bool) -> int:
    """Return the enumerator of CANopen::ValueKind for a value."""
    match value:
        case bool():
            return 0
        case int():
            return 2 if unsigned else 1
        case float():
            return 3
        case str():
            return 4
    return 5


class SdoService:
    """Base class of generated servants of CANopen::ObjectDictionary and derived interfaces.

    A subclass provides the classes of its IDL: the exceptions CANopen::SdoAbort and
    CANopen::BusGone, the union CANopen::ObjectValue and the enum CANopen::ValueKind.
    """

    aborted: ClassVar[type[Any]]
    gone: ClassVar[type[Any]]
    typed_value: ClassVar[type[Any]]
    kind: ClassVar[type[Any]]

    def __init__(self, proxy: ProxyHooks) -> None:
        self._proxy = proxy

    def get(self, index: int, subindex: int) -> Any:
        """Return the value of an object, with its kind."""
        value: ObjectValue = self._get(index, subindex)
        if isinstance(value, str):
            value = terminated(value)  # a character is a text, too
        described = self._proxy.description.by_number.get((index, subindex))
        unsigned = described is not None and described.kind in UNSIGNED_KINDS
        return self.typed_value(self.kind(value_kind(value, unsigned=unsigned)), value)

    def set(self, index: int, subindex: int, value: Any) -> None:
        """Set the value of an object."""
        self._set(index, subindex, value.value)

    def _get(self, index: int, subindex: int, factor: float | None = None) -> Any:
        """Return the value of an object; with a factor, the physical one: factor * value."""
        with self._idl_exceptions():
            value: Any = self._proxy.read_object(index, subindex)
        described = self._proxy.description.by_number.get((index, subindex))
        if described is not None and described.kind in ("string", "wstring"):
            return terminated(value)
        return value if factor is None else value * factor

    def _get_time(self, index: int, subindex: int) -> tuple[int, int]:
        """Return the value of an object, a time, as `RTC::Time` has it."""
        described = self._proxy.description.by_number[index, subindex]
        with self._idl_exceptions():
            value: Any = self._proxy.read_object(index, subindex)
            return seconds_of(described.name, value)

    def _set(
        self, index: int, subindex: int, value: Any, factor: float | None = None
    ) -> None:
        """Set the value of an object; with a factor, from the physical one."""
        with self._idl_exceptions():
            if factor is not None:
                described = self._proxy.description.by_number[index, subindex]
                real = described.kind in ("r32", "r64")
                value = (
                    value / factor if real else unscaled(described.name, value, factor)
                )
            self._proxy.write_object(index, subindex, value)

    def read(self, index: int, subindex: int) -> bytes:
        """Return the octets of an object."""
        with self._idl_exceptions():
            return self._proxy.read_octets(index, subindex)

    def write(self, index: int, subindex: int, value: bytes) -> None:
        """Set the octets of an object."""
        with self._idl_exceptions():
            self._proxy.write_octets(index, subindex, value)

    @contextmanager
    def _idl_exceptions(self) -> Iterator[None]:
        """Convert errors to exceptions of the IDL; an invalid value becomes a local SDO abort."""
        try:
            yield
        except sdo.SdoAbort as error:
            raise self.aborted(error.code, str(error)) from error
        except LinkError as error:
            raise self.gone(str(error)) from error
        except ValueError as error:
            code = getattr(error, "code", sdo.VALUE_INVALID)
            raise self.aborted(code, str(error)) from error
