"""Why samples were lost and ticks left out, for the report of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

from rtgen import runtime
from rtgen.runtime.system.records import StateRecord
from rtgen.runtime.system.runner import ALL, MACHINE
from rtgen.tools.running.texts import duration, name_of

_Counts: TypeAlias = WeakKeyDictionary[runtime.DataConnector[Any], int]

_DEADLINE = "dataport.qos.deadline"


class Losses:
    """Counts the samples that components could not read because they were not ACTIVE."""

    def __init__(self, running: runtime.System) -> None:
        self._running = running
        self._before: _Counts = WeakKeyDictionary()
        """Samples that connections had lost when their readers left ACTIVE."""
        self._idle: _Counts = WeakKeyDictionary()
        """Samples that they lost while their readers were not ACTIVE, up to the last change."""
        running.watch_states(self._changed)

    def _changed(self, record: StateRecord) -> None:
        was_active = record.before is runtime.ACTIVE_STATE
        if was_active == (record.after is runtime.ACTIVE_STATE):
            return
        for port in self._running.component(record.instance).in_ports.values():
            for connector in port.connectors:
                if was_active:
                    self._before[connector] = _full(connector)
                else:
                    self._idle[connector] = self._unread(connector)

    def _unread(self, connector: runtime.DataConnector[Any]) -> int:
        """Return the samples lost while the reader, which is not ACTIVE, was not."""
        since = _full(connector) - self._before.get(connector, 0)
        return self._idle.get(connector, 0) + since

    def notes(self, instance: str, state: runtime.LifeCycleState) -> Iterator[str]:
        """Yield lost samples of each InPort with cause and remedy, and missed deadlines."""
        for port in self._running.component(instance).in_ports.values():
            for connector in port.connectors:
                if connector.lost:
                    why = self._why(instance, state, connector)
                    yield f"{port}: {connector.lost} samples of {connector.source} lost: {why}"
                if missed := connector.missed_deadlines:
                    key = _DEADLINE if _DEADLINE in connector.properties else "deadline"
                    within = f"within {connector.deadline} s, {missed} times: {key}"
                    yield f"{port}: no sample of {connector.source} {within}"
            if port.lost_when_cut:
                yield (
                    f"{port}: {port.lost_when_cut} samples lost on connections that were cut"
                )

    def _why(
        self,
        instance: str,
        state: runtime.LifeCycleState,
        connector: runtime.DataConnector[Any],
    ) -> str:
        full = _full(connector)
        if full < connector.dropped:
            policy = connector.settings.push_policy.value
            return f"left out by the push policy {policy!r} of the connection"
        if full < connector.missed:
            return connector.why_missed
        length = connector.buffer.settings.length
        what = (
            "newer ones took their place" if connector.overwritten else "write refused"
        )
        is_active = state is runtime.ACTIVE_STATE
        idle = self._idle.get(connector, 0) if is_active else self._unread(connector)
        do = (
            "read while is_new(), or read_newest(), in each tick; where more come between two"
            " ticks, dataport.buffer.length of the connection holds them"
        )
        if idle >= full and not is_active:
            do = f"{instance} is in {name_of(state)} and does not read"
        elif idle >= full:
            do = f"{instance} was not ACTIVE and did not read"
        elif idle:
            do = f"{idle} while {instance} was not ACTIVE, {full - idle} while it was: {do}"
        return f"the buffer of {length} was full, {what}; {do}"


def _full(connector: runtime.DataConnector[Any]) -> int:
    """Return the samples lost because the buffer was full."""
    return connector.overwritten + connector.refused


def overruns(context: runtime.ExecutionContext) -> str:
    """Return why a context missed ticks, with a remedy for each cause."""
    longest, period = context.longest, context.period
    times = (
        f"the longest tick took {duration(longest)} of a period of {duration(period)}"
    )
    own = context.owner.instance_name if context.owner else "shared"
    causes = dict(context.causes)
    reasons = [
        (causes.pop(own, 0), f"{times}; do less in on_execute, or lower the rate")
    ]
    machine = f"ticks began late, the machine was busy; {times}"
    reasons.append((causes.pop(MACHINE, 0), machine))
    all_ = "the ticks of all components of the thread take longer; lower the rates"
    reasons.append((causes.pop(ALL, 0), all_))
    reasons += [
        (count, f"{name} ticked in the same thread; `rtgen.threads: own` in its .conf")
        for name, count in sorted(causes.items())
    ]
    reasons = [each for each in reasons if each[0]] or [(context.overruns, machine)]
    if len(reasons) == 1:
        return reasons[0][1]
    return "; ".join(f"{count} times: {text}" for count, text in reasons)
