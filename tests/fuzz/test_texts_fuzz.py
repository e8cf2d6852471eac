"""Definitions in UTF-8, Shift_JIS and EUC-JP: the same model, member for member."""

import pytest
from fuzzing import run
from seeds import cases
from texts import TextsTarget


@pytest.mark.nightly
def test_texts() -> None:
    numbers = cases(240, always=40)
    report = run(TextsTarget, numbers)
    assert not report.failures, report.failures[0].detail
    assert report.labels["guessed sjis"] > len(numbers) * 220 / 240
    assert report.labels["guessed euc"] > len(numbers) * 220 / 240
