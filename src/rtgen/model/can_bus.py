"""A CANopen bus: its nodes, how their PDOs are joined, and what is asked of the components."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.diagnostics import Span
from rtgen.model.canopen import Device, Value


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceKind:
    """A kind of device on the bus: its description, and how components of it are made.

    `ports` is `pdo` (a port for each PDO) or `object` (one for each object). `parameters` are the
    objects that become configuration parameters, `operations` those that have operations of their
    own in the SDO service, both by (index, sub-index), as keys of `factors` (physical value =
    factor * value) and `units` are. `device` is the description with the values
    of the kind, for no node in particular, `described` the one without, where there are any.
    """

    name: str
    module: str
    path: str
    span: Span
    device: Device
    ports: str = "pdo"
    parameters: tuple[tuple[int, int], ...] = ()
    operations: tuple[tuple[int, int], ...] = ()
    factors: tuple[tuple[tuple[int, int], float], ...] = ()
    units: tuple[tuple[tuple[int, int], str], ...] = ()
    described: Device | None = None


def kind_of(device: Device) -> DeviceKind:
    """The kind of a device that no bus file has: without settings, a port for each PDO."""
    return DeviceKind(
        name=device.name,
        module=device.name,
        path=device.file,
        span=device.span,
        device=device,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BusNode:
    """A node: its kind, and the device with the values that are written to it at start-up.

    Times are in seconds; without a `heartbeat_timeout` of its own it has three periods. After an
    error the manager resets it up to `restarts` times. One that is not `mandatory` may be missing.
    With `start` it is started when it is configured, with `lss` it may have no node-id yet.
    `revision` and `serial` are checked if they are given. `emergency_stop` has the patterns of
    codes that stop its proxy, separated by commas, empty for the default; `recoveries` is how often
    in a row its proxy leaves ERROR by itself.
    """

    name: str
    id: int
    kind: DeviceKind
    device: Device
    values: tuple[tuple[tuple[int, int], Value], ...]
    span: Span
    heartbeat_timeout: float | None = None
    boot_timeout: float = 2.0
    restarts: int = 0
    mandatory: bool = True
    start: bool = True
    lss: bool = False
    emergency_stop: str = ""
    recoveries: int = 0
    revision: int | None = None
    serial: int | None = None


@dataclass(frozen=True, slots=True)
class PdoLink:
    """A TPDO of a node that an RPDO of another takes, each as (node, number)."""

    source: tuple[str, int]
    target: tuple[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bus:
    """A network. `bit_rate` is in kbit/s; times are in seconds, 0 where there is no such message.

    `file` is the displayed path, `key` the one for generated text, `sha256` that of its bytes.
    `event` is the least time that is assumed between two event-driven PDOs that tell of none.
    `sync_counter` is the greatest SYNC counter, 0 for none. With `dcf` each node has a DCF.
    """

    name: str
    file: str
    key: str
    sha256: str
    bit_rate: int
    manager: int
    sync: float
    heartbeat: float
    event: float
    kinds: tuple[DeviceKind, ...]
    nodes: tuple[BusNode, ...]
    links: tuple[PdoLink, ...]
    sync_counter: int = 0
    dcf: bool = True
