"""An action with a component for each end, for tests with peers of each network."""

from __future__ import annotations

import importlib
import threading
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from patience import until

from rtgen.cli import run as rtgen
from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.ros2.actions import joints_of
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.ros2.services import RosServices
from rtgen.tools.running.ros2_classes import message_classes

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
    @port("both") uses lab::action::Go first;
    @port("both") uses lab::action::Go_Events second;
    provides lab::action::Go_Events other;
};
"""
PACKAGES = (
    *("lab.action", "action_msgs.srv", "action_msgs.msg"),
    *("unique_identifier_msgs.msg", "components"),
)
EXECUTING, SUCCEEDED, CANCELED = 2, 4, 5


def generated(folder: Path) -> ModuleType:
    """Return the generated package."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("lab/action").mkdir(parents=True)
        Path("lab/action/Go.action").write_text(
            "float64 x\n---\nbool done\n---\nfloat64 left\n"
        )
        Path("t.idl").write_text(IDL)
        Path("rtgen.toml").write_text(
            '[sources]\npaths = ["t.idl", "lab"]\n[output]\npackage = "ros_go"\n'
        )
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        package = importlib.import_module("ros_go")
        for name in PACKAGES:
            importlib.import_module(f"ros_go.{name}")
        for name in ("mover", "asker"):
            importlib.import_module(f"ros_go.components.{name}")
        return package


def servant(go: ModuleType, events: Any) -> Any:
    """Return a servant for one goal at a time, which ends by `finish` or a cancellation."""
    action, shared = go.lab.action, go.action_msgs

    class Goals(action.Go):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            self.changed = threading.Condition()
            self.status = 0
            self.goal: Any = None

        def _to(self, status: int) -> None:
            info = shared.msg.GoalInfo(self.goal)
            found = shared.msg.GoalStatus(info, status)
            events.status(shared.msg.GoalStatusArray([found]))
            with self.changed:
                self.status = status
                self.changed.notify_all()

        def send_goal(self, request: Any) -> Any:
            self.goal = request.goal_id
            self._to(EXECUTING)
            for left in (2.0, 1.0):
                feedback = action.Go_Feedback(left * request.goal.x)
                events.feedback(action.Go_FeedbackMessage(self.goal, feedback))
            return action.Go_SendGoal_Response(True)

        def finish(self) -> None:
            self._to(SUCCEEDED)

        def cancel_goal(self, request: Any) -> Any:
            self._to(CANCELED)
            return shared.srv.CancelGoal_Response(0, [request.goal_info])

        def get_result(self, request: Any) -> Any:
            with self.changed:
                self.changed.wait_for(lambda: self.status in (SUCCEEDED, CANCELED))
            done = action.Go_Result(self.status == SUCCEEDED)
            return action.Go_GetResult_Response(self.status, done)

    return Goals()


def component(stack: ExitStack, go: ModuleType, name: str) -> Any:
    """Return a component, which is active."""
    system = stack.enter_context(System(RealClock()))
    base = getattr(getattr(go.components, name), f"{name.capitalize()}Base")
    made = base(f"{name}0")
    system.add(made, 200.0)
    assert system.activate(made.instance_name) == RTC_OK
    until(lambda: system.run(system.time + 10_000_000) or made.is_active)
    return made


def joined(stack: ExitStack, network: Any, made: Any, name: str) -> RosServices:
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    stack.callback(network.close)
    services = RosServices(network, joints_of(made, "go", name, info))
    stack.callback(services.close)
    return services
