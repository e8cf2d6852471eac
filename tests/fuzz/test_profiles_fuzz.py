"""The reader of profiles takes anything; what it reads without errors can be generated."""

from fuzzing import run
from profiles import ProfileTarget


def test_profiles() -> None:
    report = run(ProfileTarget, range(1000))
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"] > 200
    assert report.labels["errors"] > 30
    assert report.labels["system"] > 20
    assert len(report.labels) > 30
