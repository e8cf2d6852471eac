"""Records for the listeners of a system: changes of state, and written samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import msgspec

from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.return_codes import LifeCycleState

if TYPE_CHECKING:
    from rtgen.runtime.ports.data_ports import OutPort


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
    """The reason, if `after` is ERROR; else empty."""


class SampleRecord(NamedTuple):
    """A component wrote a sample; `value` is a snapshot shared by the listeners."""

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
    """A listener that does not keep a sample after it returns, so that it needs no snapshot."""

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """Return a function that receives the samples of a port in place of the listener."""


class Viewer:
    """A `SampleWriter` that shows samples to people, who count as readers; see `OutPort.offer`."""


class MissingSamples:
    """Samples that could not be written, since they violate their type."""

    def __init__(self) -> None:
        self._found: dict[str, tuple[int, str]] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, port: object, error: Exception) -> None:
        """Count a sample of a port."""
        count, first = self._found.get(str(port), (0, str(error)))
        self._found[str(port)] = count + 1, first

    def refuse(self, port: object, reason: str) -> None:
        """Add a port of which no sample can be written."""
        self._found.setdefault(str(port), (0, reason))

    def messages(self) -> list[str]:
        """Return a message for each port, with the first reason."""
        return [
            (
                f"{count} samples of {port} are missing: {first}"
                if count
                else f"all samples of {port} are missing: {first}"
            )
            for port, (count, first) in self._found.items()
        ]


class Statistics(msgspec.Struct, frozen=True, gc=False):
    """Statistics of a component.

    `ticks` counts `on_execute`, `overruns` the times of its own context at which no tick could
    start, `lost` the samples lost before its InPorts; `reason` is that of the last failure,
    `awaited` what a request waits for, `condition` what impairs an ACTIVE component.
    """

    state: LifeCycleState
    ticks: int
    overruns: int
    lost: int
    reason: str
    awaited: str = ""
    condition: str = ""
