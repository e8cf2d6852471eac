"""Clients of actions: `GoalClient` sends goals, and calls one function with each result."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any
from uuid import uuid4

from rtgen.runtime.ros2.actions import ends_in
from rtgen.runtime.ros2.goals import GoalStatus
from rtgen.runtime.ros2.services import messages_of
from rtgen.runtime.ros2.types import blank
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import Provider
from rtgen.runtime.services.servants import ServiceError


class ClientGoal:
    """A goal that a `GoalClient` has sent."""

    def __init__(self, client: GoalClient, goal: Any) -> None:
        self.id = uuid4().bytes
        self.goal = goal
        self.accepted: bool | None = None
        """Whether the server has accepted it; None before its answer."""
        self.status = GoalStatus.UNKNOWN
        """The state told last. It stays UNKNOWN if the goal is rejected or lost."""
        self.result: Any = None
        self.error: ServiceError | None = None
        """Why it was lost: no server, or none any more."""
        self._client = client
        self._ended = threading.Event()

    @property
    def has_ended(self) -> bool:
        """Whether it has a result, is rejected, or lost."""
        return self._ended.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the end, for other threads than those of ticks; `timeout` in seconds."""
        return self._ended.wait(timeout)

    def cancel(self) -> None:
        """Ask the server to cancel it. The result follows, with the state CANCELED if it does."""
        self._client._cancel(self)


class GoalClient:
    """A client of the action of a component's service port; create it in `on_initialize`.

    Derive a class with `on_result`, and perhaps `on_feedback`, or give the functions to the
    constructor. They are called in the ticks of the component. When it leaves ACTIVE, the goals
    under way are canceled, and nothing is told any more.
    """

    def __init__(
        self,
        component: Component,
        port: str,
        on_result: Callable[[ClientGoal], None] | None = None,
        on_feedback: Callable[[ClientGoal, Any], None] | None = None,
        *,
        limit: int = 8,
    ) -> None:
        """Set the servant for feedback, if the port has it.

        At most `limit` goals are under way. Raises ServiceError if the port uses no action.
        """
        self._component = component
        self._port = port
        self._limit = limit
        self._tell_result = self.on_result if on_result is None else on_result
        self._tell_feedback = self.on_feedback if on_feedback is None else on_feedback
        self._lock = threading.Lock()
        self._goals: dict[bytes, ClientGoal] = {}
        ends = ends_in(component.consumers.values(), component.providers.values(), port)
        if ends is None:
            raise ServiceError(f"{component.instance_name}.{port} uses no action")
        self._consumer, events = ends
        if events is not None:
            events.set_servant(self._servant(events))
        component._put_before("on_deactivated", self.end)
        component._put_before("on_aborting", self.end)

    # For derived classes

    def on_result(self, goal: ClientGoal) -> None:
        """Called when a goal has ended, was rejected, or is lost."""

    def on_feedback(self, goal: ClientGoal, feedback: Any) -> None:
        """Called with the feedback of a goal that has not ended."""

    # For the component

    def send(self, goal: Any) -> ClientGoal:
        """Send a goal, without waiting. Raises ServiceError if too many are under way."""
        sent = ClientGoal(self, goal)
        with self._lock:
            if len(self._goals) >= self._limit:
                raise ServiceError(f"{self._limit} goals of {self._port} are under way")
            self._goals[sent.id] = sent
        self._start(self._run, sent)
        return sent

    @property
    def goals(self) -> tuple[ClientGoal, ...]:
        """The goals under way."""
        with self._lock:
            return tuple(self._goals.values())

    def end(self) -> None:
        """Cancel the goals under way; nothing is told of them any more."""
        with self._lock:
            goals = list(self._goals.values())
            self._goals.clear()
        for goal in goals:
            self._cancel(goal)

    # Calls, in threads of their own

    def _start(self, function: Callable[[ClientGoal], None], goal: ClientGoal) -> None:
        name = f"rtgen goal of {self._component.instance_name}"
        threading.Thread(target=function, args=(goal,), name=name, daemon=True).start()

    def _call(self, operation: str, fill: Callable[[Any], None]) -> Any:
        class_, _ = messages_of(self._consumer.interface, operation)
        request = blank(class_._descriptor_)
        fill(request)
        return getattr(self._consumer, operation)(request)

    def _run(self, goal: ClientGoal) -> None:
        def named(request: Any) -> None:
            request.goal_id.uuid = goal.id

        def with_goal(request: Any) -> None:
            named(request)
            request.goal = goal.goal

        status = GoalStatus.UNKNOWN
        try:
            goal.accepted = bool(self._call("send_goal", with_goal).accepted)
            if goal.accepted:
                self._advance(goal, GoalStatus.ACCEPTED)
                response = self._call("get_result", named)
                status, goal.result = GoalStatus(response.status), response.result
        except ServiceError as error:
            goal.error = error
        except ValueError as error:
            goal.error = ServiceError(str(error))
        self._end_of(goal, status)

    def _end_of(self, goal: ClientGoal, status: GoalStatus) -> None:
        with self._lock:
            is_under_way = self._goals.pop(goal.id, None) is not None
            goal.status = status
            goal._ended.set()
        if is_under_way:
            self._in_tick("on_result", lambda: self._tell_result(goal))

    def _cancel(self, goal: ClientGoal) -> None:
        def named(request: Any) -> None:
            request.goal_info.goal_id.uuid = goal.id

        def call(_: ClientGoal) -> None:
            try:
                self._call("cancel_goal", named)
            except ServiceError as error:
                self._component.logger.debug("a goal cannot be canceled: %s", error)

        self._start(call, goal)

    # Events

    def _servant(self, events: Provider[Any]) -> Any:
        members = {
            "feedback": lambda _, message: self._take_feedback(message),
            "status": lambda _, message: self._take_status(message),
        }
        interface: Any = events.interface
        return type("_Events", (interface,), members)()

    def _take_feedback(self, message: Any) -> None:
        with self._lock:
            goal = self._goals.get(bytes(message.goal_id.uuid))
        if goal is not None:
            feedback = message.feedback
            self._in_tick("on_feedback", lambda: self._tell_feedback(goal, feedback))

    def _take_status(self, message: Any) -> None:
        for each in message.status_list:
            with self._lock:
                goal = self._goals.get(bytes(each.goal_info.goal_id.uuid))
            if goal is not None and each.status <= GoalStatus.ABORTED:
                self._advance(goal, GoalStatus(each.status))

    def _advance(self, goal: ClientGoal, status: GoalStatus) -> None:
        """Set a state that may have been overtaken by a later one, or by the end."""
        with self._lock:
            if not goal.has_ended:
                goal.status = max(goal.status, status)

    def _in_tick(self, name: str, function: Callable[[], None]) -> None:
        """Call a user's function at the end of the next tick."""

        def call() -> None:
            try:
                function()
            except BaseException as error:
                self._component._function_failed(f"{self._port}.{name}", error)

        self._component._at_end_of_cycle(call)
