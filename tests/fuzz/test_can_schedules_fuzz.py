"""No schedule on a CAN bus makes a message later than computed.

`make fuzz` and `python tests/fuzz/can_schedules.py 10000` try more of them.
"""

import pytest
from can_schedules import ScheduleTarget
from fuzzing import run
from msgspec.structs import replace
from seeds import cases

from rtgen.compiler.layouts.can_timing import Message


@pytest.mark.nightly
def test_schedules() -> None:
    report = run(ScheduleTarget, cases(200, always=40))
    assert not report.failures, report.failures[0].detail
    assert report.labels["bound"] > 100
    assert report.labels["nearly reached"] > 6


class Unaware(ScheduleTarget):
    """An analysis that leaves something out."""

    field = ""

    def known(self, message: Message) -> Message:
        return replace(message, **{self.field: type(getattr(message, self.field))()})


class UnawareOfQueues(Unaware):
    field = "queue"


class UnawareOfTriggers(Unaware):
    field = "trigger"


class UnawareOfJitter(Unaware):
    field = "jitter"


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "unaware", [UnawareOfQueues, UnawareOfTriggers, UnawareOfJitter]
)
def test_the_schedules_find_what_an_analysis_leaves_out(unaware: type[Unaware]) -> None:
    report = run(unaware, range(40))
    assert any("computed" in failure.title for failure in report.failures)
