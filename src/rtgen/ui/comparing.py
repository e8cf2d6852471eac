"""Opens recordings that pages compare with a run that goes on meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from rtgen.ui.errors import IMPOSSIBLE, CommandError
from rtgen.ui.session import Session


class Later(NamedTuple):
    """An action for another thread, which `submit` gives it to unless too many wait.

    The action may return a further one. Raises CommandError, InputError, ToolError.
    """

    submit: Callable[[Callable[[], None]], bool]
    action: Callable[[], Later | None]


class Comparing:
    """Reads one recording at a time, in a thread of its own."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._reading = threading.Lock()

    def compare(self, name: str) -> Later | None:
        """Compare a recording of the project with the run, or nothing if the name is empty.

        Raises CommandError.
        """
        if not name:
            self._session.compare(None)
            return None
        file = self._session.project.recording(name)
        return Later(self._in_thread, partial(self._read, file))

    def _in_thread(self, action: Callable[[], None]) -> bool:
        if not self._reading.acquire(blocking=False):
            raise CommandError(IMPOSSIBLE, "another recording is being read")

        def read() -> None:
            try:
                action()
            finally:
                self._reading.release()

        threading.Thread(target=read, name="rtgen-ui-reading", daemon=True).start()
        return True

    def _read(self, file: str) -> Later:
        run = self._session.read_beside(file)
        return Later(self._session.runner.submit, partial(self._session.compare, run))
