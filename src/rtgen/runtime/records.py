"""What a system tells its listeners: changes of state, and samples as they are written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from rtgen.runtime.descriptors import DataType
from rtgen.runtime.return_codes import LifeCycleState

if TYPE_CHECKING:
    from rtgen.runtime.data_ports import OutPort


class StateRecord(NamedTuple):
    """A component changed its state in a context; `time` in ns since the start."""

    kind: str
    """`state`."""
    time: int
    instance: str
    before: LifeCycleState
    after: LifeCycleState
    ec_id: int
    reason: str
    """Why, where `after` is ERROR; else empty."""


class SampleRecord(NamedTuple):
    """A component wrote a sample; `value` is the listeners' own snapshot of it."""

    kind: str
    """`sample`."""
    time: int
    instance: str
    port: str
    value: DataType


Record = StateRecord | SampleRecord
Listener = Callable[[Record], None]


@runtime_checkable
class SampleWriter(Protocol):
    """A listener that has done with a sample when it returns, so that it needs no snapshot."""

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """What takes the samples of a port, in place of the listener itself.

        A sample goes on belonging to its writer; `elapsed` tells the time [ns since the start].
        """


@dataclass(frozen=True, slots=True)
class Statistics:
    """What became of a component so far.

    `ticks` counts `on_execute`, `overruns` the instants of its own context at which no tick could
    begin, `lost` the samples lost on the way to its InPorts; `reason` says why a callback failed,
    `awaited` what a request waits for, `condition` what hinders an ACTIVE component.
    """

    state: LifeCycleState
    ticks: int
    overruns: int
    lost: int
    reason: str
    awaited: str = ""
    condition: str = ""
