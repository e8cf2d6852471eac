"""The life cycle of a component as that of a managed node (lifecycle_msgs, rclcpp_lifecycle).

Components are configured before they are visible, and end with their run, so the requests
`configure`, `cleanup` and `shutdown` of managed nodes do not exist.
"""

from __future__ import annotations

from concurrent.futures import Future, InvalidStateError
from concurrent.futures import TimeoutError as FutureTimeoutError
from contextlib import suppress
from typing import Any, Final, NamedTuple, TypeAlias

from rtgen.runtime.failures import log
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_OK,
    LifeCycleState,
)
from rtgen.runtime.system.records import StateRecord
from rtgen.runtime.system.system import System

Members: TypeAlias = dict[str, Any]
"""Members of a message by name; others are zero."""


class Transition(NamedTuple):
    """A transition of lifecycle_msgs; `request` is a system's request, empty without one."""

    id: int
    label: str
    start: LifeCycleState
    goal: LifeCycleState
    request: str = ""


STATES: Final = {
    INACTIVE_STATE: (2, "inactive"),
    ACTIVE_STATE: (3, "active"),
    ERROR_STATE: (15, "errorprocessing"),
    CREATED_STATE: (4, "finalized"),
}
"""Id and label of lifecycle_msgs/msg/State. A component that is CREATED again has exited."""
TRANSITIONS: Final = (
    Transition(3, "activate", INACTIVE_STATE, ACTIVE_STATE, "activate"),
    Transition(4, "deactivate", ACTIVE_STATE, INACTIVE_STATE, "deactivate"),
    Transition(60, "reset", ERROR_STATE, INACTIVE_STATE, "reset"),
    Transition(32, "transition_error", INACTIVE_STATE, ERROR_STATE),
    Transition(99, "transition_error", ACTIVE_STATE, ERROR_STATE),
    Transition(6, "shutdown", INACTIVE_STATE, CREATED_STATE),
    Transition(7, "shutdown", ACTIVE_STATE, CREATED_STATE),
    Transition(61, "transition_failure", ERROR_STATE, CREATED_STATE),
)
"""All changes of state; ids are those of lifecycle_msgs/msg/Transition."""
_BY_STATES: Final = {(each.start, each.goal): each for each in TRANSITIONS}

SERVICES: Final = {
    "get_state": "GetState",
    "change_state": "ChangeState",
    "get_available_states": "GetAvailableStates",
    "get_available_transitions": "GetAvailableTransitions",
    "get_transition_graph": "GetAvailableTransitions",
}
"""Types of lifecycle_msgs/srv by names of services, which are methods of `LifeCycle`."""


class LifeCycle:
    """Implements a component's life-cycle services; `patience` [s] limits a transition."""

    def __init__(self, system: System, instance: str, patience: float) -> None:
        self._system = system
        self._instance = instance
        self._patience = patience
        self._changes: list[Future[LifeCycleState | None]] = []
        self._closed = False

    def get_state(self, request: Any) -> Members:
        """Return the current state."""
        return {"current_state": _state(self._state)}

    def change_state(self, request: Any) -> Members:
        """Request a transition, and wait for it; unsuccessful if it is impossible."""
        return {"success": self._change(request.transition)}

    def get_available_states(self, request: Any) -> Members:
        """Return all states that a component can have."""
        return {"available_states": [_state(state) for state in STATES]}

    def get_available_transitions(self, request: Any) -> Members:
        """Return the transitions that can be requested now."""
        state = self._state
        found = [each for each in TRANSITIONS if each.start is state and each.request]
        return {"available_transitions": [_described(each) for each in found]}

    def get_transition_graph(self, request: Any) -> Members:
        """Return all transitions."""
        return {"available_transitions": [_described(each) for each in TRANSITIONS]}

    def changed(self, record: StateRecord) -> Members | None:
        """Record a change of state; return the members of its TransitionEvent."""
        self._end_waiting(record.after)
        transition = _BY_STATES.get((record.before, record.after))
        if transition is None:
            return None
        return {"timestamp": self._system.clock.now(), **_described(transition)}

    def close(self) -> None:
        """End waiting requests without success."""
        self._closed = True
        self._end_waiting(None)

    def _end_waiting(self, state: LifeCycleState | None) -> None:
        for change in list(self._changes):
            # The end of a run, in another thread, may be first.
            with suppress(InvalidStateError):
                change.set_result(state)

    @property
    def _state(self) -> LifeCycleState:
        return self._system.state(self._instance)

    def _change(self, wanted: Any) -> bool:
        state = self._state
        for transition in TRANSITIONS:
            # As in rclcpp, a label takes precedence over the id.
            is_meant = (
                transition.label == wanted.label
                if wanted.label
                else transition.id == wanted.id
            )
            if transition.request and transition.start is state and is_meant:
                return self._make_transition(transition)
        return False

    def _make_transition(self, transition: Transition) -> bool:
        change: Future[LifeCycleState | None] = Future()
        self._changes.append(change)
        try:
            request = getattr(self._system, transition.request)
            if self._closed or request(self._instance) is not RTC_OK:
                return False
            return change.result(self._patience) is transition.goal
        except FutureTimeoutError:
            log.warning(
                "%s: %s is requested, and not made yet",
                self._instance,
                transition.label,
            )
            return False
        finally:
            self._changes.remove(change)


def _state(state: LifeCycleState) -> Members:
    id_, label = STATES[state]
    return {"id": id_, "label": label}


def _described(transition: Transition) -> Members:
    return {
        "transition": {"id": transition.id, "label": transition.label},
        "start_state": _state(transition.start),
        "goal_state": _state(transition.goal),
    }
