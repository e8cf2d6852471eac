"""A process's only SDO client of a node: transfers wait here for each other."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import Final, Protocol, TypeAlias

from rtgen.runtime.canopen import sdo
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.frames import SDO_RESPONSE, Frame
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.sdo_client import SdoClient

Outcome: TypeAlias = bytes | SdoAbort | LinkError
Done: TypeAlias = Callable[[Outcome], None]

ATTEMPTS: Final = 3
"""How often a transfer of a node's set-up is tried, where it may be carried out twice."""
_SLACK: Final = 100
"""A blocking transfer is given up after this many time-outs of a single message."""


@dataclass(frozen=True, slots=True)
class _Transfer:
    index: int
    subindex: int
    value: bytes | None
    block: bool
    done: Done
    attempts: int


class SdoLink(Protocol):
    """What an SDO channel needs of its `Link`."""

    @property
    def lock(self) -> AbstractContextManager[object]: ...

    @property
    def up(self) -> bool: ...

    def now(self) -> int: ...

    def refresh(self, station: SdoChannel, /) -> None: ...

    def send(self, frames: Iterable[Frame], sender: SdoChannel, /) -> None: ...

    def wait(self, until: Callable[[], bool], timeout: int, /) -> bool: ...


class SdoChannel:
    """Reads and writes variables of one node, one transfer at a time, in the order of asking.

    A station of its link. `submit_upload` and `submit_download` return at once and tell the
    outcome in a call from the link; `upload` and `download` wait, and are not for stations.
    A transfer that times out is begun anew up to `attempts` times in all, after the client has
    drained late answers: only for transfers that may be carried out twice.
    """

    def __init__(self, link: SdoLink, node_id: int, timeout: int = sdo.TIMEOUT) -> None:
        self.node_id = node_id
        self._link = link
        self._timeout = timeout
        self._client = SdoClient(node_id, timeout=timeout)
        self._waiting: deque[_Transfer] = deque()
        self._current: _Transfer | None = None
        self.unexpected = 0
        """Answers to nothing that was asked: another client is at work, or a second node."""
        self.identifiers = frozenset((SDO_RESPONSE + node_id,))

    @property
    def deadline(self) -> int | None:
        """See `Station`."""
        return self._client.deadline

    def submit_upload(
        self,
        index: int,
        subindex: int,
        done: Done,
        *,
        block: bool = False,
        attempts: int = 1,
    ) -> None:
        """Reads a variable; `done` gets its octets or what went wrong."""
        self._submit(_Transfer(index, subindex, None, block, done, attempts))

    def submit_download(
        self,
        index: int,
        subindex: int,
        value: bytes,
        done: Done,
        *,
        block: bool = False,
        attempts: int = 1,
    ) -> None:
        """Writes a variable; `done` gets b"" or what went wrong."""
        self._submit(_Transfer(index, subindex, value, block, done, attempts))

    def upload(self, index: int, subindex: int = 0, *, block: bool = False) -> bytes:
        """The octets of a variable. Raises SdoAbort, or LinkError if the bus is gone."""
        return self._awaited(
            lambda done: self.submit_upload(index, subindex, done, block=block)
        )

    def download(
        self, index: int, subindex: int, value: bytes, *, block: bool = False
    ) -> None:
        """Writes a variable. Raises SdoAbort, or LinkError if the bus is gone."""
        self._awaited(
            lambda done: self.submit_download(index, subindex, value, done, block=block)
        )

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """See `Station`."""
        client = self._client
        # Late answers, which are drained, are no news.
        draining, dropped = not (client.ready or client.busy), client.dropped
        frames = client.receive(frame, now)
        if not draining:
            self.unexpected += client.dropped - dropped
        return [*frames, *self._go_on(now)]

    def poll(self, now: int) -> Iterable[Frame]:
        """See `Station`."""
        return [*self._client.poll(now), *self._go_on(now)]

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """See `Station`: what is under way fails when the bus goes."""
        if up:
            return self._go_on(now)
        if self._client.busy:
            self._client.cancel(now)
        failed = [self._current] if self._current is not None else []
        failed += self._waiting
        self._current = None
        self._waiting.clear()
        for transfer in failed:
            transfer.done(LinkError(f"node {self.node_id}: the bus is gone"))
        return ()

    def _submit(self, transfer: _Transfer) -> None:
        with self._link.lock:
            if not self._link.up:
                transfer.done(LinkError(f"node {self.node_id}: the bus is gone"))
                return
            self._waiting.append(transfer)
            frames = self._go_on(self._link.now())
            self._link.refresh(self)
            self._link.send(frames, self)

    def _go_on(self, now: int) -> list[Frame]:
        """Tells of a transfer that has ended, and begins the next."""
        client = self._client
        if self._current is not None and not client.busy:
            ended, self._current = self._current, None
            try:
                outcome: Outcome = client.result()
            except SdoAbort as error:
                outcome = error
            if _timed_out(outcome) and ended.attempts > 1:
                again = replace(ended, attempts=ended.attempts - 1)
                self._waiting.appendleft(again)
            else:
                ended.done(outcome)
        if self._current is not None or not self._waiting or not client.ready:
            return []
        transfer = self._current = self._waiting.popleft()
        number = transfer.index, transfer.subindex
        if transfer.value is None:
            return client.upload(*number, now, block=transfer.block)
        return client.download(*number, transfer.value, now, block=transfer.block)

    def _awaited(self, submit: Callable[[Done], None]) -> bytes:
        outcomes: list[Outcome] = []
        submit(outcomes.append)
        if not self._link.wait(lambda: bool(outcomes), _SLACK * self._timeout):
            with self._link.lock:
                frames = self._client.cancel(self._link.now(), sdo.TIMED_OUT)
                self._link.send([*frames, *self._go_on(self._link.now())], self)
                self._link.refresh(self)
        outcome = outcomes[0] if outcomes else LinkError(f"node {self.node_id}: silent")
        if isinstance(outcome, bytes):
            return outcome
        raise outcome


def _timed_out(outcome: Outcome) -> bool:
    return isinstance(outcome, SdoAbort) and outcome.code == sdo.TIMED_OUT
