"""What a run has activated it deactivates, at every kind of end."""

from __future__ import annotations

import os
import re
import signal

import cpp_build
import pytest
from devices import Processes, instants
from logged_process import LoggedProcess
from watching_page import Page

pytestmark = [*cpp_build.needed, pytest.mark.waits]


def both(processes: Processes, *options: str) -> tuple[LoggedProcess, LoggedProcess]:
    return processes.device("Base0", *options), processes.device("Arm0", *options)


def begun(processes: Processes, *arguments: str) -> LoggedProcess:
    """Start a run, and wait until its last component is ACTIVE."""
    run = processes.run(*arguments)
    run.says("Pilot0 ACTIVE")
    return run


def test_the_order_is_the_reverse_of_that_of_the_activation(
    processes: Processes,
) -> None:
    base, arm = both(processes)
    run = processes.run("--until", "0.5")
    assert run.code() == 0
    first, second, third = (
        instants(arm.text, "deactivated"),
        instants(run.text, "pilot deactivated"),
        instants(base.text, "deactivated"),
    )
    assert first < second < third, run.text
    assert [*map(len, (first, second, third))] == [1, 1, 1]


def are_released(*found: LoggedProcess) -> bool:
    """Return whether each device has been activated and deactivated equally often."""
    counts = [
        (
            len(instants(each.text, "\nactivated")),
            len(instants(each.text, "deactivated")),
        )
        for each in found
    ]
    return all(one == other > 0 for one, other in counts)


SIGNALS = pytest.mark.parametrize(
    "number",
    [
        signal.SIGTERM,
        pytest.param(signal.SIGINT, marks=pytest.mark.nightly),
        pytest.param(signal.SIGHUP, marks=pytest.mark.nightly),
    ],
)


@pytest.mark.sampled(1)
@SIGNALS
def test_a_signal(processes: Processes, number: signal.Signals) -> None:
    found = both(processes)
    run = begun(processes)
    assert run.end(number) == 0, run.text
    assert are_released(*found)


@pytest.mark.parametrize("fault", ["raise", "end", "exit"])
def test_a_failure_of_a_component(processes: Processes, fault: str) -> None:
    found = both(processes)
    run = begun(processes, "--set", f"Pilot0.fault={fault}", "--until", "1")
    assert run.code() != 0, run.text
    assert are_released(*found)


def test_a_component_that_does_not_let_the_run_end(processes: Processes) -> None:
    base, arm = both(processes)
    run = begun(processes, "--set", "Pilot0.fault=hang")
    base.says("\nactivated")
    run.process.send_signal(signal.SIGTERM)
    base.says("deactivated")
    assert run.code() == 1
    assert "does not end when interrupted; rtgen ends" in run.text
    assert are_released(base, arm)


def test_an_error_of_rtgen_itself(processes: Processes) -> None:
    found = both(processes)
    run = begun(processes, "--log", "/dev/full")
    assert run.code() == 3, run.text
    assert are_released(*found)


def test_a_device_that_refuses_to_become_active(processes: Processes) -> None:
    base = processes.device("Base0")
    processes.device("Arm0", "refuses=1")
    run = processes.run("--until", "1")
    assert run.code() == 3
    assert "Arm0: it refuses to become active: UNSUPPORTED" in run.text
    assert are_released(base)


def test_a_device_that_was_active_before_remains_so(processes: Processes) -> None:
    base, arm = both(processes)
    first = begun(processes)
    base.says("\nactivated")
    arm.says("\nactivated")
    assert processes.run("--until", "0.5").code() in (0, 3)
    assert "deactivated" not in base.text + arm.text
    assert first.end() == 0
    assert are_released(base, arm)


def test_a_device_that_is_slow(processes: Processes) -> None:
    found = both(processes, "delay=800")
    run = processes.run("--until", "0.1")
    assert run.code() == 0, run.text
    assert are_released(*found)
    assert "still ACTIVE" not in run.text


def test_a_device_that_is_frozen(processes: Processes) -> None:
    base, arm = both(processes)
    run = begun(processes, "--call-timeout", "0.5")
    arm.says("\nactivated")
    arm.process.send_signal(signal.SIGSTOP)
    assert run.end() == 0, run.text
    assert "warning[SYS0024]: Arm0 is not deactivated: it does not answer" in run.text
    assert are_released(base)
    arm.process.send_signal(signal.SIGCONT)
    arm.says("deactivated")


def test_a_page_that_is_closed(processes: Processes, naming_service: str) -> None:
    base, arm = both(processes)
    page = Page(naming_service)
    try:
        first, second = page.found("/Base0").instance, page.found("/Arm0").instance
        page.done("activated", [first])
        page.done("activated", [second])
        page.done("deactivated", [second])
        base.says("\nactivated")
        assert "deactivated" not in base.text
    finally:
        page.session.close()
    assert are_released(base, arm)


@pytest.mark.sampled(1)
@SIGNALS
def test_rtgen_ui_ends_its_system_at_a_signal(
    processes: Processes, number: signal.Signals
) -> None:
    ui = processes.rtgen("ui", "system.xml", "--clock", "real", "--no-open")
    ui.says("pilot activated")
    ui.end(number)
    assert "pilot deactivated" in ui.text


def test_a_process_that_is_killed_under_supervision(processes: Processes) -> None:
    found = base, _ = both(processes)
    run = processes.run("--supervise", "on-failure", "--call-timeout", "1")
    base.says("\nactivated")
    child = re.compile(r"pilot activated at [0-9.]+ in process (\d+)")
    run.wait_for(lambda: child.search(run.text))
    killed = child.search(run.text)
    assert killed is not None
    os.kill(int(killed.group(1)), signal.SIGKILL)
    base.says("deactivated")
    run.says("Base0 is deactivated: Pilot0 had activated it")
    base.says("\nactivated", 2)
    assert run.end() == 0, run.text
    assert are_released(*found)
