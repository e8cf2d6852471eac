"""Collects samples and changes of a medium, and waits for them."""

from __future__ import annotations

import struct
from itertools import count

import media
import pytest
from patience import until

from refrobots._idl.basic_data_type import TimedOctetSeq
from rtgen.runtime.distribution.medium import Publisher, Sample, Topic

TOPIC = Topic("robot/out/pose", TimedOctetSeq)
ON_ROS_TOO = pytest.mark.parametrize("engine", media.MESSAGING, indirect=True)
"""Marks tests of what networks of ROS 2 have, too."""


class Samples(list[Sample]):
    """The samples of a subscription."""

    def on_sample(self, sample: Sample) -> None:
        self.append(sample)

    @property
    def sequences(self) -> list[int | None]:
        return [sample.sequence for sample in self]


class Changes(list[tuple[str, bool]]):
    """The reports of a watch."""

    def on_change(self, name: str, present: bool) -> None:
        self.append((name, present))


def payload(number: int, size: int = 4) -> bytes:
    """Return a serialized sample with a number and `size` octets, a multiple of four."""
    return b"\0\1\0\0" + struct.pack("<III", number, 0, size) + bytes(size)


def number_of(sample: Sample) -> int:
    """Return the number of `payload`."""
    return int.from_bytes(sample.octets[4:8], "little")


class Sender:
    """Publishes numbers, and counts them."""

    def __init__(self, publisher: Publisher) -> None:
        self.publisher = publisher
        self.sent = 0

    def send(self, number: int, size: int = 4) -> None:
        """Publish a number."""
        self.publisher.publish(payload(number, size))
        self.sent += 1

    def reach(self, number: int, *readers: Samples) -> None:
        """Publish numbers from this one on, until each subscription has received one of them."""
        following = count(number)

        def all_have() -> bool:
            self.send(next(following))
            return all(any(number_of(s) >= number for s in each) for each in readers)

        until(all_have)
