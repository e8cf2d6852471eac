"""Counts of the samples on connections: how many are written in a second, how many are lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.system.joining import Connector
from rtgen.runtime.system.system import System
from rtgen.ui import description
from rtgen.ui.protocol import ui

_SPAN: Final = 1.0
"""The time of the run over which samples are counted [s]."""


class Chains:
    """The latencies of the chains of a system, measured from the first look on.

    They are measured anew when its connections have changed.
    """

    def __init__(self, system: System) -> None:
        self.latest: list[ui.Chain] = []
        self.others: Sequence[ui.Chain] = ()
        """Those of other processes."""
        self._system = system
        self._measured: Sequence[Connector] | None = None

    def changed(self) -> bool:
        """Return whether `latest` is another one now."""
        connectors = self._system.connectors
        if connectors != self._measured:
            self._measured = connectors
            self._system.measure_latencies()
        own = map(description.chain, self._system.latencies)
        before, self.latest = self.latest, [*own, *self.others]
        return self.latest != before


class Flows:
    """The counts of a run. `written` may be called from any thread."""

    def __init__(self) -> None:
        self.latest: list[ui.Flow] = []
        self.others: Sequence[ui.Flow] = ()
        """Those of other processes."""
        self._written: Counter[int] = Counter()
        self._before: Counter[int] = Counter()
        self._since = 0.0
        self._rates: dict[int, float] = {}

    def written(self, channel: int) -> None:
        """Count a sample of a channel."""
        self._written[channel] += 1

    def changed(
        self,
        now: float,
        connectors: Iterable[Connector],
        channel_of: Callable[[DataConnector[Any]], int | None],
    ) -> bool:
        """Count anew at a time of the run [s], and return whether `latest` is another one."""
        if now - self._since >= _SPAN:
            written = self._written.copy()
            self._rates = {
                channel: (count - self._before[channel]) / (now - self._since)
                for channel, count in written.items()
            }
            self._before, self._since = written, now
        counted = self._since > 0.0
        flows = [*self.others]
        for each in connectors:
            if isinstance(each, DataConnector):
                rate = self._rates.get(channel_of(each) or 0, 0.0) if counted else -1.0
                flows.append(description.flow(each.name, each.losses, rate))
        before, self.latest = self.latest, flows
        return flows != before
