"""Components in C++ with connectors to processes that were killed, which they have not noticed."""

from __future__ import annotations

import signal
from collections.abc import Callable

import cpp_build
import pytest
from devices import Processes
from logged_process import LoggedProcess
from watching_page import Page

pytestmark = [*cpp_build.needed, pytest.mark.waits]

DEFINITION = """\
#include "BasicDataType.idl"
@rtc(category="lab", vendor="lab", rate=50.0)
component Device {
    consumes RTC::TimedDoubleSeq command;
    publishes RTC::TimedDoubleSeq measured;
};
"""


def _run(processes: Processes) -> LoggedProcess:
    run = processes.run()
    run.says("Pilot0 ACTIVE")
    return run


def _next_run(processes: Processes) -> None:
    assert processes.run("--until", "0.3").code() == 0


def _page(processes: Processes) -> None:
    page = Page(processes.names)
    try:
        assert not page.found("/Base0").silent
    finally:
        page.session.close()


def _conformance(processes: Processes) -> None:
    (processes.folder / "device.idl").write_text(DEFINITION)
    place = f"{processes.names}/Base0.rtc"
    include = ["-I", processes.types]
    made = processes.rtgen("conformance", "device.idl", "--connect", place, *include)
    made.says("ports.references")
    made.code()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("read", [_next_run, _page, _conformance])
def test_reading_a_component_does_not_crash_it(
    processes: Processes, read: Callable[[Processes], None]
) -> None:
    found = processes.device("Base0"), processes.device("Arm0")
    _run(processes).end(signal.SIGKILL)
    read(processes)
    assert all(each.runs for each in found), [each.text for each in found]
