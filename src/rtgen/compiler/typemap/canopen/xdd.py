"""Descriptions in XML (XDD and XDC, CiA 311 V1.1), as sections and keys of CiA 306.

Both formats say the same of objects; a key of an EDS that has no element in CiA 311 is a
`characteristic` of the device function, `EDS [Section] Key`, so that nothing is lost.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from datetime import date
from enum import Enum
from functools import partial
from typing import Final, TypeAlias

import msgspec

from rtgen.compiler.model.canopen import Access, DataType

NAMESPACES: Final = ("http://www.canopen.org/xml/1.1", "http://www.canopen.org/xml/1.0")
"""The namespaces of CiA 311; files are written in the first."""
XSI: Final = "http://www.w3.org/2001/XMLSchema-instance"
CONTAINER: Final = "ISO15745ProfileContainer"
DEVICE_BODY: Final = "ProfileBody_Device_CANopen"
NETWORK_BODY: Final = "ProfileBody_CommunicationNetwork_CANopen"

NO_DATE: Final = "0001-01-01"
"""The date of a file without one, since the schema requires the attribute."""

_DATE = re.compile(r"(\d\d?)-(\d\d?)-(\d{4})")
_TIME = re.compile(r"(\d\d?):(\d\d)\s?([AP])M", re.IGNORECASE)
_XML_DATE = re.compile(r"(\d{4})-(\d\d)-(\d\d)(?:Z|[+-]\d\d:\d\d)?")
_XML_TIME = re.compile(r"(\d\d):(\d\d):\d\d(?:\.\d+)?(?:Z|[+-]\d\d:\d\d)?")
_RATE = re.compile(r"(\d+)\s*[Kk](?:[Bb]ps|[Bb]it/s)")
_FLAGS = {"true": "1", "false": "0"}

EXTENSION: Final = re.compile(r"EDS \[([^\]]*)\] (.*)", re.DOTALL)
"""The name of a characteristic with a key of an EDS."""


Conversion: TypeAlias = Callable[[str], str]


def extension(section: str, key: str) -> str:
    """Return the name of the characteristic with a key of an EDS."""
    return f"EDS [{section}] {key}"


def _same(text: str) -> str:
    return text


def _date_in(text: str) -> str:
    match = _XML_DATE.fullmatch(text)
    if match is None:
        return text
    year, month, day = match.groups()
    return "" if text[:10] == NO_DATE else f"{month}-{day}-{year}"


def _date_out(text: str) -> str:
    match = _DATE.fullmatch(text)
    if match is None:
        return ""
    month, day, year = map(int, match.groups())
    with suppress(ValueError):
        return date(year, month, day).isoformat()
    return ""


def _time_in(text: str) -> str:
    match = _XML_TIME.fullmatch(text)
    if match is None:
        return text
    hour = int(match[1])
    return f"{(hour + 11) % 12 + 1:02}:{match[2]}{'AM' if hour < 12 else 'PM'}"


def _time_out(text: str) -> str:
    match = _TIME.fullmatch(text)
    if match is None or int(match[1]) > 12 or int(match[2]) > 59:
        return ""
    hour = int(match[1]) % 12 + (12 if match[3].upper() == "P" else 0)
    return f"{hour:02}:{match[2]}:00"


def _flag_in(text: str) -> str:
    return _FLAGS.get(text, text)


def _flag_out(text: str) -> str:
    return {"1": "true", "0": "false"}.get(text, "")


def _number_out(text: str) -> str:
    try:
        return str(int(text, 0))
    except ValueError:
        return ""


def rate_in(text: str) -> str:
    """Return a bit rate in kbit/s, of `500 Kbps` or a number; other texts unchanged."""
    match = _RATE.fullmatch(text.strip())
    return text if match is None else match[1]


class Body(Enum):
    """The two profiles of a description."""

    DEVICE = DEVICE_BODY
    NETWORK = NETWORK_BODY


class Field(msgspec.Struct, frozen=True):
    """A key of an EDS, and its place in a profile.

    `path` are the names of the elements below the profile's body. `attribute` is that of the last
    element, or empty for its text. `read` and `write` convert the text. `absent` is written
    without a value, where the schema requires the attribute; `other` is a further name of it.
    """

    body: Body
    path: tuple[str, ...]
    section: str
    key: str
    attribute: str = ""
    read: Conversion = _same
    write: Conversion = _same
    absent: str | None = None
    other: str = ""


_FEATURES = ("NetworkManagement", "CANopenGeneralFeatures")
_MASTER = ("NetworkManagement", "CANopenMasterFeatures")
_COMMISSIONING = ("NetworkManagement", "deviceCommissioning")
_FLAG = (_flag_in, _flag_out)
_NUMBER = (_same, _number_out)


def _identity(section: str, key: str, *path: str) -> Field:
    return Field(Body.DEVICE, ("DeviceIdentity", *path), section, key)


_of_file = partial(Field, Body.DEVICE, (), "FileInfo")
_feature = partial(Field, Body.NETWORK, _FEATURES, "DeviceInfo")
_commissioning = partial(
    Field, Body.NETWORK, _COMMISSIONING, "DeviceComissioning", absent=""
)

FIELDS: Final = (
    _of_file("FileName", "fileName", absent=""),
    _of_file("CreatedBy", "fileCreator", absent=""),
    _of_file("CreationDate", "fileCreationDate", _date_in, _date_out, absent=NO_DATE),
    _of_file("CreationTime", "fileCreationTime", _time_in, _time_out),
    _of_file("ModifiedBy", "fileModifiedBy"),
    _of_file("ModificationDate", "fileModificationDate", _date_in, _date_out),
    _of_file("ModificationTime", "fileModificationTime", _time_in, _time_out),
    _identity("DeviceInfo", "VendorName", "vendorName"),
    _identity("DeviceInfo", "VendorNumber", "vendorID"),
    _identity("DeviceInfo", "ProductName", "productName"),
    _identity("DeviceInfo", "ProductNumber", "productID"),
    _identity("FileInfo", "Description", "productText", "description"),
    _identity("DeviceInfo", "OrderCode", "orderNumber"),
    _feature("GroupMessaging", "groupMessaging", *_FLAG),
    _feature("DynamicChannelsSupported", "dynamicChannels", *_NUMBER),
    _feature("Granularity", "granularity", *_NUMBER, absent="1"),
    _feature("NrOfRXPDO", "nrOfRxPDO", *_NUMBER),
    _feature("NrOfTXPDO", "nrOfTxPDO", *_NUMBER),
    _feature("SimpleBootUpSlave", "bootUpSlave", *_FLAG),
    _feature("LSS_Supported", "layerSettingServiceSlave", *_FLAG),
    Field(
        Body.NETWORK,
        _MASTER,
        "DeviceInfo",
        "SimpleBootUpMaster",
        "bootUpMaster",
        *_FLAG,
    ),
    # CiA 311 calls it nodeID, CANopenEditor's schema and program NodeID.
    _commissioning("NodeID", "NodeID", *_NUMBER, absent="0", other="nodeID"),
    _commissioning("NodeName", "nodeName"),
    _commissioning("Baudrate", "actualBaudRate", rate_in),
    _commissioning("NetNumber", "networkNumber", *_NUMBER, absent="0"),
    _commissioning("NetworkName", "networkName"),
    _commissioning("CANopenManager", "CANopenManager", *_FLAG, absent="false"),
)
"""The keys of an EDS or DCF that are one attribute or element."""

BIT_RATES: Final = (10, 20, 50, 100, 125, 250, 500, 800, 1000)
"""The bit rates that CiA 311 has words for, in kbit/s."""
PRESET_RATE: Final = 250
"""The bit rate that a file which states none has by the schema, which requires one, in kbit/s."""
DUMMIES: Final = range(1, 8)
"""The data types that CiA 311 has gaps of."""

TYPES: Final = {
    "BOOL": DataType.BOOLEAN,
    "SINT": DataType.INTEGER8,
    "INT": DataType.INTEGER16,
    "DINT": DataType.INTEGER32,
    "LINT": DataType.INTEGER64,
    "USINT": DataType.UNSIGNED8,
    "UINT": DataType.UNSIGNED16,
    "UDINT": DataType.UNSIGNED32,
    "ULINT": DataType.UNSIGNED64,
    "REAL": DataType.REAL32,
    "LREAL": DataType.REAL64,
    "STRING": DataType.VISIBLE_STRING,
    "WSTRING": DataType.UNICODE_STRING,
}
"""Types of parameters (IEC 61131-3) that are one data type of CiA 301."""
OTHER_TYPES: Final = {
    "CHAR": DataType.INTEGER8,
    "BYTE": DataType.UNSIGNED8,
    "WORD": DataType.UNSIGNED16,
    "DWORD": DataType.UNSIGNED32,
    "LWORD": DataType.UNSIGNED64,
}
"""Further types of parameters, which are read only."""
OCTETS: Final = "BITSTRING"
"""The type of OCTET_STRING, and of DOMAIN if there is no default value."""

ACCESS: Final = {
    "const": Access.CONST,
    "read": Access.RO,
    "write": Access.WO,
    "readWrite": Access.RW,
    "readWriteInput": Access.RWR,
    "readWriteOutput": Access.RWW,
}
"""The access of parameters."""
