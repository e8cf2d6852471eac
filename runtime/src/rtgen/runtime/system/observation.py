"""Observation of a running system: records for listeners, samples for watchers of ports."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, cast

import msgspec

from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import ERROR_STATE, LifeCycleState
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.system.records import (
    Listener,
    SampleRecord,
    SampleWriter,
    StateRecord,
    Viewer,
)
from rtgen.runtime.timing.traffic import ConnectionChange


class Observation(msgspec.Struct, eq=False):
    """The listeners of a system, and the watchers of its OutPorts.

    Their exceptions are passed to `end_run`: they are not failures of a component.
    """

    _elapsed: Callable[[], int]
    _end_run: Callable[[BaseException], None]
    _listeners: tuple[Listener, ...] = ()
    _state_watchers: tuple[Callable[[StateRecord], None], ...] = ()
    _watched: dict[tuple[str, str], tuple[Callable[[Any], None], ...]] = {}

    def add(self, listener: Listener, components: Iterable[Component]) -> None:
        """Add a listener for the states of all components, and the samples of these."""
        self._set_listeners((*self._listeners, listener), components)

    def remove(self, listener: Listener, components: Iterable[Component]) -> None:
        """Remove a listener; an unknown one is ignored."""
        remaining = tuple(
            listening for listening in self._listeners if listening is not listener
        )
        self._set_listeners(remaining, components)

    def watch(self, port: OutPort[Any], action: Callable[[Any], None]) -> None:
        """Call a function with each sample that a port writes."""
        address = port.owner, port.name
        self._watched[address] = (*self._watched.get(address, ()), action)
        self._observe(port)

    def watch_states(self, action: Callable[[StateRecord], None]) -> None:
        """Call a function with each change of state."""
        self._state_watchers = (*self._state_watchers, action)

    def observe(self, component: Component) -> None:
        """Report samples of a component's OutPorts to listeners and watchers."""
        for port in component.out_ports.values():
            self._observe(port)

    def state_changed(
        self, participant: Participant, before: LifeCycleState, after: LifeCycleState
    ) -> None:
        """Notify the listeners of a change of state."""
        watchers = (*self._listeners, *self._state_watchers)
        if watchers:
            component = participant.component
            record = StateRecord(
                "state",
                self._elapsed(),
                component.instance_name,
                before,
                after,
                participant.handle,
                component.reason if after is ERROR_STATE else "",
            )
            self._notify(record, watchers)

    def _set_listeners(
        self, listeners: tuple[Listener, ...], components: Iterable[Component]
    ) -> None:
        self._listeners = listeners
        for component in components:
            self.observe(component)

    def _observe(self, port: OutPort[Any]) -> None:
        watchers = self._watched.get((port.owner, port.name), ())
        if not self._listeners and not watchers:
            port._observe(None)
            return
        of_listeners = [
            (cast(SampleWriter, one).sample_writer(port, self._elapsed), one)
            for one in self._listeners
            if isinstance(one, SampleWriter)
        ]
        shown = [write for write, one in of_listeners if isinstance(one, Viewer)]
        port._observe(
            self._sample_writer(
                port, [*watchers, *(write for write, _ in of_listeners)]
            ),
            self._guarded(shown) if shown else None,
        )

    def _sample_writer(
        self, port: OutPort[Any], writers: list[Callable[[Any], None]]
    ) -> Callable[[Any], None]:
        """Notify listeners and watchers of a sample of the port."""
        elapsed = self._elapsed
        others = [one for one in self._listeners if not isinstance(one, SampleWriter)]

        def notify(value: Any) -> None:
            record = SampleRecord(
                "sample", elapsed(), port.owner, port.name, value._snapshot_()
            )
            for listener in others:
                listener(record)

        if others:
            writers.append(notify)
        return self._guarded(writers)

    def _guarded(self, writers: list[Callable[[Any], None]]) -> Callable[[Any], None]:
        """Return a function that passes a sample to all; their exceptions end the run."""

        def write_to_all(value: Any) -> None:
            for writer in writers:
                writer(value)

        chosen = writers[0] if len(writers) == 1 else write_to_all

        def write(value: Any) -> None:
            try:
                chosen(value)
            except BaseException as error:
                self._end_run(error)

        return write

    def _notify(
        self, record: StateRecord, watchers: Iterable[Callable[[StateRecord], None]]
    ) -> None:
        for listener in watchers:
            try:
                listener(record)
            except BaseException as error:
                self._end_run(error)


def connection_change(connector: Any, *, connected: bool) -> ConnectionChange:
    """Return a connection of any kind in the form for recorders."""
    properties = getattr(connector, "properties", {})
    source, target = str(connector.source), str(connector.target)
    return ConnectionChange(connector.name, source, target, properties, connected)
