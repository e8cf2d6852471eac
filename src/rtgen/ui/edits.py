"""What a page has changed in a system, undone and redone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from rtgen.ui.errors import NOTHING_TO_UNDO, CommandError

MOST: Final = 500
"""Edits that can be undone."""


@dataclass(frozen=True, slots=True)
class Edit:
    """A change that was made: how it is called, and what makes it again and takes it back."""

    label: str
    redo: Callable[[], object]
    undo: Callable[[], object]


class Edits:
    """The stack of edits, and whether the file has them."""

    def __init__(self) -> None:
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self.saved = True

    @property
    def undo_label(self) -> str:
        """What would be undone; empty if nothing would."""
        return self._done[-1].label if self._done else ""

    @property
    def redo_label(self) -> str:
        """What would be redone."""
        return self._undone[-1].label if self._undone else ""

    def make(self, edit: Edit) -> None:
        """Make a change that can be undone. Raises what it raises."""
        edit.redo()
        self._done = [*self._done[1 - MOST :], edit]
        self._undone = []
        self.saved = False

    def undo(self) -> None:
        """Take the last change back. Raises CommandError."""
        if not self._done:
            raise CommandError(NOTHING_TO_UNDO, "there is nothing to undo")
        self._done[-1].undo()
        self._undone.append(self._done.pop())
        self.saved = False

    def redo(self) -> None:
        """Make the change again that was taken back last. Raises CommandError."""
        if not self._undone:
            raise CommandError(NOTHING_TO_UNDO, "there is nothing to redo")
        self._undone[-1].redo()
        self._done.append(self._undone.pop())
        self.saved = False

    def forget(self) -> None:
        """Forget all edits, which were made to a system that is no more."""
        self._done, self._undone = [], []
