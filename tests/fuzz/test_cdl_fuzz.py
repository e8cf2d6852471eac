"""The CDL front end with any input: units of the model and coded findings, in bounded time."""

from pathlib import Path

import pytest
from cdl import CdlTarget
from fuzzing import run
from seeds import cases


@pytest.mark.nightly
def test_definitions() -> None:
    numbers = cases(200, always=200)
    report = run(CdlTarget, numbers)
    assert not report.failures, report.failures[0].detail
    assert report.labels["read"]
    assert report.labels["errors"] > len(numbers) / 2
    assert len(report.labels) > 50


def test_random_octets(tmp_path: Path) -> None:
    target = CdlTarget(tmp_path)
    for data in (b"", b"\n", b"[", b"=", b"\xff\xfe", b'"', b"<", bytes(range(1, 256))):
        for number in range(6):
            list(target.check(number, data))
