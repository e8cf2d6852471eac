"""The check of `make lint` for the form of Python files."""

from __future__ import annotations

from pathlib import Path

import pytest
from python_form import doubtful, main

LEFT_BY_BOTH = "x = {1: 2}\n"
LEFT_BY_BLACK_ALONE = (
    "a = [\n    (\n        1\n"
    "        if condition_of_some_length_that_fills_a_line\n"
    "        else 2 if another_condition_of_a_length_that_fills_it else 3\n    )\n]\n"
)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("text", "is_doubtful", "code"),
    [
        (LEFT_BY_BOTH, False, 0),
        (LEFT_BY_BLACK_ALONE, True, 0),
        ("x = {  1:2 }\n", True, 1),
        ("x = (\n", True, 123),
    ],
)
def test_black_judges_what_ruff_would_change(
    text: str, is_doubtful: bool, code: int, tmp_path: Path
) -> None:
    (tmp_path / "left.py").write_text(LEFT_BY_BOTH)
    path = tmp_path / "tried.py"
    path.write_text(text)
    assert doubtful([str(tmp_path)]) == [str(path)] * is_doubtful
    assert main([str(tmp_path)]) == code


def test_a_folder_that_is_missing_is_no_success(tmp_path: Path) -> None:
    assert main([str(tmp_path / "nowhere")]) != 0
