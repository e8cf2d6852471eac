"""The reader of profiles with any input; profiles without errors can be generated."""

import pytest
from fuzzing import run
from profiles import ProfileTarget
from seeds import cases


@pytest.mark.nightly
def test_profiles() -> None:
    numbers = cases(300, always=300)
    report = run(ProfileTarget, numbers)
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"] > len(numbers) / 5
    assert report.labels["errors"] > len(numbers) / 5
    assert report.labels["system"] > 2
    assert len(report.labels) > 24
