"""Service ports that cannot be actions; `test_ros_conformance` has those that are."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from types import ModuleType
from typing import Any

import pytest
from action_package import generated
from patience import until

from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.ros2.actions import joints_of
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.services.servants import ServiceError
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


@pytest.fixture(scope="module")
def go(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    return generated(tmp_path_factory.mktemp("actions"), IDL, "ros_go")


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def component(stack: ExitStack, go: ModuleType, name: str) -> Any:
    """Return a component, which is active."""
    system = stack.enter_context(System(RealClock()))
    base = getattr(getattr(go.components, name), f"{name.capitalize()}Base")
    made = base(f"{name}0")
    system.add(made, 200.0)
    assert system.activate(made.instance_name) == RTC_OK
    until(lambda: system.run(system.time + 10_000_000) or made.is_active)
    return made


@pytest.mark.parametrize(
    ("name", "port", "why"),
    [
        ("mover", "way", "mover0 has no service port 'way'; known: go, alone"),
        ("mover", "alone", "mover0.alone provides lab::action::Go, but does not use "),
        ("asker", "other", "asker0.other has no interface of an action: lab::action::"),
        ("asker", "both", "asker0.both uses both lab::action::Go and lab::action::Go_"),
    ],
)
def test_other_ports_are_refused(
    go: ModuleType, stack: ExitStack, name: str, port: str, why: str
) -> None:
    made = component(stack, go, name)
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    with pytest.raises(ServiceError, match=why):
        list(joints_of(made, port, "/go", info))
