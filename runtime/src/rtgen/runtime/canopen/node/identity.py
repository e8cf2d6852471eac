"""The identity object of a device (1018h; CiA 301, 7.5.2.18) and its LSS address (CiA 305)."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.description import DeviceDescription
from rtgen.runtime.canopen.node.object_dictionary import DeviceDictionary
from rtgen.runtime.canopen.wire.lss import LssAddress

IDENTITY: Final = 0x1018
SERIAL_NUMBER: Final = (IDENTITY, 4)


def preset_identity(
    dictionary: DeviceDictionary,
    description: DeviceDescription,
    serial_number: int | None,
) -> None:
    """Set the entries of 1018h that are 0 in the description, and a given serial number."""
    for sub, value in enumerate(_numbers(description), 1):
        if not dictionary.number((IDENTITY, sub)):
            _preset(dictionary, sub, value)
    if serial_number is not None:
        _preset(dictionary, SERIAL_NUMBER[1], serial_number)


def lss_address(
    dictionary: DeviceDictionary,
    description: DeviceDescription,
    serial_number: int | None,
) -> LssAddress:
    """Return the numbers of 1018h, falling back to the description."""
    defaults = (*_numbers(description), serial_number or 0)
    return LssAddress(
        *(
            dictionary.number((IDENTITY, sub), default)
            for sub, default in enumerate(defaults, 1)
        )
    )


def _numbers(description: DeviceDescription) -> tuple[int, int, int]:
    return (
        description.vendor_id,
        description.product_code,
        description.revision_number,
    )


def _preset(dictionary: DeviceDictionary, sub: int, value: int) -> None:
    if (IDENTITY, sub) in dictionary:
        dictionary.preset((IDENTITY, sub), value)
