"""Drives the rows of the table in docs/life-cycle.md that the small runtime has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from life_cycle_rows import Row, read_table

from rtgen import runtime
from rtgen.small_runtime import (
    ACTIVE_STATE,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    SECOND,
    Component,
    System,
)

STATES = {
    "CREATED": CREATED_STATE,
    "INACTIVE": INACTIVE_STATE,
    "ACTIVE": ACTIVE_STATE,
    "ERROR": ERROR_STATE,
}
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
CALLBACKS = [name for name in vars(Component) if name.startswith("on_")]


class Probe(Component):
    """Records each callback; lets one of them fail."""

    def __init__(self) -> None:
        super().__init__("probe")
        self.calls: list[str] = []
        self.failing = ""
        self.answer: object = RTC_ERROR


def noting(name: str) -> Callable[..., Any]:
    def callback(self: Probe, *handle: int) -> object:
        assert handle in ((), (0,))
        self.calls.append(name)
        if name != self.failing:
            return RTC_OK
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer

    return callback


for _name in CALLBACKS:
    setattr(Probe, _name, noting(_name))


def tick(system: System) -> None:
    system.run(system.time + SECOND // 100)


def prepared(state: str) -> tuple[Probe, System]:
    probe, system = Probe(), System()
    system.add(probe, 100.0)
    assert probe.calls == ["on_initialize", "on_startup"]
    if state != "INACTIVE":
        probe.failing = "on_activated" if state == "ERROR" else ""
        assert system.activate(probe) == RTC_OK
        tick(system)
        probe.failing = ""
    assert system.state(probe) == STATES[state]
    probe.calls.clear()
    return probe, system


@pytest.mark.parametrize("answer", [RTC_ERROR, None, False, ValueError("no")], ids=repr)
@pytest.mark.parametrize("row", ROWS, ids=str)
def test_row(row: Row, answer: object) -> None:
    probe, system = prepared(row.state)
    probe.failing, probe.answer = row.fails, answer
    if row.request == "tick":
        tick(system)
    elif row.request == "exit":
        system.close()
    else:
        assert getattr(system, row.request)(probe) == ANSWERS[row.answer]
        assert probe.calls == []
        tick(system)
    expected = list(row.callbacks)
    if row.request in REQUESTS:
        entered_error = row.new_state == "ERROR" and row.state != "ERROR"
        expected += [] if entered_error else TICKS[row.new_state]
    assert probe.calls == expected
    assert system.state(probe) == STATES[row.new_state]


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
