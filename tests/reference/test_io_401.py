"""The f-palette board: polarity, masks, enables, triggers, error values, the reference."""

from __future__ import annotations

from math import nan

import pytest
from device_objects import objects

from refnav.io_401 import Board, Trigger, converted


@pytest.fixture
def board() -> Board:
    return Board(objects("f_palette"))


def step(board: Board) -> list[str]:
    """Return the names of the objects with an event in a step."""
    board.step()
    return [*board.events]


def enable(board: Board, **values: object) -> None:
    board._objects.Analogue_input_global_interrupt_enable = True
    for name, value in values.items():
        assert hasattr(board._objects, name)
        setattr(board._objects, name, value)


def test_digital_inputs_with_polarity(board: Board) -> None:
    assert step(board) == []
    board.digital = [0x05, 0x80]
    assert step(board) == ["Digital_inputs_1_to_8", "Digital_inputs_9_to_16"]
    made = board._objects
    assert (made.Digital_inputs_1_to_8, made.Digital_inputs_9_to_16) == (0x05, 0x80)
    assert step(board) == []
    made.Polarity_of_inputs_1_to_8 = 0xF0
    assert step(board) == ["Digital_inputs_1_to_8"]
    assert made.Digital_inputs_1_to_8 == 0xF5


def test_masks_and_the_global_enable(board: Board) -> None:
    made = board._objects
    made.Mask_of_inputs_1_to_8 = 0x02
    board.digital[0] = 0x01
    assert step(board) == []
    assert made.Digital_inputs_1_to_8 == 0x01
    board.digital[0] = 0x03
    assert step(board) == ["Digital_inputs_1_to_8"]
    made.Global_interrupt_enable_digital = False
    board.digital[0] = 0x00
    assert step(board) == []


def test_outputs(board: Board) -> None:
    made = board._objects
    made.Digital_outputs_9_to_16 = 0x0F
    made.Polarity_of_outputs_9_to_16 = 0x03
    made.Analogue_output_2 = -0x4000
    board.step()
    assert board.levels == [0x00, 0x0C]
    assert board.output_voltages == pytest.approx([0.0, -2.5, 0.0, 0.0], abs=1e-3)


def test_outputs_take_their_error_values(board: Board) -> None:
    made = board._objects
    made.Digital_outputs_1_to_8 = 0xF0
    made.Error_mode_of_outputs_1_to_8 = 0x3C
    made.Error_value_of_outputs_1_to_8 = 0x0F
    made.Analogue_output_1 = made.Analogue_output_2 = 100
    made.Error_mode_of_analogue_output_2 = 0
    made.Error_value_of_analogue_output_1 = 1 << 20
    board.leave()
    assert board.levels[0] == 0xCC
    assert (made.Analogue_output_1, made.Analogue_output_2) == (0x7FFF, 100)


def test_analogue_inputs_are_silent_until_enabled(board: Board) -> None:
    board.voltages[0] = 2.5
    assert step(board) == ["Angle_reference"]
    assert board._objects.Analogue_input_1 == 0x4000
    enable(board)
    assert step(board) == [f"Analogue_input_{n}" for n in range(1, 9)]
    assert step(board) == []
    board.voltages[6] = 0.1
    assert step(board) == ["Analogue_input_7"]


def test_first_values(board: Board) -> None:
    """A board that becomes operational transmits the inputs that may cause events."""
    names = "Analogue_input_1", "Digital_inputs_1_to_8", "Angle_reference"
    assert [board.tells_first(name) for name in names] == [False, True, True]
    enable(board, Global_interrupt_enable_digital=False)
    assert [board.tells_first(name) for name in names] == [True, False, True]


def test_delta(board: Board) -> None:
    enable(board, Delta_of_analogue_input_2=1000)
    board.step()
    transmitted = []
    for n in range(1, 41):
        board.voltages[1] = n * 100 / 0x7FFF * 5.0
        if "Analogue_input_2" in step(board):
            transmitted.append(board._objects.Analogue_input_2)
    assert transmitted == [1000, 2000, 3000, 4000]


@pytest.mark.parametrize(
    ("trigger", "expected"),
    [
        (Trigger.DELTA, [2500, 1500, 1000, 1800, 500]),
        (Trigger.RISEN, [2500]),
        (Trigger.FALLEN, [1500, 1000, 500]),
        (Trigger.UPPER_LIMIT, [2500]),
        (Trigger.LOWER_LIMIT, [1000, 500]),
        (Trigger.UPPER_LIMIT | Trigger.LOWER_LIMIT, [2500, 1000, 500]),
    ],
)
def test_triggers(board: Board, trigger: int, expected: list[int]) -> None:
    """Changes are counted from the last transmitted value; beyond a limit once each time."""
    enable(
        board,
        Trigger_of_analogue_input_1=int(trigger),
        Upper_limit_of_analogue_input_1=2400,
        Lower_limit_of_analogue_input_1=1200,
    )
    transmitted = []
    for value in (2000, 2000, 2500, 2500, 1500, 1000, 1800, 500):
        board.voltages[0] = value / 0x7FFF * 5.0
        if "Analogue_input_1" in step(board):
            transmitted.append(board._objects.Analogue_input_1)
    assert transmitted == [2000, *expected]


def test_no_trigger_no_event(board: Board) -> None:
    enable(board, Trigger_of_analogue_input_1=0)
    board.voltages[0] = 1.0
    assert "Analogue_input_1" not in step(board)


def test_angle_reference(board: Board) -> None:
    made = board._objects
    made.Angle_reference_input = 3
    made.Angle_reference_gain = 90_000
    made.Angle_reference_offset = -10_000
    board.voltages[2] = 5.0
    assert "Angle_reference" in step(board)
    assert made.Angle_reference == 80_000
    board.voltages[2] = -5.0
    board.step()
    assert made.Angle_reference == pytest.approx(-100_000, abs=4)


def test_converter() -> None:
    assert converted(5.0) == converted(7.0) == 0x7FFF
    assert converted(-9.0) == -0x8000
    with pytest.raises(ValueError, match="nan is not a voltage"):
        converted(nan)
