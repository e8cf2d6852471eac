"""A page without a browser, which applies the events of a session that watches other processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from patience import until
from ui_bench import RESULT

from rtgen.ui.commands import Commands
from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session


class Watching:
    """A page without a system of its own, which applies events."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.session.runner.start()
        self._commands = Commands(self.session)
        self._number = 0
        self.outbox = Outbox(lambda: None)
        self.components: dict[str, ui.Component] = {}
        self.connections: dict[str, ui.Connection] = {}
        self.services: list[ui.NamingService] = []
        self.results: dict[int, ui.Result] = {}
        self.notices: list[str] = []
        self.channels: list[ui.Channel] = []
        self.samples: dict[int, list[ui.Sample]] = {}
        self.edits = ui.EditState()
        self.changes: list[ui.StateChange] = []
        self.buses: dict[str, ui.Bus] = {}
        self.frames: list[ui.Frame] = []
        self.calls: list[ui.BoardCall] = []
        self.chains: list[ui.Chain] = []
        self.plan: list[ui.PlannedEvent] = []
        self.doc = ""
        self.session.runner.submit(lambda: self.session.join(self.outbox))

    def follow(self) -> None:
        """Process the events since the last call."""
        data = self.outbox.take()
        for event in ui.ServerMessage.from_cdr(data).events if data else ():
            value: Any = event.value
            match event.discriminator:
                case ui.EventKind.EVENT_SYSTEM:
                    self.components = {each.instance: each for each in value.components}
                    self.connections = {each.name: each for each in value.connections}
                    self.services = value.naming
                    self.channels = value.channels
                    self.edits = value.edits
                    self.plan, self.doc = value.plan, value.doc
                    self.buses = {each.name: each for each in value.buses}
                case ui.EventKind.EVENT_CHANNEL:
                    self.channels.append(value)
                case ui.EventKind.EVENT_SAMPLES:
                    for each in value:
                        self.samples.setdefault(each.channel, []).append(each)
                case ui.EventKind.EVENT_EDITS:
                    self.edits = value
                case ui.EventKind.EVENT_COMPONENT:
                    self.components[value.instance] = value
                case ui.EventKind.EVENT_REMOVED:
                    del self.components[value]
                case ui.EventKind.EVENT_STATE if value.instance in self.components:
                    component = self.components[value.instance]
                    component.current, component.reason = value.after, value.reason
                    self.changes.append(value)
                case ui.EventKind.EVENT_BUS:
                    self.buses[value.name] = value
                case ui.EventKind.EVENT_FRAMES:
                    self.frames.extend(value)
                case ui.EventKind.EVENT_BOARD_CALL:
                    self.calls.append(value)
                case ui.EventKind.EVENT_CHAINS:
                    self.chains = value
                case ui.EventKind.EVENT_CONNECTED:
                    self.connections[value.name] = value
                case ui.EventKind.EVENT_CUT:
                    del self.connections[value]
                case ui.EventKind.EVENT_NAMING:
                    self.services = value
                case ui.EventKind.EVENT_NOTICE:
                    self.notices.append(f"{value.kind} {value.instance}")
                case kind if kind is RESULT:
                    self.results[value.request] = value

    def until(self, condition: Callable[[], Any]) -> Any:
        """Return the value of a condition once it is true."""
        return until(lambda: self.follow() or condition(), shown=self.shown)

    def shown(self) -> str:
        """Return the parts of the state that tests wait for."""
        silent = {name: each.silent for name, each in self.components.items()}
        known = [*self.session.remote.components], [*self.session.foreign]
        return f"{silent}, {self.services}, {known}, {self.notices}"

    def ask(self, branch: str, value: Any) -> ui.Result:
        """Send a command; return its result."""
        self._number += 1
        asked = getattr(ui.Command, f"of_{branch}")(value)
        message = ui.ClientMessage(request=self._number, asked=asked)
        number = self._number
        self.session.runner.submit(lambda: self._commands.execute(self.outbox, message))
        self.until(lambda: number in self.results)
        return self.results[number]

    def done(self, branch: str, value: Any) -> ui.Result:
        """Send a command that succeeds."""
        result = self.ask(branch, value)
        assert result.done, f"{result.code}: {result.message}"
        return result

    def state(self, name: str) -> ui.State | None:
        """Return the state that the page shows."""
        found = self.components.get(name)
        return None if found is None else found.current

    def wires(self) -> dict[tuple[str, str], str]:
        """Return the names of connections by their ends, without the naming service."""
        return {
            (ending(each.source), ending(each.target)): each.name
            for each in self.connections.values()
        }


def ending(address: ui.PortAddress) -> str:
    return f"{address.instance.rpartition('/')[2]}.{address.port}"
