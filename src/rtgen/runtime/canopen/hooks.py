"""What generated code gives to the bases of proxies and devices, and what it takes from them.

`CanopenProxy` derives from `ProxyHooks`, `CanopenDevice` from `DeviceHooks`. In
generated code, with the package `refrobots` and the module `EposDrive`:

- `EposDriveProxyBase(CanopenProxy)` has the ports and the configuration, and
  `refrobots.canopen.epos_drive.proxy.EposDriveProxy(EposDriveProxyBase)` fills the hooks in.
- `refrobots.canopen.epos_drive.device.EposDriveSlave(CanopenDevice)` fills them in for a device and
  has `objects`; `EposDriveDeviceBase(EposDriveSlave)` has the ports and the configuration.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, TypeAlias

from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectNumber,
    ObjectValue,
)

Receiver: TypeAlias = Callable[[bytes, int], None]
"""Writes the data of a PDO, which came at a time (component's clock, ns), to OutPorts.

Raises PdoError for data that are too short.
"""

Sender: TypeAlias = Callable[[], Iterator[bytes]]
"""Reads what InPorts have that is unread, and gives the data of a PDO for each of the samples.

Raises PdoError for a value that its field cannot have; the samples behind it can still be had.
"""

Getter: TypeAlias = Callable[[ObjectNumber], Any]
"""Gives the value (ObjectValue) of a variable of the device's object dictionary."""

Setter: TypeAlias = Callable[[ObjectNumber, ObjectValue], None]
"""Sets the value of a variable of the device's object dictionary."""

Incoming: TypeAlias = Callable[[Getter, int], tuple[tuple[str, Any], ...]]
"""Makes the samples of an RPDO that came at a time, each with the name of its InPort."""

Outgoing: TypeAlias = Callable[[Any, Setter], None]
"""Puts a sample into the object dictionary. Raises PdoError for a value that it cannot have."""


class CanopenHooks(ABC):
    """What both need."""

    description: ClassVar[DeviceDescription]
    """The device."""
    networks: ClassVar[str] = ""
    """The package of the generated networks, empty if there is none; each has `NETWORK`."""


class ProxyHooks(CanopenHooks):
    """What a generated `<Module>Proxy` gives."""

    @abstractmethod
    def _receivers(self) -> Mapping[int, Receiver]:
        """By the number of the device's TPDO; asked once, when the proxy is made."""

    @abstractmethod
    def _senders(self) -> Mapping[int, Sender]:
        """By the number of the device's RPDO; asked once, when the proxy is made."""

    @abstractmethod
    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:
        """The configuration parameters that are objects of the device, as values of these.

        Raises PdoError for one that is outside of its object's type.
        """

    @abstractmethod
    def read_object(self, index: int, subindex: int = 0) -> ObjectValue:
        """Reads a variable of the device by SDO, for the generated servant of the SDO service.

        In blocks where that is worth it. Raises SdoAbort or LinkError. `CanopenProxy` defines it.
        """

    @abstractmethod
    def write_object(self, index: int, subindex: int, value: ObjectValue) -> None:
        """Writes one, as `read_object`; ValueError if the variable cannot have the value."""

    @abstractmethod
    def read_octets(self, index: int, subindex: int) -> bytes:
        """The octets of any object, also of one that the description does not have.

        Errors as `read_object`. `CanopenProxy` defines it.
        """

    @abstractmethod
    def write_octets(self, index: int, subindex: int, value: bytes) -> None:
        """Writes the octets of any object, as `read_octets`."""


class DeviceHooks(CanopenHooks):
    """What a generated `<Module>DeviceBase` gives.

    Samples and the object dictionary are converted by fields, so that it works for every mapping
    that a master may write: a sample of an InPort holds the objects of the default mapping.
    """

    @abstractmethod
    def get_object(self, number: ObjectNumber) -> Any:
        """The value (ObjectValue) of a variable of the object dictionary; KeyError if unknown.

        `CanopenDevice` defines it.
        """

    @abstractmethod
    def set_object(self, number: ObjectNumber, value: ObjectValue) -> None:
        """Sets one, as the application does: access is not asked for, type and limits are.

        What TPDOs carry of it goes out by their rules. KeyError if unknown, ValueError for a value
        that it cannot have. `CanopenDevice` defines it.
        """

    @abstractmethod
    def _incoming(self) -> Mapping[int, Incoming]:
        """By RPDO number; asked once, when the component is made."""

    @abstractmethod
    def _outgoing(self) -> Mapping[str, Outgoing]:
        """By OutPort name; asked once, when the component is made."""
