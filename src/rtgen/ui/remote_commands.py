"""Commands for components of other processes, whose calls run concurrently with the system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from rtgen.compiler.model import SystemComponent
from rtgen.facts.openrtm_ports import KIND
from rtgen.ui import saving
from rtgen.ui.calls import decoded
from rtgen.ui.changes import unwritten
from rtgen.ui.documents.profile import Change
from rtgen.ui.edits import Edit
from rtgen.ui.errors import IMPOSSIBLE, UNKNOWN, CommandError
from rtgen.ui.fitting import require_fitting
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind
from rtgen.ui.remote_state import restored
from rtgen.ui.session import Session

if TYPE_CHECKING:
    from rtgen.ui.watching import Watcher

_OF_BUSES: Final = frozenset(
    (
        CommandKind.COMMAND_SEND_FRAME,
        CommandKind.COMMAND_NMT,
        CommandKind.COMMAND_SDO_READ,
        CommandKind.COMMAND_SDO_WRITE,
    )
)
Action = Callable[[], None]
"""Is executed in the thread that calls other processes. Raises CommandError."""


class RemoteCommands:
    """Selects the commands that concern other processes; in the thread of the session's runner."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def action(self, command: ui.Command, result: ui.Result) -> Action | None:
        """Return the action that executes a command; None if it only concerns this process.

        Raises CommandError.
        """
        watcher = self._session.others.watcher
        if watcher is None:
            return None
        value: Any = command.value
        kind = command.discriminator
        match kind:
            case CommandKind.COMMAND_UNDO | CommandKind.COMMAND_REDO:
                return self._back(undo=kind is CommandKind.COMMAND_UNDO)
            case CommandKind.COMMAND_RESTORE:
                commands = [(c, self._effect(c)) for c in self._differences()]
                return partial(self._restore, watcher, commands)
            case _ if self._session.remote.is_attached and kind in _OF_BUSES:
                return partial(self._on_bus, command, result)
            case _ if not self._is_remote(command):
                return None
            case CommandKind.COMMAND_CALL:
                return self._call(watcher, value, result)
            case CommandKind.COMMAND_INJECT:
                return self._inject(watcher, value)
            case CommandKind.COMMAND_REMOVE:
                raise CommandError(
                    IMPOSSIBLE, f"{value} belongs to another process, which removes it"
                )
            case CommandKind.COMMAND_CONNECT:
                require_fitting(self._session, value)
        return partial(self._change, watcher, command, self._effect(command))

    def _on_bus(self, command: ui.Command, result: ui.Result) -> None:
        buses = self._session.buses
        value: Any = command.value
        match command.discriminator:
            case CommandKind.COMMAND_SEND_FRAME:
                buses.send(value)
            case CommandKind.COMMAND_NMT:
                buses.manage(value)
            case CommandKind.COMMAND_SDO_READ:
                result.text, result.reply = buses.read(value)
            case CommandKind.COMMAND_SDO_WRITE:
                buses.write(value)

    def _effect(self, command: ui.Command) -> Change | None:
        """Return the effect of a command for components of other processes on the file."""
        if self._session.is_new:
            return unwritten
        return saving.remote_effect(self._session, command)

    def _is_remote(self, command: ui.Command) -> bool:
        """Return whether a command is for components of other processes."""
        value: Any = command.value
        remote = self._session.remote
        match command.discriminator:
            case CommandKind.COMMAND_CUT:
                return value in remote.connections
            case CommandKind.COMMAND_REMOVE:
                return value in remote.components
            case (
                CommandKind.COMMAND_ACTIVATE
                | CommandKind.COMMAND_DEACTIVATE
                | CommandKind.COMMAND_RESET
            ):
                return any(each in remote.components for each in value)
            case CommandKind.COMMAND_SET | CommandKind.COMMAND_ACTIVATE_SET:
                return value.instance in remote.components
            case CommandKind.COMMAND_CALL | CommandKind.COMMAND_INJECT:
                return value.port.instance in remote.components
            case CommandKind.COMMAND_CONNECT:
                ends = value.source.instance, value.target.instance
                return any(each in remote.components for each in ends)
        return False

    def _change(
        self, watcher: Watcher, command: ui.Command, effect: Change | None
    ) -> None:
        edit = watcher.carry_out(command)
        if edit is not None:
            enter = partial(self._enter, replace(edit, change=effect))
            self._session.runner.submit(enter)

    def _restore(
        self,
        watcher: Watcher,
        commands: Sequence[tuple[ui.Command, Change | None]],
    ) -> None:
        """Execute as many commands as possible; raise CommandError for the others."""
        failed = []
        for command, effect in commands:
            try:
                self._change(watcher, command, effect)
            except CommandError as error:
                failed.append(error)
        if failed:
            message = "; ".join(dict.fromkeys(map(str, failed)))
            raise CommandError(failed[0].code, message, failed[0].hint)

    def _differences(self) -> list[ui.Command]:
        """Return the commands that bring other processes into the state of the file."""
        session = self._session
        remote = session.remote
        names = {
            component.instance: instance
            for path, component in session.foreign.items()
            if (instance := path.removesuffix(f".{KIND}")) in remote.components
        }
        commands = [
            command
            for component in session.foreign.values()
            if component.instance in names
            for command in _settings(
                component, remote.components[names[component.instance]]
            )
        ]
        there = {
            _ends(each.source, each.target) for each in remote.connections.values()
        }
        for each in session.profile.connections:
            source, target = (
                ui.PortAddress(names.get(end.instance, end.instance), end.port)
                for end in (each.source, each.target)
            )
            is_outside = {each.source.instance, each.target.instance} & names.keys()
            if is_outside and _ends(source, target) not in there:
                stated = [ui.Value(*pair) for pair in each.properties]
                connect = ui.Connect(source, target, "", restored(stated))
                commands.append(ui.Command.of_wire(connect))
        return commands

    def _enter(self, edit: Edit) -> None:
        self._session.edits.enter(edit)
        self._session.publish_edits()

    def _back(self, *, undo: bool) -> Action | None:
        edits = self._session.edits
        edit = edits.next(undo=undo)
        if not edit.remote:
            return None
        edits.begin(edit)

        def carry_out() -> None:
            done = False
            try:
                (edit.undo if undo else edit.redo)()
                done = True
            finally:
                self._session.runner.submit(partial(end, done))

        def end(done: bool) -> None:
            edits.end(edit, undo=undo, done=done)
            self._session.publish_edits()

        return carry_out

    def _port(self, address: ui.PortAddress) -> ui.Port:
        port = self._session.remote.port(address)
        if port is None:
            message = f"{address.instance} has no port {address.port!r}"
            raise CommandError(UNKNOWN, message)
        return port

    def _call(self, watcher: Watcher, command: ui.Call, result: ui.Result) -> Action:
        offered = {e.name: e for e in self._port(command.port).interfaces if e.provided}
        if command.interface_name not in offered:
            where = f"{command.port.instance}.{command.port.port}"
            names = ", ".join(offered) or "none"
            raise CommandError(
                UNKNOWN,
                f"{where} provides no {command.interface_name!r}; known: {names}",
            )
        type_ = offered[command.interface_name].type
        interface = self._session.project.interface(type_)
        if interface is None:
            raise CommandError(IMPOSSIBLE, f"the project does not define {type_}")

        def carry_out() -> None:
            result.reply = watcher.call(command, interface, type_)

        return carry_out

    def _inject(self, watcher: Watcher, command: ui.Inject) -> Action:
        port = self._port(command.port)
        if port.kind is not ui.PortKind.PORT_IN:
            raise CommandError(
                IMPOSSIBLE, "of ports of other processes InPorts alone take samples"
            )
        type_ = self._session.project.data_type(port.type)
        if type_ is None:
            raise CommandError(IMPOSSIBLE, f"the project does not define {port.type}")
        value = decoded(type_, command.data)
        return partial(watcher.give, command.port, value)


def _settings(component: SystemComponent, now: ui.Component) -> Iterator[ui.Command]:
    """Yield the commands that set the values and the active set of the file."""
    sets = {s.name: {v.name: v.text for v in s.values} for s in now.configuration_sets}
    for set_id, values in component.parameter_sets:
        for name, text in values:
            if sets.get(set_id, {}).get(name) != text:
                command = ui.SetParameter(now.instance, set_id, name, text)
                yield ui.Command.of_setting(command)
    if component.active_set != now.active_set:
        yield ui.Command.of_chosen(ui.ActiveSet(now.instance, component.active_set))


def _ends(source: ui.PortAddress, target: ui.PortAddress) -> tuple[str, ...]:
    return source.instance, source.port, target.instance, target.port
