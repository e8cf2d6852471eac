"""Serves a service, which repeats its request, and an action, which counts Fibonacci's numbers."""

from __future__ import annotations

import time
from typing import Any

from subject import Basics
from subject.components.counter import CounterBase
from subject.test_msgs import action
from subject.test_msgs.srv import BasicTypes_Response

from rtgen.runtime import RTC_OK, ReturnCode_t
from rtgen.runtime.ros2.goals import GoalHandle, GoalServer

FINISH = "finish"
"""A request with this text lets all goals succeed, which wait for it."""


class Repeating(Basics):
    """Repeats requests."""

    def __init__(self, goals: Goals) -> None:
        self._goals = goals

    def ask(self, request: Any) -> Any:
        """Return the members of the request."""
        if request.string_value == FINISH:
            self._goals.finish()
        return BasicTypes_Response(
            *(getattr(request, m) for m in request.__struct_fields__)
        )


class Goals(GoalServer):
    """Accepts positive orders. Goals wait until they are to finish."""

    def __init__(self, component: Any) -> None:
        super().__init__(component, "count", limit=100)
        self._finished: set[bytes] = set()

    def accept(self, goal: Any) -> bool:
        """Accept positive orders."""
        return bool(goal.order > 0)

    def execute(self, goal: GoalHandle) -> Any:
        """Count, with feedback."""
        sequence = [0, 1]
        while len(sequence) <= goal.goal.order:
            sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(action.Fibonacci_Feedback(list(sequence)))
        while goal.id not in self._finished:
            if goal.is_cancel_requested:
                goal.canceled()
                return action.Fibonacci_Result(sequence)
            time.sleep(0.005)
        goal.succeed()
        return action.Fibonacci_Result(sequence)

    def finish(self) -> None:
        """Let all goals succeed."""
        self._finished.update(goal.id for goal in self.goals)


class Counter(CounterBase):
    """Serves a service, and an action."""

    def on_initialize(self) -> ReturnCode_t:
        """The servants exist from the start."""
        self.basics.set_servant(Repeating(Goals(self)))
        return RTC_OK
