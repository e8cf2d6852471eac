"""Bursts over DDS: which samples share a datagram, and that none stays behind."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import pytest
from patience import PATIENCE, until

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from burst_reader import EACH, QOS, TOPIC
from media import DOMAIN

from refrobots import rtc
from rtgen.runtime.dds import bursts
from rtgen.runtime.dds.bursts import Burst
from rtgen.runtime.dds.medium import DdsMedium
from rtgen.runtime.distribution.data import encoder
from rtgen.runtime.distribution.medium import Publisher

US = 1e-6
READER = Path(__file__).with_name("burst_reader.py")
ENCODE = encoder(rtc.TimedLong)


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


class Reader:
    """A process that reads the bursts of a partition."""

    def __init__(self, partition: str, reliability: str) -> None:
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._process = subprocess.Popen(
            [sys.executable, str(READER), partition, reliability],
            stdout=subprocess.PIPE,
            text=True,
        )
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line.strip())

    def next(self) -> str:
        """Wait for the next line."""
        return self._lines.get(timeout=PATIENCE)

    def says(self, text: str) -> bool:
        """Return whether it has printed a line, which is this one."""
        return not self._lines.empty() and self.next() == text

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        self._thread.join()
        assert self._process.stdout is not None
        self._process.stdout.close()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("reliability", ["best_effort", "reliable"])
def test_the_end_of_a_burst_arrives(reliability: str) -> None:
    """What is not sent would be sent again if the writer is reliable, unless it closes.

    Cyclone DDS drops the last samples of a writer that closes and is not reliable.
    """
    partition = f"test-{os.urandom(8).hex()}"
    payloads = [ENCODE(rtc.TimedLong(data=number)) for number in range(EACH + 1)]
    with (
        closing(Reader(partition, reliability)) as reader,
        closing(DdsMedium(partition, domain=DOMAIN)) as medium,
    ):
        assert reader.next() == "ready"
        for _ in range(5):
            publisher = medium.publisher(TOPIC, QOS[reliability])

            def has_begun(publisher: Publisher = publisher) -> bool:
                publisher.publish(payloads[0])
                return reader.says("begin")

            until(has_begun)
            for payload in payloads[1:]:
                publisher.publish(payload)
            if reliability == "reliable":
                publisher.close()
            assert reader.next() == str(EACH)
            publisher.close()
