"""`GoalServer` and `GoalClient` of two connected components, in real and in simulated time."""

from __future__ import annotations

import bdb
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from types import ModuleType
from typing import Any

import pytest
from action_package import generated
from patience import PATIENCE, until

from rtgen.runtime import RTC_OK, RealClock, SimulatedClock, System
from rtgen.runtime.ros2.goal_clients import ClientGoal, GoalClient
from rtgen.runtime.ros2.goals import GoalHandle, GoalServer, GoalStatus
from rtgen.runtime.services.servants import CallEnded, ServiceError

MS = 1_000_000
IDL = """
#include "lab/action/Go.idl"
component Mover {
    @port("go") provides lab::action::Go goals;
    @port("go") uses lab::action::Go_Events events;
    provides lab::action::Go alone;
};
component Asker {
    @port("go") uses lab::action::Go goals;
    @port("go") provides lab::action::Go_Events events;
    provides lab::action::Go_Events other;
};
"""


@pytest.fixture(scope="module")
def go(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    """Import the package generated from the action and the components."""
    return generated(tmp_path_factory.mktemp("goals"), IDL, "goals_go")


class Moving(GoalServer):
    """Moves until it is let go; rejects negative goals."""

    def __init__(self, component: Any, action: Any, limit: int = 8) -> None:
        super().__init__(component, "go", limit=limit)
        self.action = action
        self.go = threading.Event()
        self.how = GoalHandle.succeed
        self.cancels = True
        self.asked = threading.Event()
        """Set once a client waits for a result."""

    def accept(self, goal: Any) -> bool:
        return bool(goal.x >= 0)

    def accept_cancel(self, goal: GoalHandle) -> bool:
        return self.cancels

    def _get_result(self, request: Any) -> Any:
        self.asked.set()
        return super()._get_result(request)

    def execute(self, goal: GoalHandle) -> Any:
        goal.publish_feedback(self.action.Go_Feedback(2.0 * goal.goal.x))
        while not self.go.wait(0.005):
            if goal.is_cancel_requested:
                goal.canceled()
                return self.action.Go_Result(False)
        self.how(goal)
        return self.action.Go_Result(True)


class Ends:
    """A server and a client with what the client is told."""

    def __init__(
        self, stack: ExitStack, go: ModuleType, clock: Any, server: Any, **options: Any
    ) -> None:
        self.action = go.lab.action
        self.system = stack.enter_context(System(clock))
        self.mover = go.components.mover.MoverBase("Mover0")
        self.asker = go.components.asker.AskerBase("Asker0")
        for component in (self.mover, self.asker):
            self.system.add(component, 200.0)
        self.server = server(self.mover)
        self.results: list[ClientGoal] = []
        self.feedback: list[float] = []
        self.client = GoalClient(
            self.asker,
            "go",
            self.results.append,
            lambda goal, feedback: self.feedback.append(feedback.left),
            **options,
        )
        self.system.connect(("Asker0", "go"), ("Mover0", "go"))
        for component in (self.mover, self.asker):
            assert self.system.activate(component.instance_name) == RTC_OK
        self.until(lambda: self.mover.is_active and self.asker.is_active)

    def until(self, holds: Any) -> None:
        until(lambda: self.system.run(self.system.time + 10 * MS) or holds())

    def send(self, x: float) -> ClientGoal:
        return self.client.send(self.action.Go_Goal(x))

    def status_of(self, *goals: ClientGoal) -> list[GoalStatus]:
        self.until(lambda: all(each in self.results for each in goals))
        return [each.status for each in goals]


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


@pytest.fixture
def ends(stack: ExitStack, go: ModuleType) -> Ends:
    made = Ends(stack, go, RealClock(), lambda mover: Moving(mover, go.lab.action))
    stack.callback(made.server.go.set)
    return made


def test_a_goal_with_feedback(ends: Ends) -> None:
    goal = ends.send(1.5)
    ends.until(lambda: goal.accepted and ends.feedback == [3.0])
    ends.until(lambda: goal.status is GoalStatus.EXECUTING)
    assert not goal.has_ended
    ends.server.go.set()
    assert ends.status_of(goal) == [GoalStatus.SUCCEEDED]
    assert goal.result.done
    assert ends.client.goals == ends.server.goals == ()


@pytest.mark.parametrize(
    ("how", "status"),
    [
        (GoalHandle.abort, GoalStatus.ABORTED),
        (lambda _: None, GoalStatus.ABORTED),
        (lambda goal: 1 / 0, GoalStatus.ABORTED),
        (GoalHandle.canceled, GoalStatus.ABORTED),
    ],
    ids=["abort", "without a state", "an error", "canceled without a request"],
)
def test_ends_of_functions(ends: Ends, how: Any, status: GoalStatus) -> None:
    failures: list[Any] = []
    ends.system.on_failure = failures.append
    ends.server.how = how
    ends.server.go.set()
    assert ends.status_of(ends.send(0.0)) == [status]
    assert [f.callback for f in failures] in ([], ["go.execute"])
    assert ends.mover.is_active


def test_a_rejected_goal(ends: Ends) -> None:
    goal = ends.send(-1.0)
    assert ends.status_of(goal) == [GoalStatus.UNKNOWN]
    assert goal.accepted is False
    assert goal.error is None


def test_five_goals_of_which_one_is_canceled(ends: Ends) -> None:
    goals = [ends.send(float(x)) for x in range(5)]
    ends.until(lambda: sorted(ends.feedback) == [0.0, 2.0, 4.0, 6.0, 8.0])
    goals[1].cancel()
    assert ends.status_of(goals[1]) == [GoalStatus.CANCELED]
    assert not goals[1].result.done
    ends.server.cancels = False
    goals[2].cancel()
    ends.server.go.set()
    assert ends.status_of(*goals) == [
        GoalStatus.SUCCEEDED,
        GoalStatus.CANCELED,
        *[GoalStatus.SUCCEEDED] * 3,
    ]


def test_the_last_status_is_the_latest(ends: Ends) -> None:
    """Also if the message before it takes longer than the rest of the goals."""
    events = next(iter(ends.mover.consumers.values()))
    carrier, statuses = events._provider, []

    class Slow:
        reachable = True

        def call(self, operation: str, arguments: tuple[Any, ...]) -> object:
            if operation != "status":
                return carrier.call(operation, arguments)
            [message] = arguments
            sent = [each.status for each in message.status_list]
            if GoalStatus.SUCCEEDED in sent:
                until(lambda: not ends.server.goals)
            statuses.append(sent)
            return None

    events._provider = Slow()
    goals = [ends.send(float(x)) for x in range(3)]
    ends.until(lambda: len(ends.feedback) == 3)
    ends.server.go.set()
    assert ends.status_of(*goals) == [GoalStatus.SUCCEEDED] * 3
    until(lambda: statuses[-1] == [GoalStatus.SUCCEEDED] * 3)
    until(lambda: not ends.server._status_sending)
    assert statuses[-1] == [GoalStatus.SUCCEEDED] * 3


def test_goals_are_bounded(stack: ExitStack, go: ModuleType) -> None:
    ends = Ends(
        stack,
        go,
        RealClock(),
        lambda mover: Moving(mover, go.lab.action, limit=2),
        limit=3,
    )
    stack.callback(ends.server.go.set)
    first = [ends.send(1.0) for _ in range(2)]
    ends.until(lambda: all(each.accepted for each in first))
    third = ends.send(1.0)
    assert ends.status_of(third) == [GoalStatus.UNKNOWN]
    assert third.accepted is False
    ends.server._limit = 3
    fourth = ends.send(1.0)
    ends.until(lambda: fourth.accepted)
    with pytest.raises(ServiceError, match="3 goals of go are under way"):
        ends.send(1.0)


def test_a_server_that_is_deactivated_ends_its_goals(ends: Ends) -> None:
    goal = ends.send(1.0)
    ends.until(ends.server.asked.is_set)
    ends.system.deactivate("Mover0")
    assert ends.status_of(goal) == [GoalStatus.ABORTED]
    ends.until(lambda: not ends.mover.is_active)
    lost = ends.send(1.0)
    assert ends.status_of(lost) == [GoalStatus.UNKNOWN]
    assert lost.accepted is None
    assert "is not active" in str(lost.error)


def test_a_client_that_is_deactivated_cancels_its_goals(ends: Ends) -> None:
    goal = ends.send(1.0)
    ends.until(lambda: ends.feedback)
    ends.system.deactivate("Asker0")
    assert goal.wait(PATIENCE)
    assert goal.status is GoalStatus.CANCELED
    ends.until(lambda: not ends.asker.is_active)
    assert ends.results == []


def test_errors_of_the_functions_of_a_client_are_reported(ends: Ends) -> None:
    failures: list[Any] = []
    ends.system.on_failure = failures.append

    def fail(goal: ClientGoal) -> None:
        raise OSError("no")

    ends.client._tell_result = fail
    ends.server.go.set()
    ends.send(1.0)
    ends.until(lambda: failures)
    assert [f.callback for f in failures] == ["go.on_result"]
    assert ends.asker.is_active


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt(), bdb.BdbQuit()])
def test_an_interrupt_in_a_function_ends_the_run(
    stack: ExitStack, go: ModuleType, interrupt: BaseException
) -> None:
    """Of a goal's step, and of a result: it is no failure of them alone."""

    def served(mover: Any) -> GoalServer:
        def execute(goal: GoalHandle) -> Any:
            yield
            raise interrupt

        return GoalServer(mover, "go", execute)

    ends = Ends(stack, go, SimulatedClock(), served)
    send = go.lab.action.Go_SendGoal_Request()
    assert ends.mover.goals.servant.send_goal(send).accepted
    with pytest.raises(type(interrupt)):
        ends.system.run(ends.system.time + 100 * MS)

    def tell(goal: ClientGoal) -> None:
        raise interrupt

    ends.client._in_tick("on_result", lambda: tell(ClientGoal(ends.client, None)))
    with pytest.raises(type(interrupt)):
        ends.system.run(ends.system.time + 100 * MS)


def test_what_the_end_of_a_run_cuts_short_has_not_failed(
    stack: ExitStack, go: ModuleType
) -> None:
    def served(mover: Any) -> GoalServer:
        def execute(goal: GoalHandle) -> Any:
            yield
            raise CallEnded("the run has ended")

        return GoalServer(mover, "go", execute)

    ends = Ends(stack, go, SimulatedClock(), served)
    failures: list[Any] = []
    ends.system.on_failure = failures.append
    send = go.lab.action.Go_SendGoal_Request()
    assert ends.mover.goals.servant.send_goal(send).accepted
    ends.system.run(ends.system.time + 100 * MS)
    assert failures == []
    assert ends.server.goals == ()


def request(ends: Ends, name: str, id_: bytes, stamp: tuple[int, int] = (0, 0)) -> Any:
    """Return the response of a cancellation."""
    from goals_go.action_msgs.msg import GoalInfo
    from goals_go.action_msgs.srv import CancelGoal_Request

    info = GoalInfo()
    info.goal_id.uuid = id_
    info.stamp.sec, info.stamp.nanosec = stamp
    return ends.mover.goals.servant.cancel_goal(CancelGoal_Request(info))


def test_the_rules_of_cancellations(ends: Ends) -> None:
    """By id, before a time, of all; with the codes of action_msgs/srv/CancelGoal."""
    goals = [ends.send(float(x)) for x in range(3)]
    ends.until(lambda: len(ends.server.goals) == 3)
    assert request(ends, "none", bytes(15) + b"\1").return_code == 2
    ends.server.cancels = False
    assert request(ends, "rejected", goals[0].id).return_code == 1
    ends.server.cancels = True
    first = min(ends.server.goals, key=lambda each: each.stamp)
    seconds = divmod(first.stamp, 10**9)
    response = request(ends, "before", bytes(16), seconds)
    assert [bytes(i.goal_id.uuid) for i in response.goals_canceling] == [first.id]
    [canceled] = [each for each in goals if each.id == first.id]
    assert ends.status_of(canceled) == [GoalStatus.CANCELED]
    assert request(ends, "ended", first.id).return_code == 3
    assert len(request(ends, "all", bytes(16)).goals_canceling) == 2
    assert ends.status_of(*goals) == [GoalStatus.CANCELED] * 3


def test_a_generator_is_continued_by_the_ticks(
    stack: ExitStack, go: ModuleType
) -> None:
    """In simulated time, without threads: a step in each tick."""
    action = go.lab.action
    at: list[int] = []

    def served(mover: Any) -> GoalServer:
        def execute(goal: GoalHandle) -> Any:
            for left in (3.0, 2.0, 1.0):
                if goal.is_cancel_requested:
                    goal.canceled()
                    return action.Go_Result(False)
                at.append(mover.now())
                goal.publish_feedback(action.Go_Feedback(left))
                yield
            goal.succeed()
            return action.Go_Result(True)

        return GoalServer(mover, "go", execute)

    ends = Ends(stack, go, SimulatedClock(), served)
    send = action.Go_SendGoal_Request(goal=action.Go_Goal(1.0))
    send.goal_id.uuid = bytes(range(16))
    begun = ends.system.time
    assert ends.mover.goals.servant.send_goal(send).accepted
    assert not ends.mover.goals.servant.send_goal(send).accepted  # the same again
    ends.system.run(begun + 25 * MS)
    assert [time - begun for time in at] == [0, 5 * MS, 10 * MS]
    result = action.Go_GetResult_Request(send.goal_id)
    answer = ends.mover.goals.servant.get_result(result)
    assert (answer.status, answer.result.done) == (GoalStatus.SUCCEEDED, True)
    other = action.Go_GetResult_Request()
    assert ends.mover.goals.servant.get_result(other).status == GoalStatus.UNKNOWN


def test_ports_without_an_action(go: ModuleType) -> None:
    mover, asker = go.components.mover.MoverBase(), go.components.asker.AskerBase()
    with pytest.raises(ServiceError, match="alone provides no action"):
        GoalServer(mover, "alone")
    with pytest.raises(ServiceError, match="other uses no action"):
        GoalClient(asker, "other")
