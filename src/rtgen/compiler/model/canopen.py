"""CANopen devices as described by EDS and DCF files (CiA 306), for the protocol of CiA 301.

Numbers have the units of the object dictionary: PDO times in 100 us (inhibit) and ms (event),
COB-IDs with their flag bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum, StrEnum
from functools import cached_property
from itertools import accumulate
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.facts.canopen import BITS as BITS
from rtgen.facts.canopen import EXTENDED as EXTENDED
from rtgen.facts.canopen import INVALID as INVALID
from rtgen.facts.canopen import NO_RTR as NO_RTR
from rtgen.facts.canopen import PDOS as PDOS
from rtgen.facts.canopen import RPDO_COMMUNICATION as RPDO_COMMUNICATION
from rtgen.facts.canopen import RPDO_MAPPING as RPDO_MAPPING
from rtgen.facts.canopen import SIGNED as SIGNED
from rtgen.facts.canopen import TPDO_COMMUNICATION as TPDO_COMMUNICATION
from rtgen.facts.canopen import TPDO_MAPPING as TPDO_MAPPING
from rtgen.facts.canopen import UNSIGNED as UNSIGNED
from rtgen.facts.canopen import DataType as DataType
from rtgen.facts.canopen import nearest_zero
from rtgen.facts.cob_ids import Standing, service_of, standing

MAPPINGS = frozenset(
    first + number for first in (RPDO_MAPPING, TPDO_MAPPING) for number in range(PDOS)
)
"""The indices of the mapping parameters of PDOs."""

BIT_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)
"""CiA 301's bit rates in kbit/s (table 1), each with a key in a description."""


class ObjectType(IntEnum):
    """Kinds of entries of the object dictionary (CiA 301, table 42)."""

    NULL = 0x0
    DOMAIN = 0x2
    DEFTYPE = 0x5
    DEFSTRUCT = 0x6
    VAR = 0x7
    ARRAY = 0x8
    RECORD = 0x9


STRUCTURES = {
    0x20: "PDO_COMMUNICATION_PARAMETER",
    0x21: "PDO_MAPPING",
    0x22: "SDO_PARAMETER",
    0x23: "IDENTITY",
}
"""Structured types of CiA 301; a variable of such a type is treated as octets."""


class Access(StrEnum):
    """Access types of variables over the network (CiA 306, 4.6.3.2)."""

    RO = "ro"
    WO = "wo"
    RW = "rw"
    RWR = "rwr"
    RWW = "rww"
    CONST = "const"

    @property
    def readable(self) -> bool:
        """Whether SDO may read it."""
        return self is not Access.WO

    @property
    def writable(self) -> bool:
        """Whether SDO may write it."""
        return self not in (Access.RO, Access.CONST)

    @property
    def in_tpdo(self) -> bool:
        """Whether a TPDO may carry it."""
        return self not in (Access.WO, Access.RWW)

    @property
    def in_rpdo(self) -> bool:
        """Whether an RPDO may carry it."""
        return self in (Access.WO, Access.RW, Access.RWW)


class NodeRelative(msgspec.Struct, frozen=True):
    """A number relative to the node-id: `$NODEID+offset`."""

    offset: int

    def of(self, node_id: int) -> int:
        """Return the number for a node-id."""
        return node_id + self.offset

    def __str__(self) -> str:
        if not self.offset:
            return "$NODEID"
        sign = "-" if self.offset < 0 else "+"
        return f"$NODEID{sign}0x{abs(self.offset):X}"


Value: TypeAlias = int | float | str | bytes | NodeRelative
"""A value of a variable; its Python type depends on the data type (bytes: octets and domains)."""


def resolved(value: Value | None, node_id: int | None) -> Value | None:
    """Return the value for a node-id; without one, a relative value is left unchanged."""
    if isinstance(value, NodeRelative) and node_id is not None:
        return value.of(node_id)
    return value


def cob_id_in_force(
    number: tuple[int, int],
    stated: Value | None,
    node_id: int | None,
    *,
    chosen: bool = False,
) -> Value | None:
    """Return the COB-ID that an object has, or its formula; `stated` for other objects.

    `number` is (index, sub-index). See `facts.cob_ids.standing`.
    """
    service = service_of(number)
    if service is None:
        return stated
    if not isinstance(stated, int | NodeRelative):
        stated = None
    probe = resolved(stated, node_id or 1)
    cob_id = probe & 0xFFFFFFFF if isinstance(probe, int) else None
    match standing(service, cob_id, chosen=chosen):
        case Standing.OFF if isinstance(stated, NodeRelative):
            return NodeRelative(service.switched_off(stated.offset & 0xFFFFFFFF))
        case Standing.OFF:
            assert cob_id is not None
            return service.switched_off(cob_id)
        case Standing.PREDEFINED:
            flags = service.flags_of(cob_id or 0)
            if service.base is None:
                return INVALID | flags
            base = service.base | flags
            return NodeRelative(base) if service.relative else base
    return stated


class Variable(msgspec.Struct, frozen=True, kw_only=True):
    """A value of the object dictionary: an object of type VAR or DOMAIN, or a sub-object.

    `data_type` is a DataType if the code is known, else the file's code. `value` is the value
    configured by a DCF (ParameterValue). `written_access` is the file's word, in lower case.
    `value_span` is the place of the current value, or else of the variable. Limits, `unit` and
    `factor` (physical value = factor * value) are None or empty if not given.
    """

    index: int
    subindex: int
    name: str
    data_type: int
    access: Access
    written_access: str
    span: Span
    value_span: Span
    domain: bool = False
    pdo_mappable: bool = False
    default: Value | None = None
    value: Value | None = None
    low: int | float | NodeRelative | None = None
    high: int | float | NodeRelative | None = None
    unit: str = ""
    factor: float | None = None
    description: str = ""
    denotation: str = ""
    flags: int = 0
    upload_file: str = ""
    download_file: str = ""

    @property
    def type_name(self) -> str:
        """The name of the data type, or its number."""
        code = self.data_type
        return code.name if isinstance(code, DataType) else f"type {code:04X}h"

    @property
    def number(self) -> tuple[int, int]:
        """Index and sub-index."""
        return self.index, self.subindex

    @property
    def current(self) -> Value | None:
        """The configured value, defaulting to the default value."""
        return self.default if self.value is None else self.value

    def in_force(self, node_id: int | None) -> Value | None:
        """Return the value that is in force: the current one, or a COB-ID in its place."""
        chosen = self.value is not None
        return cob_id_in_force(self.number, self.current, node_id, chosen=chosen)

    def start(self, node_id: int | None) -> Value | None:
        """Return the value in force; without one, that within its limits nearest to 0."""
        value = self.in_force(node_id)
        if value is not None or (self.low is None and self.high is None):
            return value
        low, high = resolved(self.low, node_id), resolved(self.high, node_id)
        return nearest_zero(
            low if isinstance(low, int | float) else None,
            high if isinstance(high, int | float) else None,
        )

    def initial(self, node_id: int | None) -> Value | None:
        """Return the value that is in force before the configuration."""
        return cob_id_in_force(self.number, self.default, node_id)

    @property
    def bits(self) -> int | None:
        """Width of its type in bits, None for strings and other types of variable length."""
        try:
            return BITS.get(DataType(self.data_type))
        except ValueError:
            return None


class Object(msgspec.Struct, frozen=True, kw_only=True):
    """An entry of the object dictionary with its variables in order of sub-index."""

    index: int
    name: str
    type: ObjectType
    variables: tuple[Variable, ...]
    span: Span
    denotation: str = ""
    flags: int = 0
    links: tuple[int, ...] = ()


class PdoDirection(StrEnum):
    """Direction as the device sees it: it transmits TPDOs and receives RPDOs."""

    TPDO = "tpdo"
    RPDO = "rpdo"


class PdoEntry(msgspec.Struct, frozen=True):
    """An entry of a PDO mapping: an object or a gap."""

    index: int
    subindex: int
    bits: int

    @property
    def dummy(self) -> bool:
        """Whether it is a gap: mapped by the index of a data type, or no object at all."""
        return self.index < 0x1000


class Pdo(msgspec.Struct, frozen=True, kw_only=True):
    """A process data object: `number` from 1; None for values missing in the file.

    `entries` is the current mapping (that of a DCF if it has one), `default_entries` that of the
    EDS. `cob_id` is the one in force, with the flag bits. `inhibit_time` is in 100 us,
    `event_timer` in ms. `multiplexed`: it has no mapping, but addresses (CiA 301, 7.2.2.5).
    """

    direction: PdoDirection
    number: int
    cob_id: int | NodeRelative
    transmission_type: int | None
    entries: tuple[PdoEntry, ...]
    default_entries: tuple[PdoEntry, ...]
    span: Span
    inhibit_time: int | None = None
    event_timer: int | None = None
    sync_start: int | None = None
    multiplexed: bool = False

    @property
    def communication(self) -> int:
        """The index of its communication parameter."""
        sent = self.direction is PdoDirection.TPDO
        return (TPDO_COMMUNICATION if sent else RPDO_COMMUNICATION) + self.number - 1

    @property
    def mapping(self) -> int:
        """The index of its mapping parameter."""
        return self.communication + RPDO_MAPPING - RPDO_COMMUNICATION

    @property
    def places(self) -> Iterator[tuple[int, PdoEntry]]:
        """The entries, each with its first bit."""
        starts = accumulate((entry.bits for entry in self.entries), initial=0)
        return zip(starts, self.entries, strict=False)

    @property
    def bits(self) -> int:
        """The length of its data."""
        return sum(entry.bits for entry in self.entries)

    @property
    def valid(self) -> bool:
        """Whether the PDO is valid: the valid bit of its COB-ID is clear."""
        cob_id = self.cob_id
        offset = cob_id.offset if isinstance(cob_id, NodeRelative) else cob_id
        return not offset & INVALID


class FileInfo(msgspec.Struct, frozen=True, kw_only=True):
    """The section FileInfo; texts are empty where missing."""

    file_name: str = ""
    version: int | None = None
    revision: int | None = None
    eds_version: str = "3.0"
    description: str = ""
    created: tuple[str, str] = ("", "")
    created_by: str = ""
    modified: tuple[str, str] = ("", "")
    modified_by: str = ""
    last_eds: str = ""


class DeviceInfo(msgspec.Struct, frozen=True, kw_only=True):
    """The section DeviceInfo. `bit_rates` are in kbit/s, `granularity` in bits (0: no mapping)."""

    vendor_name: str = ""
    vendor_number: int | None = None
    product_name: str = ""
    product_number: int | None = None
    revision_number: int | None = None
    order_code: str = ""
    bit_rates: tuple[int, ...] = ()
    boot_up_master: bool = False
    boot_up_slave: bool = False
    granularity: int | None = None
    dynamic_channels: int = 0
    compact_pdo: int = 0
    group_messaging: bool = False
    rpdos: int | None = None
    tpdos: int | None = None
    lss: bool = False


class Commissioning(msgspec.Struct, frozen=True, kw_only=True):
    """The section DeviceComissioning of a DCF. `bit_rate` is in kbit/s."""

    node_id: int | None = None
    node_name: str = ""
    bit_rate: int | None = None
    net_number: int | None = None
    network_name: str = ""
    manager: bool = False
    serial_number: int | None = None


class Module(msgspec.Struct, frozen=True):
    """A module type of a modular device."""

    number: int
    product_name: str
    order_code: str = ""


class Device(msgspec.Struct, frozen=True, dict=True, kw_only=True):
    """A device described by one EDS or DCF.

    `name` is that of its IDL module. `file` is the displayed path, `key` the one for generated
    text, `sha256` that of the file's content. `node_id` is the requested one, else that of a DCF.
    `dummies` are the data types that may be mapped as gaps. `modules` are the supported module
    types, `connected` the numbers of those in its slots. `further` holds the sections unknown to
    CiA 306, as (section, ((key, value), ...)).
    """

    name: str
    file: str
    key: str
    sha256: str
    span: Span
    node_id: int | None
    file_info: FileInfo
    info: DeviceInfo
    commissioning: Commissioning | None
    objects: tuple[Object, ...]
    pdos: tuple[Pdo, ...]
    dummies: tuple[int, ...] = ()
    comments: str = ""
    modules: tuple[Module, ...] = ()
    connected: tuple[int, ...] = ()
    further: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()

    @cached_property
    def _by_number(self) -> dict[tuple[int, int], Variable]:
        return {v.number: v for v in self.variables}

    @property
    def variables(self) -> Iterator[Variable]:
        """All variables, by index and sub-index."""
        return (v for o in self.objects for v in o.variables)

    def find(self, index: int, subindex: int = 0) -> Variable | None:
        """Find a variable by index and sub-index."""
        return self._by_number.get((index, subindex))

    def number(self, index: int, subindex: int = 0) -> int | None:
        """Return the current value of a variable, if it has one that is an integer."""
        variable = self.find(index, subindex)
        value = None if variable is None else variable.current
        return value if isinstance(value, int) else None

    @property
    def vendor_id(self) -> int | None:
        """DeviceInfo's vendor number, else the identity object's."""
        return self._identity(self.info.vendor_number, 1)

    @property
    def product_code(self) -> int | None:
        """DeviceInfo's product number, else the identity object's."""
        return self._identity(self.info.product_number, 2)

    def _identity(self, declared: int | None, subindex: int) -> int | None:
        return self.number(0x1018, subindex) if declared is None else declared
