"""Drives the rows of the table in docs/life-cycle.md that the small runtime has."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from life_cycle_driver import CALLBACKS, FAILURES, STATES, Probe, drive
from life_cycle_rows import Row, read_table
from micropython import micropython

from rtgen import runtime, small_runtime
from rtgen.small_runtime import CREATED_STATE, PRECONDITION_NOT_MET, RTC_OK, System

DRIVER = Path(__file__).with_name("life_cycle_driver.py")
ALL_STATES = {"CREATED": CREATED_STATE, **STATES}
ANSWERS = {"RTC_OK": RTC_OK, "PRECONDITION_NOT_MET": PRECONDITION_NOT_MET, "-": None}
REQUESTS = ("activate", "deactivate", "reset")
ROWS = [
    row
    for row in read_table()
    if row.state in ("INACTIVE", "ACTIVE", "ERROR")
    and row.request in (*REQUESTS, "tick", "exit")
    and row.fails != "gate"
]
TICKS = {
    row.state: row.callbacks for row in ROWS if row.request == "tick" and not row.fails
}


def result_of(row: Row) -> list[Any]:
    """Return what a row says: the answer, the callbacks, and the number of the new state."""
    answer, callbacks = None, list(row.callbacks)
    if row.request in REQUESTS:
        answer = ANSWERS[row.answer]
        entered_error = row.new_state == "ERROR" and row.state != "ERROR"
        callbacks += [] if entered_error else TICKS[row.new_state]
    return [answer, callbacks, ALL_STATES[row.new_state]]


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("row", ROWS, ids=str)
def test_row(row: Row, failure: str) -> None:
    assert drive(row.state, row.request, row.fails, failure) == result_of(row)


def test_rows_on_micropython(tmp_path: Path) -> None:
    assert small_runtime.__file__
    source = Path(small_runtime.__file__).parent
    shutil.copytree(source, tmp_path / "rtgen" / "small_runtime")
    driven = [(row, failure) for row in ROWS for failure in FAILURES]
    given = "".join(
        f"{json.dumps([row.state, row.request, row.fails, failure])}\n"
        for row, failure in driven
    )
    results = micropython(DRIVER.read_text("utf-8"), tmp_path, given).splitlines()
    assert [*map(json.loads, results)] == [result_of(row) for row, _ in driven]


def test_rows_are_of_every_kind() -> None:
    assert {(row.state, row.request) for row in ROWS} == {
        (state, request)
        for state in ("INACTIVE", "ACTIVE", "ERROR")
        for request in (*REQUESTS, "tick", "exit")
    }


def test_all_callbacks_but_that_of_the_rate_are_there() -> None:
    embedded = {name for name in vars(runtime.Component) if name.startswith("on_")}
    assert embedded - {"on_rate_changed"} == set(CALLBACKS)


def test_the_component_added_last_goes_first() -> None:
    system = System()
    first, second = Probe(), Probe()
    gone: list[Probe] = []
    for probe in (first, second):
        probe.on_finalize = lambda probe=probe: gone.append(probe)  # type: ignore[method-assign,misc]
        system.add(probe)
    system.close()
    assert gone == [second, first]
