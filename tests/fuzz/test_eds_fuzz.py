"""The EDS front end takes anything: a device or coded findings, in bounded time."""

from pathlib import Path

from eds import ComponentsTarget, EdsTarget
from fuzzing import run


def test_device_descriptions() -> None:
    report = run(EdsTarget, range(1000))
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"] > 300
    assert report.labels["errors"] > 30
    assert len(report.labels) > 60


def test_components() -> None:
    report = run(ComponentsTarget, range(20))
    assert not report.failures, report.failures[0].detail
    assert report.labels["made"] > 5


def test_random_octets(tmp_path: Path) -> None:
    target = EdsTarget(tmp_path)
    for data in (b"", b"\n", b"[", b"=", b"\xff\xfe", b"[1000]", bytes(range(1, 256))):
        for number in range(6):
            list(target.check(number, data))
