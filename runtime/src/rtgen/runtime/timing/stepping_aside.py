"""Threads that do the work of several contexts, and what they do before they wait.

Whoever waits in a call of a component, for another process or for a port, calls `step_aside`: the
thread leaves the other contexts to another one first.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

shared: Final[dict[int, Callable[[], None]]] = {}
"""What the threads with several contexts call before they wait, by their identifiers."""


def step_aside() -> None:
    """Prepare this thread to wait; without effect in a thread of one context, or of none."""
    leave = shared.get(threading.get_ident())
    if leave is not None:
        leave()
