"""The ORB of the process."""

from __future__ import annotations

import threading
import time
from typing import Any

import omniORB
from omniORB import CORBA

_running: list[Any] = []


def start(arguments: list[str]) -> Any:
    """Start the ORB; calls wait until `activate`."""
    running = CORBA.ORB_init(["manager", *arguments], CORBA.ORB_ID)
    _running[:] = [running]
    return running


def activate() -> None:
    """Let the root POA take calls."""
    poa()._get_the_POAManager().activate()


def stop() -> None:
    """End the ORB, and wait until its threads have left Python.

    A thread that is still active when the interpreter ends would abort the process.
    """
    if _running:
        _running.pop().destroy()
        end = time.monotonic() + 2.0
        while _has_threads() and time.monotonic() < end:
            time.sleep(0.01)


def _has_threads() -> bool:
    return any(isinstance(each, omniORB.WorkerThread) for each in threading.enumerate())


def orb() -> Any:
    return _running[0]


def poa() -> Any:
    return orb().resolve_initial_references("RootPOA")


def to_text(reference: Any) -> str:
    text: str = orb().object_to_string(reference)
    return text


def from_text(text: str) -> Any:
    return orb().string_to_object(text)


def local(reference: Any) -> Any:
    """Return the servant of a reference; None if it is remote or cannot be called now."""
    try:
        return poa().reference_to_servant(reference)
    except CORBA.Exception:
        return None
