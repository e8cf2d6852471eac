"""The reader of profiles with any input; profiles without errors can be generated."""

from fuzzing import run
from profiles import ProfileTarget
from seeds import budget, cases


def test_profiles() -> None:
    report = run(ProfileTarget, cases(300))
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"] > budget(60)
    assert report.labels["errors"] > budget(60)
    assert report.labels["system"] > 2
    assert len(report.labels) > 24
