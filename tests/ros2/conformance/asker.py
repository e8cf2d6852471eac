"""Does the tasks that come as JSON: calls of a service and goals of an action of other nodes."""

from __future__ import annotations

import json
import threading
from queue import SimpleQueue
from typing import Any
from uuid import uuid4

from subject.action_msgs.msg import GoalInfo
from subject.action_msgs.srv import CancelGoal_Request
from subject.components.asker import AskerBase
from subject.std_msgs.msg import String
from subject.test_msgs import action
from subject.test_msgs.srv import BasicTypes_Request
from subject.unique_identifier_msgs.msg import UUID

from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError


class Events(action.Fibonacci_Events):
    """Tells feedback and states."""

    def __init__(self, told: SimpleQueue[Any]) -> None:
        self._told = told

    def feedback(self, message: Any) -> None:
        """Tell the numbers so far of a goal."""
        goal = bytes(message.goal_id.uuid).hex()
        self._told.put(["feedback", goal, list(message.feedback.sequence)])

    def status(self, message: Any) -> None:
        """Tell the state of each goal."""
        for each in message.status_list:
            goal = bytes(each.goal_info.goal_id.uuid).hex()
            self._told.put(["status", goal, each.status])


class Asker(AskerBase):
    """Does the tasks that come as JSON."""

    def on_initialize(self) -> ReturnCode_t:
        """What is told waits for the next cycle."""
        self.results: SimpleQueue[Any] = SimpleQueue()
        self.events.set_servant(Events(self.results))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Begin tasks, and tell results."""
        while self.task.is_new():
            words = json.loads(self.task.read().data)
            threading.Thread(target=self._do, args=words, daemon=True).start()
        while not self.results.empty():
            self.told.write(String(json.dumps(self.results.get())))
        return RTC_OK

    def _do(self, task: str, *arguments: Any) -> None:
        try:
            self.results.put([task, *getattr(self, f"do_{task}")(*arguments)])
        except ServiceError as error:
            self.results.put(["failed", task, str(error)])

    def do_echo(self, value: Any) -> Any:
        """Return the value."""
        return [value]

    def do_call(self, values: dict[str, Any]) -> Any:
        """Call the service; return the members of the response."""
        request = BasicTypes_Request(**values)
        response = self.asks.ask(request)
        return [{m: getattr(response, m) for m in values}]

    def do_goal(self, order: int) -> Any:
        """Send a goal; return its identity, whether it is accepted, and its result."""
        goal = UUID(uuid4().bytes)
        name = bytes(goal.uuid).hex()
        request = action.Fibonacci_SendGoal_Request(goal, action.Fibonacci_Goal(order))
        accepted = self.goals.send_goal(request).accepted
        self.results.put(["accepted", name, accepted])
        if not accepted:
            return name, None, None
        end = self.goals.get_result(action.Fibonacci_GetResult_Request(goal))
        return name, end.status, list(end.result.sequence)

    def do_cancel(self, name: str) -> Any:
        """Cancel a goal; return the code and how many are cancelled."""
        info = GoalInfo(UUID(bytes.fromhex(name)))
        response = self.goals.cancel_goal(CancelGoal_Request(info))
        return name, response.return_code, len(response.goals_canceling)
