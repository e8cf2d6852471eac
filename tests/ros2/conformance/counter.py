"""Serves a service, which repeats its request, and an action, which counts Fibonacci's numbers."""

from __future__ import annotations

import threading
from typing import Any

from subject import Basics
from subject.action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from subject.action_msgs.srv import CancelGoal_Response
from subject.components.counter import CounterBase
from subject.test_msgs import action
from subject.test_msgs.srv import BasicTypes_Response

from rtgen.runtime import RTC_OK, ReturnCode_t

EXECUTING, CANCELING, SUCCEEDED, CANCELED = 2, 3, 4, 5
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


class Goal:
    """A goal with its state."""

    def __init__(self, info: GoalInfo, order: int) -> None:
        self.info, self.order = info, order
        self.status = EXECUTING
        self.sequence = [0, 1]
        self.ending = threading.Event()
        self.done = threading.Event()


class Goals(action.Fibonacci):
    """Accepts positive orders."""

    def __init__(self, events: Any) -> None:
        self._events = events
        self._lock = threading.Lock()
        self._goals: dict[bytes, Goal] = {}

    def send_goal(self, request: Any) -> Any:
        """Execute the goal in a thread of its own."""
        order = request.goal.order
        response = action.Fibonacci_SendGoal_Response(accepted=order > 0)
        if order > 0:
            goal = Goal(GoalInfo(request.goal_id, response.stamp), order)
            with self._lock:
                self._goals[bytes(request.goal_id.uuid)] = goal
            threading.Thread(target=self._execute, args=(goal,), daemon=True).start()
        return response

    def _execute(self, goal: Goal) -> None:
        self._tell()
        while len(goal.sequence) <= goal.order:
            goal.sequence.append(goal.sequence[-1] + goal.sequence[-2])
            feedback = action.Fibonacci_Feedback(list(goal.sequence))
            self._events.feedback(
                action.Fibonacci_FeedbackMessage(goal.info.goal_id, feedback)
            )
        goal.ending.wait()
        goal.status = CANCELED if goal.status == CANCELING else SUCCEEDED
        self._tell()
        goal.done.set()

    def _tell(self) -> None:
        with self._lock:
            states = [
                GoalStatus(goal.info, goal.status) for goal in self._goals.values()
            ]
        self._events.status(GoalStatusArray(states))

    def cancel_goal(self, request: Any) -> Any:
        """Cancel one goal that is executed."""
        goal = self._goals.get(bytes(request.goal_info.goal_id.uuid))
        if goal is None or goal.done.is_set():
            return CancelGoal_Response(1)
        goal.status = CANCELING
        goal.ending.set()
        return CancelGoal_Response(0, [goal.info])

    def get_result(self, request: Any) -> Any:
        """Wait for the end of a goal."""
        goal = self._goals[bytes(request.goal_id.uuid)]
        goal.done.wait()
        result = action.Fibonacci_Result(goal.sequence)
        return action.Fibonacci_GetResult_Response(goal.status, result)

    def finish(self) -> None:
        """Let all goals succeed."""
        for goal in list(self._goals.values()):
            goal.ending.set()


class Counter(CounterBase):
    """Serves a service, and an action."""

    def on_initialize(self) -> ReturnCode_t:
        """The servants exist from the start."""
        self.served = Goals(self.events)
        self.basics.set_servant(Repeating(self.served))
        self.goals.set_servant(self.served)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Say so."""
        self.log.warning("the counter counts")
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """No call waits for a goal."""
        self.served.finish()
        return RTC_OK
