"""Components of other processes that this one has activated, and deactivates at its end."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from omniORB import CORBA

from rtgen.facts.files import read_file, write_atomically
from rtgen.runtime.corba.faults import is_silent, is_timeout
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.remote import FAULTS, RemoteRtc
from rtgen.runtime.corba.rt_objects.wire import EXECUTION_CONTEXT
from rtgen.runtime.failures import log
from rtgen.runtime.return_codes import ACTIVE_STATE

_PATIENCE: Final = 2.0
"""Maximum time for a component to become INACTIVE, and for one call at the end [s]."""


@dataclass(slots=True)
class _Activated:
    rtc: RemoteRtc
    context: Any
    pending: bool = True
    """Whether it may not have become ACTIVE yet."""


class Activations:
    """The components that a process has activated, in order; usable from any thread.

    `file` lists their references, one per line, for the supervisor of the process,
    which may have been killed at any moment.
    """

    def __init__(self, exported: Exported, file: Path | None = None) -> None:
        self._exported = exported
        self._file = file
        self._lock = threading.Lock()
        self._activated: dict[str, _Activated] = {}
        self._before: dict[str, bool] = {}
        """Whether each component was ACTIVE when its activation was first requested."""
        self._over = False

    def activate(
        self, name: str, rtc: RemoteRtc, request: Callable[[], None] | None = None
    ) -> None:
        """Activate a component, and deactivate it at the end unless it was ACTIVE before.

        `request` replaces `RemoteRtc.activate`; its exceptions are raised. Does nothing after
        `release_all`. Raises FAULTS.
        """
        with self._lock:
            if self._over:
                return
            was_active = rtc.state() is ACTIVE_STATE
            if not self._before.setdefault(name, was_active) and not was_active:
                # Also after a failure: the request may have arrived.
                self._activated[name] = _Activated(rtc, rtc.context)
                self._write()
            (request or rtc.activate)()
            known = self._activated.get(name)
            if known is not None and rtc.state() is ACTIVE_STATE:
                known.pending = False
                self._write()

    def forget(self, name: str) -> None:
        """Leave a component as it is at the end."""
        with self._lock:
            self._activated.pop(name, None)
            self._before.pop(name, None)
            self._write()

    def release(self, name: str) -> None:
        """Deactivate a component that `activate` has activated; a failure is logged.

        A KeyboardInterrupt is raised after that.
        """
        self._finish(lambda: self._release([name]))

    def release_all(self) -> None:
        """Deactivate all of them, the last one first, as `release` does.

        Nothing is activated later.
        """

        def release() -> None:
            self._over = True
            self._release([*reversed(self._activated)])

        self._finish(release)

    def _finish(self, action: Callable[[], None]) -> None:
        """Execute an action in a thread of its own, which no signal interrupts."""
        thread = threading.Thread(target=action, name="rtgen deactivation", daemon=True)
        thread.start()
        interrupt: KeyboardInterrupt | None = None
        while thread.is_alive():
            try:
                thread.join()
            except KeyboardInterrupt as error:
                interrupt = error
        if interrupt is not None:
            raise interrupt

    def _release(self, names: list[str]) -> None:
        with self._lock:
            for name in names:
                known = self._activated.pop(name, None)
                if known is not None:
                    problem = _deactivated(known, self._exported)
                    if problem:
                        log.warning("%s %s", name, problem)
            self._write()

    def _write(self) -> None:
        if self._file is not None:
            text = self._exported.text
            lines = [
                f"{int(each.pending)} {text(each.rtc.reference)} {text(each.context)} {name}\n"
                for name, each in self._activated.items()
            ]
            try:
                write_atomically(self._file, "".join(lines).encode())
            except OSError as error:
                log.warning("cannot write %s: %s", self._file, error.strerror)


def _deactivated(known: _Activated, exported: Exported) -> str:
    """Deactivate a component at the end of a run; return the problem, else an empty text."""
    exported.hasten(_PATIENCE)
    rtc = known.rtc
    try:
        state = rtc.deactivate(_PATIENCE, pending=known.pending)
    except CORBA.OBJECT_NOT_EXIST:
        return ""  # the component has ended
    except FAULTS as error:
        if isinstance(error, CORBA.SystemException) and is_timeout(error):
            # A process that has stopped executes the request when it continues.
            exported.post(
                known.context, EXECUTION_CONTEXT, "deactivate_component", rtc.reference
            )
            return "is not deactivated: it does not answer"
        silent = isinstance(error, CORBA.SystemException) and is_silent(error)
        return f"is not deactivated: {'it does not answer' if silent else error}"
    if state is ACTIVE_STATE:
        return f"is still ACTIVE {_PATIENCE:g} s after the request to deactivate it"
    return ""


def release_file(file: Path, exported: Exported) -> list[tuple[str, str]]:
    """Deactivate the components that a process which has ended had listed in its file.

    Returns their names, each with its problem or an empty text.
    """
    found = []
    for line in reversed(read_file(file).decode("utf-8").splitlines()):
        pending, ior, context_ior, name = line.split(" ", 3)
        reference, context = map(exported.reference, (ior, context_ior))
        known = _Activated(RemoteRtc(reference, exported), context, pending == "1")
        found.append((name, _deactivated(known, exported)))
    file.unlink()
    return found
