"""Records what the page's server receives of the processes that run a system."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any, Final

from rtgen.runtime.system.records import MissingSamples
from rtgen.runtime.timing.steady import steady_utc
from rtgen.tools.kit.member_units import of_type
from rtgen.tools.recording import messages
from rtgen.tools.recording.channels import LAYOUT, Channels, Writer, unit_entries
from rtgen.tools.recording.lasting_writer import LastingWriter
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.messages import Topic
from rtgen.ui.description import STATES_BY_NAME
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.watching import Take

_NAMES: Final = {state: name for name, state in STATES_BY_NAME.items()}
_BEGIN: Final = _NAMES[ui.State.STATE_INACTIVE]
"""The state before the first change that a recording has."""


class PeersRecorder:
    """Writes components, states, parameters, connections and samples, at the times of arrival here.

    Times are UTC since 1970 [ns]. `report` gets the text of a failure, after which nothing is
    written any more; `files` closes the writer.
    """

    def __init__(
        self,
        writer: Writer,
        files: ExitStack,
        report: Callable[[str], None],
        now: Callable[[], int] = steady_utc,
    ) -> None:
        self.missing = MissingSamples()
        """The samples that cannot be encoded, and the ports that give none."""
        self._writer = LastingWriter(
            writer, lambda error: report(f"the recording has ended: {error}")
        )
        self._files = files
        self._now = now
        self._channels = Channels(self._writer)
        self._of_ports: dict[tuple[str, str], int] = {}
        self._state = RemoteState()
        """What was recorded last."""
        entries = {"layout": LAYOUT, "clock": "real", "start": str(now())}
        self._writer.metadata(METADATA, entries)

    def follow(self, state: RemoteState) -> None:
        """Record the changes of components and connections."""
        before, self._state = self._state, state
        for name, component in state.components.items():
            self._component(before.components.get(name), component)
        for name, connection in before.connections.items():
            if name not in state.connections:
                self._connection(connection, connected=False)
        for name, connection in state.connections.items():
            if name not in before.connections:
                self._connection(connection, connected=True)

    def _component(self, before: ui.Component | None, component: ui.Component) -> None:
        instance = component.instance
        if before is None:
            rate = component.contexts[0].rate if component.contexts else 0.0
            described = messages.Component(instance, component.type, rate)
            self._put(Topic.COMPONENTS, "component", described)
        if component.silent and (before is None or component.silent != before.silent):
            line = messages.LogLine(instance, logging.WARNING, component.silent)
            self._put(Topic.LOGS, "log", line)
        former = {} if before is None else _parameters(before)
        for name, text in _parameters(component).items():
            if former.get(name) != text:
                parameter = messages.Parameter(instance, name, text)
                self._put(Topic.PARAMETERS, "parameter", parameter)
        state = _BEGIN if before is None else _NAMES[before.current]
        if _NAMES[component.current] != state:
            after = _NAMES[component.current]
            change = messages.State(instance, state, after, 0, component.reason)
            self._put(Topic.STATES, "state", change)

    def _connection(self, connection: ui.Connection, *, connected: bool) -> None:
        ends = (connection.source, connection.target)
        source, target = (f"{end.instance}.{end.port}" for end in ends)
        properties = [
            messages.Property(each.name, each.text) for each in connection.properties
        ]
        change = messages.Connection(
            connection.name, source, target, properties, connected
        )
        self._put(Topic.CONNECTIONS, "connection", change)

    def taker(self, instance: str, port: str, type_: Any, unit: str) -> Take:
        """Return what records samples of an OutPort, of a type that CDR encodes."""
        key = instance, port
        if key not in self._of_ports:
            units = {".".join(p): u for p, u in of_type(type_, unit).units.items()}
            entries = {"during": "", **unit_entries(unit, units)}
            self._of_ports[key] = self._channels.of_port(instance, port, type_, entries)
        channel, put, now = self._of_ports[key], self._writer.put, self._now

        def record(data: bytes) -> None:
            with self._writer.lock:
                put(channel, now(), data)

        return record

    def close(self) -> None:
        """Record the end, and write what is left."""
        self._put(Topic.RUN, "run", messages.Run("end", through=True))
        self._writer.close(self._files)

    def _put(self, topic: str, kind: str, value: Any) -> None:
        self._channels.put(topic, kind, value, self._now)


def _parameters(component: ui.Component) -> Mapping[str, str]:
    """Return the values of the active configuration set."""
    return {
        value.name: value.text
        for each in component.configuration_sets
        if each.name == component.active_set
        for value in each.values
    }
