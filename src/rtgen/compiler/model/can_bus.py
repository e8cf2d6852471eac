"""A CANopen bus: nodes, PDO links, and settings for generated components."""

from __future__ import annotations

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.canopen import Device, Value
from rtgen.facts.canopen import SYNC


class DeviceKind(msgspec.Struct, frozen=True, kw_only=True):
    """A kind of device on the bus: its description, and settings for its components.

    `ports` is `pdo` (a port for each PDO) or `object` (one for each object). `parameters` are the
    objects that become configuration parameters, `operations` those with operations in the SDO
    service, both by (index, sub-index), as are the keys of `factors` (physical value = factor *
    value) and `units`. `device` is the description with the values of the kind, for no particular
    node; `described` is the one without these values, if there are any.
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
    """Return the default kind of a device without a bus file: no settings, a port for each PDO."""
    return DeviceKind(
        name=device.name,
        module=device.name,
        path=device.file,
        span=device.span,
        device=device,
    )


class BusNode(msgspec.Struct, frozen=True, kw_only=True):
    """A node: its kind, and the device with the values written to it at start-up.

    Times are in seconds; `heartbeat_timeout` defaults to three periods. After an error the
    manager resets the node up to `restarts` times. A node that is not `mandatory` may be missing.
    With `start` the manager starts the configured node; with `lss` the node may have no node-id
    yet. `revision` and `serial` are checked if given. `emergency_stop` has the comma-separated
    patterns of emergency codes that stop its proxy, empty for the default; `recoveries` is how
    often in a row its proxy leaves ERROR by itself.
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


class PdoLink(msgspec.Struct, frozen=True):
    """A TPDO that another node receives as an RPDO, each as (node, number)."""

    source: tuple[str, int]
    target: tuple[str, int]


class Bus(msgspec.Struct, frozen=True, kw_only=True):
    """A network. `bit_rate` is in kbit/s; times are in seconds, 0 for none.

    `file` is the displayed path, `key` the one for generated text, `sha256` that of its content.
    `event` is the assumed minimum time between two event-driven PDOs without an inhibit time.
    `sync_counter` is the highest SYNC counter, 0 for none; `sync_cob_id` has the identifier of
    SYNC. With `dcf` each node gets a DCF.
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
    sync_cob_id: int = SYNC
