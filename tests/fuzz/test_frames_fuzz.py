"""Stations of a CANopen bus take any frames."""

from frames import BusTarget, NodeTarget
from fuzzing import run


def test_a_slave() -> None:
    report = run(NodeTarget, range(700))
    assert not report.failures, report.failures[0].detail
    assert len(report.labels) == 4


def test_a_bus() -> None:
    report = run(BusTarget, range(6))
    assert not report.failures, report.failures[0].detail
    assert report.labels["sdo"] == report.labels["heartbeat"] == 6
