"""`rtgen conformance` of running components: rtgen's pass, and violations fail their check."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from corba_runs import NAVIGATION, ROOT, wait_for
from json_schemas import valid
from omniORB import CORBA
from omniORB import any as anys

from rtgen import compile as compiled
from rtgen.cli import run as rtgen
from rtgen.cli.components.chosen_component import chosen
from rtgen.cli.conformance.check import Permission
from rtgen.cli.conformance.report import Report, Verdict
from rtgen.cli.conformance.rtc.checks import CHECKS
from rtgen.cli.conformance.rtc.component import RtcUnderTest
from rtgen.cli.conformance.rtc.expected import Expected
from rtgen.cli.conformance.rtc.testing import checked
from rtgen.diagnostics import ToolError
from rtgen.facts.connector_properties import STRICTNESS
from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.component import ContextService, RtObject
from rtgen.runtime.corba.rt_objects.configuration import Configuration
from rtgen.runtime.corba.rt_objects.foreign import located
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import ConnectorProfile, texts, values
from rtgen.runtime.corba.transport import CorbaTransport
from rtgen.runtime.return_codes import (
    PRECONDITION_NOT_MET,
    ExecutionKind,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.configuration import ConfigurationSets
from rtgen.runtime.rtc.execution_context import ExecutionContext

if TYPE_CHECKING:
    from corba_runs import Run

PATIENCE = 5.0
"""Time for a working component to reach a state [s]."""
SOON = 0.2
"""Time-out for a component that never reaches it [s]."""

IDL = """module Bench {
  struct Level { long value; };
  enum Mode { SLOW, FAST };
  interface Valve { void open(); };
  interface Pump { void run(); };
};

/** Measures. */
@rtc(category="Test", vendor="labs", version="2.1.0", rate=200.0)
component Gauge {
  consumes Bench::Level level;
  publishes Bench::Level shown;
  @port("valves") provides Bench::Valve own;
  @port("valves") uses Bench::Pump other;
  @default(2.0) @min(0.5) @max(8.0) attribute double gain;
  @default(3) @constraint("x>0") attribute long count;
  attribute Bench::Mode mode;
  attribute sequence<double> weights;
  attribute string label;
};

component Idle { publishes Bench::Level shown; };
"""
SETTINGS = """[sources]
paths = ["gauge.idl"]
[output]
package = "gaugebot"
skeletons = "src/gaugenodes"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a project with a component."""
    folder = tmp_path_factory.mktemp("conformance")
    (folder / "gauge.idl").write_text(IDL)
    (folder / "rtgen.toml").write_text(SETTINGS)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q"]) == 0
        patch.setattr(sys, "path", [str(folder / "generated"), *sys.path])
        importlib.invalidate_caches()
        yield folder


@pytest.fixture(scope="module")
def gauge(folder: Path, names: str) -> Iterator[Any]:
    """Yield the running component."""
    module = importlib.import_module("gaugebot.components.gauge")
    bench = importlib.import_module("gaugebot.bench")

    class Valve(bench.Valve):  # type: ignore[misc, name-defined]
        def open(self) -> None:
            """Do nothing."""

    class Gauge(module.GaugeBase):  # type: ignore[misc, name-defined]
        def on_initialize(self) -> Any:
            self.own.set_servant(Valve())
            return RTC_OK

    with (
        CorbaTransport(name_server=names) as transport,
        System(RealClock(), transport) as system,
    ):
        made = Gauge("Gauge0")
        system.add(made, 200.0)
        system.run(until_ns=1)
        yield made


@pytest.fixture(scope="module")
def expected(folder: Path) -> Expected:
    return definition(folder / "gauge.idl")


def definition(file: Path, component: str = "Gauge") -> Expected:
    """Return the expectations of a definition file."""
    model = compiled([file])
    [name] = (source.name for source in model.files if source.main)
    return Expected(model, chosen(model, name, component))


def report_of(
    expected: Expected,
    names: str,
    permissions: Collection[Permission] = tuple(Permission),
    patience: float = PATIENCE,
) -> Report:
    with closing(Orb()) as orb:
        exported = Exported(orb)
        found = located(
            f"{names}/Gauge0.rtc", exported, lambda address: Naming(orb.orb, address)
        )
        rtc = RtcUnderTest(expected, found, exported, patience)
        return checked(rtc, "Gauge0", "gauge.idl", permissions)


def failed(report: Report) -> list[str]:
    return [o.check for o in report.outcomes if o.verdict is Verdict.FAILED]


def state_of(component: Any) -> str:
    [context] = component.get_owned_contexts()
    return str(context.get_component_state(component).name)


def test_a_component_of_ours_passes_every_check(
    gauge: Any, expected: Expected, names: str
) -> None:
    report = report_of(expected, names)
    skipped = {
        "life-cycle.error": "it is not in ERROR, and no request leads there",
        "exit": "it ends only with its process: exit returned UNSUPPORTED",
    }
    assert [(o.check, o.verdict, o.problems) for o in report.outcomes] == [
        (
            (check.name, Verdict.SKIPPED, (skipped[check.name],))
            if check.name in skipped
            else (check.name, Verdict.PASSED, ())
        )
        for check in CHECKS
    ]


def test_nothing_is_changed_without_permission(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    called: list[str] = []
    changing = {
        ContextService: "start stop set_rate activate_component deactivate_component "
        "reset_component add_component remove_component",
        Configuration: "set_configuration_set_values activate_configuration_set "
        "set_configuration_parameter add_configuration_set remove_configuration_set",
        RtObject: "initialize finalize exit attach_context detach_context",
        PortService: "connect notify_connect disconnect_all notify_disconnect",
    }
    for class_, operations in changing.items():
        for operation in operations.split():

            def noted(self: Any, *given: Any, name: str = operation) -> None:
                called.append(name)

            monkeypatch.setattr(class_, operation, noted)
    report = report_of(expected, names, ())
    assert called == []
    assert report.passed
    assert [o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED] == [
        check.name for check in CHECKS if check.needs is not None
    ]


def otherwise(
    change: Callable[[Any], Any], when: Callable[..., bool] = lambda *given: True
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a method that returns another answer for some arguments."""

    def broken(right: Callable[..., Any]) -> Callable[..., Any]:
        def wrong(self: Any, *given: Any) -> Any:
            found = right(self, *given)
            return change(found) if when(self, *given) else found

        return wrong

    return broken


def instead(
    answer: Callable[..., Any], when: Callable[..., bool] = lambda *given: True
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a method that does something else for some arguments."""

    def broken(right: Callable[..., Any]) -> Callable[..., Any]:
        def wrong(self: Any, *given: Any) -> Any:
            return (answer if when(self, *given) else right)(self, *given)

        return wrong

    return broken


def in_port(name: str, **changed: Any) -> Callable[[Any], Any]:
    """Return a component profile in which one port is changed."""
    return changed_port(name, lambda port: replace(port, **changed))


def changed_port(name: str, change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a component profile with another profile of a port."""

    def changed(profile: Any) -> Any:
        ports = [
            change(port) if port.name.endswith(f".{name}") else port
            for port in profile.port_profiles
        ]
        return replace(profile, port_profiles=ports)

    return changed


def typed(kind: str, type_: str) -> list[Any]:
    return values({"port.port_type": kind, "dataport.data_type": type_})


def state(self: ContextService) -> LifeCycleState:
    return self.context.get_component_state(self._owner.component)


def is_state(name: str) -> Callable[..., bool]:
    return lambda self, given: is_known(self, given) and state(self).name == name


def is_known(self: ContextService, reference: Any) -> bool:
    return self._component(reference) is not None


def pairs(given: Any) -> dict[str, str]:
    return {each.name: each.value.value() for each in given.configuration_data}


def is_value(name: str, *texts: str) -> Callable[..., bool]:
    return lambda self, given: pairs(given).get(name) in texts


def is_unknown_text(self: Any, given: Any) -> bool:
    return pairs(given).get("count") == "no value"


def pretend(self: Any, *given: Any) -> bool:
    return True


def taken(self: Any, profile: Any) -> Any:
    return RTC_OK, profile


def has(key: str, text: str) -> Callable[..., bool]:
    return lambda self, profile: (
        text in [each.value.value() for each in profile.properties if each.name == key]
    )


def ok(self: Any, *given: Any) -> Any:
    return RTC_OK


LEVEL = "IDL:Bench/Level:1.0"
PROFILE = "get_component_profile"
MUTANTS: dict[str, tuple[type, str, Callable[..., Any]]] = {
    "profile": (RtObject, PROFILE, otherwise(lambda p: replace(p, version="2.1.1"))),
    "profile.properties": (
        RtObject,
        PROFILE,
        otherwise(lambda p: replace(p, properties=values({"max_instance": "7"}))),
    ),
    "profile.identity": (RtObject, "get_sdo_id", otherwise(lambda _: "Gauge1")),
    "ports.directions": (
        RtObject,
        PROFILE,
        otherwise(in_port("shown", properties=typed("DataInPort", LEVEL))),
    ),
    "ports.types": (
        RtObject,
        PROFILE,
        otherwise(in_port("shown", properties=typed("DataOutPort", "IDL:Other:1.0"))),
    ),
    "ports.interfaces": (
        RtObject,
        PROFILE,
        otherwise(in_port("valves", interfaces=[])),
    ),
    "ports.references": (RtObject, "get_ports", otherwise(lambda ports: ports[1:])),
    "ports.unknown": (PortService, "disconnect", otherwise(lambda _: RTC_OK)),
    "configuration.active": (
        Configuration,
        "get_active_configuration_set",
        otherwise(lambda found: replace(found, id="other")),
    ),
    "configuration.unknown": (
        Configuration,
        "get_configuration_set",
        instead(lambda self, name: self.get_active_configuration_set()),
    ),
    "contexts.profile": (
        ContextService,
        "get_profile",
        otherwise(lambda found: replace(found, rate=found.rate + 1)),
    ),
    "contexts.handles": (RtObject, "get_context", otherwise(lambda _: None)),
    "contexts.kind": (
        ExecutionContext,
        "get_kind",
        otherwise(lambda _: ExecutionKind.EVENT_DRIVEN),
    ),
    "contexts.state": (
        ContextService,
        "get_component_state",
        otherwise(lambda _: LifeCycleState.CREATED_STATE),
    ),
    "configuration.values": (
        ConfigurationSets,
        "texts",
        otherwise(lambda found: {**found, "count": "-5"}),
    ),
    "life-cycle.activation": (
        ContextService,
        "activate_component",
        instead(ok, is_state("INACTIVE_STATE")),
    ),
    "life-cycle.inactive": (
        ContextService,
        "reset_component",
        instead(ok, is_state("INACTIVE_STATE")),
    ),
    "life-cycle.active": (
        ContextService,
        "activate_component",
        instead(ok, is_state("ACTIVE_STATE")),
    ),
    "life-cycle.initialization": (RtObject, "finalize", otherwise(lambda _: RTC_OK)),
    "contexts.strangers": (
        ContextService,
        "activate_component",
        instead(ok, lambda self, reference: not is_known(self, reference)),
    ),
    "contexts.running": (
        ContextService,
        "start",
        instead(ok, lambda self: self.context.is_running()),
    ),
    "contexts.rate": (
        ContextService,
        "set_rate",
        instead(ok, lambda self, rate: rate <= 0),
    ),
    "configuration.set": (
        Configuration,
        "set_configuration_set_values",
        instead(pretend, is_value("mode", "FAST")),
    ),
    "configuration.limits": (
        Configuration,
        "set_configuration_set_values",
        instead(pretend, is_value("count", "0", "-1")),
    ),
    "configuration.types": (
        Configuration,
        "set_configuration_set_values",
        instead(pretend, is_unknown_text),
    ),
    "connections": (
        PortService,
        "get_connector_profile",
        otherwise(lambda found: replace(found, name="other")),
    ),
    "connections.types": (
        PortService,
        "connect",
        instead(taken, has("dataport.data_type", "IDL:rtgen/Conformance/NoType:1.0")),
    ),
    "connections.interfaces": (
        PortService,
        "connect",
        instead(taken, has("dataport.interface_type", "rtgen-conformance-none")),
    ),
    "configuration.sets": (
        Configuration,
        "activate_configuration_set",
        instead(pretend, lambda self, name: name not in self._sets.ids),
    ),
    "configuration.defaults": (
        ConfigurationSets,
        "texts",
        otherwise(lambda found: {**found, "count": "4"}),
    ),
    "connections.services": (
        PortService,
        "connect",
        instead(taken, has(STRICTNESS, "strict")),
    ),
    "exit": (RtObject, "exit", instead(ok)),
    "configuration.reads": (
        Configuration,
        "get_configuration_parameter_value",
        otherwise(lambda _: anys.to_any("17")),
    ),
    "configuration.parameters": (
        Configuration,
        "set_configuration_parameter",
        instead(pretend),
    ),
    "configuration.added": (
        Configuration,
        "add_configuration_set",
        instead(pretend, lambda self, given: given.id not in self._sets.ids),
    ),
    "contexts.defaults": (
        ExecutionContext,
        "get_rate",
        otherwise(lambda rate: rate / 2),
    ),
    "connections.all": (PortService, "disconnect_all", instead(ok)),
}
WITHOUT_MUTANT = {"ports.names", "configuration.names", "life-cycle.error", "left"}
"""Checks that have tests of their own."""


def with_property(key: str, text: str) -> Callable[[Any], Any]:
    """Return a change of an answer: another value of a property that its profile has."""

    def change(found: Any) -> Any:
        if isinstance(found, tuple):
            return found[0], change(found[1])
        stated = texts(found.properties)
        if key not in stated:
            return found
        return replace(found, properties=values({**stated, key: text}))

    return change


def but(operation: str) -> Callable[..., Any]:
    """Return a method of a context that refuses a request, and carries out another one."""

    def answer(self: ContextService, _reference: Any) -> ReturnCode_t:
        getattr(self.context, operation)(self._owner.component)
        return PRECONDITION_NOT_MET

    return answer


def set_two(self: Configuration, given: Any) -> bool:
    self._sets.set("label", f"beside {pairs(given)}", "default")
    return self.add_configuration_set(given)


FURTHER: list[tuple[str, str, tuple[type, str, Callable[..., Any]]]] = [
    (
        "ports.names",
        "a port twice",
        (
            RtObject,
            PROFILE,
            otherwise(
                lambda p: replace(p, port_profiles=[*p.port_profiles, *p.port_profiles])
            ),
        ),
    ),
    (
        "ports.interfaces",
        "an interface twice",
        (
            RtObject,
            PROFILE,
            otherwise(
                changed_port(
                    "valves", lambda p: replace(p, interfaces=2 * p.interfaces)
                )
            ),
        ),
    ),
    (
        "ports.unknown",
        "a profile of an unknown connector",
        (
            PortService,
            "get_connector_profile",
            otherwise(lambda p: replace(p, connector_id=p.connector_id or "other")),
        ),
    ),
    (
        "contexts.profile",
        "a participant twice",
        (
            ContextService,
            "get_profile",
            otherwise(lambda p: replace(p, participants=[p.owner, p.owner])),
        ),
    ),
    (
        "contexts.handles",
        "a context twice",
        (RtObject, "get_owned_contexts", otherwise(lambda found: 2 * found)),
    ),
    (
        "contexts.handles",
        "a context of an unknown handle",
        (
            RtObject,
            "get_context",
            instead(lambda self, _: self.get_owned_contexts()[0]),
        ),
    ),
    (
        "life-cycle.inactive",
        "a refused deactivation that activates",
        (
            ContextService,
            "deactivate_component",
            instead(but("activate_component"), is_state("INACTIVE_STATE")),
        ),
    ),
    (
        "life-cycle.active",
        "a refused reset that deactivates",
        (
            ContextService,
            "reset_component",
            instead(but("deactivate_component"), is_state("ACTIVE_STATE")),
        ),
    ),
    (
        "configuration.set",
        "another parameter is set, too",
        (
            Configuration,
            "set_configuration_set_values",
            instead(set_two, is_value("mode", "FAST")),
        ),
    ),
    *[
        (
            "connections",
            f"{operation} with another {key}",
            (
                PortService,
                operation,
                otherwise(with_property(key, text)),
            ),
        )
        for operation, key, text in (
            ("connect", "dataport.interface_type", "data_service"),
            ("connect", "dataport.dataflow_type", "pull"),
            ("connect", "dataport.corba_cdr.inport_ior", "IOR:00"),
            ("get_connector_profile", "dataport.interface_type", "data_service"),
        )
    ],
    (
        "connections",
        "a port profile without connectors",
        (
            PortService,
            "get_port_profile",
            otherwise(lambda p: replace(p, connector_profiles=[])),
        ),
    ),
]
"""Further violations: the check that fails, what is wrong, and the mutant."""


def test_each_check_has_a_mutant() -> None:
    assert {*MUTANTS, *WITHOUT_MUTANT} == {check.name for check in CHECKS}


@pytest.mark.parametrize("name", MUTANTS)
def test_a_check_fails_for_a_component_that_breaks_just_it(
    name: str,
    gauge: Any,
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert failed_of(name, MUTANTS[name], expected, names, monkeypatch) == [name]
    assert state_of(gauge) == "INACTIVE_STATE"


@pytest.mark.parametrize(
    ("name", "mutant"), [pytest.param(n, m, id=f"{n}: {w}") for n, w, m in FURTHER]
)
def test_further_violations(
    name: str,
    mutant: tuple[type, str, Callable[..., Any]],
    gauge: Any,
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert failed_of(name, mutant, expected, names, monkeypatch) == [name]
    assert state_of(gauge) == "INACTIVE_STATE"


def failed_of(
    name: str,
    mutant: tuple[type, str, Callable[..., Any]],
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> list[str]:
    """Return the failed checks of a mutant, tested with the permission of one check."""
    class_, operation, broken = mutant
    needed = next(check.needs for check in CHECKS if check.name == name)
    with monkeypatch.context() as patch:
        patch.setattr(class_, operation, broken(getattr(class_, operation)))
        report = report_of(expected, names, [needed] if needed else [], SOON)
    return failed(report)


def of_another_type(profile: Any) -> Any:
    """Return a component profile whose service interfaces have an unknown type."""
    ports = [
        replace(
            port,
            interfaces=[replace(i, type_name="Bench::Tap") for i in port.interfaces],
        )
        for port in profile.port_profiles
    ]
    return replace(profile, port_profiles=ports)


def test_service_interfaces_of_another_type(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = otherwise(of_another_type)(RtObject.get_component_profile)
    monkeypatch.setattr(RtObject, PROFILE, wrong)
    report = report_of(expected, names, ())
    assert failed(report) == ["ports.interfaces"]
    [outcome] = [o for o in report.outcomes if o.check == "ports.interfaces"]
    assert outcome.problems == (
        "valves: provided Valve has type Bench::Tap, not IDL:Bench/Valve:1.0",
        "valves: required Pump has type Bench::Tap, not IDL:Bench/Pump:1.0",
    )


@pytest.mark.parametrize(
    ("offered", "problem"),
    [
        (lambda ior, key: key, "the connector has no reference of it"),
        (lambda ior, key: ior, "its object is no IDL:Bench/Valve:1.0"),
    ],
)
def test_a_provided_interface_whose_object_is_of_another_type(
    offered: Callable[[str, str], str],
    problem: str,
    gauge: Any,
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = PortService.connect

    def connect(self: PortService, profile: Any) -> Any:
        code, made = right(self, profile)
        own = self._ports.exported.text(self.reference)
        changed = {
            key if offered(own, key) == own else f"other.{key}": own
            for key in texts(made.properties)
            if key.startswith("port.") and key.endswith(".Valve")
        }
        kept = [p for p in made.properties if not p.name.endswith(".Valve")]
        return code, replace(made, properties=[*kept, *values(changed)])

    monkeypatch.setattr(PortService, "connect", connect)
    report = report_of(expected, names)
    assert failed(report) == ["connections.services"]
    [outcome] = [o for o in report.outcomes if o.check == "connections.services"]
    assert outcome.problems == (f"valves.Valve: {problem}",)


def test_other_connections_of_a_port_are_kept(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = ConnectorProfile("other", "other", [], [])
    found = PortService.get_connector_profiles
    ended: list[PortService] = []
    monkeypatch.setattr(
        PortService, "get_connector_profiles", lambda self: [*found(self), other]
    )
    monkeypatch.setattr(PortService, "disconnect_all", ended.append)
    report = report_of(expected, names, [Permission.ACTUATE])
    [outcome] = [o for o in report.outcomes if o.check == "connections.all"]
    assert outcome.verdict is Verdict.SKIPPED
    assert outcome.problems == ("each port has other connections",)
    assert failed(report) == []
    assert ended == []


def test_a_participant_in_the_context_of_another_component(
    folder: Path, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such a context has one reference and one owner; its profile lists the participant."""
    module = importlib.import_module("gaugebot.components.idle")
    with (
        CorbaTransport(name_server=names) as transport,
        System(RealClock(), transport) as system,
        closing(Orb()) as orb,
    ):
        for instance in ("Idle0", "Idle1"):
            system.add(module.IdleBase(instance), 100.0)
        system.run(until_ns=1)
        exported = Exported(orb)
        expected = definition(folder / "gauge.idl", "Idle")

        def idle(instance: str) -> RtcUnderTest:
            place = f"{names}/{instance}.rtc"
            found = located(place, exported, lambda to: Naming(orb.orb, to))
            return RtcUnderTest(expected, found, exported, PATIENCE)

        owner, other = idle("Idle0"), idle("Idle1")
        context = owner.context
        assert owner.ask(context, "add_component", other.reference) is RTC_OK
        [found] = other.call("get_participating_contexts")
        assert found._is_equivalent(context)
        profile = other.ask(found, "get_profile")
        assert profile.owner._is_equivalent(owner.reference)
        [participant] = profile.participants
        assert participant._is_equivalent(other.reference)
        assert failed(checked(other, "Idle1", "gauge.idl", [])) == []
        monkeypatch.setattr(
            ContextService,
            "get_profile",
            otherwise(lambda p: replace(p, participants=[]))(
                ContextService.get_profile
            ),
        )
        report = checked(other, "Idle1", "gauge.idl", [])
        assert failed(report) == ["contexts.profile"]


def test_a_component_that_exits_is_gone(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone: list[bool] = []
    alive = RtObject.is_alive

    def is_alive(self: RtObject, reference: Any) -> bool:
        if gone:
            raise CORBA.OBJECT_NOT_EXIST
        return alive(self, reference)

    def leaves(self: RtObject) -> Any:
        gone.append(True)
        return RTC_OK

    monkeypatch.setattr(RtObject, "is_alive", is_alive)
    monkeypatch.setattr(RtObject, "exit", leaves)
    report = report_of(expected, names, [Permission.EXIT])
    assert report.passed
    assert report.outcomes[-1].verdict is Verdict.PASSED


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (
            ("component Gauge {", "component Gauge { publishes Bench::Level more;"),
            "ports.names",
        ),
        (("publishes Bench::Level shown;\n  @", "@"), "ports.names"),
        (("attribute string label;", ""), "configuration.names"),
        (("string label;", "string label, more;"), "configuration.names"),
        (("provides Bench::Valve own", "uses Bench::Valve own"), "ports.interfaces"),
        (
            ("consumes Bench::Level level", "publishes Bench::Level level"),
            "ports.directions",
        ),
        (('vendor="labs"', 'vendor="other"'), "profile"),
        (("@default(3)", "@default(5) @min(4)"), "configuration.values"),
    ],
)
def test_a_component_of_another_definition(
    change: tuple[str, str], name: str, gauge: Any, names: str, tmp_path: Path
) -> None:
    assert change[0] in IDL
    file = tmp_path / "gauge.idl"
    file.write_text(IDL.replace(*change, 1))
    report = report_of(definition(file), names, ())
    assert failed(report) == [name]


@pytest.fixture
def in_error(gauge: Any) -> Iterator[None]:
    """Put the component in ERROR meanwhile."""
    [context] = gauge.get_owned_contexts()
    assert context.fail_component(gauge, "by the test") is RTC_OK
    wait_for(lambda: state_of(gauge) == "ERROR_STATE")
    yield
    assert context.reset_component(gauge) is RTC_OK
    wait_for(lambda: state_of(gauge) == "INACTIVE_STATE")


def test_a_component_in_error_stays_there(
    in_error: None,
    gauge: Any,
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    report = report_of(expected, names)
    verdicts = {o.check: (o.verdict, o.problems) for o in report.outcomes}
    assert verdicts["life-cycle.error"] == (Verdict.PASSED, ())
    left = (Verdict.SKIPPED, ("it is in ERROR, and stays there",))
    assert verdicts["life-cycle.activation"] == left
    assert report.passed
    assert state_of(gauge) == "ERROR_STATE"
    in_error_too = instead(ok, is_state("ERROR_STATE"))
    right = ContextService.activate_component
    monkeypatch.setattr(ContextService, "activate_component", in_error_too(right))
    assert failed(report_of(expected, names)) == ["life-cycle.error"]


@pytest.fixture
def active(gauge: Any) -> Iterator[None]:
    """Put the component in ACTIVE meanwhile."""
    [context] = gauge.get_owned_contexts()
    assert context.activate_component(gauge) is RTC_OK
    wait_for(lambda: state_of(gauge) == "ACTIVE_STATE")
    yield
    assert context.deactivate_component(gauge) is RTC_OK
    wait_for(lambda: state_of(gauge) == "INACTIVE_STATE")


def test_an_active_component_is_active_again(
    active: None, gauge: Any, expected: Expected, names: str
) -> None:
    assert report_of(expected, names).passed
    assert state_of(gauge) == "ACTIVE_STATE"


@pytest.mark.parametrize(
    ("operation", "check"),
    [("set_rate", "contexts.rate"), ("stop", "contexts.running")],
)
@pytest.mark.parametrize("interrupted", [True, False])
def test_it_is_left_as_it_was_found_after_a_failure(
    operation: str,
    check: str,
    interrupted: bool,
    active: None,
    gauge: Any,
    expected: Expected,
    names: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The call takes effect, and then fails, or Ctrl-C comes."""
    error = KeyboardInterrupt() if interrupted else CORBA.TRANSIENT()
    asked = RtcUnderTest.ask
    failures = [error]

    def ask(self: RtcUnderTest, context: Any, called: str, *given: Any) -> Any:
        found = asked(self, context, called, *given)
        if called == operation and found is RTC_OK and failures:
            raise failures.pop()
        return found

    monkeypatch.setattr(RtcUnderTest, "ask", ask)
    if interrupted:
        with pytest.raises(KeyboardInterrupt):
            report_of(expected, names)
    else:
        assert failed(report_of(expected, names)) == [check]
    assert failures == []
    [context] = gauge.get_owned_contexts()
    assert (context.get_rate(), context.is_running()) == (200.0, True)
    assert state_of(gauge) == "ACTIVE_STATE"


def test_a_connection_that_failed_to_end_is_ended(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = PortService.disconnect
    times = iter([True])
    ended: list[str] = []

    def disconnect(self: Any, name: str) -> Any:
        if "unknown" not in name and next(times, False):
            return RTC_OK
        ended.append(name)
        return right(self, name)

    monkeypatch.setattr(PortService, "disconnect", disconnect)
    report = report_of(expected, names)
    assert failed(report) == ["connections"]
    [outcome] = [o for o in report.outcomes if o.check == "connections"]
    assert [problem.partition(": ")[2] for problem in outcome.problems] == [
        "its connector is still listed",
        "it did not notify the other port of the disconnection",
    ]
    assert ended[-1].startswith("rtgen-conformance-")
    assert failed(report_of(expected, names)) == []


def test_nil_references_are_reported(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    without = otherwise(in_port("shown", port_ref=None))
    monkeypatch.setattr(RtObject, PROFILE, without(RtObject.get_component_profile))
    report = report_of(expected, names, ())
    assert failed(report) == ["ports.references", "ports.unknown"]
    monkeypatch.setattr(RtObject, "get_configuration", lambda self: None)
    with pytest.raises(ToolError, match="state that --actuate would have to restore"):
        report_of(expected, names)


def test_what_cannot_be_restored_is_reported(
    gauge: Any, expected: Expected, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = Configuration.activate_configuration_set

    def adding(self: Any, name: str) -> bool:
        monkeypatch.setitem(self._sets._texts, "junk", {})
        return right(self, name)

    monkeypatch.setattr(Configuration, "activate_configuration_set", adding)
    assert failed(report_of(expected, names)) == ["left"]


def test_the_command(
    gauge: Any,
    names: str,
    folder: Path,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    command = ["conformance", "gauge.idl", "--component", "Gauge", "--connect"]
    place, page = f"{names}/Gauge0.rtc", tmp_path / "report.html"
    assert rtgen([*command, place, "--html", str(page)]) == 0
    assert "Gauge Gauge0: 18 passed, 0 failed, 23 skipped" in capfd.readouterr().out
    assert "configuration.names" in page.read_text()
    by_name = f"corbaname::{names}#Gauge0.rtc"
    every = ["--actuate", "--defaults", "--exit"]
    assert rtgen([*command, by_name, "--json", *every]) == 0
    assert valid(capfd.readouterr().out, "conformance.schema.json")["passed"]
    command[3] = "Idle"
    assert rtgen([*command, place]) == 1
    assert "the definition has no port level" in capfd.readouterr().out


@pytest.mark.parametrize("form", ["rtc-xml", "rtc-yaml"])
def test_its_profile_is_a_definition_too(
    form: str,
    gauge: Any,
    names: str,
    folder: Path,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    asked = ["convert", "gauge.idl", "--component", "Gauge", "--to", form]
    assert rtgen(asked) == 0
    profile = tmp_path / f"RTC.{form[4:]}"
    profile.write_text(capfd.readouterr().out)
    command = ["conformance", str(profile), "-I", str(folder), "--actuate"]
    assert rtgen([*command, "--connect", f"{names}/Gauge0.rtc"]) == 0


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["gauge.idl"], 2, "--connect"),
        (
            ["gauge.idl", "--connect", "tcp:127.0.0.1:1"],
            2,
            "not a place of a component",
        ),
        (["gauge.idl", "--connect", "{0}/Gauge0.rtc"], 2, "--component NAME"),
        (["gauge.idl", "--connect", "IOR:00", "--component", "No"], 2, "it has Gauge"),
        (
            ["gauge.idl", "--connect", "IOR:00", "--component", "Idle"],
            3,
            "no component",
        ),
        (["gauge.idl", "--connect", "{0}/No.rtc", "--component", "Idle"], 3, "rtls"),
        (
            ["gauge.idl", "--connect", "127.0.0.1:1/No.rtc", "--component", "Idle"],
            3,
            "rtgen run",
        ),
        (
            [str(NAVIGATION), "--connect", "{0}/Gauge0.rtc"],
            2,
            "not the profile of a component",
        ),
        (
            [
                "gauge.idl",
                "--connect",
                "corbaloc::{0}/NameService",
                "--component",
                "Idle",
            ],
            3,
            "does not respond as a component",
        ),
        (["missing.idl", "--connect", "{0}/Gauge0.rtc"], 2, "missing.idl"),
        (["rtgen.toml", "--connect", "{0}/Gauge0.rtc"], 2, "definition of a component"),
    ],
)
def test_wrong_arguments(
    words: list[str],
    code: int,
    text: str,
    folder: Path,
    names: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert rtgen(["conformance", *(word.format(names) for word in words)]) == code
    assert text in capfd.readouterr().err


def test_components_of_rh3(
    start: Callable[..., Run],
    names: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    run = start("--until", "100", system=NAVIGATION)
    run.wait_for("PositionInput0 ACTIVE")
    monkeypatch.chdir(ROOT)
    for type_ in ("Odometry", "PathFollower", "Navigation"):
        file = f"specs/navigation/{type_}.idl"
        place = f"{names}/{type_}0.rtc"
        code = rtgen(
            ["conformance", file, "--component", type_, "--connect", place, "--actuate"]
        )
        assert code == 0, capfd.readouterr()
