"""Passes samples of InPorts to RPDOs in generated proxies."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any, Final, TypeVar

from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.data_ports import InPort

T = TypeVar("T", bound=DataType)

_MAX_WAITING: Final = 1024
"""Maximum number of samples waiting for a PDO."""


def unread(port: InPort[T]) -> Iterator[T]:
    """Yield the unread samples, oldest first."""
    while port.is_new():
        sample = port.read()
        if sample is not None:
            yield sample


class Inlet:
    """An InPort of one object, shared by all PDOs that map the object."""

    def __init__(self, port: InPort[Any], pdos: Sequence[int]) -> None:
        self._port = port
        self._queues: dict[int, deque[Any]] = {
            number: deque(maxlen=_MAX_WAITING) for number in pdos
        }

    def take(self, pdo: int) -> Any:
        """Return the next sample for a PDO, None if there is none."""
        for sample in unread(self._port):
            for queue in self._queues.values():
                queue.append(sample)
        queue = self._queues[pdo]
        return queue.popleft() if queue else None


class Gathering:
    """An RPDO whose objects have separate InPorts; it is sent with the latest value of each."""

    def __init__(self, pdo: int, *fields: tuple[Inlet, Any]) -> None:
        """Initialize with `fields`, the inlets of its objects with their initial values."""
        self._pdo = pdo
        self._inlets = [inlet for inlet, _ in fields]
        self._values = [value for _, value in fields]

    def rounds(self) -> Iterator[list[Any]]:
        """Yield the values to send, once for each new sample."""
        values = self._values
        while True:
            fresh = False
            for place, inlet in enumerate(self._inlets):
                sample = inlet.take(self._pdo)
                if sample is not None:
                    values[place] = sample.data
                    fresh = True
            if not fresh:
                return
            yield values
