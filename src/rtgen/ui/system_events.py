"""What happens in the system of a session, as events for its pages."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rtgen import runtime
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.system.joining import instances_of
from rtgen.runtime.system.json_printers import json_printer
from rtgen.runtime.system.records import Record, StateRecord, Viewer
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import (
    BoardCall,
    BusFrame,
    ConnectionChange,
    ParameterChange,
)
from rtgen.runtime.timing.traffic import Event as Happening
from rtgen.tools.recording.channels import cdr_encoder
from rtgen.ui import boards, description
from rtgen.ui.description import STATES
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.ui.session_view import SessionView


class SystemEvents(Viewer):
    """Publishes samples, states, parameters, connections, frames and calls of a system."""

    def __init__(self, session: SessionView, system: runtime.System) -> None:
        self._session = session
        self._system = system
        self._codecs = boards.Codecs(
            lambda instance: boards.codec_of(system.component(instance))
        )
        self._across: set[str] = set()
        """Names of the connections to other processes, which those show."""
        system.clock.traffic.watch(self._on_traffic)
        system.add_listener(self)

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """Return a writer that sends the samples of a port to the pages that watch it."""
        type_number = self._session.describe.type_number(port.type)
        channel = self._session.channels.opened(port.owner, port.name, type_number)
        number = channel.id
        encode: Any = cdr_encoder(port.type)
        if channel.type_number < 0 or encode is None:
            printed = json_printer(port.type)

            def encode(value: Any) -> bytes:
                return printed(value).encode()

        def write(value: Any) -> None:
            try:
                data = encode(value)
            except CdrError:
                return  # The recorder counts invalid samples; pages cannot show them.
            self._session.sample(ui.Sample(number, elapsed() / SECOND, data))

        return write

    def __call__(self, record: Record) -> None:
        """Publish a change of state."""
        if not isinstance(record, StateRecord) or self._is_over:
            return
        self._session.publish(
            ui.Event.of_change(
                ui.StateChange(
                    time=record.time / SECOND,
                    instance=record.instance,
                    handle=record.ec_id,
                    before=STATES[record.before],
                    after=STATES[record.after],
                    reason=record.reason,
                )
            )
        )

    @property
    def _is_over(self) -> bool:
        """Whether the system is being closed, so that it is no longer shown."""
        return self._session.system is not self._system

    def _on_traffic(self, happening: Happening) -> None:
        if self._is_over:
            return
        match happening:
            case ParameterChange(instance) if instance not in self._system.instances:
                pass  # It is being added, and is described afterwards.
            case ParameterChange(instance, parameter, value):
                sets = self._system.component(instance).configuration_sets
                change = ui.ParameterChange(
                    instance=instance,
                    set=sets.active,
                    parameter=parameter,
                    text=value,
                    effective=True,
                )
                self._session.publish(ui.Event.of_setting(change))
            case ConnectionChange(name, connected=True):
                self._codecs.forget()
                connector = self._system.connector(name)
                if not self._session.is_within(connector):
                    self._across.add(name)
                    return
                self._session.publish(
                    ui.Event.of_connected(description.connection(connector))
                )
            case ConnectionChange(name) if name in self._across:
                self._across.discard(name)
            case ConnectionChange(name):
                self._session.publish(ui.Event.of_cut(name))
            case BusFrame():
                self._session.buses.on_frame(happening, self._session.now)
            case BoardCall(instance):
                joined = map(instances_of, self._session.connectors)
                codec = self._codecs.of(instance, joined)
                call = boards.described_call(happening, self._session.now, codec)
                self._session.publish(ui.Event.of_call(call))
