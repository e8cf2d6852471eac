"""Watches the states of the instances of a running system from another process."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec

from rtgen.runtime.distribution.control import ControlError, State
from rtgen.runtime.distribution.peers import Peers


class Change(msgspec.Struct, frozen=True):
    """The new state of an instance; None if its process is lost or has ended."""

    instance: str
    state: State | None


class Watch:
    """Compares the states of all or the named instances at each `look`."""

    def __init__(self, peers: Peers, instances: Collection[str] = ()) -> None:
        self._peers = peers
        self._instances = frozenset(instances)
        self._descriptions: dict[str, tuple[str, str]] = {}

    def look(self) -> Iterator[Change]:
        """Yield the changes of state since the last call; the first call yields all states.

        An instance that does not answer keeps its last state until its process is lost.
        """
        present = [
            name
            for name in self._peers.instances
            if not self._instances or name in self._instances
        ]
        for name in [name for name in self._descriptions if name not in present]:
            del self._descriptions[name]
            yield Change(name, None)
        for name in present:
            try:
                state = self._peers.asker(name).state()
            except ControlError:
                continue
            if self._descriptions.get(name) != (state.state, state.reason):
                self._descriptions[name] = state.state, state.reason
                yield Change(name, state)
