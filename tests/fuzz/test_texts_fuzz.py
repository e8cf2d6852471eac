"""Definitions in UTF-8, Shift_JIS and EUC-JP: the same model, member for member."""

from fuzzing import run
from seeds import budget, cases
from texts import TextsTarget


def test_texts() -> None:
    report = run(TextsTarget, cases(240))
    assert not report.failures, report.failures[0].detail
    assert report.labels["guessed sjis"] > budget(220)
    assert report.labels["guessed euc"] > budget(220)
