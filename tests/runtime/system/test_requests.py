"""Requests of clients: in turn, within their part of the time, those of operators first."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rtgen.runtime.requests import (
    Allowance,
    Client,
    Overruns,
    Pace,
    Queues,
    Rates,
    Requests,
)


class Time:
    """A clock that requests let pass."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


class Bench:
    """Requests that take a time, and the order in which they are executed."""

    def __init__(self, share: float = 0.1, burst: float = 0.05) -> None:
        self.time = Time()
        self.requests = Requests(share, burst, self.time)
        self.order: list[str] = []

    def taking(self, name: str, seconds: float) -> Callable[[], None]:
        def request() -> None:
            self.order.append(name)
            self.time.now += seconds

        return request

    def fill(self, client: Client, name: str, seconds: float, count: int = 1) -> None:
        for _ in range(count):
            assert client.put(self.taking(name, seconds))

    def executed(self, longest: float = 1.0, *, limited: bool = True) -> str:
        """Return the names of the requests of one slice."""
        self.order = []
        self.requests.carry_out(longest, limited=limited)
        return "".join(self.order)


def test_clients_are_served_in_turn() -> None:
    bench = Bench(share=1.0, burst=10.0)
    one, other = bench.requests.join(10), bench.requests.join(10)
    bench.fill(one, "a", 0.001, 5)
    bench.fill(other, "b", 0.001, 2)
    assert bench.executed() == "ababaaa"


def test_a_client_with_long_requests_has_fewer_turns() -> None:
    bench = Bench(share=1.0, burst=10.0)
    slow, quick = bench.requests.join(10), bench.requests.join(10)
    bench.fill(slow, "S", 0.004, 3)
    bench.fill(quick, "q", 0.001, 8)
    assert bench.executed() == "SqqqqSqqqqS"


def test_a_client_does_not_save_up_turns() -> None:
    bench = Bench(share=1.0, burst=100.0)
    busy, late = bench.requests.join(10), bench.requests.join(10)
    for _ in range(20):
        bench.fill(busy, "b", 0.001, 5)
        bench.executed()
    bench.fill(busy, "b", 0.001, 4)
    bench.fill(late, "l", 0.001, 4)
    assert bench.executed() in ("blblblbl", "lblblblb")


def test_requests_take_no_more_than_their_part_of_the_time() -> None:
    bench = Bench(share=0.1)
    clients = [bench.requests.join(100) for _ in range(3)]
    count = 0
    for _ in range(500):
        for client in clients:
            while client.put(bench.taking("a", 0.003)):
                pass
        count += len(bench.executed(0.01))
        bench.time.now += 0.02
    assert 0.09 < count * 0.003 / bench.time.now < 0.11


def test_the_time_that_requests_take_elsewhere_counts() -> None:
    time = Time()
    requests = Requests(0.1, 0.05, time, conversion=0.01)
    client = requests.join(100)
    for _ in range(100):
        assert client.put(lambda: None)
    requests.carry_out(1.0)
    assert client.spent == pytest.approx(0.05)  # five of them; then the time is used up
    time.now += 1.0
    requests.carry_out(1.0)
    assert client.spent == pytest.approx(0.10)


def test_one_long_request_is_paid_for_later() -> None:
    bench = Bench(share=0.1)
    client = bench.requests.join(10)
    bench.fill(client, "a", 1.0)
    bench.fill(client, "b", 0.001)
    assert bench.executed() == "a"
    bench.time.now += 8.4
    assert bench.executed() == ""
    bench.time.now += 0.2
    assert bench.executed() == "b"


def test_time_that_a_client_has_taken_elsewhere_counts() -> None:
    bench = Bench(share=0.1)
    client = bench.requests.join(10)
    client.charge(0.15)
    bench.fill(client, "a", 0.001)
    assert bench.executed() == ""
    bench.time.now += 1.1
    assert bench.executed() == "a"


def test_those_who_come_first_wait_for_no_other_and_have_no_limit() -> None:
    bench = Bench(share=0.0, burst=0.0)
    reader = bench.requests.join(100)
    operator = bench.requests.join(100, first=True)
    bench.fill(reader, "r", 0.01, 50)
    bench.fill(operator, "o", 0.01, 3)
    assert bench.executed() == "ooo"
    assert bench.executed(0.02, limited=False) == "rr"
    bench.fill(operator, "o", 0.01)
    assert bench.executed(0.02, limited=False) == "or"


def test_a_slice_ends_after_its_time() -> None:
    bench = Bench()
    operator = bench.requests.join(100, first=True)
    bench.fill(operator, "o", 0.004, 5)
    assert bench.executed(0.01) == "ooo"
    assert bench.executed(0.01) == "oo"


def test_a_queue_is_bounded_and_ends_with_its_client() -> None:
    bench = Bench(share=1.0)
    client = bench.requests.join(2)
    bench.fill(client, "a", 0.001, 2)
    assert client.is_full
    assert not client.put(bench.taking("b", 0.001))
    bench.requests.leave(client)
    assert not client.put(bench.taking("b", 0.001))
    assert bench.executed() == ""


def test_a_client_that_is_not_ready_is_left_out() -> None:
    bench = Bench(share=1.0)
    ready = [False]
    client = bench.requests.join(10, ready=lambda: ready[0])
    other = bench.requests.join(10)
    bench.fill(client, "a", 0.001)
    bench.fill(other, "b", 0.001)
    assert bench.executed() == "b"
    ready[0] = True
    assert bench.executed() == "a"


def test_a_request_that_raises_is_counted() -> None:
    bench = Bench(share=0.1)
    client = bench.requests.join(10)

    def fail() -> None:
        bench.time.now += 1.0
        raise ValueError

    client.put(fail)
    bench.fill(client, "a", 0.001)
    try:
        bench.executed()
    except ValueError:
        assert bench.executed() == ""
    else:
        raise AssertionError


def test_the_queues_of_idle_clients_are_forgotten() -> None:
    bench = Bench(share=1.0, burst=10.0)
    queues = Queues(bench.requests, 2, 1)
    for name in range(1000):
        assert queues.put(name, bench.taking("a", 0.0))
        assert bench.executed() == "a"
    assert len(bench.requests._clients) <= 256
    assert queues.put("flood", bench.taking("f", 0.001))
    assert queues.put("flood", bench.taking("f", 0.001))
    assert not queues.put("flood", bench.taking("f", 0.001))
    assert queues.put("other", bench.taking("o", 0.001))
    assert queues.put("flood", bench.taking("S", 0.001), first=True)
    assert bench.executed() in ("Sfof", "Soff")


def test_a_client_that_takes_too_much_time_is_refused_and_others_are_not() -> None:
    time = Time()
    allowance = Allowance(0.2, 0.05, time)
    taken = {"greedy": 0.0, "modest": 0.0}
    for step in range(10_000):
        time.now += 0.001
        if allowance.allows("greedy"):
            allowance.charge("greedy", 0.005)
            taken["greedy"] += 0.005
        if step % 1000 == 999:
            assert allowance.allows("modest")
            allowance.charge("modest", 0.005)
            taken["modest"] += 0.005
    assert 0.9 < taken["greedy"] < 1.1
    assert taken["modest"] == pytest.approx(0.05)


def test_many_clients_together_take_no_more_than_the_share() -> None:
    time = Time()
    allowance = Allowance(0.2, 0.05, time)
    taken = 0.0
    for _ in range(20_000):
        time.now += 0.001
        for client in range(20):
            if allowance.allows(client):
                allowance.charge(client, 0.002)
                taken += 0.002
    # A client that was not served for a second is served in any case.
    assert 0.19 < taken / time.now < 0.2 + 20 * 0.002 + 0.01


def test_threads_that_can_wait_keep_their_pace() -> None:
    time = Time()

    def sleep(seconds: float) -> None:
        assert 0.0 < seconds <= 0.05
        time.now += seconds

    pace = Pace(0.2, 0.05, time, sleep)
    for _ in range(1000):
        pace.wait()
        time.now += 0.002
        pace.charge(0.002)
    assert 0.19 < 2.0 / time.now < 0.21


def test_threads_wait_only_while_there_is_a_reason() -> None:
    time = Time()
    overruns = Overruns(time)
    waited: list[float] = []

    def sleep(seconds: float) -> None:
        waited.append(seconds)
        time.now += seconds

    pace = Pace(0.25, 0.05, time, sleep, overruns.recent)

    def call(seconds: float) -> float:
        """Return for how long a call waits that then takes a time."""
        begun = time.now
        pace.wait()
        found = time.now - begun
        time.now += seconds
        pace.charge(seconds)
        return found

    assert [call(0.1) for _ in range(50)] == [0.0] * 50
    overruns.report()
    assert overruns.recent()
    assert call(0.1) == 0.0
    assert 0.0 < call(0.1) <= 0.05 / 0.25 + 0.05  # a long one is not paid for long
    assert 0.0 < call(10.0) <= 0.05 / 0.25 + 0.05
    assert not overruns.recent()
    assert call(0.1) == 0.0


def messages(rates: Rates, time: Time, clients: int, seconds: float) -> list[int]:
    """Return how many messages clients can send that send all they can."""
    due = dict.fromkeys(range(clients), 0.0)
    sent = [0] * clients
    while (now := min(due.values())) < seconds:
        time.now = now
        for client in [each for each in due if due[each] <= now]:
            due[client] = now + max(rates.delay(client, 1), 1e-6)
            sent[client] += 1
    return sent


def test_a_client_sends_at_its_rate() -> None:
    time = Time()
    assert messages(Rates(100.0, 400.0, 50.0, time), time, 1, 2.0)[0] in range(249, 253)


def test_clients_that_send_without_end_share_the_total() -> None:
    time = Time()
    rates = Rates(100.0, 400.0, 50.0, time)
    sent = messages(rates, time, 10, 10.0)
    assert sum(sent) < 10 * 50 + 10 * 400 * 1.05
    assert max(sent) - min(sent) <= 5
    assert rates.delay("quiet", 1) == 0.0


def test_a_client_that_has_left_is_forgotten() -> None:
    rates = Rates(100.0, 400.0, 50.0, Time())
    assert rates.delay("a", 60) == pytest.approx(0.1)
    rates.leave("a")
    assert rates.delay("a", 50) == 0.0
