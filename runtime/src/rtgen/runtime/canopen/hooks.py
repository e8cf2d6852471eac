"""Interface between generated code and the base classes of proxies and devices.

`CanopenProxy` derives from `ProxyHooks`, `CanopenDevice` from `DeviceHooks`. In generated code,
with the package `refrobots` and the module `EposDrive`:

- `EposDriveProxyBase(CanopenProxy)` has the ports and the configuration, and
  `EposDriveProxy(EposDriveProxyBase)` implements the hooks, both in
  `refrobots.components.epos_drive_proxy`.
- `EposDriveSlave(CanopenDevice)` implements them for a device and has `objects`;
  `EposDriveDeviceBase(EposDriveSlave)` has the ports and the configuration, both in
  `refrobots.components.epos_drive_device`.
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
"""Function that writes a PDO's data to OutPorts, with the time of arrival (component's clock, ns).

Raises PdoError for data that are too short.
"""

Sender: TypeAlias = Callable[[], Iterator[bytes]]
"""Function that yields the data of a PDO for each unread sample of the InPorts.

Raises PdoError for a value outside its field's range; later samples remain available.
"""

Getter: TypeAlias = Callable[[ObjectNumber], Any]
"""Function that returns the value (ObjectValue) of an object of the device's object dictionary."""

Setter: TypeAlias = Callable[[ObjectNumber, ObjectValue], None]
"""Function that sets an object of the device's object dictionary."""

Incoming: TypeAlias = Callable[[Getter, int], tuple[tuple[str, Any], ...]]
"""Function that converts a received RPDO to samples, each with the name of its InPort."""

Outgoing: TypeAlias = Callable[[Any, Setter], None]
"""Function that stores a sample in the object dictionary. Raises PdoError for an invalid value."""


class CanopenHooks(ABC):
    """Attributes of proxies and devices."""

    description: ClassVar[DeviceDescription]
    """The description of the device."""
    networks: ClassVar[str] = ""
    """The package of the generated networks, empty if there are none; each module has `NETWORK`."""


class ProxyHooks(CanopenHooks):
    """Methods that a generated `<Module>Proxy` implements."""

    @abstractmethod
    def _receivers(self) -> Mapping[int, Receiver]:
        """Return the receivers by TPDO number; called once, during construction."""

    @abstractmethod
    def _senders(self) -> Mapping[int, Sender]:
        """Return the senders by RPDO number; called once, during construction."""

    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:
        """Return the configuration parameters that correspond to objects, as values of the objects.

        Raises PdoError for a parameter outside the range of its object's type.
        """
        return {}

    @abstractmethod
    def read_object(self, index: int, subindex: int = 0) -> ObjectValue:
        """Read an object by SDO, for the generated servant of the SDO service.

        Long values are read by block transfer. Raises SdoAbort or LinkError. Defined by
        `CanopenProxy`.
        """

    @abstractmethod
    def write_object(self, index: int, subindex: int, value: ObjectValue) -> None:
        """Write an object by SDO. Errors as `read_object`, and ValueError for an invalid value."""

    @abstractmethod
    def read_octets(self, index: int, subindex: int) -> bytes:
        """Read the octets of any object, even one that is not in the description.

        Errors as `read_object`. Defined by `CanopenProxy`.
        """

    @abstractmethod
    def write_octets(self, index: int, subindex: int, value: bytes) -> None:
        """Write the octets of any object; see `read_octets`."""


class DeviceHooks(CanopenHooks):
    """Methods that a generated `<Module>DeviceBase` implements.

    Samples are converted to and from the object dictionary field by field, so that any mapping
    written by a master is supported: a sample of an InPort holds the objects of the default
    mapping.
    """

    @abstractmethod
    def get_object(self, number: ObjectNumber) -> Any:
        """Return the value (ObjectValue) of an object. Raises KeyError for an unknown object.

        Defined by `CanopenDevice`.
        """

    @abstractmethod
    def set_object(self, number: ObjectNumber, value: ObjectValue) -> None:
        """Set an object on behalf of the application: type and limits are checked, access is not.

        TPDOs that map the object are sent according to their transmission types. Raises KeyError
        for an unknown object, ValueError for an invalid value. Defined by `CanopenDevice`.
        """

    @abstractmethod
    def _incoming(self) -> Mapping[int, Incoming]:
        """Return the converters by RPDO number; called once, during construction."""

    @abstractmethod
    def _outgoing(self) -> Mapping[str, Outgoing]:
        """Return the converters by OutPort name; called once, during construction."""
