"""Scripts of sticks: values over time, and refusals."""

from __future__ import annotations

import pytest

from refnav.stick_script import ScriptError, parse


def test_values_are_held_for_their_time() -> None:
    script = parse("# forward, turn\n1.5 1 0\n\n0.5 0 -0.5 # left\n", "s.txt", 2)
    assert script.end == 2.0
    assert script.at(0.0) == script.at(1.49) == (1.0, 0.0)
    assert script.at(1.5) == (0.0, -0.5)
    assert script.at(2.0) is None


def test_many_short_times_add_up() -> None:
    script = parse("0.1 0\n" * 1000, "s.txt", 1)
    assert script.end == 100.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "s.txt: holds no line"),
        ("1 0\n1 x", "s.txt:2: not numbers: '1 x'"),
        ("1 0 0", "s.txt:1: SECONDS and 1 values expected, 3 numbers found"),
        ("0 0", "s.txt:1: 0 is not a duration"),
        ("nan 0", "s.txt:1: nan is not a duration"),
        ("1 1.5", "s.txt:1: values go from -1 to 1"),
        ("1 nan", "s.txt:1: values go from -1 to 1"),
    ],
)
def test_what_is_no_script_is_refused(text: str, message: str) -> None:
    with pytest.raises(ScriptError, match=message):
        parse(text, "s.txt", 1)
