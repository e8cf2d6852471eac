"""`rtgen conformance` of components in C++, which behave as those of OpenRTM-aist 2.1.0."""

from __future__ import annotations

import json
from typing import Any

import cpp_build
import pytest
from devices import Processes

pytestmark = [*cpp_build.needed, pytest.mark.waits]

DEFINITION = """\
#include "BasicDataType.idl"

/** by hand in C++ */
@rtc(category="lab", vendor="lab", rate=50.0{more})
component Device {{
    consumes RTC::TimedDoubleSeq command;
    publishes RTC::TimedDoubleSeq measured;
    @default(0) @constraint("0<=x<=1000") attribute long size;
    @default(3) attribute long big;
    @default(1000000) attribute long after;
    @default("") attribute string label;
}};
"""


def outcomes_of(processes: Processes, more: str, *options: str) -> tuple[int, Any]:
    """Return the exit code and the outcomes by check."""
    (processes.folder / "device.idl").write_text(DEFINITION.format(more=more))
    place = f"{processes.names}/Base0.rtc"
    words = ["device.idl", "--connect", place, "-I", processes.types, "--json"]
    made = processes.rtgen("conformance", *words, "--actuate", *options)
    code = made.code()
    report = json.loads(made.text)
    return code, {each["check"]: each for each in report["outcomes"]}


def failed(outcomes: Any) -> dict[str, list[str]]:
    return {
        name: each["problems"]
        for name, each in outcomes.items()
        if each["verdict"] == "failed"
    }


@pytest.mark.nightly
def test_a_correct_device_passes(processes: Processes) -> None:
    processes.device("Base0")
    code, outcomes = outcomes_of(processes, "", "--defaults")
    assert failed(outcomes) == {}, json.dumps(failed(outcomes), indent=1)
    assert code == 0
    skipped = outcomes["configuration.unknown-parameters"]
    assert skipped["verdict"] == "skipped"
    assert skipped["problems"] == [
        "it has no values of single parameters, like OpenRTM"
    ]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "activity",
    [
        *(pytest.param(a, marks=pytest.mark.nightly) for a in ("PERIODIC", "SPORADIC")),
        "EVENTDRIVEN",
    ],
)
def test_an_activity_is_said(processes: Processes, activity: str) -> None:
    processes.device("Base0", f"activity={activity}")
    code, outcomes = outcomes_of(processes, f', activity="{activity}"')
    assert (code, failed(outcomes)) == (0, {})


def test_an_activity_that_is_not_said(processes: Processes) -> None:
    processes.device("Base0", "activity=SPORADIC")
    code, outcomes = outcomes_of(processes, "")
    assert code == 1
    assert failed(outcomes) == {
        "profile.properties": [
            "activity_type is 'SPORADIC', not 'PERIODIC'; @rtc(activity=\"SPORADIC\") says so"
        ]
    }


@pytest.mark.parametrize("activity", ["STATIC", "DataFlowComponent"])
def test_the_type_or_kind_as_activity(processes: Processes, activity: str) -> None:
    processes.device("Base0", f"activity={activity}")
    code, outcomes = outcomes_of(processes, "")
    assert (code, failed(outcomes)) == (0, {})


@pytest.mark.sampled(1)
@pytest.mark.parametrize("activity", ["DataFlowComponent", "My own: kind"])
def test_the_registered_text_is_said(processes: Processes, activity: str) -> None:
    processes.device("Base0", f"activity={activity}")
    code, outcomes = outcomes_of(processes, f', activity_type="{activity}"')
    assert (code, failed(outcomes)) == (0, {})
    code, outcomes = outcomes_of(processes, ', activity_type="STATIC"')
    assert code == 1
    assert failed(outcomes) == {
        "profile.properties": [
            f"activity_type is '{activity}', not 'STATIC'; "
            f'@rtc(activity_type="{activity}") says so'
        ]
    }


def test_a_device_that_cannot_be_deactivated_in_time(processes: Processes) -> None:
    device = processes.device("Base0", "delay=8000")
    code, outcomes = outcomes_of(processes, "", "--timeout", "1")
    assert code == 1
    problems = failed(outcomes)
    assert {*problems} == {"life-cycle.activation", "left"}
    assert "activate_component returned RTC_ERROR, and leads to INACTIVE" in str(
        problems["life-cycle.activation"]
    )
    assert problems["left"] == [
        "it is INACTIVE_STATE, and activate_component may take effect later"
    ]
    device.says("activated")


@pytest.mark.nightly
def test_a_device_that_was_active_and_is_deactivated_later(
    processes: Processes,
) -> None:
    device = processes.device("Base0", "delay=8000")
    run = processes.run("--wait", "60")
    processes.device("Arm0")
    device.says("\nactivated")
    code, outcomes = outcomes_of(processes, "", "--timeout", "1")
    assert code == 1
    problems = failed(outcomes)
    assert problems["life-cycle.activation"] == [
        "deactivate_component returned RTC_ERROR, and leads to ACTIVE_STATE, not to "
        "INACTIVE_STATE"
    ]
    assert problems["left"] == [
        "it is ACTIVE_STATE, and deactivate_component may take effect later"
    ]
    device.says("deactivated")
    run.end()
