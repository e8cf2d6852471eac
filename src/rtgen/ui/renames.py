"""Renames by pages: an instance, or what a definition names, with all that follows.

The files change as by `rtgen generate --rename`; then the run begins again with them.
"""

from __future__ import annotations

from difflib import unified_diff
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rtgen.compiler.project import shown
from rtgen.facts.encodings import decode
from rtgen.runtime.timing.clocks import SECOND
from rtgen.ui.edits import Edit
from rtgen.ui.errors import IMPOSSIBLE, UNKNOWN, WRONG_STATE, CommandError
from rtgen.ui.fitting import require_port
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import RenameKind

if TYPE_CHECKING:
    from rtgen.tools.renaming.plan import Renaming
    from rtgen.ui.session import Session

_MAX_FILES: Final = 200
_MAX_LENGTH: Final = 20_000
"""Maximum length of the lines of a file that a page gets [characters]."""


def rename(session: Session, command: ui.Rename) -> list[ui.FileChange]:
    """Return what a rename changes, and carry it out if the command says so.

    Raises CommandError, InputError, ToolError; then all files are as before.
    """
    if not session.runner.is_simulated:
        message = "a rename begins the run again, and real time cannot be set back"
        hint = "start `rtgen ui` with --clock sim, or use `rtgen generate --rename`"
        raise CommandError(IMPOSSIBLE, message, hint)
    if not session.edits.saved:
        message = f"the edits of {session.file} are not saved"
        hint = "save or undo them: a rename changes the file"
        raise CommandError(WRONG_STATE, message, hint)
    renaming = _planned(session, command)
    changes = [*_changes(renaming)]
    if command.carried_out:
        label = f"rename {renaming.old} to {renaming.new}"
        _carry_out(session, renaming, label)
    return changes


def _planned(session: Session, command: ui.Rename) -> Renaming:
    """Return the plan of a rename. Raises CommandError, InputError."""
    instance = command.instance
    if instance not in session.system.instances:
        raise CommandError(UNKNOWN, f"there is no component {instance!r} in this run")
    if command.kind is RenameKind.RENAME_INSTANCE:
        if session.changes.component(instance) is None:
            raise CommandError(UNKNOWN, f"{instance} is not in the file {session.file}")
        return session.project.renaming_of_instance(
            session.file, instance, command.name
        )
    name = session.system.component(instance).profile.type_name
    if command.kind is RenameKind.RENAME_PORT:
        require_port(session.system, instance, command.part)
    elif command.kind is RenameKind.RENAME_PARAMETER:
        sets = session.system.component(instance).configuration_sets
        if command.part not in (each.name for each in sets.parameters):
            raise CommandError(UNKNOWN, f"{instance} has no parameter {command.part!r}")
    if command.kind is not RenameKind.RENAME_COMPONENT:
        name = f"{name}.{command.part}"
    return session.project.renaming(name, command.name)


def _changes(renaming: Renaming) -> list[ui.FileChange]:
    moves = {str(source): target for source, target in renaming.moves}
    found = []
    for name in sorted({*renaming.contents, *moves}):
        old, new = renaming.contents.get(name, (b"", b""))
        before, after = (decode(each).normal.splitlines() for each in (old, new))
        lines = [*unified_diff(before, after, n=1, lineterm="")][2:]
        target = moves.get(name)
        found.append(
            ui.FileChange(
                file=shown(Path(name)),
                moved_to="" if target is None else shown(target),
                lines="\n".join(lines)[:_MAX_LENGTH],
            )
        )
    return found[:_MAX_FILES]


def _carry_out(
    session: Session, renaming: Renaming, label: str, *, undone: bool = False
) -> None:
    """Change the files, and continue with them at the time of before."""
    now = session.now
    session.project.rename(renaming)
    try:
        session.open(session.file)
    except CommandError:
        session.project.rename(_reverted(renaming))
        raise
    session.renew_palette()
    back = _reverted(renaming)
    if undone:
        renaming, back = back, renaming
    session.edits.inherit(
        Edit(
            label,
            lambda: _carry_out(session, renaming, label),
            lambda: _carry_out(session, back, label, undone=True),
        ),
        undone=undone,
    )
    if now:
        session.runner.step(round(now * SECOND))
    session.publish(ui.Event.of_clock(session.time()))
    session.publish_edits()


def _reverted(renaming: Renaming) -> Renaming:
    """Return the rename that makes another one undone."""
    from rtgen.tools.renaming.plan import Renaming

    moves = {str(source): str(target) for source, target in renaming.moves}
    return Renaming(
        renaming.new,
        renaming.old,
        renaming.root,
        contents={
            moves.get(name, name): (new, old)
            for name, (old, new) in renaming.contents.items()
        },
        moves=[(target, source) for source, target in renaming.moves],
    )
