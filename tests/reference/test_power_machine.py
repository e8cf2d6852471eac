"""The automaton of CiA 402: every transition, its cause, and how the drive brakes."""

from __future__ import annotations

import pytest

from refnav.cia402 import Command, DriveMaster, PowerState, command_of, state_of
from refnav.power_machine import TRANSITIONS, Braking, PowerMachine

S = PowerState
RESET = 0x80


class Bench:
    def __init__(self) -> None:
        self.taken: list[int] = []
        self.machine = PowerMachine(self.taken.append)
        self.machine.initialised()

    def since(self) -> list[int]:
        taken = self.taken.copy()
        self.taken.clear()
        return taken

    def to(self, state: PowerState) -> None:
        ways = {
            S.SWITCH_ON_DISABLED: [],
            S.READY_TO_SWITCH_ON: [0x06],
            S.SWITCHED_ON: [0x06, 0x07],
            S.OPERATION_ENABLED: [0x06, 0x0F],
            S.QUICK_STOP_ACTIVE: [0x06, 0x0F, 0x02],
        }
        if state in (S.FAULT_REACTION_ACTIVE, S.FAULT):
            self.to(
                S.OPERATION_ENABLED
                if state is S.FAULT_REACTION_ACTIVE
                else S.SWITCH_ON_DISABLED
            )
            self.machine.fault()
            self.machine.command(0)
        else:
            for controlword in ways[state]:
                self.machine.command(controlword)
        assert self.machine.state is state
        self.since()


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_drive_initialises_itself(bench: Bench) -> None:
    assert bench.since() == [0, 1]
    assert bench.machine.state is S.SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    ("state", "controlword", "taken"),
    [
        (S.SWITCH_ON_DISABLED, 0x06, [2]),
        (S.SWITCH_ON_DISABLED, 0x0F, []),
        (S.SWITCH_ON_DISABLED, 0x07, []),
        (S.SWITCH_ON_DISABLED, 0x02, []),
        (S.READY_TO_SWITCH_ON, 0x07, [3]),
        (S.READY_TO_SWITCH_ON, 0x0F, [3, 4]),
        (S.READY_TO_SWITCH_ON, 0x06, []),
        (S.READY_TO_SWITCH_ON, 0x00, [7]),
        (S.READY_TO_SWITCH_ON, 0x02, [7]),
        (S.SWITCHED_ON, 0x0F, [4]),
        (S.SWITCHED_ON, 0x07, []),
        (S.SWITCHED_ON, 0x06, [6]),
        (S.SWITCHED_ON, 0x00, [10]),
        (S.SWITCHED_ON, 0x02, [10]),
        (S.OPERATION_ENABLED, 0x0F, []),
        (S.OPERATION_ENABLED, 0x06, [8]),
        (S.OPERATION_ENABLED, 0x00, [9]),
        (S.OPERATION_ENABLED, 0x02, [11]),
        (S.QUICK_STOP_ACTIVE, 0x00, [12]),
        (S.QUICK_STOP_ACTIVE, 0x06, []),
        (S.FAULT, 0x06, []),
        (S.FAULT, RESET, [15]),
        # High bits depend on the mode: they command nothing.
        (S.SWITCH_ON_DISABLED, 0xFF76, [2]),
        (S.OPERATION_ENABLED, 0xFF7F, []),
    ],
)
def test_controlwords(
    bench: Bench, state: PowerState, controlword: int, taken: list[int]
) -> None:
    bench.to(state)
    bench.machine.command(controlword)
    assert bench.since() == taken
    bench.machine.command(controlword)
    assert bench.since() == []


def test_operation_is_disabled_after_braking(bench: Bench) -> None:
    bench.to(S.OPERATION_ENABLED)
    bench.machine.command(0x07)
    assert bench.machine.braking is Braking.SLOW_DOWN
    assert bench.since() == []
    bench.machine.at_rest()
    assert bench.since() == [5]
    assert bench.machine.braking is None


def test_operation_goes_on_if_it_is_enabled_while_braking(bench: Bench) -> None:
    bench.to(S.OPERATION_ENABLED)
    bench.machine.command(0x07)
    bench.machine.command(0x0F)
    assert bench.machine.braking is None
    bench.machine.at_rest()
    assert bench.since() == []
    bench.machine.disable_code = 0
    bench.machine.command(0x07)
    assert bench.since() == [5]


@pytest.mark.parametrize(
    ("code", "braking", "end"),
    [
        (0, None, [11, 12]),
        (1, Braking.SLOW_DOWN, [11, 12]),
        (2, Braking.QUICK, [11, 12]),
        (3, Braking.CURRENT_LIMIT, [11, 12]),
        (4, Braking.VOLTAGE_LIMIT, [11, 12]),
        (5, Braking.SLOW_DOWN, [11]),
        (6, Braking.QUICK, [11]),
        (7, Braking.CURRENT_LIMIT, [11]),
        (8, Braking.VOLTAGE_LIMIT, [11]),
    ],
)
def test_quick_stops(
    bench: Bench, code: int, braking: Braking | None, end: list[int]
) -> None:
    bench.machine.quick_stop_code = code
    bench.to(S.OPERATION_ENABLED)
    bench.machine.command(0x02)
    assert bench.machine.braking is braking
    bench.machine.at_rest()
    assert bench.taken == end
    bench.since()
    bench.machine.command(0x0F)
    assert bench.since() == ([16] if code >= 5 else [])


@pytest.mark.parametrize("code", range(5))
def test_faults_of_a_drive_that_turns(bench: Bench, code: int) -> None:
    bench.machine.fault_code = code
    bench.to(S.OPERATION_ENABLED)
    bench.machine.fault()
    if code:
        assert bench.since() == [13]
        assert bench.machine.braking is Braking(code)
        bench.machine.command(RESET)
        bench.machine.at_rest()
        assert bench.since() == [14]
    else:
        assert bench.since() == [13, 14]
    bench.machine.fault()
    assert bench.since() == []


@pytest.mark.parametrize(
    "state", [S.SWITCH_ON_DISABLED, S.READY_TO_SWITCH_ON, S.SWITCHED_ON]
)
def test_faults_without_power(bench: Bench, state: PowerState) -> None:
    bench.to(state)
    bench.machine.fault()
    assert bench.since() == [13, 14]


def test_a_fault_is_reset_by_a_rising_edge_once_its_cause_has_gone(
    bench: Bench,
) -> None:
    bench.to(S.FAULT)
    bench.machine.command(RESET, faultless=False)
    bench.machine.command(RESET)
    assert bench.machine.state is S.FAULT
    bench.machine.command(0)
    bench.machine.command(RESET)
    assert bench.since() == [15]


def test_every_transition_is_between_its_states() -> None:
    """The table is that of the figure: 0 to 16."""
    assert sorted(TRANSITIONS) == list(range(17))
    for state in S:
        assert state_of(state.bits) is state
        assert state_of(state.bits | 0xFF90) is state
    assert state_of(0x004B) is None


def test_commands() -> None:
    assert [command_of(word) for word in (0x00, 0x02, 0x06, 0x07, 0x0F)] == [*Command]
    assert command_of(0x0B) is Command.QUICK_STOP
    assert command_of(0x0D) is Command.DISABLE_VOLTAGE
    assert command_of(0x80) is command_of(0x8F) is None


@pytest.mark.parametrize("state", [s for s in S if s is not S.NOT_READY_TO_SWITCH_ON])
def test_a_master_brings_a_drive_to_operation(bench: Bench, state: PowerState) -> None:
    bench.to(state)
    master = DriveMaster()
    machine = bench.machine
    for _ in range(10):
        master.take(0x0200 | machine.state.bits)
        if master.enabled:
            break
        machine.command(master.controlword)
        machine.at_rest()
    assert machine.state is S.OPERATION_ENABLED
    assert master.controlword == Command.ENABLE_OPERATION
    master.forget()
    assert (master.state, master.enabled) == (None, False)


def test_a_master_tries_again_while_the_fault_lasts(bench: Bench) -> None:
    bench.to(S.FAULT)
    master = DriveMaster()
    words = []
    for _ in range(4):
        master.take(bench.machine.state.bits)
        words.append(master.controlword)
        bench.machine.command(master.controlword, faultless=False)
    assert words == [RESET, 0, RESET, 0]
