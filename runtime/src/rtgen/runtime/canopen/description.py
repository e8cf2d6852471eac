"""Descriptions of devices and networks, the content of generated modules."""

from __future__ import annotations

from functools import cached_property
from typing import Literal, TypeAlias

import msgspec
from msgspec.structs import replace

from rtgen.facts.canopen import (
    NUMBER_KINDS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    SYNC,
    TPDO_COMMUNICATION,
    nearest_zero,
)
from rtgen.facts.canopen import Kind as Kind
from rtgen.facts.cob_ids import COB_ID_EMERGENCY, in_force, is_stated

ObjectValue: TypeAlias = bool | int | float | str | bytes
"""A value of an object; times are ints in ns (time of day: since 1970, UTC), octets are bytes."""

ObjectNumber: TypeAlias = tuple[int, int]
"""Index and sub-index."""


class ObjectDescription(msgspec.Struct, frozen=True, gc=False):
    """An object of the object dictionary (CiA 301, 7.4).

    `name` is its identifier. `default`, `low` and `high` are None if the description has none;
    with `relative` the default is an offset to the node-id. `access` is an access type of CiA
    306. `initial` is the value with which the object begins.
    """

    index: int
    subindex: int
    name: str
    kind: Kind
    access: str
    default: ObjectValue | None = None
    low: int | float | None = None
    high: int | float | None = None
    relative: bool = False
    mappable: bool = False

    @property
    def readable(self) -> bool:
        """Whether SDO may read the object."""
        return self.access != "wo"

    @property
    def writable(self) -> bool:
        """Whether SDO may write the object."""
        return self.access not in ("ro", "const")

    @property
    def limited(self) -> bool:
        """Whether the description restricts the range of its kind."""
        return self.low is not None or self.high is not None

    @property
    def start(self) -> int | float | None:
        """The value without a default, within the limits; None for that of its kind."""
        if self.limited and self.kind in NUMBER_KINDS:
            return nearest_zero(self.low, self.high)
        return None

    def named(self, name: str) -> ObjectDescription:
        """Return a copy with another name."""
        return replace(self, name=name)

    def initial(self, node_id: int) -> ObjectValue | None:
        """Return the value with which the object begins in a node; None for that of its kind.

        That is the default, the COB-ID in force (`facts.cob_ids`), or `start`.
        """
        value = self._default(node_id)
        if self.kind == "u32" and (value is None or isinstance(value, int)):
            value = in_force((self.index, self.subindex), value, node_id)
        return self.start if value is None else value

    def states(self, node_id: int) -> bool:
        """Return whether it has no COB-ID, or states that with which a node begins."""
        value = self._default(node_id)
        number = self.index, self.subindex
        return is_stated(number, value if isinstance(value, int) else None)

    def _default(self, node_id: int) -> ObjectValue | None:
        value = self.default
        return value + node_id if self.relative and isinstance(value, int) else value


class PdoDescription(msgspec.Struct, frozen=True, gc=False):
    """A PDO as the device sees it: the device transmits a `tpdo` and receives an `rpdo`.

    `cob_id` includes the flag bits; with `relative` it is an offset to the node-id; None: not
    given, so that it is the predefined one. `mapping` holds (index, sub-index, bits); gaps have
    the index of a data type. `fixed`: the mapping is read-only. Times are in the units of the
    object dictionary: `inhibit_time` in 100 us, `event_timer` in ms.
    """

    direction: Literal["tpdo", "rpdo"]
    number: int
    cob_id: int | None
    relative: bool
    transmission_type: int
    mapping: tuple[tuple[int, int, int], ...]
    inhibit_time: int = 0
    event_timer: int = 0
    sync_start: int = 0
    fixed: bool = False

    def cob_id_of(self, node_id: int) -> int:
        """Return the COB-ID in force, with its flags, in a node with this node-id."""
        cob_id = self.cob_id
        if self.relative and cob_id is not None:
            cob_id += node_id
        cob_id_in_force = in_force(
            (self.communication_index, 1), cob_id, node_id, chosen=True
        )
        assert cob_id_in_force is not None
        return cob_id_in_force

    @property
    def communication_index(self) -> int:
        """The index of its communication parameter."""
        received = self.direction == "rpdo"
        base = RPDO_COMMUNICATION if received else TPDO_COMMUNICATION
        return base + self.number - 1

    @property
    def mapping_index(self) -> int:
        """The index of its mapping parameter."""
        return self.communication_index + RPDO_MAPPING - RPDO_COMMUNICATION


class DeviceDescription(msgspec.Struct, frozen=True, dict=True):
    """A device: `DESCRIPTION` of a generated module `objects`.

    `lss`: the device supports layer setting services. `granularity` is the smallest unit of a
    mapping in bits, `dummies` are the data types that can fill gaps. `configuration` is written to
    the node by a master without a network description. `bit_rates` are those that LSS can set, in
    kbit/s; empty: all.
    """

    name: str
    objects: tuple[ObjectDescription, ...]
    pdos: tuple[PdoDescription, ...]
    vendor_id: int = 0
    product_code: int = 0
    revision_number: int = 0
    lss: bool = False
    granularity: int = 8
    dummies: tuple[int, ...] = ()
    configuration: tuple[Write, ...] = ()
    bit_rates: tuple[int, ...] = ()

    @cached_property
    def by_number(self) -> dict[ObjectNumber, ObjectDescription]:
        """The objects by index and sub-index."""
        return {(o.index, o.subindex): o for o in self.objects}

    @cached_property
    def by_name(self) -> dict[str, ObjectDescription]:
        """The objects by identifier."""
        return {o.name: o for o in self.objects}

    def cob_id(self, number: ObjectNumber, node_id: int) -> int:
        """Return a COB-ID of a configured node; that of CiA 301 if there is no such object."""
        for write in reversed(self.configuration):
            if (write.index, write.subindex) == number:
                return int.from_bytes(write.octets(node_id), "little")
        described = self.by_number.get(number)
        initial = None if described is None else described.initial(node_id)
        if isinstance(initial, int):
            return initial
        return in_force(number, None, node_id) or 0

    def initial_number(self, number: ObjectNumber, node_id: int) -> int:
        """Return the integer with which an object begins; 0 without one."""
        described = self.by_number.get(number)
        initial = None if described is None else described.initial(node_id)
        return initial if isinstance(initial, int) else 0

    def pdo(self, direction: str, number: int) -> PdoDescription:
        """Find a PDO. Raises KeyError."""
        for pdo in self.pdos:
            if pdo.direction == direction and pdo.number == number:
                return pdo
        raise KeyError(f"{self.name} has no {direction}{number}")


class Write(msgspec.Struct, frozen=True, gc=False):
    """A value to be written by SDO, in octets."""

    index: int
    subindex: int
    value: bytes
    verify: bool = True
    relative: bool = False

    def octets(self, node_id: int) -> bytes:
        """Return the octets to write to a node with this node-id."""
        if not self.relative:
            return self.value
        size = len(self.value)
        number = int.from_bytes(self.value, "little") + node_id
        return (number & (1 << 8 * size) - 1).to_bytes(size, "little")

    @property
    def repeatable(self) -> bool:
        """Whether the write may be repeated.

        An object that cannot be read back may be a command (1010h, 1011h, write-only objects).
        """
        return self.verify


class NodeDescription(msgspec.Struct, frozen=True, gc=False):
    """A node of a network, and how the manager starts it.

    `identity` holds the expected values of 1000h and 1018h:1 to 4; None skips the check.
    `configuration` is written by the manager, in order, after the boot-up message; `pdos` are in
    force afterwards, with absolute COB-IDs. `heartbeat` is the node's producer time and
    `heartbeat_timeout` the manager's consumer time; `boot_timeout` limits the boot procedure;
    `guard_time` is the period of node guarding for a node without heartbeat (all in ms, 0 for
    none). `emergency_stop` holds the patterns of `EmergencyPolicy`, empty for the default;
    `recoveries` is how often in a row its proxy leaves ERROR by itself. On an error the manager
    resets the node up to `restarts` times. A node that is not `mandatory` may be missing. With
    `start` the manager starts the node once it is configured. `lss`: the node may have no node-id
    yet; the manager assigns it by its identity. `emergency` is the COB-ID of its emergencies,
    None for the predefined one.
    """

    name: str
    id: int
    module: str
    identity: tuple[int | None, int | None, int | None, int | None, int | None]
    configuration: tuple[Write, ...]
    pdos: tuple[PdoDescription, ...]
    heartbeat: int
    heartbeat_timeout: int
    boot_timeout: int = 2000
    restarts: int = 0
    mandatory: bool = True
    start: bool = True
    lss: bool = False
    guard_time: int = 0
    emergency_stop: str = ""
    recoveries: int = 0
    emergency: int | None = None

    @property
    def emergency_cob_id(self) -> int:
        """The COB-ID of its emergencies."""
        cob_id_in_force = in_force(
            COB_ID_EMERGENCY, self.emergency, self.id, chosen=True
        )
        assert cob_id_in_force is not None
        return cob_id_in_force


class Network(msgspec.Struct, frozen=True, gc=False):
    """A network: `NETWORK` of a generated module `networks.<name>`.

    `bit_rate` is in kbit/s; `sync` is the SYNC period in us and `heartbeat` the manager's
    producer time in ms, 0 for none. `sync_overflow` is the highest SYNC counter, 0 for none;
    `sync_cob_id` has the identifier of SYNC.
    """

    name: str
    bit_rate: int
    manager: int
    sync: int
    heartbeat: int
    nodes: tuple[NodeDescription, ...]
    sync_overflow: int = 0
    sync_cob_id: int = SYNC

    def node(self, node_id: int) -> NodeDescription | None:
        """Find a node by its id."""
        return next((node for node in self.nodes if node.id == node_id), None)
