"""The instances of other processes: their presence and their descriptions."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from enum import Enum
from typing import TypeAlias

from rtgen.runtime.distribution import control, names
from rtgen.runtime.distribution.descriptions import Description
from rtgen.runtime.distribution.medium import Medium, Token
from rtgen.runtime.distribution.rpc_header import OctetsClient
from rtgen.runtime.failures import NOTE, log

_RETRY_INTERVAL = 0.2
"""Interval between attempts to query an instance that did not answer [s]."""


class Presence(Enum):
    """The presence of an instance of another process."""

    LOST = "is lost: its process ended or is out of reach"
    ENDED = "has ended"
    BACK = "is there again"


Listener: TypeAlias = Callable[[str, Presence], None]
"""Called with an instance, in a thread of the engine."""


def _log(instance: str, presence: Presence) -> None:
    level = logging.WARNING if presence is Presence.LOST else NOTE
    log.log(level, "%s %s", instance, presence.value)


class Peers:
    """Follows the presence of all instances of the system, including those of this process.

    `timeout` [s] of a query. `listeners` are called when an instance of another process is lost,
    ends as announced, or returns; the first one logs it. Raises MediumError.
    """

    def __init__(self, medium: Medium, process: str, timeout: float) -> None:
        self._medium = medium
        self._process = process
        self._timeout = timeout
        self._changed = threading.Condition()
        self._present: dict[str, list[str]] = {}
        self._lost: set[str] = set()
        self._ending: set[tuple[str, str]] = set()
        """Instances of processes that have announced their end."""
        self._descriptions: dict[str, Description] = {}
        self._silent: dict[str, float] = {}
        self._askers: dict[str, control.Asker] = {}
        self.listeners: list[Listener] = [_log]
        self._watch: Token = medium.watch("", self._on_change)

    def close(self) -> None:
        """Stop following."""
        self._watch.close()
        for asker in self._askers.values():
            asker.close()
        self._askers.clear()

    def is_present(self, instance: str) -> bool:
        """Return whether a process has the instance."""
        return instance in self._present

    def is_lost(self, instance: str) -> bool:
        """Return whether a process had the instance, and none has it now."""
        return instance in self._lost

    def is_elsewhere(self, instance: str) -> bool:
        """Return whether another process has the instance."""
        processes = self._present.get(instance, ())
        return any(process != self._process for process in processes)

    @property
    def instances(self) -> list[str]:
        """The names of all present instances, sorted."""
        with self._changed:
            return sorted(self._present)

    def asker(self, instance: str) -> control.Asker:
        """Return a client of the instance's control service. Raises MediumError."""
        with self._changed:
            client = self._askers.get(instance)
            if client is None:
                octets = OctetsClient(self._medium, names.control_name(instance))
                client = control.Asker(octets, instance, self._timeout)
                self._askers[instance] = client
            return client

    def description(self, instance: str) -> Description | None:
        """Return the description of an instance, which is queried once; None if it is absent."""
        return self._descriptions.get(instance) or self.fresh(instance)

    def fresh(self, instance: str) -> Description | None:
        """Query the description of an instance again."""
        if not self.is_present(instance):
            return None
        if time.monotonic() < self._silent.get(instance, 0.0) + _RETRY_INTERVAL:
            return None
        processes = self._present.get(instance)
        try:
            description = self.asker(instance).describe()
        except control.ControlError as error:
            log.debug("%s does not answer: %s", instance, error)
            self._silent[instance] = time.monotonic()
            return None
        with self._changed:
            if self._present.get(instance) is processes:
                self._descriptions[instance] = description
        return description

    def wait(self, seconds: float) -> None:
        """Wait for a change of presence, at most this time."""
        with self._changed:
            self._changed.wait(seconds)

    def _on_change(self, name: str, present: bool) -> None:
        presence = names.present(name)
        if presence is None:
            return
        instance, process = presence
        if process.endswith(names.ENDING):
            ended = (instance, process.removesuffix(names.ENDING))
            if present:
                self._ending.add(ended)
            return
        if present:
            self._ending.discard(presence)
        with self._changed:
            before = self._present.get(instance, [])
            after = [p for p in before if p != process] + [process] * present
            self._descriptions.pop(instance, None)
            self._silent.pop(instance, None)
            was_lost = instance in self._lost
            if after:
                self._present[instance] = after
                self._lost.discard(instance)
            elif before:
                del self._present[instance]
                self._lost.add(instance)
            self._changed.notify_all()
        if process == self._process:
            return  # Its own presence ends and returns with the engine's link to a router.
        if not after and before:
            is_ended = presence in self._ending
            self._notify(instance, Presence.ENDED if is_ended else Presence.LOST)
        elif after and was_lost:
            self._notify(instance, Presence.BACK)

    def _notify(self, instance: str, presence: Presence) -> None:
        for listener in tuple(self.listeners):
            listener(instance, presence)
