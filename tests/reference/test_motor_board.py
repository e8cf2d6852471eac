"""The program of the simulated motor board alone: limits, encoders, stop, watchdog, log."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan, tau

import pytest

from refnav.geometry import Pose
from refnav.motor_board import NAME, MotorBoard
from refrobots.components.simulated_motor_board import SimulatedMotorBoardConfiguration
from refrobots.rh3 import BoardEvent, BoardEventKind
from refrobots.tecs.board._types import NAME_SIZE, tagWheelState
from rtgen.runtime.opaque_rpc import E_OK, E_PAR

MILLISECOND = 1_000_000


@dataclass
class Bench:
    """A board with a clock of the test."""

    time: int = 5_000 * MILLISECOND

    def __post_init__(self) -> None:
        self.log: list[BoardEvent] = []
        self.board = MotorBoard(
            SimulatedMotorBoardConfiguration(),
            Pose(1.0, 2.0, 0.5),
            lambda: self.time,
            self.log.append,
        )
        assert self.board.setLimits(10.0, 50.0) == E_OK

    def run(self, milliseconds: int, *speeds: float, every: int = 10) -> None:
        """Run the board's loop at 1000 Hz; `every` [ms] sends commands in between."""
        for step in range(milliseconds):
            if speeds and step % every == 0:
                code, _ = self.board.drive(speeds, len(speeds))
                assert code == E_OK
            self.time += MILLISECOND
            self.board.turn()

    def state(self) -> tagWheelState:
        code, state = self.board.getState()
        assert code == E_OK
        return state

    @property
    def kinds(self) -> list[BoardEventKind]:
        return [event.kind for event in self.log]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_name_that_fits_the_buffer(bench: Bench) -> None:
    assert bench.board.identify() == (E_OK, NAME)
    assert len(NAME) < NAME_SIZE


def test_wheels_keep_their_limits(bench: Bench) -> None:
    bench.run(100, 30.0, -30.0)
    assert bench.state().speed == pytest.approx([5.0, -5.0])
    bench.run(200, 30.0, -30.0)
    assert bench.state().speed == [10.0, -10.0]
    assert bench.board.setLimits(2.0, 1000.0) == E_OK
    bench.run(10, 30.0, -30.0)
    assert bench.state().speed == pytest.approx([2.0, -2.0])


def test_encoders_count_turns(bench: Bench) -> None:
    bench.run(1000, 4.0, -2.0)
    left, right = bench.state().count
    per_turn = 2000 * 74.91
    assert left / per_turn * tau == pytest.approx(bench.board.base.angles[0], abs=1e-4)
    assert right / per_turn * tau == pytest.approx(bench.board.base.angles[1], abs=1e-4)
    assert left > 0 > right
    assert bench.state().time == 6_000


def test_a_counter_of_32_bits_goes_round(bench: Bench) -> None:
    size = tau / (2000 * 74.91)
    bench.board.base.angles[0] = (2**31 + 0.5) * size
    bench.board.base.angles[1] = (-(2**31) - 0.5) * size
    assert bench.state().count == [-(2**31), 2**31 - 1]


def test_the_watchdog_holds_the_wheels_when_speeds_fail_to_come(bench: Bench) -> None:
    bench.run(500, 3.0, 3.0)
    commanded = bench.time - 10 * MILLISECOND
    bench.run(69)
    assert bench.state().speed == [3.0, 3.0]
    assert not bench.state().watchdog
    bench.run(1)
    assert bench.state().speed == [0.0, 0.0]
    assert bench.state().watchdog
    assert bench.kinds == [BoardEventKind.DRIVING, BoardEventKind.WATCHDOG]
    stop = bench.log[-1]
    assert stop.tm.sec * 10**9 + stop.tm.nsec == commanded + 80 * MILLISECOND
    assert stop.command.sec * 10**9 + stop.command.nsec == commanded
    assert (stop.left, stop.right) == (0.0, 0.0)
    assert stop.pose.position.x > 1.0
    pose = bench.board.base.pose
    bench.run(500)
    assert bench.board.base.pose == pose
    bench.run(10, 3.0, 3.0)
    assert not bench.state().watchdog
    assert bench.state().speed[0] > 0.0
    assert bench.kinds[2:] == [BoardEventKind.DRIVING]


def test_looking_does_not_feed_the_watchdog(bench: Bench) -> None:
    bench.run(10, 3.0, 3.0)
    for _ in range(8):
        bench.state()
        bench.run(10)
    assert bench.state().watchdog


def test_stop_holds_until_release(bench: Bench) -> None:
    bench.run(100, 3.0, 3.0)
    bench.board.stop()
    bench.board.stop()
    assert bench.state().speed == [0.0, 0.0]
    bench.run(100, 3.0, 3.0)
    assert bench.state().stopped
    assert bench.state().speed == [0.0, 0.0]
    assert bench.board.release() == E_OK
    assert bench.board.release() == E_OK
    bench.run(100, 3.0, 3.0)
    assert bench.state().speed == [3.0, 3.0]
    assert bench.kinds == [
        BoardEventKind.DRIVING,
        BoardEventKind.STOPPED,
        BoardEventKind.RELEASED,
    ]


@pytest.mark.parametrize("speeds", [(1.0,), (), (nan, 1.0), (1.0, inf)])
def test_speeds_that_are_none_are_refused(
    bench: Bench, speeds: tuple[float, ...]
) -> None:
    code, state = bench.board.drive(speeds, len(speeds))
    assert code == E_PAR
    assert state.speed == [0.0, 0.0]
    bench.run(100)
    assert bench.kinds == []


@pytest.mark.parametrize("limits", [(-1.0, 1.0), (1.0, -1.0), (nan, 1.0), (1.0, inf)])
def test_limits_that_are_none_are_refused(
    bench: Bench, limits: tuple[float, float]
) -> None:
    assert bench.board.setLimits(*limits) == E_PAR
    bench.run(200, 30.0, 30.0)
    assert bench.state().speed == [10.0, 10.0]
