"""What a session shows of other processes, which a watcher follows."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rtgen.facts.openrtm_ports import KIND
from rtgen.runtime.distribution.local_link import LEFT_OUT
from rtgen.runtime.distribution.local_runs import Changed, Noted, OnBoard, OnBus
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.member_units import of_type
from rtgen.ui import boards
from rtgen.ui.description import STATES_BY_NAME, member_units
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.type_table import NO_TYPE
from rtgen.ui.watching import Attach, Key, Use, Watcher

if TYPE_CHECKING:
    from rtgen.runtime.distribution.local_runs import Event
    from rtgen.runtime.opaque_rpc.codecs import Codec
    from rtgen.ui.session_view import SessionView


_MAX_EVENTS: Final = 2000
"""Maximum number of frames, calls and notices of a run that wait; further ones are left out."""
_AT_ONCE: Final = 50
"""Number of them between other requests."""


class OtherProcesses:
    """The last state that the watcher has told, and its changes for pages.

    Only the thread of the session's runner changes it.
    """

    def __init__(self, session: SessionView) -> None:
        self._session = session
        self.state = RemoteState()
        self.watcher: Watcher | None = None
        self._codecs = boards.Codecs(self._codec_of)
        self._events: deque[Event] = deque()
        """Those that wait for the session's thread."""
        self._lock = threading.Lock()
        self._is_processing = self._left_out = self._told_left_out = False

    def follow(self, attach: Attach) -> None:
        """Begin to watch."""
        self.watcher = attach(self._update, self._report)
        if self.watcher.access is not None:
            self._session.buses.access = self.watcher.access
        self.watcher.follow(self._take_event)

    def close(self) -> None:
        """Stop watching."""
        if self.watcher is not None:
            self.watcher.close()

    @property
    def time(self) -> float | None:
        """The time of the run that is watched [s]; None if there is none."""
        return None if self.watcher is None else self.watcher.time

    def watch(self, channels: Iterable[ui.Channel]) -> None:
        """Receive the samples of these channels, if they are of other processes."""
        if self.watcher is not None:
            known = self.state.components
            self.watcher.watch(
                {
                    Key(Use.LISTEN, each.port.instance, each.port.port): partial(
                        self._take, each.id
                    )
                    for each in channels
                    if each.port.instance in known
                }
            )

    def _take(self, channel: int, data: bytes) -> None:
        session = self._session
        session.sample(ui.Sample(channel, session.now, data))

    def _update(self, state: RemoteState) -> bool:
        """Publish the changes; from any thread."""
        return self._session.runner.submit(partial(self._changed, state))

    @property
    def settings(self) -> Iterator[Mapping[str, str]]:
        """The values of the parameters of each component."""
        for component in [*self.state.components.values()]:
            for each in component.configuration_sets:
                if each.name == component.active_set:
                    yield {value.name: value.text for value in each.values}

    def _codec_of(self, instance: str) -> Codec | None:
        component = self.state.components.get(instance)
        return (
            None if component is None else self._session.project.codec(component.type)
        )

    def _take_event(self, event: Event) -> None:
        """Process an event soon; of those that come too fast, changes of state alone."""
        runner = self._session.runner
        if isinstance(event, Changed):
            runner.submit(partial(self._happened, event))
            return
        with self._lock:
            if len(self._events) >= _MAX_EVENTS:
                self._left_out = True
                return
            self._events.append(event)
            if self._is_processing:
                return
            self._is_processing = True
        runner.submit(self._process)

    def _process(self) -> None:
        """Process some of the events that wait, between other requests."""
        if self._left_out and not self._told_left_out:
            self._told_left_out = True
            self._session.notice("lost", "", LEFT_OUT)
        with self._lock:
            number = min(_AT_ONCE, len(self._events))
            events = [self._events.popleft() for _ in range(number)]
        try:
            for event in events:
                self._happened(event)
        finally:
            with self._lock:
                waits = self._is_processing = bool(self._events)
            if waits:
                self._session.runner.submit(self._process)

    def _happened(self, event: Event) -> None:
        session, time = self._session, event.time / SECOND
        match event:
            case OnBus(frame=frame):
                session.buses.on_frame(frame, time)
            case OnBoard(call=called):
                joined = (
                    (each.source.instance, each.target.instance)
                    for each in self.state.connections.values()
                )
                codec = self._codecs.of(called.instance, joined)
                shown = boards.described_call(called, time, codec)
                session.publish(ui.Event.of_call(shown))
            case Noted(kind=kind, instance=instance, text=text):
                session.notice(kind, instance, text)
            case Changed(instance=instance, reason=reason):
                component = self.state.components.get(instance)
                after = STATES_BY_NAME[event.after]
                if component is None or component.current is after:
                    return  # It is not known yet, or has been asked for meanwhile.
                component.current, component.reason = after, reason
                before = STATES_BY_NAME[event.before]
                change = ui.StateChange(
                    time, instance, event.ec_id, before, after, reason
                )
                session.publish(ui.Event.of_change(change))

    def _report(self, instance: str, text: str) -> None:
        session = self._session
        session.runner.submit(lambda: session.notice("error", instance, text))

    def _changed(self, state: RemoteState) -> None:
        session = self._session
        before, self.state = self.state, state.known(self._completed)
        session.flows.others = self.state.flows
        session.chains.others = self.state.chains
        if self.state.connections.keys() != before.connections.keys():
            self._codecs.forget()
        session.buses.open()
        if self.state.run.number != before.run.number:
            session.run_again()
            session.edits.forget()
            session.runner.play()
            session.watch_changed()
            return
        for instance in before.components.keys() - self.state.components.keys():
            session.forget(instance)
        for instance in self.state.components.keys() - before.components.keys():
            component = session.foreign.get(f"{instance}.{KIND}")
            if component is not None and component.location is not None:
                x, y = component.location[:2]
                session.places.setdefault(instance, (float(x), float(y)))
        opened = self.open()
        changes = self.state.changes(before, session.now)
        session.publish(*map(self._placed, changes), *map(ui.Event.of_opened, opened))
        if self.state.run.less and not before.run.less:
            session.notice("lost", "", self.state.run.less)
        if self.state.run.ended != before.run.ended:
            if self.state.run.ended:
                session.notice("end", "", self.state.run.ended)
            session.publish(ui.Event.of_clock(session.time()))
        session.watch_changed()

    def _completed(self, port: ui.Port) -> ui.Port:
        """Return a port with the project's types."""
        session = self._session
        project, describe = session.project, session.describe
        number, units = NO_TYPE, port.units
        if port.type and (type_ := project.data_type(port.type)) is not None:
            number = describe.type_number(type_)
            units = member_units(of_type(type_, port.unit))
        interfaces = [
            (
                replace(each, operations=describe.operations(interface))
                if each.provided and (interface := project.interface(each.type))
                else each
            )
            for each in port.interfaces
        ]
        return replace(port, type_number=number, units=units, interfaces=interfaces)

    def open(self) -> list[ui.Channel]:
        """Return the channels of new OutPorts."""
        return [
            self._session.channels.opened(instance, port.name, port.type_number)
            for instance, component in self.state.components.items()
            for port in component.ports
            if port.kind is ui.PortKind.PORT_OUT
            and port.type_number >= 0
            and (instance, port.name) not in self._session.channels
        ]

    def _placed(self, event: ui.Event) -> ui.Event:
        """Add the place of its box to an event about a component."""
        if event.discriminator is not ui.EventKind.EVENT_COMPONENT:
            return event
        return ui.Event.of_described(self._session.component(event.described.instance))
