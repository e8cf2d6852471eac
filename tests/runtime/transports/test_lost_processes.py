"""Systems whose other process dies or freezes: calls end, and the system continues."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import media
import pytest
from both_sides import FarProcess, Pair, near_side
from far_side import NEAR, STEPS
from patience import PATIENCE, until

from rtgen import runtime

LOST = runtime.PortStatus.CONNECTION_LOST
pytestmark = [pytest.mark.slow, pytest.mark.waits]


class Mortal:
    """Both sides, of which the far one is killed or frozen, and perhaps restarted."""

    def __init__(self, network: media.Transports, folder: Path, pair: Pair) -> None:
        self.pair = pair
        self._network = network
        self._folder = folder
        self._written = 0
        self._taken: dict[str, list[int]] = {"many": [], "pulled": []}
        self._asked = 0
        self._came: dict[str, list[int]] = {"many": [], "pulled": []}
        self._far: FarProcess | None = None

    @property
    def far(self) -> FarProcess:
        """The far process."""
        assert self._far is not None
        return self._far

    def begin(self) -> None:
        """Start the far process, wait until both sides are connected, activate the near one."""
        self._far = self._started()
        self.pair.near.transport.await_others(PATIENCE)
        self.far.ready()
        self.pair.near.activate()

    def _started(self, *last_step: str) -> FarProcess:
        address = self._network.address
        assert address is not None
        log = self._folder / f"{time.monotonic_ns()}.txt"
        return FarProcess(address, log, *last_step)

    def dies_at(self, step: str) -> None:
        """Start a far process that dies at a step of its start."""
        self._started(step).has_died()

    def close(self) -> None:
        """End the far process."""
        if self._far is not None:
            self._far.kill()

    def start_again(self) -> None:
        """Start a new far process, which may read pending samples of the near side."""
        for numbers in self._taken.values():
            numbers.clear()
        self._far = self._started()
        self.far.ready()

    def lose(self) -> None:
        """Check that calls and writes end in time with errors, and the near side stays ACTIVE."""
        statuses = set()
        for _ in range(2):
            with pytest.raises(runtime.ServiceError):
                self.pair.ask("echo x", 1)
            statuses |= self.write()
            self._read()
        until(lambda: LOST in statuses or statuses.update(self.write()))
        ticks = self._ticks
        until(lambda: self._ticks > ticks + 2)
        state = self.pair.near.system.state(NEAR)
        assert state is runtime.LifeCycleState.ACTIVE_STATE

    @property
    def _ticks(self) -> int:
        ticks: int = self.pair.near.system.statistics(NEAR).ticks
        return ticks

    def write(self) -> set[runtime.PortStatus]:
        """Write the next number; return the statuses."""
        self._written += 1
        return {self.pair.write(port, self._written) for port in self._taken}

    def flows(self) -> None:
        """Wait until calls and samples pass in both directions again; none arrives twice."""
        until(self.pair.answers)
        self._take()
        written, asked = self._written, self._asked
        until(lambda: self._reaches(written))
        until(lambda: self._is_reached(asked))
        for numbers in (*self._taken.values(), *self._came.values()):
            assert numbers == sorted(set(numbers))

    def _reaches(self, before: int) -> bool:
        self.write()
        self._take()
        return all(max(each, default=0) > before for each in self._taken.values())

    def _take(self) -> None:
        with suppress(runtime.ServiceError):
            for port, numbers in self._taken.items():
                numbers += [number for number, _ in self.pair.taken(port)]

    def holds(self) -> bool:
        """Return whether the far side has a call that waits."""
        with suppress(runtime.ServiceError):
            return self.pair.ask("counted holds") == b"1"
        return False

    def _is_reached(self, before: int) -> bool:
        self._asked += 1
        # On a busy machine the far side may be lost for a moment.
        with suppress(runtime.ServiceError):
            for port in self._came:
                self.pair.ask(f"write {port}", self._asked)
        self._read()
        return all(max(each, default=0) > before for each in self._came.values())

    def _read(self) -> None:
        """Take received samples."""
        for port, numbers in self._came.items():
            numbers += [sample.tm.sec for sample in self.pair.end.take(port)]


@pytest.fixture(params=["dds", "zenoh", "corba"])
def mortal(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Mortal]:
    with (
        media.transports(request.param, media.LEASE) as network,
        ExitStack() as stack,
        near_side(network, 1.0) as pair,
    ):
        made = Mortal(network, tmp_path, pair)
        stack.callback(made.close)
        yield made


@pytest.mark.nightly
def test_a_process_stands_still_is_killed_and_is_started_again(mortal: Mortal) -> None:
    mortal.begin()
    mortal.flows()
    mortal.far.freeze()
    mortal.lose()
    mortal.far.thaw()
    mortal.flows()
    raised: list[BaseException] = []

    def call() -> None:
        try:
            mortal.pair.rpc.more(1)
        except runtime.ServiceError as error:
            raised.append(error)

    caller = threading.Thread(target=call)
    caller.start()
    until(mortal.holds)
    mortal.far.kill()
    caller.join()
    assert isinstance(raised[0], runtime.CommunicationFailure)
    mortal.lose()
    mortal.start_again()
    mortal.flows()


@pytest.mark.nightly
def test_a_process_that_dies_at_any_step_of_its_start_is_followed_by_another(
    mortal: Mortal,
) -> None:
    for step in STEPS:
        mortal.dies_at(step)
    mortal.begin()
    mortal.flows()
