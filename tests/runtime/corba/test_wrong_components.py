"""`rtgen conformance` of running components: each check fails for a violation of its own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from gauge_component import IDL, PATIENCE, SOON, Bench, definition, failed
from omniORB import CORBA
from wrong_components import (
    FURTHER,
    MUTANTS,
    WITHOUT_MUTANT,
    Mutant,
    in_port,
    install,
    instead,
    ok,
    profile,
)

from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime import RTC_OK
from rtgen.runtime.corba.rt_objects.component import ContextService, RtObject
from rtgen.runtime.corba.rt_objects.configuration import Configuration
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import texts, values
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Verdict
from rtgen.tools.conformance.rtc.checks import CHECKS


def test_each_check_has_a_mutant() -> None:
    assert {*MUTANTS, *WITHOUT_MUTANT} == {check.name for check in CHECKS}


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", MUTANTS)
def test_a_check_fails_for_a_component_that_breaks_just_it(
    name: str, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert failed_of(name, MUTANTS[name], bench, monkeypatch) == [name]
    assert bench.state == "INACTIVE_STATE"


@pytest.mark.parametrize("what", FURTHER)
def test_further_violations(
    what: str, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = what.partition(":")[0]
    assert failed_of(name, FURTHER[what], bench, monkeypatch) == [name]
    assert bench.state == "INACTIVE_STATE"


def failed_of(
    name: str, mutant: Mutant, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> list[str]:
    """Return the failed checks of a mutant, tested with the permission of one check.

    On a busy machine, states that the component reaches come later than `SOON`.
    """
    needed = next(check.needs for check in CHECKS if check.name == name)
    with monkeypatch.context() as patch:
        install(mutant, patch)
        for patience in (SOON, PATIENCE):
            found = failed(bench.report([needed] if needed else [], patience))
            if found == [name]:
                break
    return found


def test_a_request_that_is_taken_and_without_effect_may_take_effect_later(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    install((ContextService, "activate_component", instead(ok)), monkeypatch)
    report = bench.report([Permission.ACTUATE], SOON)
    assert failed(report) == ["life-cycle.activation", "contexts.strangers", "left"]
    [outcome] = [o for o in report.outcomes if o.check == "left"]
    assert outcome.problems == (
        "it is INACTIVE_STATE, and activate_component may take effect later",
    )


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
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(profile(of_another_type), monkeypatch)
    report = bench.report(())
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
    bench: Bench,
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
    report = bench.report()
    assert failed(report) == ["connections.services"]
    [outcome] = [o for o in report.outcomes if o.check == "connections.services"]
    assert outcome.problems == (f"valves.Valve: {problem}",)


def test_a_component_that_exits_is_gone(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
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
    report = bench.report([Permission.EXIT])
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
    change: tuple[str, str], name: str, bench: Bench, tmp_path: Path
) -> None:
    assert change[0] in IDL
    file = tmp_path / "gauge.idl"
    file.write_text(IDL.replace(*change, 1))
    report = bench.report((), expected=definition(file))
    assert failed(report) == [name]


def test_nil_references_are_reported(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(profile(in_port("shown", port_ref=None)), monkeypatch)
    report = bench.report(())
    assert failed(report) == ["ports.references", "ports.unknown"]
    monkeypatch.setattr(RtObject, "get_configuration", lambda self: None)
    with pytest.raises(ToolError, match="state that --actuate would have to restore"):
        bench.report()


def test_what_cannot_be_restored_is_reported(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = Configuration.activate_configuration_set

    def adding(self: Any, name: str) -> bool:
        monkeypatch.setitem(self._sets._texts, "junk", {})
        return right(self, name)

    monkeypatch.setattr(Configuration, "activate_configuration_set", adding)
    assert bench.failed() == ["left"]
