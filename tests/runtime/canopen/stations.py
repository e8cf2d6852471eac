"""Stations for tests of links."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rtgen.runtime.canopen.wire.frames import Frame


class Recorder:
    """Records received frames with their times, and answers as configured."""

    def __init__(
        self,
        *identifiers: int,
        answer: Callable[[Frame], Iterable[Frame]] | None = None,
    ) -> None:
        self.identifiers = frozenset(identifiers) if identifiers else None
        self.deadline: int | None = None
        self.period = 0
        self.frames: list[Frame] = []
        self.times: list[int] = []
        self.polls: list[int] = []
        self.changes: list[bool] = []
        self.poll_frames: list[Frame] = []
        self._answer = answer

    @property
    def ids(self) -> list[int]:
        return [frame.can_id for frame in self.frames]

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.frames.append(frame)
        self.times.append(now)
        return self._answer(frame) if self._answer is not None else ()

    def poll(self, now: int) -> Iterable[Frame]:
        self.polls.append(now)
        self.deadline = now + self.period if self.period else None
        return list(self.poll_frames)

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        self.changes.append(up)
        return ()
