"""Executes the commands of pages between two instants of the run."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from msgspec.structs import replace

from rtgen.compiler.backends.kit.quoting.code import UnquotableError
from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.model import System, SystemComponent
from rtgen.runtime.errors import (
    ConfigurationError,
    ConnectError,
    DuplicateConnectionError,
    ParameterValueError,
    RtcError,
    UnknownComponentError,
    UnknownConnectionError,
)
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.system.joining import instances_of
from rtgen.runtime.timing.clocks import SECOND
from rtgen.ui import calls, renames, saving
from rtgen.ui.adjusting import adjust
from rtgen.ui.changes import ends_of, new_component, unwritten
from rtgen.ui.comparing import Comparing, Later
from rtgen.ui.description import properties_of
from rtgen.ui.documents.document import DocumentError
from rtgen.ui.documents.profile import Change
from rtgen.ui.edits import Edit
from rtgen.ui.errors import (
    BAD_VALUE,
    CALL_FAILED,
    FILE,
    IMPOSSIBLE,
    NO_FIT,
    NO_RIGHT,
    QUESTION,
    UNKNOWN,
    WRONG_STATE,
    CommandError,
)
from rtgen.ui.fitting import fits, require_fitting
from rtgen.ui.outbox import Outbox
from rtgen.ui.project import Known
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind
from rtgen.ui.remote_commands import RemoteCommands
from rtgen.ui.session import Session
from rtgen.ui.texts import explained

READING: Final = frozenset(
    (
        CommandKind.COMMAND_WATCH,
        CommandKind.COMMAND_FITS,
        CommandKind.COMMAND_OBJECTS,
        CommandKind.COMMAND_LOOK,
        CommandKind.COMMAND_RECORDINGS,
    )
)
"""Commands that a read-only page may send."""
_URGENT: Final = frozenset(
    (
        CommandKind.COMMAND_ACTIVATE,
        CommandKind.COMMAND_DEACTIVATE,
        CommandKind.COMMAND_RESET,
    )
)
_OF_FILES: Final = frozenset(
    (
        CommandKind.COMMAND_ADD,
        CommandKind.COMMAND_REMOVE,
        CommandKind.COMMAND_SAVE,
        CommandKind.COMMAND_REPLACE,
        CommandKind.COMMAND_OPEN,
        CommandKind.COMMAND_RENAME,
        CommandKind.COMMAND_ADJUST,
    )
)
"""Commands that concern the file of the system that this process runs."""
_NAME: Final = re.compile(r"[^./\\\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]+")
"""The name of a new component, also in names of files and of naming services."""
_MAX_NAME: Final = 100
_MAX_SEEK_TIME: Final = 3600.0
"""Maximum time to which a simulation can be set [s]."""


class Commands:
    """Executes the commands of pages on a session, in the thread of its runner."""

    def __init__(self, session: Session) -> None:
        self._session = session
        kinds = CommandKind
        self._handlers: dict[CommandKind, Callable[[Any], str | None]] = {
            kinds.COMMAND_CONNECT: self._connect,
            kinds.COMMAND_CUT: self._cut,
            kinds.COMMAND_ADJUST: lambda command: adjust(
                session, command, self._adjusted
            )[0],
            kinds.COMMAND_ACTIVATE: partial(self._request, "activate"),
            kinds.COMMAND_DEACTIVATE: partial(self._request, "deactivate"),
            kinds.COMMAND_RESET: partial(self._request, "reset"),
            kinds.COMMAND_SET: self._set,
            kinds.COMMAND_ACTIVATE_SET: self._activate_set,
            kinds.COMMAND_ADD: self._add,
            kinds.COMMAND_REMOVE: self._remove,
            kinds.COMMAND_MOVE: self._move,
            kinds.COMMAND_SAVE: partial(self._save, replace_file=False),
            kinds.COMMAND_REPLACE: partial(self._save, replace_file=True),
            kinds.COMMAND_UNDO: lambda _: self._undo(undo=True),
            kinds.COMMAND_REDO: lambda _: self._undo(undo=False),
            kinds.COMMAND_PLAY: self._play,
            kinds.COMMAND_PAUSE: self._pause,
            kinds.COMMAND_STEP: self._step,
            kinds.COMMAND_SPEED: self._speed,
            kinds.COMMAND_SEEK: self._seek,
            kinds.COMMAND_OPEN: self._open,
            kinds.COMMAND_BESIDE: self._compare_with_this_run,
            kinds.COMMAND_INJECT: self._inject,
            kinds.COMMAND_SEND_FRAME: lambda frame: session.buses.send(frame),
            kinds.COMMAND_NMT: lambda command: session.buses.manage(command),
            kinds.COMMAND_SDO_WRITE: lambda value: session.buses.write(value),
        }
        self._injector = calls.Injector()
        self._remote_commands = RemoteCommands(session)
        self._comparing = Comparing(session)

    def is_urgent(self, page: Outbox, message: ui.ClientMessage) -> bool:
        """Return whether a command can be carried out at once, in any thread.

        That are requests for states in real time, by which people stop a robot.
        """
        runner = self._session.runner
        return (
            page.full
            and message.asked.discriminator in _URGENT
            and not runner.is_simulated
        )

    def execute(self, page: Outbox, message: ui.ClientMessage) -> None:
        """Execute a command and send the page its result.

        A command for components of other processes runs concurrently with the system.
        """
        result = ui.Result(request=message.request, done=True)
        action = partial(self._dispatch, page, message.asked, result)
        self._answer(page, result, action)

    def _answer(
        self,
        page: Outbox,
        result: ui.Result,
        action: Callable[[], Later | None],
    ) -> None:
        """Execute an action, and report to the page whether it succeeded.

        The action may return another one, for another thread.
        """
        try:
            later = action()
            if later is not None:
                answer = partial(self._answer, page, result, later.action)
                if not later.submit(answer):
                    raise CommandError(IMPOSSIBLE, "too many commands wait")
                return
        except CommandError as error:
            result.done = False
            result.code, result.hint = error.code, error.hint
            result.message = str(error)
        except RtcError as error:
            result.done, result.code = False, code_of(error)
            result.message = str(error)
        except (InputError, ToolError) as error:
            result.done, result.code = False, BAD_VALUE
            result.message = explained(error)
        except Exception as error:
            result.done, result.code = False, CALL_FAILED
            result.message = f"{type(error).__name__}: {error}"
        page.put(ui.Event.of_outcome(result))

    def _dispatch(
        self, page: Outbox, command: ui.Command, result: ui.Result
    ) -> Later | None:
        kind = command.discriminator
        value: Any = command.value
        _require_right(page, command)
        elsewhere = self._remote_commands.action(command, result)
        watcher = self._session.others.watcher
        if elsewhere is not None and watcher is not None:
            return Later(watcher.submit, elsewhere)
        if kind in _OF_FILES and self._session.remote.is_attached:
            raise CommandError(
                IMPOSSIBLE,
                "not possible in a run that is only watched",
                "`rtgen ui SYSTEM` edits the file of the system",
            )
        if kind is CommandKind.COMMAND_WATCH:
            self._session.watch(page, value)
        elif kind is CommandKind.COMMAND_LOOK:
            self._session.look(page, value)
        elif kind is CommandKind.COMMAND_RECORDINGS:
            result.files = [*self._session.project.recordings]
        elif kind is CommandKind.COMMAND_COMPARE:
            return self._comparing.compare(value)
        elif kind is CommandKind.COMMAND_FITS:
            result.fits = fits(self._session, value)
        elif kind is CommandKind.COMMAND_CALL:
            result.reply = calls.call(self._session.system, value)
        elif kind is CommandKind.COMMAND_SDO_READ:
            result.text, result.reply = self._session.buses.read(value)
        elif kind is CommandKind.COMMAND_RENAME:
            result.renamed = renames.rename(self._session, value)
        elif kind is CommandKind.COMMAND_OBJECTS:
            result.objects = self._session.buses.objects(value)
        elif kind is CommandKind.COMMAND_ADJUST and not value.carried_out:
            result.text, result.renamed = adjust(self._session, value, self._adjusted)
        elif kind in self._handlers:
            before = self._session.edit_state()
            try:
                result.text = self._handlers[kind](value) or ""
            finally:
                if self._session.edit_state() != before:
                    self._session.publish_edits()
        else:
            raise CommandError(
                IMPOSSIBLE,
                "no naming service is watched",
                "start `rtgen ui` with --nameserver",
            )
        return None

    # Wiring.

    def _connect(self, command: ui.Connect) -> None:
        session = self._session
        source = command.source.instance, command.source.port
        target = command.target.instance, command.target.port
        properties = {each.name: each.text for each in command.properties}
        name = command.name or f"{'.'.join(source)}_{'.'.join(target)}"
        require_fitting(session, command)
        connector = session.system.connect(source, target, properties, name)
        session.edits.enter(
            Edit(
                f"connect {name}",
                lambda: session.system.connect(source, target, properties, name),
                lambda: session.system.disconnect(name),
                self._effect(session.changes.connect(connector, properties)),
            )
        )

    def _cut(self, name: str) -> None:
        session = self._session
        again = self._reconnect_action(name)
        ends = ends_of(session.system.connector(name))
        self._edit(
            f"cut {name}",
            lambda: session.system.disconnect(name),
            again,
            session.changes.cut(name, ends),
        )

    def _adjusted(
        self,
        name: str,
        after: Mapping[str, str],
        before: Mapping[str, str],
        change: Change | None,
    ) -> None:
        """Make a connection again with other properties; samples that wait in it are lost."""
        session = self._session

        def put(properties: Mapping[str, str], former: Mapping[str, str]) -> None:
            ends = ends_of(session.system.connector(name))
            session.system.disconnect(name)
            try:
                session.system.connect(*ends, properties, name)
            except RtcError:
                session.system.connect(*ends, former, name)
                raise

        self._edit(
            f"properties of {name}"[:200],
            lambda: put(after, before),
            lambda: put(before, after),
            change,
        )

    def _reconnect_action(self, name: str) -> Callable[[], object]:
        """Return an action that makes an existing connection again."""
        session = self._session
        connector = session.system.connector(name)
        ends = ends_of(connector)
        properties = properties_of(connector)
        return lambda: session.system.connect(*ends, properties, name)

    # Components.

    def _request(self, what: str, instances: Sequence[str]) -> None:
        """Request a state of components; without names, of all that this process runs.

        Raises CommandError for named components that cannot enter it, or if none of all can.
        """
        system = self._session.system
        request: Callable[[str], ReturnCode_t] = getattr(system, what)
        chosen = list(instances) or system.activation_order(system.instances)
        if not chosen:
            raise CommandError(
                IMPOSSIBLE,
                "this process runs no components",
                "components of other processes are controlled one by one",
            )
        answers = {instance: request(instance) for instance in chosen}
        wrong = [
            f"{instance}: {code.name}"
            for instance, code in answers.items()
            if code is not RTC_OK
        ]
        if instances and wrong:
            raise CommandError(WRONG_STATE, "; ".join(wrong))
        if len(wrong) == len(chosen):
            raise CommandError(
                WRONG_STATE, f"{what}: no component is in a state for it"
            )
        if not self._session.runner.playing and self._session.runner.is_simulated:
            self._session.notice("waiting", "", f"{what}: takes effect with time")

    def _add(self, command: ui.AddComponent) -> None:
        session = self._session
        name = command.instance or self._free_name(command.type)
        if len(name) > _MAX_NAME or not _NAME.fullmatch(name):
            raise CommandError(
                BAD_VALUE,
                f"{name[:80]!r} cannot be the name of a component",
                f"at most {_MAX_NAME} characters, without dots, slashes and controls",
            )
        if session.changes.component(name) and name not in session.system.instances:
            message = f"{name} is the name of another component of the file"
            raise CommandError(WRONG_STATE, message)
        component = new_component(name, command.type)
        place = (command.where.x, command.where.y) if command.placed else None
        self._put_in(component, place)
        change = session.changes.add(
            replace(component, location=_location(place)), session.system
        )
        session.edits.enter(
            Edit(
                f"add {name}",
                lambda: self._put_in(component, place),
                lambda: self._take_out(name),
                self._effect(change),
            )
        )
        session.watch_changed()

    def _put_in(
        self, component: SystemComponent, place: tuple[float, float] | None
    ) -> None:
        session, name = self._session, component.instance
        if component.type not in (each.type for each in session.palette):
            raise CommandError(UNKNOWN, f"the project knows no type {component.type}")
        folder = Path(session.profile.file).absolute().parent
        session.project.add(session.system, component, folder)
        if place is not None:
            session.places[name] = place
        session.publish(ui.Event.of_described(session.component(name)))
        for channel in session.channels_of(name):
            session.publish(ui.Event.of_opened(channel))

    def _take_out(self, name: str) -> None:
        self._session.system.remove(name)
        self._session.forget(name)
        self._session.publish(ui.Event.of_removed(name))

    def _remove(self, name: str) -> None:
        session = self._session
        component = saving.component_now(session, name)
        place = session.places.get(name)
        again = [
            self._reconnect_action(each.name)
            for each in session.connectors
            if name in instances_of(each)
        ]

        def undo() -> None:
            self._put_in(component, place)
            _all_of(again)

        change = session.changes.remove(name)
        self._edit(f"remove {name}", lambda: self._take_out(name), undo, change)

    def _free_name(self, type_: str) -> str:
        written = self._session.changes.written.components
        taken = {*self._session.system.instances, *(c.instance for c in written)}
        number = 0
        while f"{type_}{number}" in taken:
            number += 1
        return f"{type_}{number}"

    def _move(self, command: ui.Moved) -> None:
        session, name = self._session, command.instance
        before = session.places.get(name)
        after = command.where.x, command.where.y
        if name not in session.remote.components:
            session.system.component(name)

        def put(place: tuple[float, float] | None) -> None:
            if place is None:
                session.places.pop(name, None)
                session.publish(ui.Event.of_described(session.component(name)))
                return
            session.places[name] = place
            where = ui.Location(*place)
            session.publish(ui.Event.of_place(ui.Moved(instance=name, where=where)))

        change = self._moved(name, after)
        self._edit(f"move {name}", lambda: put(after), lambda: put(before), change)

    def _moved(self, name: str, place: tuple[float, float]) -> Change | None:
        """Return the effect of moving a component of this or another process."""
        session = self._session
        if name in session.remote.components and not session.is_new:
            return saving.remote_move(session, name, place)
        return session.changes.move(name, place)

    # Configuration.

    def _set(self, command: ui.SetParameter) -> None:
        instance, name = command.instance, command.parameter
        sets = self._session.system.component(instance).configuration_sets
        set_id = command.set or sets.active
        sets.check(name, command.text)

        def put(text: str) -> None:
            self._session.system.configure(instance, name, text, set_id)
            change = ui.ParameterChange(
                instance=instance, set=set_id, parameter=name, text=text
            )
            self._session.publish(ui.Event.of_setting(change))

        def describe(change: Callable[[], None]) -> None:
            change()
            component = self._session.component(instance)
            self._session.publish(ui.Event.of_described(component))

        redo = partial(put, command.text)
        if set_id in sets.ids:
            undo = partial(put, sets.texts(set_id)[name])
        else:
            redo = partial(describe, redo)
            undo = partial(describe, partial(sets.remove, set_id))
        change = self._session.changes.configure(instance, set_id, name, command.text)
        self._edit(f"{instance}.{name} = {command.text}"[:200], redo, undo, change)

    def _activate_set(self, command: ui.ActiveSet) -> None:
        instance = command.instance
        sets = self._session.system.component(instance).configuration_sets
        before = sets.active
        values = sets.texts(command.set) if command.set in sets.ids else {}
        change = self._session.changes.activate_set(instance, command.set, values)

        def put(set_id: str) -> None:
            self._session.system.activate_set(instance, set_id)
            chosen = ui.ActiveSet(instance=instance, set=set_id)
            self._session.publish(ui.Event.of_activated(chosen))

        self._edit(
            f"{instance}: set {command.set}"[:200],
            lambda: put(command.set),
            lambda: put(before),
            change,
        )

    def _edit(
        self,
        label: str,
        redo: Callable[[], object],
        undo: Callable[[], object],
        change: Change | None,
    ) -> None:
        self._session.edits.make(Edit(label, redo, undo, self._effect(change)))

    def _effect(self, change: Change | None) -> Change | None:
        """Return the effect of an edit on the file; of a new system each edit has one."""
        return unwritten if self._session.is_new else change

    def _undo(self, *, undo: bool) -> None:
        """Revert or repeat an edit in the file, and in the run if that is possible."""
        edits = self._session.edits
        edit = edits.next(undo=undo)
        try:
            edits.carry_out(edit, undo=undo)
        except (RtcError, CommandError, InputError, ToolError) as error:
            if edit.change is None:
                raise
            what = "undone" if undo else "redone"
            message = f"{edit.label}: {what} in the file, not in the run"
            raise CommandError(WRONG_STATE, f"{message}: {explained(error)}") from error

    # Files and time.

    def _save(self, file: str, *, replace_file: bool) -> str:
        """Save the file as opened with the edits; return what is to be said about it."""
        session = self._session
        target = file or session.file
        if not target:
            raise CommandError(FILE, "the file needs a name", "system.xml, for example")
        if session.is_new and not session.profile.name:
            name = target.rpartition("/")[2].partition(".")[0]
            session.take_over(replace(session.profile, name=name))
        try:
            data, profile = saving.content(session, target)
        except (DocumentError, UnquotableError) as error:
            raise CommandError(FILE, str(error)) from error
        if not replace_file:
            self._require_runnable(profile)
        content = session.known
        backup = session.project.write(target, data, content, replace=replace_file)
        session.take_over(profile)
        session.file, session.known = target, Known(target, data)
        session.edits.mark_saved()
        return f"the former content is in {backup}" if backup else ""

    def _require_runnable(self, profile: System) -> None:
        """Raise CommandError if the file could no longer be run, as it could when it was opened."""
        project = self._session.project
        before = project.refusals(self._session.profile)
        problems = [each for each in project.refusals(profile) if each not in before]
        if problems:
            more = f", and {len(problems) - 1} more" if len(problems) > 1 else ""
            message = f"`rtgen run` would refuse the saved system: {problems[0]}{more}"
            raise CommandError(QUESTION, message, "the timeline must be edited, too")

    def _open(self, file: str) -> None:
        if file not in self._session.project.systems:
            raise CommandError(UNKNOWN, f"{file} is not a system of the project")
        self._session.open(file)

    def _play(self, _: bool) -> None:
        self._session.runner.play()
        self._publish_time()

    def _pause(self, _: bool) -> None:
        self._require_simulated()
        self._session.runner.playing = False
        self._publish_time()

    def _step(self, duration: float) -> None:
        self._require_simulated()
        _check_range(duration, 0.0, _MAX_SEEK_TIME)
        self._session.runner.playing = False
        self._session.runner.step(round(duration * SECOND) or self._shortest())
        self._publish_time()

    def _shortest(self) -> int:
        """Return the shortest period of a component [ns]."""
        system = self._session.system
        rates = [system.context(each).get_rate() for each in system.instances]
        return round(SECOND / max(rates, default=1000.0))

    def _speed(self, speed: float) -> None:
        self._require_simulated()
        _check_range(speed, 0.0, 1e6)
        self._session.runner.set_speed(speed)
        self._publish_time()

    def _seek(self, time: float) -> None:
        """Set the time of a simulation: restart it with all edits, and run until that time."""
        self._require_simulated()
        _check_range(time, 0.0, _MAX_SEEK_TIME)
        session = self._session
        was_playing = session.runner.playing
        session.run_again()
        session.edits.forget()
        if time:
            session.runner.step(round(time * SECOND))
        if was_playing:
            session.runner.play()
        self._publish_time()

    def _compare_with_this_run(self, kept: bool) -> None:
        if not self._session.remote.is_attached:
            self._require_simulated()
        self._session.keep(kept=kept)

    def _require_simulated(self) -> None:
        if not self._session.runner.is_simulated:
            raise CommandError(
                IMPOSSIBLE,
                "real time cannot be stopped",
                "start `rtgen ui` with --clock sim",
            )

    def _publish_time(self) -> None:
        self._session.publish(ui.Event.of_clock(self._session.time()))

    def _inject(self, command: ui.Inject) -> None:
        self._injector.put(self._session.system, command)


def _location(place: tuple[float, float] | None) -> tuple[int, int, int, int] | None:
    return None if place is None else (round(place[0]), round(place[1]), -1, -1)


def _all_of(actions: Iterable[Callable[[], object]]) -> None:
    """Execute all actions that can be; raise CommandError for the others."""
    failed = []
    for action in actions:
        try:
            action()
        except RtcError as error:
            failed.append(str(error))
    if failed:
        raise CommandError(WRONG_STATE, "; ".join(failed))


def _require_right(page: Outbox, command: ui.Command) -> None:
    """Raise CommandError if the page has no permission for this command."""
    if command.discriminator not in READING and not page.full:
        raise CommandError(NO_RIGHT, "this page may only look")


def code_of(error: RtcError) -> str:
    """Return the code of an error of the runtime."""
    match error:
        case ParameterValueError():
            return BAD_VALUE
        case UnknownComponentError() | UnknownConnectionError() | ConfigurationError():
            return UNKNOWN
        case ConnectError() | DuplicateConnectionError():
            return NO_FIT
    return WRONG_STATE


def _check_range(value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise CommandError(BAD_VALUE, f"{value:g} is not between {low:g} and {high:g}")
