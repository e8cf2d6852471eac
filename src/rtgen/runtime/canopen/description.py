"""What generated modules tell of devices and networks: plain tables, digested when generated."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal[
    "bool", "char", "string", "wstring", "octets", "time_of_day", "time_difference",
    "i8", "i16", "i24", "i32", "i40", "i48", "i56", "i64",
    "u8", "u16", "u24", "u32", "u40", "u48", "u56", "u64",
    "r32", "r64",
]  # fmt: skip
"""What a value is: an integer of that many bits, a real, text, octets, or a time."""

ObjectValue: TypeAlias = bool | int | float | str | bytes
"""A value of an object: times are ints in ns (of day: since 1970, UTC), octets are bytes."""

ObjectNumber: TypeAlias = tuple[int, int]
"""Index and sub-index."""


@dataclass(frozen=True, slots=True)
class ObjectDescription:
    """A variable of the object dictionary.

    `name` is its identifier. `default`, `low` and `high` are None where the file has none; with
    `relative` the default is an offset to the node-id. `access` is one of CiA 306.
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
        """Whether SDO may read it."""
        return self.access != "wo"

    @property
    def writable(self) -> bool:
        """Whether SDO may write it."""
        return self.access not in ("ro", "const")

    def named(self, name: str) -> ObjectDescription:
        """The same with another name."""
        return replace(self, name=name)

    def initial(self, node_id: int) -> ObjectValue | None:
        """The default for a node."""
        if self.relative and isinstance(self.default, int):
            return node_id + self.default
        return self.default


@dataclass(frozen=True, slots=True)
class PdoDescription:
    """A PDO as its device has it: the device transmits a `tpdo` and receives an `rpdo`.

    `cob_id` has the flag bits; with `relative` it is an offset to the node-id. None: the file does
    not tell, so the PDO is not valid. `mapping` holds (index, sub-index, bits); gaps have the
    index of a data type. `fixed` says that the mapping cannot be written. Times are in the units
    of the object dictionary: `inhibit_time` in 100 us, `event_timer` in ms.
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

    def cob_id_of(self, node_id: int) -> int | None:
        """The COB-ID for a node, with its flags."""
        if self.cob_id is None:
            return None
        return self.cob_id + node_id if self.relative else self.cob_id


@dataclass(frozen=True)
class DeviceDescription:
    """A device: what a generated module `objects` has as `DESCRIPTION`.

    `lss` says that it takes part in layer setting services, `granularity` is the smallest unit of
    a mapping in bits, `dummies` are the data types that may fill gaps. `configuration` is what a
    master writes to the node where no network says so. `bit_rates` are those that LSS may set, in
    kbit/s, none for all.
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
        """The variables by index and sub-index."""
        return {(o.index, o.subindex): o for o in self.objects}

    @cached_property
    def by_name(self) -> dict[str, ObjectDescription]:
        """The variables by identifier."""
        return {o.name: o for o in self.objects}

    def pdo(self, direction: str, number: int) -> PdoDescription:
        """A PDO. Raises KeyError if there is none."""
        for pdo in self.pdos:
            if pdo.direction == direction and pdo.number == number:
                return pdo
        raise KeyError(f"{self.name} has no {direction}{number}")


@dataclass(frozen=True, slots=True)
class Write:
    """A value that is written by SDO, as octets on the wire.

    `verify` says that it is read back, `relative` that the node-id is to be added to it.
    """

    index: int
    subindex: int
    value: bytes
    verify: bool = True
    relative: bool = False

    def octets(self, node_id: int) -> bytes:
        """The octets for a node."""
        if not self.relative:
            return self.value
        size = len(self.value)
        number = int.from_bytes(self.value, "little") + node_id
        return (number & (1 << 8 * size) - 1).to_bytes(size, "little")

    @property
    def repeatable(self) -> bool:
        """Whether it may be carried out twice.

        What cannot be read back may be a command (1010h, 1011h, write-only objects).
        """
        return self.verify


@dataclass(frozen=True, slots=True)
class NodeDescription:
    """A node of a network, and how it is started.

    `identity` is what 1000h and 1018h:1 to 4 must hold, None for what is not checked.
    `configuration` is what the manager writes, in order, after the boot-up message. `pdos` are
    those that hold after it, COB-IDs absolute. `heartbeat` is the node's period and
    `heartbeat_timeout` the manager's time-out, both in ms, 0 for none; `boot_timeout` is in ms.
    `guard_time` is the period of node guarding in ms, for a node without heartbeat; 0 for none.
    `emergency_stop` has the patterns of `EmergencyPolicy`, empty for the default; `recoveries` is
    how often in a row its proxy leaves ERROR by itself.
    On an error the manager resets the node up to `restarts` times. A node that is not `mandatory`
    may be missing. With `start` it is started when it is configured.
    `lss` says that it may have no node-id yet: the manager assigns it by its identity.
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


@dataclass(frozen=True, slots=True)
class Network:
    """A network: what a generated module `networks.<name>` has as `NETWORK`.

    `bit_rate` is in kbit/s; `sync` and `heartbeat` (the manager's) are periods in us and ms, 0 for
    none. `sync_overflow` is the greatest SYNC counter, 0 for none.
    """

    name: str
    bit_rate: int
    manager: int
    sync: int
    heartbeat: int
    nodes: tuple[NodeDescription, ...]
    sync_overflow: int = 0

    def node(self, node_id: int) -> NodeDescription | None:
        """The node of an id."""
        return next((node for node in self.nodes if node.id == node_id), None)
