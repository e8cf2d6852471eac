"""RefHardRh3Tecs alone: its calls, its use of the answers, Stop and Go, lost calls."""

from __future__ import annotations

from math import tau

import pytest
from component_bench import Bench

from refnav.ref_hard_rh3_tecs import RefHardRh3Tecs
from refrobots import RefHard, iis, rtc
from refrobots.tecs.board import MotorBoard, tagWheelState
from rtgen.runtime import Component, LifeCycleState
from rtgen.runtime.opaque_rpc import E_OK, E_PAR, E_RPC, E_TMOUT, ERCD


class FakeBoard(MotorBoard):
    """Answers as configured, and records the requests."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.speed = [0.0, 0.0]
        self.limits = (0.0, 0.0)
        self.code = E_OK
        self.count = [0, 0]

    def identify(self) -> tuple[int, str]:
        self.calls.append("identify")
        return self.code, "fake"

    def setLimits(self, speed: float, acceleration: float) -> int:
        self.calls.append("setLimits")
        self.limits = (speed, acceleration)
        return self.code

    def drive(self, speed: list[float], count: int) -> tuple[int, tagWheelState]:
        self.calls.append("drive")
        self.speed = speed
        assert count == 2
        return self.code, tagWheelState(count=self.count)

    def getState(self) -> tuple[int, tagWheelState]:
        self.calls.append("getState")
        return self.code, tagWheelState(count=self.count)

    def stop(self) -> None:
        self.calls.append("stop")

    def release(self) -> int:
        self.calls.append("release")
        return self.code

    def taken(self) -> list[str]:
        calls, self.calls = self.calls, []
        return calls


class Peer(Component):
    """Has the board, and the services of the base."""

    def __init__(self, board: FakeBoard) -> None:
        super().__init__("Hardware0")
        port = self.add_provider("board", "motor_board", MotorBoard)
        port.set_servant(board)
        self.base = self.add_consumer("base", "RefHard", RefHard)


@pytest.fixture
def board() -> FakeBoard:
    return FakeBoard()


@pytest.fixture
def bench(board: FakeBoard) -> Bench:
    bench = Bench(RefHardRh3Tecs("Base0"), 100.0)
    bench.system.add(Peer(board), 100.0)
    bench.system.connect(("Base0", "motor_board"), ("Hardware0", "board"), {}, "calls")
    bench.system.connect(("Base0", "BumpRefHard"), ("Hardware0", "base"))
    bench.system.activate("Hardware0")
    bench.run(0.01)
    bench.activate()
    return bench


def velocity(vx: float, va: float = 0.0) -> iis.TimedVelocity2D:
    return iis.TimedVelocity2D(data=rtc.Velocity2D(vx, 0.0, va))


def calls(bench: Bench) -> tuple[float, ...]:
    return bench.system.observable("Base0.calls")


def test_a_board_is_met_before_it_drives(bench: Bench, board: FakeBoard) -> None:
    assert board.taken() == ["identify", "setLimits", "release", "drive"]
    assert board.limits == (10.0, 50.0)
    bench.send("InTargetVelocity", velocity(0.2, 0.1))
    bench.run(0.02)
    assert board.taken() == ["drive", "drive"]
    assert board.speed == pytest.approx([2.0 - 0.2205, 2.0 + 0.2205])


def test_counts_become_angles(bench: Bench, board: FakeBoard) -> None:
    bench.set(EncoderConstant_R="2.0")
    bench.run(0.01)
    bench.sent("OutWheelAngle")
    board.count = [2000 * 7491, -2000 * 7491]
    bench.run(0.01)
    [sample] = bench.sent("OutWheelAngle")
    assert sample.data == pytest.approx([100 * tau, -200 * tau])


def test_velocities_that_fail_to_come_mean_rest(bench: Bench, board: FakeBoard) -> None:
    bench.send("InTargetVelocity", velocity(0.2))
    bench.run(0.4)
    assert board.speed == pytest.approx([2.0, 2.0])
    bench.run(0.2)
    assert board.speed == [0.0, 0.0]


def test_stop_and_go_reach_the_board(bench: Bench, board: FakeBoard) -> None:
    hardware = bench.system.component("Hardware0")
    assert isinstance(hardware, Peer)
    bench.send("InTargetVelocity", velocity(0.2))
    bench.run(0.01)
    board.taken()
    hardware.base.object.Stop()
    bench.run(0.02)
    assert board.taken() == ["stop", "drive", "drive"]
    assert board.speed == [0.0, 0.0]
    hardware.base.object.Go()
    bench.run(0.02)
    assert board.taken() == ["release", "drive", "drive"]
    assert board.speed == pytest.approx([2.0, 2.0])


def test_a_board_that_is_lost_is_met_again(bench: Bench, board: FakeBoard) -> None:
    bench.sent("OutWheelAngle")
    board.taken()
    board.code = ERCD(E_RPC, E_TMOUT)
    bench.run(0.03)
    assert board.taken() == ["drive", "identify", "identify"]
    assert bench.sent("OutWheelAngle") == []
    assert bench.state is LifeCycleState.ACTIVE_STATE
    board.code = E_OK
    bench.run(0.02)
    assert board.taken() == ["identify", "setLimits", "release", "drive", "drive"]
    assert len(bench.sent("OutWheelAngle")) == 2
    assert calls(bench)[1] == 3


def test_a_stopped_base_stays_stopped_when_its_board_comes_back(
    bench: Bench, board: FakeBoard
) -> None:
    hardware = bench.system.component("Hardware0")
    assert isinstance(hardware, Peer)
    hardware.base.object.Stop()
    bench.system.disconnect("calls")
    bench.run(0.02)
    board.taken()
    bench.system.connect(("Base0", "motor_board"), ("Hardware0", "board"))
    bench.run(0.01)
    assert board.taken() == ["identify", "setLimits", "stop", "drive"]


def test_a_board_that_refuses_is_an_error(bench: Bench, board: FakeBoard) -> None:
    board.code = E_PAR
    bench.run(0.01)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert "the board refuses drive (-17)" in bench.component.reason


def test_deactivation_stops_the_board(bench: Bench, board: FakeBoard) -> None:
    board.taken()
    bench.deactivate()
    assert board.taken() == ["stop"]
