"""What is tested: the options of `rtgen conformance`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from rtgen.tools.can.access import BusAccess
from rtgen.tools.conformance.check import Permission
from rtgen.tools.rpc.signatures import Wire


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """What is tested, where it is, and what a test may do; times in seconds.

    `access` and `node_id` are of a node; `signature`, `functions`, `wire`, `baud` and `stall` of a
    board; `component` and `include` of a component; `connect` is the address of the latter two.
    """

    connect: str = ""
    access: BusAccess
    node_id: int | None
    signature: str | None
    functions: Sequence[str]
    wire: Wire
    baud: int
    stall: float | None
    component: str | None
    include: tuple[str, ...]
    timeout: float
    boot: float
    permissions: Collection[Permission]
