"""A process's SDO client of a node, which queues transfers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Final, Protocol, TypeAlias

import msgspec
from msgspec.structs import replace

from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SDO_RESPONSE, Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient

Outcome: TypeAlias = bytes | SdoAbort | LinkError
Done: TypeAlias = Callable[[Outcome], None]

ATTEMPTS: Final = 3
"""Attempts per transfer of a node's set-up, if it may be repeated."""
_MAX_TIMEOUTS: Final = 100
"""Number of time-outs of a single message after which a blocking transfer is abandoned."""


class _Transfer(msgspec.Struct, frozen=True):
    index: int
    subindex: int
    value: bytes | None
    block: bool
    done: Done
    attempts: int


class SdoLink(Protocol):
    """Members of a `Link` that an SDO channel uses."""

    @property
    def lock(self) -> AbstractContextManager[object]: ...

    @property
    def up(self) -> bool: ...

    def now(self) -> int: ...

    def refresh(self, station: SdoChannel, /) -> None: ...

    def send(self, frames: Iterable[Frame], sender: SdoChannel, /) -> None: ...

    def wait(self, until: Callable[[], bool], timeout: int, /) -> bool: ...


class SdoChannel:
    """Reads and writes objects of one node, one transfer at a time, in order of submission.

    A station of its link. `submit_upload` and `submit_download` return immediately and report the
    outcome in a call from the link; `upload` and `download` block, and must not be called by
    stations. A transfer that times out is repeated, up to `attempts` in total, after the client
    has drained late responses; only for transfers that may be repeated.
    """

    def __init__(self, link: SdoLink, node_id: int) -> None:
        self.node_id = node_id
        self._link = link
        self._client = SdoClient(node_id)
        self._waiting: deque[_Transfer] = deque()
        self._current: _Transfer | None = None
        self.unexpected = 0
        """Number of unexpected responses: of another client, or of a second node with this id."""
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
        """Read an object; `done` receives its octets or the error."""
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
        """Write an object; `done` receives b"" or the error."""
        self._submit(_Transfer(index, subindex, value, block, done, attempts))

    def upload(self, index: int, subindex: int = 0, *, block: bool = False) -> bytes:
        """Return the octets of an object. Raises SdoAbort, or LinkError if the bus is lost."""
        return self._awaited(
            lambda done: self.submit_upload(index, subindex, done, block=block)
        )

    def download(
        self, index: int, subindex: int, value: bytes, *, block: bool = False
    ) -> None:
        """Write an object. Raises SdoAbort, or LinkError if the bus is lost."""
        self._awaited(
            lambda done: self.submit_download(index, subindex, value, done, block=block)
        )

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """See `Station`."""
        client = self._client
        # Late responses during draining are expected.
        draining, dropped = not (client.ready or client.busy), client.dropped
        frames = client.receive(frame, now)
        if not draining:
            self.unexpected += client.dropped - dropped
        return [*frames, *self._advance(now)]

    def poll(self, now: int) -> Iterable[Frame]:
        """See `Station`."""
        return [*self._client.poll(now), *self._advance(now)]

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """See `Station`: the current transfer fails when the bus is lost."""
        if up:
            return self._advance(now)
        if self._client.busy:
            self._client.cancel(now)
        self._fail(LinkError(f"node {self.node_id}: the bus is gone"))
        return ()

    def restart(self) -> None:
        """End all transfers, because the node has booted: its server knows none of them.

        Called by stations, with the link's lock held.
        """
        self._client.reset()
        self._fail(SdoAbort(sdo.DEVICE_STATE))

    def _fail(self, error: SdoAbort | LinkError) -> None:
        failed = [self._current] if self._current is not None else []
        failed += self._waiting
        self._current = None
        self._waiting.clear()
        for transfer in failed:
            transfer.done(error)

    def _submit(self, transfer: _Transfer) -> None:
        with self._link.lock:
            if not self._link.up:
                transfer.done(LinkError(f"node {self.node_id}: the bus is gone"))
                return
            self._waiting.append(transfer)
            frames = self._advance(self._link.now())
            self._link.refresh(self)
            self._link.send(frames, self)

    def _advance(self, now: int) -> list[Frame]:
        """Report a completed transfer, and start the next one."""
        client = self._client
        if self._current is not None and not client.busy:
            transfer_over, self._current = self._current, None
            try:
                outcome: Outcome = client.result()
            except SdoAbort as error:
                outcome = error
            if _timed_out(outcome) and transfer_over.attempts > 1:
                again = replace(transfer_over, attempts=transfer_over.attempts - 1)
                self._waiting.appendleft(again)
            else:
                transfer_over.done(outcome)
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
        if not self._link.wait(lambda: bool(outcomes), _MAX_TIMEOUTS * sdo.TIMEOUT):
            with self._link.lock:
                frames = self._client.cancel(self._link.now(), sdo.TIMED_OUT)
                self._link.send([*frames, *self._advance(self._link.now())], self)
                self._link.refresh(self)
        outcome = outcomes[0] if outcomes else LinkError(f"node {self.node_id}: silent")
        if isinstance(outcome, bytes):
            return outcome
        raise outcome


def _timed_out(outcome: Outcome) -> bool:
    return isinstance(outcome, SdoAbort) and outcome.code == sdo.TIMED_OUT
