"""Stations of a CANopen bus with any frames."""

import pytest
from frames import BusTarget, NodeTarget
from fuzzing import run
from seeds import budget, cases


@pytest.mark.nightly
def test_a_slave() -> None:
    report = run(NodeTarget, cases(200, always=40))
    assert not report.failures, report.failures[0].detail
    assert len(report.labels) == 4


def test_a_bus() -> None:
    report = run(BusTarget, cases(4))
    assert not report.failures, report.failures[0].detail
    assert report.labels["sdo"] == report.labels["heartbeat"] == budget(4)
