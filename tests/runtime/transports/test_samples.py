"""Samples between media: at most once, in order, losses countable, histories for late readers."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from itertools import pairwise

import media
import pytest
from collecting import ON_ROS_TOO, TOPIC, Samples, Sender, number_of, payload
from patience import PATIENCE, until

from refrobots._idl.basic_data_type import TimedLong
from rtgen.runtime.distribution.medium import (
    SEQUENCES,
    Medium,
    MediumError,
    PublishTimeoutError,
    Qos,
    Sample,
    Topic,
)
from rtgen.runtime.distribution.rpc_header import OctetsClient, serve_octets

Join = Callable[..., Medium]


@ON_ROS_TOO
def test_every_subscription_gets_all_samples_in_order(join: Join) -> None:
    here, there, third = join(), join(), join()
    got = [Samples() for _ in range(3)]
    for medium, samples in zip((here, there, third), got, strict=True):
        medium.subscribe(TOPIC, Qos(depth=None), samples.on_sample)
    publisher = here.publisher(TOPIC, Qos(depth=None))
    until(lambda: publisher.matched)
    sender = Sender(publisher)
    # The first known subscription may be that of the same medium.
    sender.reach(1, *got)
    for number in range(1_000_000, 1_002_000):
        sender.send(number)
    for samples in got:
        until(lambda samples=samples: number_of(samples[-1]) == 1_001_999)
        found = [n for n in map(number_of, samples) if n >= 1_000_000]
        assert found == list(range(1_000_000, 1_002_000))


def test_two_publishers_are_told_apart_and_each_keeps_its_order(join: Join) -> None:
    reader, first, second = join(), join(), join()
    got = Samples()
    reader.subscribe(TOPIC, Qos(depth=None), got.on_sample)
    publishers = [
        medium.publisher(TOPIC, Qos(depth=None)) for medium in (first, second)
    ]
    for publisher in publishers:
        until(lambda publisher=publisher: publisher.matched)

    def send(publisher_index: int) -> None:
        for number in range(1, 501):
            publishers[publisher_index].publish(
                payload(publisher_index * 1000 + number)
            )

    threads = [threading.Thread(target=send, args=(index,)) for index in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    until(lambda: len(got) == 1000)
    assert len({sample.source for sample in got}) == 2
    for index in (0, 1):
        mine = [number_of(s) for s in got if number_of(s) // 1000 == index]
        assert mine == [index * 1000 + number for number in range(1, 501)]


def test_a_gap_in_the_numbers_shows_what_was_lost(
    join: Join, engine: media.Engine
) -> None:
    """A blocked subscription loses samples of a publisher that keeps few."""
    here, there = join(), join()
    got, go = Samples(), threading.Event()
    loses = engine.address is not None

    def on_sample(sample: Sample) -> None:
        got.on_sample(sample)
        if loses:
            go.wait(PATIENCE)

    there.subscribe(TOPIC, Qos(depth=4), on_sample)
    publisher = here.publisher(TOPIC, Qos(depth=4))
    until(lambda: publisher.matched)
    sender = Sender(publisher)

    def send(size: int = 4) -> None:
        sender.send(sender.sent + 1, size)

    until(lambda: send() or got)
    for _ in range(1000):
        send(50_000)
    flooded = sender.sent
    go.set()
    until(lambda: send() or number_of(got[-1]) > flooded)
    assert None not in got.sequences
    gaps = [(b - a) % SEQUENCES for a, b in pairwise(got.sequences)]
    assert gaps == [b - a for a, b in pairwise(map(number_of, got))]
    assert (max(gaps) > 1) is loses


@ON_ROS_TOO
def test_other_names_types_and_systems_are_not_received(join: Join) -> None:
    here, there, elsewhere = join(), join(), join("another")
    got = Samples()
    there.subscribe(TOPIC, Qos(), got.on_sample)
    strangers = [
        here.publisher(Topic("robot/out/other", TOPIC.type), Qos()),
        here.publisher(Topic(TOPIC.name, TimedLong), Qos()),
        elsewhere.publisher(TOPIC, Qos()),
    ]
    publisher = here.publisher(TOPIC, Qos())
    until(lambda: publisher.matched)
    assert not any(stranger.matched for stranger in strangers)
    for stranger in strangers:
        stranger.publish(payload(1))
    publisher.publish(payload(2))
    until(lambda: got)
    assert [number_of(sample) for sample in got] == [2]


@ON_ROS_TOO
@pytest.mark.parametrize("kept", [1, 5])
def test_a_late_joiner_gets_the_last_samples_once(join: Join, kept: int) -> None:
    here = join()
    publisher = here.publisher(TOPIC, Qos(durable=True, depth=kept))
    sender = Sender(publisher)
    for number in range(1, 11):
        sender.send(number)
    late, volatile = Samples(), Samples()
    join().subscribe(TOPIC, Qos(durable=True, depth=kept), late.on_sample)
    join().subscribe(TOPIC, Qos(), volatile.on_sample)
    until(lambda: len(late) >= kept)
    sender.reach(11, late, volatile)
    wanted = [*range(11 - kept, 11)]
    assert [number_of(s) for s in late if number_of(s) < 11] == wanted
    assert not [number_of(s) for s in volatile if number_of(s) < 11]


@ON_ROS_TOO
def test_a_durable_subscription_finds_a_publisher_that_comes_later(join: Join) -> None:
    here, there = join(), join()
    got = Samples()
    there.subscribe(TOPIC, Qos(durable=True, depth=4), got.on_sample)
    publisher = here.publisher(TOPIC, Qos(durable=True, depth=4))
    for number in range(1, 5):
        publisher.publish(payload(number))
    until(lambda: len(got) >= 4)
    assert [number_of(sample) for sample in got] == [1, 2, 3, 4]


@pytest.mark.sampled(3)
@ON_ROS_TOO
@pytest.mark.parametrize("megabytes", [1, 10])
def test_big_samples_arrive_whole(join: Join, megabytes: int) -> None:
    here, there = join(), join()
    got = Samples()
    there.subscribe(TOPIC, Qos(depth=None), got.on_sample)
    publisher = here.publisher(TOPIC, Qos(depth=None))
    until(lambda: publisher.matched)
    octets = bytes(range(256)) * (megabytes << 12)
    samples = [payload(n, len(octets))[: -len(octets)] + octets for n in (1, 2, 3)]
    for sample in samples:
        publisher.publish(sample)
    until(lambda: len(got) == 3)
    # Avoid a diff of megabytes.
    assert all(sample.octets == sent for sample, sent in zip(got, samples, strict=True))


def test_a_slow_subscription_slows_the_publisher_down_and_loses_nothing(
    join: Join, engine: media.Engine
) -> None:
    if engine.address is None:
        pytest.skip(
            "samples within a process are handled by the thread that sends them"
        )
    here, there = join(), join()
    got, go = Samples(), threading.Event()

    def on_sample(sample: object) -> None:
        go.wait(60)
        got.append(sample)  # type: ignore[arg-type]

    there.subscribe(TOPIC, Qos(depth=None), on_sample)
    publisher = here.publisher(TOPIC, Qos(depth=None, patience=0.1))
    until(lambda: publisher.matched)
    sender = Sender(publisher)

    def flood() -> None:
        for number in range(5000):
            sender.send(number, 100_000)

    with pytest.raises(PublishTimeoutError):
        flood()
    sent = sender.sent
    assert sent > 0
    go.set()
    until(lambda: len(got) == sent)
    sender.send(sent)
    until(lambda: len(got) == sent + 1)
    assert [number_of(sample) for sample in got] == list(range(sent + 1))


@ON_ROS_TOO
def test_a_publisher_that_keeps_few_does_not_wait_for_a_slow_subscription(
    join: Join,
) -> None:
    here, there = join(), join()
    got = Samples()
    there.subscribe(TOPIC, Qos(depth=4), got.on_sample)
    publisher = here.publisher(TOPIC, Qos(depth=4))
    until(lambda: publisher.matched)
    sender = Sender(publisher)
    for number in range(1, 5001):
        sender.send(number, 1000)
    sender.reach(10_000, got)
    found = [number_of(sample) for sample in got if number_of(sample) <= 5000]
    assert found == sorted(set(found))


def test_missed_deadlines_are_counted_by_subscription(join: Join) -> None:
    here, there = join(), join()
    got = [Samples() for _ in range(3)]
    short, *others = (
        there.subscribe(TOPIC, Qos(deadline=deadline), samples.on_sample)
        for deadline, samples in zip((0.01, 900, None), got, strict=True)
    )
    publisher = here.publisher(TOPIC, Qos(deadline=0.01))
    until(lambda: publisher.matched)
    assert short.missed_deadlines == 0
    Sender(publisher).reach(1, *got)
    until(lambda: short.missed_deadlines >= 5)
    assert [other.missed_deadlines for other in others] == [0, 0]
    short.close()
    ended = short.missed_deadlines
    assert ended >= 5
    publisher.close()
    assert short.missed_deadlines == ended


@ON_ROS_TOO
def test_nothing_comes_after_close(join: Join) -> None:
    here, there = join(), join()
    got, still = Samples(), Samples()
    subscription = there.subscribe(TOPIC, Qos(), got.on_sample)
    there.subscribe(TOPIC, Qos(), still.on_sample)
    publisher = here.publisher(TOPIC, Qos())
    until(lambda: publisher.matched)
    sender = Sender(publisher)
    sender.reach(1, got, still)
    subscription.close()
    before = len(got)
    sender.reach(1_000_000, still)
    assert len(got) == before
    publisher.close()
    with pytest.raises(MediumError):
        publisher.publish(payload(1))
    subscription.close()
    publisher.close()
    for depth in (1, None):
        last = here.publisher(TOPIC, Qos(depth=depth))
        here.close()
        with pytest.raises(MediumError):
            last.publish(payload(1))
        here = join()


@pytest.mark.sampled(1)
def test_subscriptions_come_and_go_while_samples_flow(join: Join) -> None:
    here, there = join(), join()
    publisher = here.publisher(TOPIC, Qos(depth=None))
    over = threading.Event()
    failures: list[Exception] = []

    def flood() -> None:
        sender = Sender(publisher)
        while not (over.is_set() or failures):
            try:
                sender.send(sender.sent)
            except Exception as error:
                failures.append(error)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        for _ in range(15):
            got = Samples()
            subscription = there.subscribe(TOPIC, Qos(depth=None), got.on_sample)
            until(lambda got=got: len(got) > 20)
            subscription.close()
            numbers = [number_of(sample) for sample in got]
            assert numbers == sorted(set(numbers))
    finally:
        over.set()
        thread.join()
    assert not failures


def test_wrong_names_are_refused(join: Join) -> None:
    medium = join()
    for name in ("", "/a", "a/", "a b", "a*", "ä", "a" * 201, "a?b#"):
        topic = Topic(name, TOPIC.type)
        for attempt in (
            partial(medium.publisher, topic, Qos()),
            partial(medium.subscribe, topic, Qos(), lambda _: None),
            partial(serve_octets, medium, name, lambda *_: None),
            partial(OctetsClient, medium, name),
            partial(medium.announce, name),
        ):
            with pytest.raises(MediumError, match="cannot be a name"):
                attempt()
