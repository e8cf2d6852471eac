"""The callbacks of a component (OMG RTC 1.0, 5.2.2.4 ComponentAction, and data-flow actions)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rtgen.facts.activities import EVENT_DRIVEN


@dataclass(frozen=True, slots=True)
class Action:
    """A callback: its element in an RtcProfile, its method, and when it is called.

    `implemented`: skeletons contain the method; `parameters` are those after `self`, in Python.
    """

    element: str
    method: str
    description: str
    implemented: bool = False
    parameters: str = ", ec_id: int"


ACTIONS = (
    Action(
        "OnInitialize", "on_initialize", "Called once, when it is created.", True, ""
    ),
    Action(
        "OnFinalize", "on_finalize", "Called once, before it is destroyed.", False, ""
    ),
    Action("OnStartup", "on_startup", "Called when its execution context starts."),
    Action("OnShutdown", "on_shutdown", "Called when its execution context stops."),
    Action("OnActivated", "on_activated", "Called when it is activated.", True),
    Action("OnDeactivated", "on_deactivated", "Called when it is deactivated.", True),
    Action("OnAborting", "on_aborting", "Called when it enters the error state."),
    Action("OnError", "on_error", "Called in every cycle of the error state."),
    Action("OnReset", "on_reset", "Called when it is reset out of the error state."),
    Action(
        "OnExecute", "on_execute", "Called in every cycle while it is active.", True
    ),
    Action(
        "OnStateUpdate", "on_state_update", "Called in every cycle, after on_execute."
    ),
    Action("OnRateChanged", "on_rate_changed", "Called when the rate has changed."),
)
"""All callbacks, in the order of the profile's schema (RtcProfile 0.3, `rtc:Actions`)."""


def skeleton_actions(activity: str) -> list[Action]:
    """Return the callbacks that the skeleton of a component contains."""
    actions = [action for action in ACTIONS if action.implemented]
    if activity != EVENT_DRIVEN:
        return actions
    by_samples = "Called when samples have arrived while it is active."
    return [
        (
            replace(action, description=by_samples)
            if action.method == "on_execute"
            else action
        )
        for action in actions
    ]
