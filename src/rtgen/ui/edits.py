"""Undo and redo of the changes that pages make to a system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from rtgen.ui.errors import NOTHING_TO_UNDO, CommandError

MAX_EDITS: Final = 500
"""Maximum number of edits that can be undone."""


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """A change: its name, and actions that repeat and revert it.

    `remote`: a change in other processes, made by the thread that calls them.
    """

    label: str
    redo: Callable[[], object]
    undo: Callable[[], object]
    remote: bool = False


class Edits:
    """The stack of edits, and whether the file contains them."""

    def __init__(self) -> None:
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self._under_way: Edit | None = None
        self.saved = True

    @property
    def undo_label(self) -> str:
        """Name of the edit that would be undone; empty if there is none."""
        return self._done[-1].label if self._done else ""

    @property
    def redo_label(self) -> str:
        """Name of the edit that would be redone; empty if there is none."""
        return self._undone[-1].label if self._undone else ""

    def make(self, edit: Edit) -> None:
        """Make a change that can be undone; passes on its exceptions."""
        edit.redo()
        self.enter(edit)

    def enter(self, edit: Edit) -> None:
        """Add a change that was made already."""
        self._done = [*self._done[1 - MAX_EDITS :], edit]
        self._undone = []
        self.saved = False

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
        """Revert the last change. Raises CommandError."""
        self.carry_out(self.next(undo=True), undo=True)

    def redo(self) -> None:
        """Repeat the change that was reverted last. Raises CommandError."""
        self.carry_out(self.next(undo=False), undo=False)

    def carry_out(self, edit: Edit, *, undo: bool) -> None:
        """Revert or repeat a change at once."""
        (edit.undo if undo else edit.redo)()
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
        self.saved = False

    def forget(self) -> None:
        """Forget all edits, because their system was replaced."""
        self._done, self._undone = [], []
