"""CORBA, DDS and Zenoh by their Python libraries alone, for the benchmark `transports.py`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from media import DOMAIN

from rtgen.runtime.distribution.data import encoder

LAST_NUMBER = 0x7FFFFFFF
LAST = LAST_NUMBER.to_bytes(4, "little")
"""Nanoseconds in the time stamp of the last sample of a round."""


def bare_reader(
    medium: Any,
    name: str,
    type_: type[Any],
    taken: Callable[[bool], None],
    depth: int | None = None,
) -> Any:
    """Return a reader of the library alone, with the same interface as rtgen's.

    `taken` is called for each sample, with True for the last of its round.
    """
    if hasattr(medium, "bare_reader"):
        return medium.bare_reader(name, lambda v: taken(v.tm.nsec == LAST_NUMBER))
    if hasattr(medium, "_session"):
        return medium._session.declare_subscriber(
            name, lambda sample: taken(sample.payload.to_bytes()[8:12] == LAST)
        )
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.util import duration

    participant = DomainParticipant(DOMAIN)
    _, reader = bare_ends(participant, name, type_, depth)

    def read() -> None:
        for sample in reader.take_iter(timeout=duration(days=1)):
            taken(sample.tm.nsec == LAST_NUMBER)

    threading.Thread(target=read, daemon=True).start()
    return participant, reader


def bare_ends(
    participant: Any, name: str, type_: type[Any], depth: int | None
) -> tuple[Any, Any]:
    """Return writer and reader of cyclonedds-python's class; without `depth` they keep all."""
    from cyclonedds.core import Policy
    from cyclonedds.core import Qos as TheirQos
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic as TheirTopic
    from cyclonedds.util import duration

    from rtgen.runtime.dds.types import idl_class

    kept = Policy.History.KeepAll if depth is None else Policy.History.KeepLast(depth)
    waits = 0 if depth is not None else duration(seconds=60)
    qos = TheirQos(Policy.Reliability.Reliable(waits), kept)
    topic = TheirTopic(participant, name, idl_class(type_), qos=qos)
    return (
        DataWriter(participant, topic, qos=qos),
        DataReader(participant, topic, qos=qos),
    )


@contextmanager
def bare_writer(
    medium: Any, name: str, type_: type[Any]
) -> Iterator[tuple[Callable[[Any], Any], Callable[[Any], object]]]:
    """Yield a converter from rtgen's samples to the library's, and a writer of these."""
    encode = encoder(type_)
    if hasattr(medium, "bare_writer"):
        yield medium.bare_writer(name, type_)
        return
    if hasattr(medium, "_session"):
        import zenoh

        publisher = medium._session.declare_publisher(
            name, congestion_control=zenoh.CongestionControl.BLOCK
        )
        await_match(lambda: publisher.matching_status.matching)
        yield encode, publisher.put
        publisher.undeclare()
        return
    from cyclonedds.domain import DomainParticipant

    from rtgen.runtime.dds.types import idl_class

    participant = DomainParticipant(DOMAIN)
    writer, own = bare_ends(participant, name, type_, None)
    del own
    await_match(writer.get_matched_subscriptions)
    yield lambda value: idl_class(type_).deserialize(encode(value)), writer.write


# The writers of TimedPose2D alone, for which there are limits.


def await_match(matched: Callable[[], object]) -> None:
    """Wait until the reader is discovered."""
    while not matched():
        time.sleep(0.01)
