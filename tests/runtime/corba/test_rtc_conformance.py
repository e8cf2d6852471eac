"""`rtgen conformance` of running components: rtgen's pass, and are left as they were."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from patience import until

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from corba_runs import NAVIGATION, ROOT, Run
from gauge_component import PATIENCE, Bench, definition, failed, serving
from json_schemas import valid
from omniORB import CORBA
from wrong_components import changing, install, instead, is_state, ok

from rtgen.cli import run as rtgen
from rtgen.runtime import RTC_OK
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.component import ContextService, RtObject
from rtgen.runtime.corba.rt_objects.configuration import Configuration
from rtgen.runtime.corba.rt_objects.foreign import located
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import ConnectorProfile
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Verdict
from rtgen.tools.conformance.rtc.checks import CHECKS
from rtgen.tools.conformance.rtc.component import RtcUnderTest
from rtgen.tools.conformance.rtc.testing import checked


def test_a_component_of_ours_passes_every_check(bench: Bench) -> None:
    report = bench.report()
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
    bench: Bench, monkeypatch: pytest.MonkeyPatch
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
    report = bench.report(())
    assert called == []
    assert report.passed
    assert [o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED] == [
        check.name for check in CHECKS if check.needs is not None
    ]


def test_other_connections_of_a_port_are_kept(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = ConnectorProfile("other", "other", [], [])
    found = PortService.get_connector_profiles
    ended: list[PortService] = []
    monkeypatch.setattr(
        PortService, "get_connector_profiles", lambda self: [*found(self), other]
    )
    monkeypatch.setattr(PortService, "disconnect_all", ended.append)
    report = bench.report([Permission.ACTUATE])
    [outcome] = [o for o in report.outcomes if o.check == "connections.all"]
    assert outcome.verdict is Verdict.SKIPPED
    assert outcome.problems == ("each port has other connections",)
    assert failed(report) == []
    assert ended == []


def test_a_participant_in_the_context_of_another_component(
    gauge_project: Path, names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such a context has one reference and one owner; its profile lists the participant."""
    module = importlib.import_module("gaugebot.components.idle")
    with serving(names) as system, closing(Orb()) as orb:
        for instance in ("Idle0", "Idle1"):
            system.add(module.IdleBase(instance), 100.0)
        system.run(until_ns=1)
        exported = Exported(orb)
        expected = definition(gauge_project / "gauge.idl", "Idle")

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
        alone = (ContextService, "get_profile", changing(participants=[]))
        install(alone, monkeypatch)
        report = checked(other, "Idle1", "gauge.idl", [])
        assert failed(report) == ["contexts.profile"]


@pytest.fixture
def in_error(bench: Bench) -> Iterator[None]:
    """Put the component in ERROR meanwhile."""
    assert bench.context.fail_component(bench.gauge, "by the test") is RTC_OK
    until(lambda: bench.state == "ERROR_STATE")
    yield
    assert bench.context.reset_component(bench.gauge) is RTC_OK
    until(lambda: bench.state == "INACTIVE_STATE")


def test_a_component_in_error_stays_there(
    in_error: None, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = bench.report()
    verdicts = {o.check: (o.verdict, o.problems) for o in report.outcomes}
    assert verdicts["life-cycle.error"] == (Verdict.PASSED, ())
    left = (Verdict.SKIPPED, ("it is in ERROR, and stays there",))
    assert verdicts["life-cycle.activation"] == left
    assert report.passed
    assert bench.state == "ERROR_STATE"
    in_error_too = instead(ok, is_state("ERROR_STATE"))
    install((ContextService, "activate_component", in_error_too), monkeypatch)
    assert bench.failed() == ["life-cycle.error"]


@pytest.fixture
def active(bench: Bench) -> Iterator[None]:
    """Put the component in ACTIVE meanwhile."""
    assert bench.context.activate_component(bench.gauge) is RTC_OK
    until(lambda: bench.state == "ACTIVE_STATE")
    yield
    assert bench.context.deactivate_component(bench.gauge) is RTC_OK
    until(lambda: bench.state == "INACTIVE_STATE")


def test_an_active_component_is_active_again(active: None, bench: Bench) -> None:
    assert bench.report().passed
    assert bench.state == "ACTIVE_STATE"


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
    bench: Bench,
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
            bench.report()
    else:
        assert bench.failed() == [check]
    assert failures == []
    assert (bench.context.get_rate(), bench.context.is_running()) == (200.0, True)
    assert bench.state == "ACTIVE_STATE"


def test_a_connection_that_failed_to_end_is_ended(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
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
    report = bench.report()
    assert failed(report) == ["connections"]
    [outcome] = [o for o in report.outcomes if o.check == "connections"]
    assert [problem.partition(": ")[2] for problem in outcome.problems] == [
        "its connector is still listed",
        "it did not notify the other port of the disconnection",
    ]
    assert ended[-1].startswith("rtgen-conformance-")
    assert bench.failed() == []


@pytest.mark.nightly
def test_the_command(
    bench: Bench,
    names: str,
    gauge_project: Path,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    command = ["conformance", "gauge.idl", "--component", "Gauge", "--connect"]
    place, page = f"{names}/Gauge0.rtc", tmp_path / "report.html"
    assert rtgen([*command, place, "--html", str(page)]) == 0
    assert "Gauge Gauge0: 19 passed, 0 failed, 23 skipped" in capfd.readouterr().out
    assert "configuration.names" in page.read_text()
    by_name = f"corbaname::{names}#Gauge0.rtc"
    every = ["--actuate", "--defaults", "--exit"]
    assert rtgen([*command, by_name, "--json", *every]) == 0
    assert valid(capfd.readouterr().out, "conformance.schema.json")["passed"]
    assert rtgen(["conformance", *command[2:], place]) == 0
    assert "Gauge Gauge0: 19 passed, 0 failed" in capfd.readouterr().out
    assert rtgen(["conformance", "--connect", place]) == 2
    assert "the project defines " in capfd.readouterr().err
    command[3] = "Idle"
    assert rtgen([*command, place]) == 1
    assert "the definition has no port level" in capfd.readouterr().out


@pytest.mark.parametrize("form", ["rtc-xml", "rtc-yaml"])
def test_its_profile_is_a_definition_too(
    form: str,
    bench: Bench,
    names: str,
    gauge_project: Path,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    asked = ["convert", "gauge.idl", "--component", "Gauge", "--to", form]
    assert rtgen(asked) == 0
    profile = tmp_path / f"RTC.{form[4:]}"
    profile.write_text(capfd.readouterr().out)
    command = ["conformance", str(profile), "-I", str(gauge_project), "--actuate"]
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
    gauge_project: Path,
    names: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert rtgen(["conformance", *(word.format(names) for word in words)]) == code
    assert text in capfd.readouterr().err


@pytest.mark.sampled(0)
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
