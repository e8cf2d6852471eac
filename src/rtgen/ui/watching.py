"""What a session asks of those who watch the components of other processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.runtime.distribution.local_runs import Event
    from rtgen.runtime.marshalling.descriptors import DataType
    from rtgen.runtime.services.servants import Servant
    from rtgen.ui.buses import Access
    from rtgen.ui.edits import Edit
    from rtgen.ui.remote_state import RemoteState

Take = Callable[[bytes], None]
"""Receives a sample with its encapsulation header; from any thread."""


class Use(StrEnum):
    """The purpose of a connection."""

    LISTEN = "listen"
    GIVE = "give"
    CALL = "call"


class Key(NamedTuple):
    """A connection of a page to a port, for calls to one of its interfaces."""

    use: Use
    instance: str
    port: str
    interface: str = ""


class Watcher(Protocol):
    """Follows components of other processes in a thread of its own, and carries out commands."""

    @property
    def time(self) -> float | None:
        """The time of the run that is watched [s]; None if components have no common one."""

    @property
    def access(self) -> Access | None:
        """The access to the buses of the run; None if there is none."""

    def follow(self, take: Callable[[Event], None]) -> None:
        """Let a function take the events of the run, from any thread; components have none."""

    def close(self) -> None:
        """Stop watching."""

    def submit(self, request: Callable[[], None]) -> bool:
        """Queue a request, which must not raise; return False if too many wait."""

    def watch(self, takers: Mapping[Key, Take]) -> None:
        """Receive the samples of only these OutPorts from now on; from any thread."""

    def carry_out(self, command: ui.Command) -> Edit | None:
        """Carry out a command; by `submit` only.

        Return the change, if it can be reverted. Raises CommandError.
        """

    def call(self, command: ui.Call, interface: type[Servant], type_name: str) -> bytes:
        """Call an operation of a service; by `submit` only. Raises CommandError."""

    def give(self, address: ui.PortAddress, value: DataType) -> None:
        """Send a sample to an InPort; by `submit` only. Raises CommandError."""


Attach = Callable[
    [Callable[["RemoteState"], bool], Callable[[str, str], None]], Watcher
]
"""Begins to watch: publishes each new state, and reports errors of a component by its name."""
