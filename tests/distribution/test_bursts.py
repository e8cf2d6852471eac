"""Bursts over DDS: which samples share a datagram, and that none stays behind."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

import pytest
from distributed_system import wait_for

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from burst_reader import EACH, QOS, TOPIC
from media import DOMAIN

from refrobots import rtc
from rtgen.runtime.dds import bursts
from rtgen.runtime.dds.bursts import Burst
from rtgen.runtime.dds.medium import DdsMedium
from rtgen.runtime.distribution.data import encoder

US = 1e-6
READER = Path(__file__).with_name("burst_reader.py")
OCTETS = encoder(rtc.TimedLong)(rtc.TimedLong())


class Datagrams:
    """A writer with a clock, whose datagrams are counted by their samples."""

    def __init__(self, patch: pytest.MonkeyPatch, depth: int | None) -> None:
        self.now = 1000.0
        self.waits: list[Burst] = []
        self.sizes: list[int] = []
        self._written = 0
        patch.setattr(bursts, "time", SimpleNamespace(monotonic=lambda: self.now))
        patch.setattr(bursts.entities, "flush", self._flush)
        sender: Any = SimpleNamespace(soon=self.waits.append)
        self._burst = Burst(self, sender, depth)

    def _flush(self, writer: object) -> None:
        assert writer is self
        if self._written:
            self.sizes.append(self._written)
        self._written = 0

    def write(self, count: int, pause: float) -> list[int]:
        """Return the sizes of datagrams after samples with a pause before each [s]."""
        self.sizes.clear()
        for _ in range(count):
            self.now += pause
            self._written += 1
            self._burst.written()
        return self.sizes


def test_a_burst_shares_datagrams_after_its_first_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sent = Datagrams(monkeypatch, None)
    assert sent.write(8 + 4 * 16 + 5, 1 * US) == [*[1] * 8, *[16] * 4]
    assert len(sent.waits) == 1
    sent.waits.pop().send_held()
    assert sent.sizes[-1] == 5
    assert sent.write(3, 1 * US) == []
    assert len(sent.waits) == 1
    assert sent.write(1, 200 * US) == [4]


@pytest.mark.parametrize(
    ("depth", "pause", "sizes"),
    [
        (None, 30, [1] * 40),  # There is time for a datagram each.
        (None, 200, [1] * 40),
        (None, 6, [*[1] * 8, *[4] * 8]),
        (64, 1, [*[1] * 8, 16, 16]),
        (8, 1, [*[1] * 8, *[2] * 16]),
        (1, 1, [1] * 40),
    ],
)
def test_pauses_and_short_histories_have_small_datagrams(
    monkeypatch: pytest.MonkeyPatch, depth: int | None, pause: int, sizes: list[int]
) -> None:
    assert Datagrams(monkeypatch, depth).write(40, pause * US) == sizes


@pytest.fixture
def partition() -> str:
    return f"test-{os.urandom(8).hex()}"


@pytest.fixture
def reader(partition: str) -> Iterator[IO[str]]:
    """The output of a process that reads the samples, a line for each `EACH` of them."""
    with subprocess.Popen(
        [sys.executable, str(READER), partition], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process.stdout
        process.kill()


def test_the_end_of_a_burst_arrives_whether_the_writer_pauses_or_closes(
    reader: IO[str], partition: str
) -> None:
    """Nothing is sent again here: the writer is not reliable."""
    with closing(DdsMedium(partition, domain=DOMAIN)) as medium:
        for _ in range(5):
            publisher = medium.publisher(TOPIC, QOS)
            wait_for(lambda publisher=publisher: publisher.matched)
            for ending in (lambda: None, publisher.close):
                for _ in range(EACH):
                    publisher.publish(OCTETS)
                ending()
                assert reader.readline() == f"{EACH}\n"
