"""Servers of actions: `GoalServer` manages the goals, and calls one function for each.

The states and answers are those of rcl_action (design.ros2.org, "Actions").
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from enum import IntEnum
from inspect import isgeneratorfunction
from typing import Any, Final

from rtgen.facts.ros import EVENTS_SUFFIX
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.actions import ends_in
from rtgen.runtime.ros2.services import message_of, messages_of
from rtgen.runtime.ros2.types import blank
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.servants import ServiceError
from rtgen.runtime.timing.clocks import SECOND

_MAX_KEPT: Final = 64
"""Number of goals that have ended whose results are kept."""
_ANY: Final = bytes(16)


class GoalStatus(IntEnum):
    """Constants of action_msgs/msg/GoalStatus."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def has_ended(self) -> bool:
        """Whether nothing follows."""
        return self >= GoalStatus.SUCCEEDED


class _Cancel(IntEnum):
    """Return codes of action_msgs/srv/CancelGoal."""

    NONE = 0
    REJECTED = 1
    UNKNOWN_GOAL_ID = 2
    GOAL_TERMINATED = 3


class GoalHandle:
    """A goal of a `GoalServer`, for the function that executes it."""

    def __init__(self, server: GoalServer, id_: bytes, goal: Any, stamp: int) -> None:
        self.id = id_
        self.goal = goal
        """The goal as the client sent it."""
        self.status = GoalStatus.ACCEPTED
        self.result: Any = None
        self.stamp = stamp
        """When it was accepted [ns]."""
        self._server = server

    @property
    def is_active(self) -> bool:
        """Whether it has not ended."""
        return not self.status.has_ended

    @property
    def is_cancel_requested(self) -> bool:
        """Whether the function should end: it is to be canceled, or has been ended already."""
        return self.status not in (GoalStatus.ACCEPTED, GoalStatus.EXECUTING)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the clients; none once the goal has ended."""
        self._server._publish_feedback(self, feedback)

    def succeed(self) -> None:
        """Set the state SUCCEEDED; the function's result follows."""
        self._server._set(self, GoalStatus.SUCCEEDED)

    def abort(self) -> None:
        """Set the state ABORTED; the function's result follows."""
        self._server._set(self, GoalStatus.ABORTED)

    def canceled(self) -> None:
        """Set the state CANCELED after a request to cancel; the function's result follows.

        Raises ValueError without such a request.
        """
        if not self.is_cancel_requested:
            raise ValueError("nobody has asked to cancel the goal")
        self._server._set(self, GoalStatus.CANCELED)


class GoalServer:
    """Serves the action of a component's service port; create it in `on_initialize`.

    Derive a class with `execute`, or give the function to the constructor. It gets a `GoalHandle`,
    calls `succeed`, `canceled` or `abort`, and returns the result. Each goal has a thread of its
    own, at most `limit`; more goals are rejected. A generator function has none: it is continued
    by the ticks of the component, one step between two `yield`, in simulated time too.

    When the component leaves ACTIVE, its goals are aborted.
    """

    def __init__(
        self,
        component: Component,
        port: str,
        execute: Callable[[GoalHandle], Any] | None = None,
        *,
        limit: int = 8,
    ) -> None:
        """Set the servant of the port. Raises ServiceError if it provides no action."""
        self._component = component
        self._function = self.execute if execute is None else execute
        self._limit = limit
        match ends_in(component.providers.values(), component.consumers.values(), port):
            case provider, events if events is not None:
                self._provider, self._events = provider, events
            case _:
                where = f"{component.instance_name}.{port}"
                raise ServiceError(
                    f"{where} provides no action with its {EVENTS_SUFFIX}"
                )
        self._changed = threading.Condition()
        self._goals: OrderedDict[bytes, GoalHandle] = OrderedDict()
        self._working: dict[bytes, Iterator[Any] | None] = {}
        """The goals whose functions have not returned, with the generators."""
        self._threads = 0
        self._status_changed = self._status_sending = False
        self._provider.set_servant(self._servant())
        component._put_before("on_deactivated", self.end)
        component._put_before("on_aborting", self.end)
        if isgeneratorfunction(self._function):
            component._put_before("on_execute", self._step_all)

    # For derived classes

    def execute(self, goal: GoalHandle) -> Any:
        """Execute a goal, and return the result."""
        raise NotImplementedError("give a function to GoalServer, or define `execute`")

    def accept(self, goal: Any) -> bool:
        """Return whether to accept a goal."""
        return True

    def accept_cancel(self, goal: GoalHandle) -> bool:
        """Return whether to accept that a goal is canceled."""
        return True

    # For the component

    @property
    def goals(self) -> tuple[GoalHandle, ...]:
        """The goals that have not ended, in the order in which they came."""
        with self._changed:
            return tuple(each for each in self._goals.values() if each.is_active)

    def end(self) -> None:
        """Abort all goals. Functions that are called see it by `is_cancel_requested`."""
        for goal in self.goals:
            self._finish(goal, GoalStatus.ABORTED, None)
        self._working = {k: v for k, v in self._working.items() if v is None}

    # The servant

    def _servant(self) -> Any:
        members = {
            "send_goal": lambda _, request: self._send_goal(request),
            "cancel_goal": lambda _, request: self._cancel_goal(request),
            "get_result": lambda _, request: self._get_result(request),
        }
        interface: Any = self._provider.interface
        return type("_Goals", (interface,), members)()

    def _response(self, operation: str) -> Any:
        _, class_ = messages_of(self._provider.interface, operation)
        return blank(class_._descriptor_)

    def _send_goal(self, request: Any) -> Any:
        response = self._response("send_goal")
        id_, now = bytes(request.goal_id.uuid), self._component.now()
        response.stamp.sec, response.stamp.nanosec = divmod(now, SECOND)
        if not self.accept(request.goal):
            return response
        with self._changed:
            # A function may go on after the end of its goal.
            under_way = max(len(self._working), self._threads)
            if id_ in self._goals or under_way >= self._limit:
                return response
            goal = GoalHandle(self, id_, request.goal, now)
            self._goals[id_] = goal
            self._working[id_] = None
        response.accepted = True
        self._publish_status()
        if isgeneratorfunction(self._function):
            self._working[id_] = self._function(goal)
            self._set(goal, GoalStatus.EXECUTING)
        else:
            with self._changed:
                self._threads += 1
            name = f"rtgen goal of {self._component.instance_name}"
            threading.Thread(
                target=self._run, args=(goal,), name=name, daemon=True
            ).start()
        return response

    def _cancel_goal(self, request: Any) -> Any:
        response = self._response("cancel_goal")
        info = request.goal_info
        id_ = bytes(info.goal_id.uuid)
        stamp = info.stamp.sec * SECOND + info.stamp.nanosec
        with self._changed:
            goals = tuple(self._goals.values())
            known = self._goals.get(id_)
        if id_ == _ANY:
            asked = [each for each in goals if not stamp or each.stamp <= stamp]
        elif known is None and not stamp:
            response.return_code = _Cancel.UNKNOWN_GOAL_ID
            return response
        else:
            before = [each for each in goals if stamp and each.stamp <= stamp]
            asked = list(dict.fromkeys([*before, *([known] if known else [])]))
        if known is not None and not known.is_active and not stamp:
            response.return_code = _Cancel.GOAL_TERMINATED
            return response
        canceling = [
            each for each in asked if each.is_active and self.accept_cancel(each)
        ]
        for goal in canceling:
            self._set(goal, GoalStatus.CANCELING)
            response.goals_canceling.append(self._info(goal, request.goal_info))
        rejected = id_ != _ANY and not canceling
        response.return_code = _Cancel.REJECTED if rejected else _Cancel.NONE
        return response

    def _get_result(self, request: Any) -> Any:
        response = self._response("get_result")
        with self._changed:
            goal = self._goals.get(bytes(request.goal_id.uuid))
            if goal is None:
                return response
            self._changed.wait_for(lambda: self._is_complete(goal))
            response.status = int(goal.status)
            if goal.result is not None:
                response.result = goal.result
        return response

    def _is_complete(self, goal: GoalHandle) -> bool:
        """Return whether state and result are there."""
        return not goal.is_active and goal.id not in self._working

    # Execution

    def _run(self, goal: GoalHandle) -> None:
        self._set(goal, GoalStatus.EXECUTING)
        try:
            result = self._function(goal)
        except BaseException as error:
            self._fail(goal, error)
        else:
            self._end_of(goal, result)
        finally:
            with self._changed:
                self._threads -= 1

    def _step_all(self) -> None:
        for id_, steps in list(self._working.items()):
            if steps is None:
                continue
            goal = self._goals[id_]
            try:
                next(steps)
            except StopIteration as stop:
                self._end_of(goal, stop.value)
            except BaseException as error:
                self._fail(goal, error)

    def _fail(self, goal: GoalHandle, error: BaseException) -> None:
        self._component._function_failed(f"{self._provider.port}.execute", error)
        self._finish(goal, GoalStatus.ABORTED, None)

    def _end_of(self, goal: GoalHandle, result: Any) -> None:
        if goal.is_active:
            log.warning(
                "%s.%s: a goal has no state at its end, so it is aborted",
                self._component.instance_name,
                self._provider.port,
            )
        self._finish(goal, GoalStatus.ABORTED, result)

    def _finish(self, goal: GoalHandle, status: GoalStatus, result: Any) -> None:
        """Give a goal its result, and this state if it has none of the last ones."""
        with self._changed:
            self._working.pop(goal.id, None)
            goal.result = goal.result if result is None else result
            self._forget()
            self._changed.notify_all()
        self._set(goal, status)

    def _forget(self) -> None:
        ended = [
            each
            for each in self._goals.values()
            if not each.is_active and each.id not in self._working
        ]
        for goal in ended[: max(0, len(ended) - _MAX_KEPT)]:
            del self._goals[goal.id]

    def _set(self, goal: GoalHandle, status: GoalStatus) -> None:
        with self._changed:
            if goal.status >= status or goal.status.has_ended:
                return
            goal.status = status
            self._changed.notify_all()
        self._publish_status()

    # Topics

    def _info(self, goal: GoalHandle, like: Any) -> Any:
        info = type(like)()
        info.goal_id.uuid = goal.id
        info.stamp.sec, info.stamp.nanosec = divmod(goal.stamp, SECOND)
        return info

    def _publish_feedback(self, goal: GoalHandle, feedback: Any) -> None:
        if not goal.is_active:
            return
        class_ = message_of(self._events.interface, "feedback")
        message = blank(class_._descriptor_)
        message.goal_id.uuid, message.feedback = goal.id, feedback
        self._send("feedback", message)

    def _publish_status(self) -> None:
        """Send the states of all goals, from one thread at a time, so that the latest is last."""
        with self._changed:
            self._status_changed = True
            if self._status_sending:
                return
            self._status_sending = True
        while (message := self._next_status()) is not None:
            self._send("status", message)

    def _next_status(self) -> Any:
        """Return a message with the states of all goals; None after the last change was sent."""
        class_: Any = message_of(self._events.interface, "status")
        message = blank(class_._descriptor_)
        element: Any = class_._descriptor_.members[0].type.element
        with self._changed:
            self._status_sending = self._status_changed
            if not self._status_changed:
                return None
            self._status_changed = False
            for goal in self._goals.values():
                each = blank(element)
                each.goal_info = self._info(goal, each.goal_info)
                each.status = int(goal.status)
                message.status_list.append(each)
        return message

    def _send(self, operation: str, message: Any) -> None:
        try:
            getattr(self._events, operation)(message)
        except ServiceError as error:
            log.debug("%s: %s", self._component.instance_name, error)
