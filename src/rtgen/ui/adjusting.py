"""Changes the properties of a connection, in its run and in its file."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import unified_diff
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rtgen.compiler.project import shown
from rtgen.facts.encodings import decode
from rtgen.runtime.ports import connector_properties
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.ui.changes import ends_of
from rtgen.ui.description import properties_of
from rtgen.ui.documents.document import DocumentError
from rtgen.ui.errors import FILE, IMPOSSIBLE, CommandError
from rtgen.ui.fitting import judged, text_of
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from collections.abc import Callable

    from rtgen.ui.documents.profile import Change
    from rtgen.ui.session import Session

_MAX_LENGTH: Final = 20_000
"""Maximum length of the lines of a change that a page gets [characters]."""


def adjust(
    session: Session,
    command: ui.Adjust,
    make: Callable[[str, Mapping[str, str], Mapping[str, str], Change | None], None],
) -> tuple[str, list[ui.FileChange]]:
    """Return the findings about a connection with other properties, and the change of the file.

    If the command says so, `make` makes it: an edit with the name of the connection and its
    properties after and before. Raises CommandError, RtcError; then nothing has changed.
    """
    name = command.connection
    if name in session.remote.connections:
        raise CommandError(
            IMPOSSIBLE,
            f"{name} is a connection of other processes, whose properties are fixed",
            "cut it, and connect the ports again",
        )
    connector = session.system.connector(name)
    before = dict(properties_of(connector))
    stated = {each.name: each.text.strip() for each in command.properties}
    merged = before | stated
    after = {key: text for key, text in merged.items() if text or key not in stated}
    if isinstance(connector, DataConnector):
        connector_properties.parse(after)
    elif stated:
        raise CommandError(IMPOSSIBLE, f"{name} connects service ports")
    ends = ends_of(connector)
    source, target = (ui.PortAddress(instance=i, port=p) for i, p in ends)
    findings = judged(session, source, target, after)
    said = "\n".join(map(text_of, findings))
    if not stated:
        return said, []
    change = session.changes.adjust(name, ends, stated)
    changes = [] if change is None else _changes(session, change)
    if command.carried_out:
        make(name, after, before, change)
    return said, changes


def _changes(session: Session, change: Change) -> list[ui.FileChange]:
    """Return what a change does to the file with all edits before it."""
    if session.is_new:
        return []
    try:
        old, new = session.edits.octets(), session.edits.octets_with(change)
    except DocumentError as error:
        raise CommandError(FILE, str(error)) from error
    before, after = (decode(each).normal.splitlines() for each in (old, new))
    lines = [*unified_diff(before, after, n=2, lineterm="")][2:]
    name = shown(Path(session.file)) if session.file else ""
    return [ui.FileChange(file=name, lines="\n".join(lines)[:_MAX_LENGTH])]
