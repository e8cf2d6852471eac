"""Automatic recovery of a proxy from ERROR, if its network or a parameter allows it."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.wire.frames import SECOND

PAUSE: Final = 1 * SECOND
"""Time in ERROR before a reset: the node stands still, and others can react."""
SOUND: Final = 10 * SECOND
"""Time in ACTIVE after which attempts are counted from zero."""


class Recovery:
    """Up to `attempts` resets in a row, each followed by an activation; 0 for none.

    Times are in ns of the component's clock.
    """

    def __init__(self, attempts: int) -> None:
        self._attempts = attempts
        self._count = 0
        self._failed_at: int | None = None
        self._active_since: int | None = None
        self._was_active = False
        self._resumes = False

    def worked(self, now: int) -> None:
        """Record that the component has entered ACTIVE."""
        self._active_since = now
        self._was_active = True

    def failed(self, now: int) -> None:
        """Record that the component has entered ERROR, or that its reset has failed."""
        since, self._active_since = self._active_since, None
        if since is not None and now - since >= SOUND:
            self._count = 0
        self._failed_at = now
        self._resumes = False

    def due(self, now: int, *, up: bool) -> bool:
        """Return whether to reset now; `up`: the bus is available. Counts the attempt."""
        if self._count >= self._attempts or self._failed_at is None:
            return False
        if not up:
            # The delay starts when the bus is available again.
            self._failed_at = now
            return False
        if now - self._failed_at < PAUSE:
            return False
        self._count += 1
        self._failed_at = None
        self._resumes = True
        return True

    def resumes(self) -> bool:
        """Return whether to activate the component after a reset: only after one due to `due`."""
        resumes = self._resumes and self._was_active
        self._resumes = False
        return resumes
