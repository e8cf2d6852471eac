"""Verified facts about components and contexts of OpenRTM-aist-Python 2.1: stub, or real one."""

from __future__ import annotations

from typing import Any

import pytest
from openrtm_lab import Lab, answers
from patience import until


def test_a_component_begins_inactive_in_a_running_context(lab: Lab) -> None:
    import RTC

    component = lab.component()
    assert component.calls == ["onInitialize", "onStartup"]
    assert lab.state(component) == RTC.INACTIVE_STATE
    assert lab.context(component).is_running()
    assert component.getObjRef().get_context_handle(lab.context(component)) == 0


def test_a_cycle_executes_then_updates(lab: Lab) -> None:
    import RTC

    component = lab.component()
    assert lab.activate(component) == RTC.RTC_OK
    assert lab.state(component) == RTC.ACTIVE_STATE
    assert component.calls[2] == "onActivated"
    assert lab.tick(component) == ["onExecute", "onStateUpdate"]


def test_a_failed_initialization_leaves_nothing(lab: Lab) -> None:
    import RTC

    kind = lab.kind(onInitialize=answers(RTC.RTC_ERROR))
    assert lab.create(kind) is None
    assert lab.manager.getComponent(f"{kind}0") is None


@pytest.mark.parametrize("failing", ["onExecute", "onStateUpdate"])
def test_an_error_is_followed_by_deactivation_and_abortion(
    lab: Lab, failing: str
) -> None:
    import RTC

    component = lab.component(**{failing: answers(RTC.RTC_OK, RTC.RTC_ERROR)})
    lab.activate(component)
    cycle = lab.tick(component)
    assert cycle[-1] == failing
    assert lab.state(component) == RTC.ACTIVE_STATE
    assert lab.tick(component) == ["onDeactivated", "onAborting", "onError"]
    assert lab.state(component) == RTC.ERROR_STATE
    assert lab.tick(component) == ["onError"]


def test_a_failed_activation_answers_ok(lab: Lab) -> None:
    import RTC

    component = lab.component(onActivated=answers(RTC.RTC_ERROR))
    assert lab.activate(component) == RTC.RTC_OK
    assert "onExecute" not in component.calls
    assert lab.tick(component) == ["onDeactivated", "onAborting", "onError"]
    assert lab.state(component) == RTC.ERROR_STATE


def raising(self: Any, ec_id: int) -> Any:
    raise ValueError("no")


@pytest.mark.parametrize("callback", [answers(None), raising])
def test_what_is_no_code_is_an_error(lab: Lab, callback: Any) -> None:
    import RTC

    component = lab.component(onExecute=callback)
    lab.activate(component)
    lab.tick(component)
    assert lab.state(component) == RTC.ERROR_STATE


def in_error(lab: Lab, **callbacks: Any) -> Any:
    import RTC

    component = lab.component(onExecute=answers(RTC.RTC_ERROR), **callbacks)
    lab.activate(component)
    lab.tick(component)
    return component


def test_reset_ends_the_error(lab: Lab) -> None:
    import RTC

    component = in_error(lab)
    assert lab.reset(component) == RTC.RTC_OK
    assert component.calls[-1] == "onReset"
    assert lab.state(component) == RTC.INACTIVE_STATE


def test_a_failed_reset_stays_in_error(lab: Lab) -> None:
    import RTC

    component = in_error(lab, onReset=answers(RTC.RTC_ERROR))
    lab.reset(component)
    assert "onReset" in component.calls
    assert lab.state(component) == RTC.ERROR_STATE


def test_transitions_from_a_wrong_state_are_refused(lab: Lab) -> None:
    import RTC

    component = lab.component()
    assert lab.deactivate(component) == RTC.PRECONDITION_NOT_MET
    assert lab.reset(component) == RTC.PRECONDITION_NOT_MET
    lab.activate(component)
    assert lab.activate(component) == RTC.PRECONDITION_NOT_MET
    assert lab.reset(component) == RTC.PRECONDITION_NOT_MET
    assert lab.deactivate(component) == RTC.RTC_OK
    assert component.calls[-1] == "onDeactivated"
    assert lab.state(component) == RTC.INACTIVE_STATE


def test_who_does_not_take_part_is_a_bad_parameter(lab: Lab) -> None:
    import RTC

    stranger = lab.component().getObjRef()
    context = lab.context(lab.component())
    for operation in ("activate", "deactivate", "reset"):
        asked = getattr(context, f"{operation}_component")
        assert asked(stranger) == RTC.BAD_PARAMETER


def test_a_context_starts_and_stops_and_keeps_the_states(lab: Lab) -> None:
    import RTC

    component = lab.component()
    context = lab.context(component)
    assert context.start() == RTC.PRECONDITION_NOT_MET
    lab.activate(component)
    assert context.stop() == RTC.RTC_OK
    # A cycle that has begun may end after it.
    assert "onShutdown" in component.calls[-3:]
    assert context.stop() == RTC.PRECONDITION_NOT_MET
    assert lab.state(component) == RTC.ACTIVE_STATE
    assert context.start() == RTC.RTC_OK
    assert "onStartup" in component.calls[-3:]
    assert lab.state(component) == RTC.ACTIVE_STATE


def test_rates(lab: Lab) -> None:
    import RTC

    component = lab.component()
    context = lab.context(component)
    assert context.set_rate(0.0) == RTC.BAD_PARAMETER
    assert context.set_rate(-5.0) == RTC.BAD_PARAMETER
    assert context.set_rate(25.0) == RTC.RTC_OK
    assert component.calls[-1] == "onRateChanged"
    assert context.get_rate() == 25.0


def test_the_rate_of_a_module_specification_has_no_effect(lab: Lab) -> None:
    component = lab.component("exec_cxt.periodic.rate", "7")
    assert lab.context(component).get_rate() == 1000.0


def test_exit_runs_the_last_callbacks(lab: Lab) -> None:
    component = lab.component()
    lab.activate(component)
    before = len(component.calls)
    lab.made.remove(component)
    component.exit()
    last = [name for name in component.calls[before:] if not name.startswith("onE")]
    assert last == ["onDeactivated", "onFinalize", "onShutdown"]
    until(lambda: lab.manager.getComponent(component.getInstanceName()) is None)


def test_each_phase_runs_over_all_participants(lab: Lab) -> None:
    import RTC

    order: list[str] = []

    def note(name: str) -> Any:
        def callback(self: Any, ec_id: int) -> Any:
            order.append(f"{name} {ec_id >= 1000}")
            return RTC.RTC_OK

        return callback

    first, second = (
        lab.component(onExecute=note("execute"), onStateUpdate=note("update"))
        for _ in range(2)
    )
    context = lab.context(first)
    assert context.add_component(second.getObjRef()) == RTC.RTC_OK
    assert second.getObjRef().get_context_handle(context) == 1000
    lab.activate(first)
    context.activate_component(second.getObjRef())
    order.clear()
    lab.tick(first)
    expected = ["execute False", "execute True", "update False", "update True"]
    assert order == expected
    assert context.remove_component(second.getObjRef()) == RTC.RTC_OK


def test_arguments_of_a_creation_stay_for_the_next_one(lab: Lab) -> None:
    kind = lab.kind("conf.default.gain", "1")
    first = lab.create(f"{kind}?instance_name=Chosen{kind}&conf.default.gain=2")
    second = lab.create(kind)
    for component in (first, second):
        assert component.getInstanceName() == f"Chosen{kind}"
        assert component.getProperties().getProperty("conf.default.gain") == "2"


def test_instances_are_numbered_from_zero(lab: Lab) -> None:
    kind = lab.kind()
    assert [lab.create(kind).getInstanceName() for _ in range(2)] == [
        f"{kind}0",
        f"{kind}1",
    ]


def test_a_profile_has_what_the_specification_says(lab: Lab) -> None:
    component = lab.component("own.property", "seen")
    profile = component.getObjRef().get_component_profile()
    assert profile.instance_name == component.getInstanceName()
    assert profile.type_name == component.getTypeName()
    assert (profile.description, profile.version) == ("a test", "1.0")
    assert (profile.vendor, profile.category) == ("labs", "lab")
    by_manager = lab.rtm.get_component_profile(component.getObjRef())
    assert by_manager.getProperty("own.property") == "seen"


def test_a_transition_need_not_be_waited_for(lab: Lab) -> None:
    import RTC

    kind = lab.kind()
    component = lab.create(f"{kind}?exec_cxt.sync_transition=NO")
    assert lab.activate(component) == RTC.RTC_OK
    assert lab.state(component) == RTC.INACTIVE_STATE
    lab.tick(component)
    assert lab.state(component) == RTC.ACTIVE_STATE


def test_a_component_always_has_a_context(lab: Lab) -> None:
    """`None` selects the default one, whatever the manager's options."""
    import OpenRTM

    component = lab.component("execution_contexts", "None")
    [context] = component.getObjRef().get_owned_contexts()
    assert context._narrow(OpenRTM.ExtTrigExecutionContextService) is None
    assert context.get_rate() == 1000.0


def test_a_taken_instance_name_gives_the_component_that_has_it(lab: Lab) -> None:
    kind = lab.kind()
    first = lab.create(f"{kind}?instance_name=Only{kind}")
    assert lab.manager.createComponent(f"{kind}?instance_name=Only{kind}") is first


def test_a_port_is_called_by_what_follows_the_last_dot(lab: Lab) -> None:
    import RTC

    component = lab.component()
    out = lab.rtm.OutPort(".some.position", RTC.TimedLong(RTC.Time(0, 0), 0))
    assert component.addOutPort(".some.position", out)
    instance = component.getInstanceName()
    assert out.getPortRef().get_port_profile().name == f"{instance}.position"
    other = lab.rtm.InPort("position", RTC.TimedLong(RTC.Time(0, 0), 0))
    assert not component.addInPort("position", other)
