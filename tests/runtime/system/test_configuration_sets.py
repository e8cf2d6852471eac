"""Configuration sets: when values change, refused values, and `.conf` files over code."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import pytest
from runtime_samples import MS, activated

from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    ConfFileError,
    ParameterProfile,
    ParameterValueError,
    ReturnCode_t,
    System,
    UnknownComponentError,
    UnknownConfigurationSetError,
    UnknownParameterError,
)
from rtgen.runtime.rtc.conf_file import parse, read


@dataclass(slots=True)
class Configuration:
    gain: float = 1.0
    p01_x: int = 3
    name: str = "code"
    limits: list[float] = field(default_factory=lambda: [1.0, 2.0])


class Configured(Component):
    profile: ClassVar[ComponentProfile] = ComponentProfile(
        "Configured",
        rate=1000.0,
        configuration=(
            ParameterProfile("gain", "gain", "double", "1.0", minimum=0.0),
            ParameterProfile("01_x", "p01_x", "short", "3"),
            ParameterProfile("name", "name", "string", "code"),
            ParameterProfile("limits", "limits", "sequence<double>", "1.0,2.0"),
        ),
    )

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.config = self.add_configuration(Configuration())
        self.seen: list[tuple[str, float, int]] = []

    def note(self, callback: str) -> ReturnCode_t:
        self.seen.append((callback, self.config.gain, self.config.p01_x))
        return RTC_OK

    def on_initialize(self) -> ReturnCode_t:
        return self.note("on_initialize")

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        return self.note("on_activated")

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return self.note("on_execute")

    def on_state_update(self, ec_id: int) -> ReturnCode_t:
        return self.note("on_state_update")


@pytest.fixture
def component() -> Configured:
    return Configured()


@pytest.fixture
def system(component: Configured) -> System:
    return activated(System(), component)


def test_values_of_the_code_hold_without_any_other(component: Configured) -> None:
    assert component.config == Configuration()
    assert component.configuration_sets.ids == ("default",)
    assert component.configuration_sets.texts() == {
        "gain": "1.0",
        "01_x": "3",
        "name": "code",
        "limits": "1.0,2.0",
    }


def test_what_is_set_before_is_there_in_on_initialize(component: Configured) -> None:
    component.configuration_sets.set("gain", "2.5")
    System().add(component)
    assert component.seen == [("on_initialize", 2.5, 3)]


def test_values_change_between_cycles_only(
    system: System, component: Configured
) -> None:
    def change() -> None:
        system.configure("Configured0", "gain", "2")
        system.configure("Configured0", "01_x", "4")

    original = component.note

    def changing(callback: str) -> ReturnCode_t:
        if callback == "on_execute" and system.time == MS:
            change()
        return original(callback)

    component.note = changing  # type: ignore[method-assign]
    system.run(until_ns=3 * MS)
    cycles = [values for name, *values in component.seen if name == "on_execute"]
    updates = [values for name, *values in component.seen if name == "on_state_update"]
    assert cycles == [[1.0, 3], [1.0, 3], [2.0, 4]]
    assert updates == cycles


def test_values_are_there_before_on_activated(component: Configured) -> None:
    system = activated(System(), component)
    system.configure("Configured0", "gain", "2")
    system.run(until_ns=1)
    assert component.seen[1] == ("on_activated", 2.0, 3)


def test_a_set_is_switched_as_a_whole_between_cycles(
    system: System, component: Configured
) -> None:
    system.configure("Configured0", "gain", "5", "fast")
    system.configure("Configured0", "01_x", "6", "fast")
    system.configure("Configured0", "01_x", "7")
    system.run(until_ns=1 * MS)
    assert (component.config.gain, component.config.p01_x) == (1.0, 7)
    system.activate_set("Configured0", "fast")
    assert (component.config.gain, component.config.p01_x) == (1.0, 7)
    system.run(until_ns=2 * MS)
    assert (component.config.gain, component.config.p01_x) == (5.0, 6)
    assert component.configuration_sets.active == "fast"
    assert component.configuration_sets.ids == ("default", "fast")
    assert component.configuration_sets.texts("fast")["name"] == "code"
    system.activate_set("Configured0", "default")
    system.run(until_ns=3 * MS)
    assert (component.config.gain, component.config.p01_x) == (1.0, 7)


def test_a_set_takes_what_it_lacks_from_default(
    system: System, component: Configured
) -> None:
    system.configure("Configured0", "gain", "5", "fast")
    system.activate_set("Configured0", "fast")
    system.configure("Configured0", "name", "told")
    system.run(until_ns=1)
    assert component.config == Configuration(5.0, 3, "told")


def test_a_set_is_removed(system: System, component: Configured) -> None:
    sets = component.configuration_sets
    system.configure("Configured0", "gain", "5", "fast")
    system.activate_set("Configured0", "fast")
    for kept in ("fast", "default", "nothing"):
        with pytest.raises(UnknownConfigurationSetError, match="that can be removed"):
            sets.remove(kept)
    system.activate_set("Configured0", "default")
    sets.remove("fast")
    assert sets.ids == ("default",)


def test_bad_texts_are_refused_and_change_nothing(
    system: System, component: Configured
) -> None:
    with pytest.raises(
        ParameterValueError, match="'gain' cannot be '-1': it must be at least 0"
    ):
        system.configure("Configured0", "gain", "-1")
    with pytest.raises(
        UnknownParameterError, match="no configuration parameter 'gian'; known: gain"
    ):
        system.configure("Configured0", "gian", "1")
    with pytest.raises(
        UnknownConfigurationSetError, match="no configuration set 'slow'"
    ):
        system.activate_set("Configured0", "slow")
    with pytest.raises(UnknownComponentError):
        system.configure("Nobody0", "gain", "1")
    system.run(until_ns=1)
    assert component.config == Configuration()
    assert component.configuration_sets.ids == ("default",)


def test_a_list_of_the_component_is_its_own(
    system: System, component: Configured
) -> None:
    system.configure("Configured0", "limits", "5,6")
    system.run(until_ns=1)
    component.config.limits.append(7.0)
    system.configure("Configured0", "gain", "2")
    system.run(until_ns=2 * MS)
    assert component.config.limits == [5.0, 6.0, 7.0]
    assert component.configuration_sets.texts()["limits"] == "5,6"


def test_conf_file_over_code_and_later_calls_over_the_file(
    component: Configured,
) -> None:
    conf = parse("""
        # a comment
        conf.default.gain: 2.0
        conf.default.01_x: 4
        conf.mode1.gain: 4.0
        configuration.active_config: mode1
        exec_cxt.periodic.rate: 100
        conf.__widget__.gain: spin
        logger.enable: NO
        """)
    component.configuration_sets.load(conf)
    component.configuration_sets.set("01_x", "5")
    system = System()
    context = system.add(component)
    assert (component.config.gain, component.config.p01_x) == (4.0, 5)
    assert component.configuration_sets.active == "mode1"
    assert context.get_rate() == 100.0
    assert conf.others == {"conf.__widget__.gain": "spin", "logger.enable": "NO"}


def test_rate_of_the_system_over_that_of_the_file(component: Configured) -> None:
    component.configuration_sets.load(parse("exec_cxt.periodic.rate: 100"))
    assert System().add(component, 50.0).get_rate() == 50.0
    assert System().add(Configured()).get_rate() == 1000.0


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("conf.default.gain: 2\nconf.default.ghost: 1", UnknownParameterError),
        ("conf.default.gain: 2\nconf.default.01_x: much", ParameterValueError),
        (
            "conf.default.gain: 2\nconfiguration.active_config: none",
            UnknownConfigurationSetError,
        ),
    ],
)
def test_a_bad_conf_file_is_taken_all_or_nothing(
    component: Configured, text: str, error: type[Exception]
) -> None:
    with pytest.raises(error):
        component.configuration_sets.load(parse(text))
    component.configuration_sets.apply()
    assert component.config == Configuration()


def test_conf_syntax() -> None:
    conf = parse(
        "\ufeffconf.default.a: 1\\\n   , 2 \\\n\n"
        "conf.default.b = x=y: z\n"
        "  conf.default.c:\n"
        "conf.default.a.b: dotted\n"
        "conf.default.b = last\n"
        "conf.default.d: joined \\"
    )
    assert conf.sets == {
        "default": {"a": "1, 2", "b": "last", "c": "", "a.b": "dotted", "d": "joined"}
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\nnonsense\n", "odo.conf:2: this is not of the form `key: value`"),
        (
            "conf.gain: 1",
            "odo.conf:1: 'conf.gain' is not of the form conf.<set>.<parameter>",
        ),
        ("conf..gain: 1", "'conf..gain' is not of the form"),
        (
            "# x\nexec_cxt.periodic.rate: 0",
            "odo.conf:2: the rate '0' must be a number of Hz",
        ),
        ("exec_cxt.periodic.rate: often", "the rate 'often' must be"),
    ],
)
def test_bad_conf_syntax(text: str, message: str) -> None:
    with pytest.raises(ConfFileError) as caught:
        parse(text, "odo.conf")
    assert message in str(caught.value)


def test_reading_a_conf_file(tmp_path: Path) -> None:
    path = tmp_path / "Odometry.conf"
    path.write_text("conf.default.gain: 2.0\n", encoding="utf-8")
    assert read(path).sets == {"default": {"gain": "2.0"}}
    with pytest.raises(ConfFileError, match="No such file"):
        read(tmp_path / "missing.conf")
    for codec in ("utf-8-sig", "cp932", "euc_jp", "utf-16"):
        path.write_text("conf.default.name: 表示\n# 能\nconf.a.b: 1", encoding=codec)
        assert read(path).sets == {"default": {"name": "表示"}, "a": {"b": "1"}}


def test_a_component_without_configuration() -> None:
    class Plain(Component):
        profile: ClassVar[ComponentProfile] = ComponentProfile("Plain")

    plain: Any = Plain()
    with pytest.raises(UnknownParameterError, match="known: none"):
        plain.configuration_sets.set("gain", "1")
