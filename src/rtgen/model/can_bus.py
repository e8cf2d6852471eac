"""A CANopen bus: its nodes, how their PDOs are joined, and what is asked of the components."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.diagnostics import Span
from rtgen.model.canopen import Device, Value


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceKind:
    """A kind of device on the bus: its description, and how components of it are made.

    `ports` is `pdo` (a port for each PDO) or `object` (one for each object). `parameters` are the
    objects that become configuration parameters, by (index, sub-index), as keys of `factors`
    (physical value = factor * value) and `units` are. `device` is the description with the values
    of the kind, for no node in particular.
    """

    name: str
    module: str
    path: str
    span: Span
    device: Device
    ports: str = "pdo"
    parameters: tuple[tuple[int, int], ...] = ()
    factors: tuple[tuple[tuple[int, int], float], ...] = ()
    units: tuple[tuple[tuple[int, int], str], ...] = ()


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
    """A node: its kind, and the device with the values that are written to it at start-up."""

    name: str
    id: int
    kind: DeviceKind
    device: Device
    values: tuple[tuple[tuple[int, int], Value], ...]
    span: Span


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
