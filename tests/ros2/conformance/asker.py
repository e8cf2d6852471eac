"""Does the tasks that come as JSON: calls of a service and goals of an action of other nodes."""

from __future__ import annotations

import json
import threading
import time
from queue import SimpleQueue
from typing import Any

from subject.action_msgs.msg import GoalInfo
from subject.action_msgs.srv import CancelGoal_Request
from subject.components.asker import AskerBase
from subject.std_msgs.msg import String
from subject.test_msgs import action
from subject.test_msgs.srv import BasicTypes_Request
from subject.unique_identifier_msgs.msg import UUID

from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError
from rtgen.runtime.ros2.goal_clients import ClientGoal, GoalClient


class Asking(GoalClient):
    """Tells feedback and states."""

    def __init__(self, component: Any, told: SimpleQueue[Any]) -> None:
        super().__init__(component, "count", limit=100)
        self._told = told

    def on_feedback(self, goal: ClientGoal, feedback: Any) -> None:
        """Tell the numbers so far of a goal."""
        self._told.put(["feedback", goal.id.hex(), list(feedback.sequence)])

    def _take_status(self, message: Any) -> None:
        """Tell the state of each goal, also of one that has ended."""
        super()._take_status(message)
        for each in message.status_list:
            goal = bytes(each.goal_info.goal_id.uuid).hex()
            self._told.put(["status", goal, each.status])

    def on_result(self, goal: ClientGoal) -> None:
        """Tell the result of a goal, none of one that is rejected."""
        numbers = list(goal.result.sequence) if goal.accepted else None
        status = int(goal.status) if goal.accepted else None
        self._told.put(["goal", goal.id.hex(), status, numbers])


class Asker(AskerBase):
    """Does the tasks that come as JSON."""

    def on_initialize(self) -> ReturnCode_t:
        """What is told waits for the next cycle."""
        self.results: SimpleQueue[Any] = SimpleQueue()
        self.client = Asking(self, self.results)
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
            word = "accepted" if task == "goal" else task
            self.results.put([word, *getattr(self, f"do_{task}")(*arguments)])
        except ServiceError as error:
            self.results.put(["failed", task, str(error)])

    def do_echo(self, value: Any) -> Any:
        """Return the value."""
        return [value]

    def do_log(self, text: str) -> Any:
        """Write a line of the log."""
        self.logger.warning(text)
        return [text]

    def do_call(self, values: dict[str, Any]) -> Any:
        """Call the service; return the members of the response."""
        request = BasicTypes_Request(**values)
        response = self.asks.ask(request)
        return [{m: getattr(response, m) for m in values}]

    def do_goal(self, order: int) -> Any:
        """Send a goal; return its identity, and whether it is accepted."""
        goal = self.client.send(action.Fibonacci_Goal(order))
        while goal.accepted is None and not goal.has_ended:
            time.sleep(0.002)
        if goal.error is not None:
            raise goal.error
        return goal.id.hex(), goal.accepted

    def do_cancel(self, name: str) -> Any:
        """Cancel a goal; return the code and how many are cancelled."""
        info = GoalInfo(UUID(bytes.fromhex(name)))
        response = self.goals.cancel_goal(CancelGoal_Request(info))
        return name, response.return_code, len(response.goals_canceling)
