"""What a system tells its listeners: changes of state, and samples as they are written."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rtgen.runtime.descriptors import DataType
from rtgen.runtime.return_codes import LifeCycleState


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
