"""When a proxy leaves ERROR by itself, where its network or a parameter allows that."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.frames import SECOND

PAUSE: Final = 1 * SECOND
"""How long it waits in ERROR before a reset: the node stands still, and others can notice."""
SOUND: Final = 10 * SECOND
"""After so long in ACTIVE the attempts are counted anew."""


class Recovery:
    """Up to `attempts` resets in a row, each followed by an activation; 0 for none.

    Times are in ns of the component's clock.
    """

    def __init__(self, attempts: int) -> None:
        self._attempts = attempts
        self._made = 0
        self._failed_at: int | None = None
        self._active_since: int | None = None
        self._was_active = False
        self._resumes = False

    def worked(self, now: int) -> None:
        """The component has become ACTIVE."""
        self._active_since = now
        self._was_active = True

    def failed(self, now: int) -> None:
        """The component has come to ERROR, or a reset of it has failed."""
        since, self._active_since = self._active_since, None
        if since is not None and now - since >= SOUND:
            self._made = 0
        self._failed_at = now
        self._resumes = False

    def due(self, now: int, *, up: bool) -> bool:
        """Whether a reset is to be tried now; `up`: the bus is there. Counts the attempt."""
        if self._made >= self._attempts or self._failed_at is None:
            return False
        if not up:
            # The pause begins when the bus is back.
            self._failed_at = now
            return False
        if now - self._failed_at < PAUSE:
            return False
        self._made += 1
        self._failed_at = None
        self._resumes = True
        return True

    def resumes(self) -> bool:
        """Whether the component, just reset, is to be activated: only after a reset of `due`.

        A component that has never been ACTIVE stays INACTIVE.
        """
        resumes = self._resumes and self._was_active
        self._resumes = False
        return resumes
