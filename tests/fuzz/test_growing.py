"""Short definitions with large effects are read within the limits, or refused with a position."""

from functools import partial

import pytest
from fuzzing import run
from growing import CASES, GrowthTarget

ONCE_ENDLESS = {
    *(("structs that double", 60, word) for word in ("openrtm", "small")),
    *(("diamonds of interfaces", 60, word) for word in ("lint", "a.idl")),
    *(("diamonds of value types", 60, word) for word in ("lint", "a.idl")),
    *(("chain of structs", 5000, word) for word in ("openrtm", "rtc-xml")),
    *(("chain of components", 3000, word) for word in ("inspect", "lint")),
    *(("cdl structs that double", 60, word) for word in ("inspect", "openrtm")),
    ("c structs that double", 60, "openrtm"),
    ("cdl chain of structs", 1000, "openrtm"),
    ("cdl arrays that multiply", 20, "openrtm"),
    ("composites that double", 40, "openrtm"),
    ("chain of composites", 3000, "openrtm"),
    ("arrays of ports", 1_000_000_000, "inspect"),
    ("open arrays of ports", 1_000_000_000, "inspect"),
    ("compact sub objects", 16000, "generate"),
    ("dotted keys", 100_000, "inspect"),
    ("many dotted keys", 3000, "inspect"),
    ("project file with dotted keys", 20000, "inspect"),
    ("system at random", 400, "graph"),
    ("hexadecimal numbers", 20000, "adopt"),
    ("chain of attributes", 2000, "adopt"),
    ("chain of sums", 2000, "adopt"),
    ("odd encodings", 1, "adopt"),
}
"""Former defects by kind, size and command: hours, gigabytes, or an internal error."""


@pytest.mark.nightly
def test_growing() -> None:
    chosen = [
        case
        for case in CASES
        if any((*case[:2], word) in ONCE_ENDLESS for word in case[2])
    ]
    assert len(chosen) >= len(ONCE_ENDLESS)
    report = run(partial(GrowthTarget, cases=chosen), range(len(chosen)))
    assert not report.failures, report.failures[0].detail
