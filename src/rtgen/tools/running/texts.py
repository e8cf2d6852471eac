"""Texts of states and durations in reports of runs."""

from __future__ import annotations

import json
from typing import Final

from rtgen.compiler.systems.timeline import (
    Call,
    Connect,
    Disconnect,
    SetParameter,
    StateRequest,
    Step,
)
from rtgen.runtime import LifeCycleState
from rtgen.runtime.distribution.local_runs import Planned
from rtgen.runtime.system.json_calls import Outcome

ERROR: Final = "ERROR"
FINISHED: Final = "finished"
"""What reports call ERROR where it is the end of a component's work."""
_UNITS: Final = (("s", 10**9), ("ms", 10**6), ("us", 10**3))


def name_of(state: LifeCycleState) -> str:
    """Return the name of a state in reports and conditions."""
    return state.name.removesuffix("_STATE")


def planned(step: Step) -> Planned:
    """Describe an event of the timeline."""
    match step.action:
        case Disconnect(name):
            return Planned(step.time, "disconnect", name)
        case Connect(name, source, target):
            ends = (source.instance, source.port), (target.instance, target.port)
            return Planned(step.time, "connect", f"{source} to {target}", *ends)
        case SetParameter(instance, parameter, text):
            return Planned(step.time, "set", f"{instance}.{parameter} = {text}")
        case StateRequest(request, instance):
            return Planned(step.time, request, instance)
        case Call(text=call):
            return Planned(step.time, "call", call.text)


def outcome_text(outcome: Outcome) -> str:
    """Return what follows the text of a call: the results, or the exception."""
    if outcome.exception:
        return f" raises {outcome.exception}: {outcome.message}".removesuffix(": ")
    values = [] if outcome.result is None else [value_text(outcome.result)]
    values += (f"{name} = {value_text(value)}" for name, value in outcome.out.items())
    return f" -> {', '.join(values)}" if values else ""


def outcome_json(outcome: Outcome) -> dict[str, object]:
    """Return an outcome for --json: `result` and `out`, or the exception."""
    if outcome.exception:
        raised = {"name": outcome.exception, "message": outcome.message}
        return {"exception": raised | {"members": outcome.members}}
    return {"result": outcome.result, "out": outcome.out}


def value_text(value: object) -> str:
    """Return a value of a call as JSON."""
    return json.dumps(value, ensure_ascii=False)


def duration(time: int) -> str:
    """Return a duration, given in ns, as people write it: `3.02 s`, `20 ms`, `85 us`."""
    for unit, size in _UNITS:
        value = float(f"{time / size:.3g}")
        if value >= 1.0:
            return f"{value:.10g} {unit}"
    return f"{time} ns"
