"""Drives a component through a row of docs/life-cycle.md; also for MicroPython, so untyped.

As a program it reads rows from `given.txt`, a line of JSON each, and prints what came of them.
"""

import json

from rtgen.small_runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_ERROR,
    RTC_OK,
    SECOND,
    Component,
    System,
)

STATES = {"INACTIVE": INACTIVE_STATE, "ACTIVE": ACTIVE_STATE, "ERROR": ERROR_STATE}
CALLBACKS = [name for name in dir(Component) if name.startswith("on_")]
FAILURES = {
    "RTC_ERROR": RTC_ERROR,
    "None": None,
    "False": False,
    "ValueError": ValueError("no"),
}
"""What a failing callback returns, or raises."""


class Probe(Component):
    """Records each callback; lets one of them fail."""

    def __init__(self):
        super().__init__("probe")
        self.calls = []
        self.failing = ""
        self.failure = RTC_ERROR


def noting(name):
    """Return a callback of this name."""

    def callback(self, *handle):
        assert handle in ((), (0,))
        self.calls.append(name)
        if name != self.failing:
            return RTC_OK
        if isinstance(self.failure, Exception):
            raise self.failure
        return self.failure

    return callback


for _name in CALLBACKS:
    setattr(Probe, _name, noting(_name))


def tick(system):
    """Let one tick pass."""
    system.run(system.time + SECOND // 100)


def prepared(state):
    """Return a component in a state, and its system."""
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


def drive(state, request, failing, failure):
    """Return the answer to a request, the callbacks in order, and the number of the new state."""
    probe, system = prepared(state)
    probe.failing, probe.failure = failing, FAILURES[failure]
    answer = None
    if request == "tick":
        tick(system)
    elif request == "exit":
        system.close()
    else:
        answer = getattr(system, request)(probe)
        assert probe.calls == []
        tick(system)
    return [answer, probe.calls, system.state(probe)]


if __name__ == "__main__":
    with open("given.txt") as rows:  # noqa: PTH123 (MicroPython has no pathlib)
        for row in rows:
            print(json.dumps(drive(*json.loads(row))))
