"""The EDS front end with any input: a device or coded findings, in bounded time."""

from pathlib import Path

import pytest
from eds import ComponentsTarget, EdsTarget
from fuzzing import run
from seeds import cases


def test_device_descriptions() -> None:
    numbers = cases(300, always=300)
    report = run(EdsTarget, numbers)
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"] > len(numbers) * 80 / 300
    assert report.labels["errors"] > len(numbers) / 3
    assert len(report.labels) > 45


@pytest.mark.nightly
def test_components() -> None:
    report = run(ComponentsTarget, cases(12, always=12))
    assert not report.failures, report.failures[0].detail
    assert report.labels["made"]


def test_random_octets(tmp_path: Path) -> None:
    target = EdsTarget(tmp_path)
    for data in (b"", b"\n", b"[", b"=", b"\xff\xfe", b"[1000]", bytes(range(1, 256))):
        for number in range(6):
            list(target.check(number, data))
