"""The changes that pages make to a system: undone, redone, and applied to its file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from rtgen.compiler.model import System
from rtgen.ui.documents.document import Document
from rtgen.ui.documents.profile import Change
from rtgen.ui.errors import NOTHING_TO_UNDO, CommandError

MAX_EDITS: Final = 500
"""Maximum number of edits that can be undone."""


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """A change: its name, and actions that repeat and revert it in the run.

    `change` is its effect on the file; None for a change of the run alone. `remote`: a change in
    other processes, made by the thread that calls them.
    """

    label: str
    redo: Callable[[], object]
    undo: Callable[[], object]
    change: Change | None = None
    remote: bool = False


class Edits:
    """The stack of edits of a system, and the system's file with them."""

    def __init__(self, document: Document) -> None:
        """Set up without edits; `document` is the file as opened."""
        self._document = document
        self._settled: list[Change] = []
        """The changes of edits that can no longer be undone, since `document`."""
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self._under_way: Edit | None = None
        self._bottom: object = self
        self._saved: object = self
        self._system: tuple[object, System] | None = None

    @property
    def undo_label(self) -> str:
        """Name of the edit that would be undone; empty if there is none."""
        return self._done[-1].label if self._done else ""

    @property
    def redo_label(self) -> str:
        """Name of the edit that would be redone; empty if there is none."""
        return self._undone[-1].label if self._undone else ""

    # The file.

    @property
    def saved(self) -> bool:
        """Whether the file has all edits."""
        return self._head is self._saved

    def mark_saved(self) -> None:
        """Note that the file has all edits."""
        self._saved = self._head

    def octets(self, file: str = "") -> bytes:
        """Return the file with all edits; see `Document.octets`. Raises DocumentError."""
        return self._document.octets(self._changes, file)

    def octets_with(self, change: Change) -> bytes:
        """Return the file with all edits and a further change. Raises DocumentError."""
        return self._document.octets([*self._changes, change])

    @property
    def system(self) -> System:
        """The system of the file with all edits. Raises DocumentError."""
        head = self._head
        if self._system is None or self._system[0] is not head:
            self._system = head, self._document.system(self._changes)
        return self._system[1]

    @property
    def _changes(self) -> list[Change]:
        changes = (edit.change for edit in self._done)
        return [*self._settled, *(each for each in changes if each is not None)]

    @property
    def _head(self) -> object:
        """The last edit that concerns the file."""
        edits = (each for each in reversed(self._done) if each.change is not None)
        return next(edits, self._bottom)

    # Edits.

    def make(self, edit: Edit) -> None:
        """Make a change that can be undone; passes on its exceptions."""
        edit.redo()
        self.enter(edit)

    def enter(self, edit: Edit) -> None:
        """Add a change that was made already."""
        self._done.append(edit)
        self._undone = []
        if len(self._done) > MAX_EDITS:
            self._settle(self._done.pop(0))

    def inherit(self, edit: Edit, *, undone: bool) -> None:
        """Take over an edit from before the file was opened again."""
        (self._undone if undone else self._done).append(edit)

    def forget(self) -> None:
        """Forget how to undo all edits, because their run was replaced; the file keeps them."""
        for edit in self._done:
            self._settle(edit)
        self._done, self._undone = [], []

    def _settle(self, edit: Edit) -> None:
        if edit.change is None:
            return
        self._bottom = edit
        self._settled.append(edit.change)
        if len(self._settled) >= MAX_EDITS:
            document = self._document
            data = document.octets(self._settled)
            self._document = Document(document.file, data)
            self._settled = []

    def next(self, *, undo: bool) -> Edit:
        """Return the change to revert or to repeat. Raises CommandError."""
        changes = self._done if undo else self._undone
        if not changes or self._under_way is not None:
            what = "undo" if undo else "redo"
            message = f"there is nothing to {what}"
            if self._under_way is not None:
                message = f"{self._under_way.label} is under way"
            raise CommandError(NOTHING_TO_UNDO, message)
        return changes[-1]

    def undo(self) -> None:
        """Revert the last change; see `carry_out`."""
        self.carry_out(self.next(undo=True), undo=True)

    def redo(self) -> None:
        """Repeat the change that was reverted last; see `carry_out`."""
        self.carry_out(self.next(undo=False), undo=False)

    def carry_out(self, edit: Edit, *, undo: bool) -> None:
        """Revert or repeat a change at once.

        Its effect on the file is reverted or repeated in any case. Passes on the exceptions of its
        action, for example if the run has changed meanwhile.
        """
        try:
            (edit.undo if undo else edit.redo)()
        finally:
            self._moved(edit, undo=undo)

    def begin(self, edit: Edit) -> None:
        """Mark that a change is being reverted or repeated elsewhere, which excludes others."""
        self._under_way = edit

    def end(self, edit: Edit, *, undo: bool, done: bool) -> None:
        """Mark that reverting or repeating has ended."""
        self._under_way = None
        if done:
            self._moved(edit, undo=undo)

    def _moved(self, edit: Edit, *, undo: bool) -> None:
        changes, others = self._done, self._undone
        if not undo:
            changes, others = others, changes
        if edit in changes:
            changes.remove(edit)
            others.append(edit)
