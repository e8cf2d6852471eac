"""Durations and values in reports of runs, as people write them."""

from __future__ import annotations

import re

import pytest

from rtgen.runtime.library.canopen import SdoAbort
from rtgen.runtime.system.json_calls import Outcome
from rtgen.tools.running.texts import duration, outcome_text


@pytest.mark.parametrize(
    ("time", "text"),
    [
        (0, "0 ns"),
        (999, "999 ns"),
        (1000, "1 us"),
        (85_400, "85.4 us"),
        (999_999, "1 ms"),
        (20_000_000, "20 ms"),
        (999_400_000, "999 ms"),
        (999_600_000, "1 s"),
        (3_019_000_000, "3.02 s"),
        (3_000_000_000_000, "3000 s"),
    ],
)
def test_durations(time: int, text: str) -> None:
    assert duration(time) == text


def test_a_duration_of_any_size_has_no_exponent() -> None:
    for digits in range(14):
        for head in (1, 1.004, 3.14159, 9.994, 9.996, 9.9999):
            time = int(head * 10**digits)
            text = duration(time)
            assert re.fullmatch(r"\d+(\.\d+)? (s|ms|us|ns)", text)
            number, unit = text.split()
            size = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}[unit]
            assert float(number) * size == pytest.approx(time, rel=5.1e-3, abs=1)


def test_abort_codes_are_hexadecimal() -> None:
    for code in (0x05030000, 0x06090030, 0x08000022):
        assert str(SdoAbort(code, "why")) == f"code=0x{code:08x}, text='why'"


@pytest.mark.parametrize(
    ("outcome", "text"),
    [
        (Outcome(), ""),
        (Outcome(result=2.5), " -> 2.5"),
        (Outcome(result="ON", out={"n": [1, 2]}), ' -> "ON", n = [1, 2]'),
        (Outcome(exception="A::B", message="x=1"), " raises A::B: x=1"),
        (Outcome(exception="A::B"), " raises A::B"),
    ],
)
def test_outcomes_of_calls(outcome: Outcome, text: str) -> None:
    assert outcome_text(outcome) == text
