"""No text of a definition becomes code, for any input language and target."""

from functools import partial

import pytest
from fuzzing import run
from hostile import ConversionsTarget, HostileTarget
from hostile_names import NamesTarget
from seeds import cases


@pytest.mark.nightly
def test_hostile_definitions() -> None:
    report = run(partial(HostileTarget, count=2), cases(20, always=24))
    assert not report.failures, report.failures[0].detail
    assert report.labels["made"] >= 20


@pytest.mark.nightly
def test_hostile_names() -> None:
    report = run(NamesTarget, cases(18, always=6))
    assert not report.failures, report.failures[0].detail
    assert report.labels["made"] >= 5


@pytest.mark.nightly
def test_hostile_systems_modules_and_profiles() -> None:
    report = run(ConversionsTarget, cases(40, always=6))
    assert not report.failures, report.failures[0].detail
    assert report.labels["made"] >= 5
