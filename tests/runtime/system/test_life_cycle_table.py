"""Drives every row of the table in docs/life-cycle.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from life_cycle_rows import Row, read_table

from rtgen.runtime import (
    RTC_ERROR,
    RTC_OK,
    Component,
    ExecutionContext,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.life_cycle import TRANSITIONS, Request

CALLBACKS = [name for name in vars(Component) if name.startswith("on_")]
REQUESTS_OF_THE_NEXT_TICK = {"activate", "deactivate", "reset", "set_rate", "fail"}
NOT_IN_A_CONTEXT = {"exit", "add_component", "remove_component"}
ROWS = read_table()
TICKS = {
    row.state: row.callbacks for row in ROWS if row.request == "tick" and not row.fails
}


class Probe(Component):
    """Records each callback; lets one of them fail in a given way."""

    def __init__(self) -> None:
        super().__init__("probe")
        self.calls: list[str] = []
        self.handles: set[tuple[int, ...]] = set()
        self.failing = ""
        self.fail_by: Callable[[], Any] = lambda: RTC_ERROR
        self.closed = False

    def _gate(self, request: Request) -> Any:
        if self.closed:
            return None
        return self.fail_by() if self.failing == "gate" else RTC_OK


def noting(name: str) -> Callable[..., Any]:
    def callback(self: Probe, *handle: int) -> Any:
        self.calls.append(name)
        if handle:
            self.handles.add(handle)
        return self.fail_by() if name == self.failing else RTC_OK

    return callback


for _name in CALLBACKS:
    setattr(Probe, _name, noting(_name))


def raise_error() -> None:
    raise ValueError("on purpose")


WAYS_TO_FAIL = {
    "returns RTC_ERROR": lambda: RTC_ERROR,
    "returns BAD_PARAMETER": lambda: ReturnCode_t.BAD_PARAMETER,
    "returns None": lambda: None,
    "returns False": lambda: False,
    "raises": raise_error,
}


def prepared(state: str) -> tuple[Probe, ExecutionContext]:
    probe = Probe()
    context = ExecutionContext(100.0, owner=probe)
    context.start()
    if state != "CREATED":
        assert probe.initialize() is RTC_OK
    if state in {"INACTIVE", "ACTIVE", "ERROR"}:
        assert context.add_component(probe) is RTC_OK
    if state == "ACTIVE":
        assert context.activate_component(probe) is RTC_OK
        context.tick()
    if state == "ERROR":
        probe.failing = "on_activated"
        context.activate_component(probe)
        context.tick()
        probe.failing = ""
    assert state_of(probe, context) == state
    return probe, context


def name_of(state: LifeCycleState) -> str:
    return state.name.removesuffix("_STATE")


def state_of(probe: Probe, context: ExecutionContext) -> str:
    if probe.is_alive(context):
        return name_of(context.get_component_state(probe))
    assert context.get_component_state(probe).name == "CREATED_STATE"
    return "Alone" if probe.is_alive() else "CREATED"


def ask(probe: Probe, context: ExecutionContext, request: str) -> ReturnCode_t | None:
    name, _, circumstance = request.partition(" ")
    match name:
        case "initialize" | "finalize" | "exit":
            return getattr(probe, name)()
        case "add_component" | "remove_component":
            return getattr(context, name)(probe)
        case "activate" | "deactivate" | "reset":
            return getattr(context, f"{name}_component")(probe)
        case "fail":
            return context.fail_component(probe, "on purpose")
        case "set_rate":
            return context.set_rate(50.0 if circumstance == "(above 0)" else 0.0)
        case "start" | "stop":
            return getattr(context, name)()
        case "tick":
            context.tick()
            return None
    raise AssertionError(f"unknown request {request!r}")


def cases() -> list[Any]:
    return [
        pytest.param(row, way, id=f"{row}-{way}".replace(" ", "-"))
        for row in ROWS
        for way in (WAYS_TO_FAIL if row.fails else ["-"])
        if (row.fails, way) != ("gate", "returns None")
    ]


@pytest.mark.parametrize(("row", "way"), cases())
def test_row(row: Row, way: str) -> None:
    probe, context = prepared(row.state)
    name, _, circumstance = row.request.partition(" ")
    if circumstance == "(stopped)":
        context.stop()
    probe.closed = circumstance == "(closed)"
    probe.failing = row.fails
    probe.fail_by = WAYS_TO_FAIL.get(way, raise_error)
    probe.calls.clear()
    probe.handles.clear()

    answer = ask(probe, context, row.request)

    assert (answer.name if answer is not None else "-") == row.answer
    expected = list(row.callbacks)
    if name in REQUESTS_OF_THE_NEXT_TICK and row.answer == "RTC_OK":
        assert probe.calls == []
        context.tick()
        entered_error = row.new_state == "ERROR" and row.state != "ERROR"
        expected += [] if entered_error else TICKS[row.new_state]
    assert probe.calls == expected
    assert state_of(probe, context) == row.new_state
    assert probe.handles <= {(0,)}

    context.start()
    probe.calls.clear()
    context.tick()
    assert probe.calls == ([] if row.new_state == "CREATED" else TICKS[row.new_state])


def test_table_is_complete() -> None:
    """Every request in every state, and every callback failing somewhere it is called."""
    found = {(row.state, row.request) for row in ROWS}
    common = {"initialize", "finalize", "exit", "add_component", "remove_component"}
    common |= {"activate", "deactivate", "reset", "fail", "tick"}
    taking_part = {
        "start (stopped)",
        "start (running)",
        "stop (stopped)",
        "stop (running)",
    }
    taking_part |= {"set_rate (above 0)", "set_rate (0)"}
    expected = {
        (state, request) for state in ("CREATED", "Alone") for request in common
    }
    for state in ("INACTIVE", "ACTIVE", "ERROR"):
        expected |= {(state, request) for request in common | taking_part}
    gated = [("INACTIVE", "activate"), ("ACTIVE", "deactivate"), ("ERROR", "reset")]
    expected |= {(state, f"{request} (closed)") for state, request in gated}
    assert found == expected
    assert {row.fails for row in ROWS} - {""} == {"gate", *CALLBACKS} - {"on_aborting"}


def transitions_of_the_document() -> dict[tuple[str, str], tuple[str, str, str]]:
    """Return callback, state after success and state after failure by state and request."""
    own = {"Alone": "INACTIVE"}
    found: dict[tuple[str, str], dict[str, str]] = {}
    for row in ROWS:
        name = row.request.partition(" ")[0]
        if not row.callbacks or row.fails == "gate" or name in NOT_IN_A_CONTEXT:
            continue
        callback = "" if row.callbacks[0] == "on_aborting" else row.callbacks[0]
        if "on_state_update" in (row.fails, *row.callbacks[1:]):
            update = found.setdefault((row.state, "state_update"), {})
            update["callback"] = "on_state_update"
            update["failure" if row.fails else "success"] = row.new_state
            if row.fails:
                continue
        new = found.setdefault((own.get(row.state, row.state), name), {})
        new["callback"] = callback
        new["failure" if row.fails else "success"] = own.get(
            row.new_state, row.new_state
        )
    return {
        key: (row["callback"], row["success"], row.get("failure", row["success"]))
        for key, row in found.items()
    }


def test_the_table_of_the_runtime_is_that_of_the_document() -> None:
    assert transitions_of_the_document() == {
        (name_of(state), request.value): (
            row.callback,
            name_of(row.success),
            name_of(row.failure),
        )
        for (state, request), row in TRANSITIONS.items()
    }


@pytest.mark.parametrize("way", WAYS_TO_FAIL.values(), ids=WAYS_TO_FAIL)
def test_failing_on_aborting_stays_in_error(way: Callable[[], Any]) -> None:
    probe, context = prepared("ACTIVE")
    probe.failing, probe.fail_by = "on_aborting", way
    probe.calls.clear()
    probe.on_execute = lambda ec_id: RTC_ERROR  # type: ignore[method-assign]
    context.tick()
    context.tick()
    assert probe.calls == ["on_aborting", "on_error"]
    assert state_of(probe, context) == "ERROR"
    assert probe.reason == "on_execute: returned RTC_ERROR"
