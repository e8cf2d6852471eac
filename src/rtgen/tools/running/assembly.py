"""Builds a runnable system from the model: components, configuration, connections, start."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    Rule,
    Span,
    ToolError,
    has_errors,
)
from rtgen.compiler.frontends.kit.suggestions import guess, nearest
from rtgen.compiler.model import Connection, System, SystemComponent
from rtgen.compiler.systems.checks import conf_span
from rtgen.compiler.systems.rules import (
    CONNECTION,
    NO_COMPONENT,
    PARAMETER,
    SKIPPED,
    TIMELINE,
    UNKNOWN_TYPE,
)
from rtgen.compiler.systems.timeline import (
    Action,
    Call,
    Connect,
    Disconnect,
    SetParameter,
    StateRequest,
    Step,
)
from rtgen.compiler.typemap.openrtm_ports import InstancePorts, with_definition_names
from rtgen.facts.connector_properties import embedded_properties
from rtgen.facts.openrtm_ports import IN, OUT, SERVICE, registered_names
from rtgen.runtime.rtc.conf_file import ACTIVE_SET
from rtgen.runtime.rtc.conf_file import read as read_conf
from rtgen.runtime.services.transports import ForeignTransport, PublishingTransport
from rtgen.runtime.system.json_calls import JsonCall, provider_of
from rtgen.runtime.system.watchdog import calling
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, FAILED, ReportedError
from rtgen.tools.running import idle
from rtgen.tools.running.factories import Factories, FactoryImportError
from rtgen.tools.running.failures import FailureOptions, FailureReport
from rtgen.tools.running.joins import join, unit_errors

if TYPE_CHECKING:
    from rtgen.runtime.services.transports import ProcessTransport

_MILLISECOND = 1_000_000
_POLL_PERIOD = 20 * _MILLISECOND
_CHOICES = re.compile(r"'([^']*)'; known: (.+)$")
"""A name that is not there, and those that are, at the end of an error of the runtime."""
_GONE = (
    runtime.UnknownComponentError,
    runtime.UnknownConnectionError,
    runtime.DuplicateConnectionError,
    runtime.ConnectionLimitError,
)
"""Errors of events for which the run has changed: by a person, another process, a component."""


def assemble(
    profile: System,
    factories: Factories,
    clock: runtime.Clock,
    settings: Sequence[SetParameter],
    steps: Sequence[Step],
    transport: ProcessTransport | None = None,
    patience: float = 0.0,
    report: FailureReport | None = None,
    prepare: Callable[[runtime.System], None] | None = None,
    checkpoints: runtime.CheckpointFolder | None = None,
    check_values: str = "first",
    threads: str = "shared",
    skipped: Callable[[Diagnostic], None] | None = None,
    stay_inactive: bool = False,
) -> runtime.System:
    """Assemble the system: all components INACTIVE, their start scheduled on its timeline, unless
    they `stay_inactive`.

    A component that calls providers of other processes is activated once the components before it
    in the order of activation are ACTIVE, after `patience` [s] at the latest. `prepare` is called
    when all components are added, before they are connected. Other processes find the components
    when they are connected. Raises InputError with all inconsistencies, ToolError if a factory
    cannot be loaded or the transport fails.

    An event of the timeline whose component or connection is gone, or whose connection exists, is
    skipped with a warning; another one that fails ends the run with an InputError. With `skipped`,
    for systems that people change, both are skipped, and it is called with each warning.
    """
    findings = [
        UNKNOWN_TYPE.at(
            c.span,
            f"no factory for the type {c.type!r} of {c.instance}",
            hint=factories.hint(c.type),
        )
        for c in profile.components
        if c.type not in factories
    ]
    _raise_if_any(findings)
    report = report or FailureReport(Console("text", False, False), FailureOptions())
    system = runtime.System(clock, transport, checkpoints, check_values, threads)
    system.on_failure = report
    publishing: AbstractContextManager[None] = nullcontext()
    if isinstance(transport, PublishingTransport):
        publishing = transport.publishing()
    try:
        with publishing:
            _add_all(system, profile, factories, settings, report)
            if prepare is not None:
                prepare(system)
            if skipped is None:
                for finding in idle.findings(system):
                    report.notice(finding)
            defined = factories.defined
            _fill(system, profile, steps, report.notice, defined)
            if not stay_inactive:
                _schedule_start(system, profile, transport, patience)
            _schedule(system, steps, report, skipped)
    except runtime.TransportError as error:
        system.close()
        raise ToolError(str(error)) from error
    except BaseException:
        system.close()
        raise
    return system


def _add_all(
    system: runtime.System,
    profile: System,
    factories: Factories,
    settings: Sequence[SetParameter],
    report: FailureReport,
) -> None:
    """Add the components to the system. Raises as `assemble` does."""
    findings: list[Diagnostic] = []
    folder = Path(profile.file).absolute().parent
    for c in profile.components:
        findings += _add(
            system,
            c,
            factories,
            folder,
            [s for s in settings if s.instance == c.instance],
            report,
        )
    _raise_if_any(findings)
    if report.interrupt is not None:
        raise report.interrupt
    if report.raised:
        raise ReportedError(BAD_INPUT)


def add_component(
    system: runtime.System,
    component: SystemComponent,
    factories: Factories,
    folder: Path,
    report: FailureReport,
) -> None:
    """Add a component to a system, which may be running. Raises as `assemble` does."""
    if component.type not in factories:
        hint = factories.hint(component.type)
        message = f"no factory for the type {component.type!r}"
        raise InputError([UNKNOWN_TYPE.at(component.span, message, hint=hint)])
    _raise_if_any([*_add(system, component, factories, folder, (), report)])
    if report.raised:
        raise ReportedError(BAD_INPUT)


def _fill(
    system: runtime.System,
    profile: System,
    steps: Sequence[Step],
    warn: Callable[[Diagnostic], None],
    defined: Collection[str],
) -> None:
    """Add connections to the system, and check the timeline.

    The judge has compared the ends of connections of `defined` types. Raises as `assemble` does.
    """
    findings: list[Diagnostic] = []
    others = {c.instance for c in profile.components if c.type not in defined}
    profile = with_definition_names(
        profile, {name: _ports(system.component(name)) for name in system.instances}
    )
    for connection in profile.connections:
        action = Connect(
            connection.name,
            connection.source,
            connection.target,
            embedded_properties(connection.properties),
        )
        if {connection.source.instance, connection.target.instance} & others:
            findings += unit_errors(system, connection, warn)
        span, hint = _failed_end(system, connection)
        connect = partial(join, system, action, span, warn)
        diagnostics = _findings(CONNECTION, span, connect)
        findings += (replace(finding, hint=hint) for finding in diagnostics)
    instances = system.instances
    for step in steps:
        match step.action:
            case SetParameter(instance=instance) if instance in instances:
                checking = _checking(system, step.action)
                findings += _findings(PARAMETER, step.span, checking)
            case Call(instance=instance) if instance in instances:
                prepare = partial(_prepared, system, step.action)
                findings += _findings(TIMELINE, step.span, prepare)
    _raise_if_any(findings)


def _schedule_start(
    system: runtime.System,
    profile: System,
    transport: ProcessTransport | None,
    patience: float,
) -> None:
    """Add the activations to the system; see `assemble`."""
    before: list[str] = []
    earlier: list[str] = []
    for time, instance in _start(profile, system):
        if instance in system.instances:
            earlier.append(instance)
            activate: Callable[[], None] = partial(_activate, system, instance)
            if transport is not None and before:
                is_ready = partial(transport.is_ready, instance, tuple(before))
                activate = _when(system, is_ready, activate, patience)
            system.at(time, activate)
        elif profile.activation:
            before.append(instance)
            if isinstance(transport, ForeignTransport) and transport.is_foreign(
                instance
            ):
                activate = partial(transport.activate_foreign, instance)
                system.at(time, _reporting(activate))
                deactivate = partial(transport.deactivate_foreign, instance)
                system.closing.at_close(deactivate, before=tuple(earlier))


def _schedule(
    system: runtime.System,
    steps: Sequence[Step],
    report: FailureReport,
    skipped: Callable[[Diagnostic], None] | None,
) -> None:
    """Add a timeline to the system; see `assemble`."""
    outdated = _GONE if skipped is None else runtime.RtcError

    def carry_out(step: Step) -> None:
        try:
            if isinstance(step.action, Connect):
                join(system, step.action, step.span, skipped or report.notice)
            elif isinstance(step.action, Call):
                outcome = _prepared(system, step.action)()
                report.called(system.time, step, step.action, outcome)
            else:
                _performing(system, step.action)()
        except outdated as error:
            message = f"{error}: the event is skipped"
            (skipped or report.notice)(SKIPPED.at(step.span, message))
        except runtime.TransportError as error:
            raise ToolError(str(error)) from error
        except runtime.RtcError as error:
            raise InputError([TIMELINE.at(step.span, str(error))]) from error

    for step in steps:
        system.at(step.time, partial(carry_out, step))


def _ports(component: runtime.Component) -> InstancePorts:
    """Return the port names of a component, and the types of its interfaces."""
    providers, consumers = component.providers, component.consumers
    keys = [
        *((IN, name) for name in component.in_ports),
        *((OUT, name) for name in component.out_ports),
        *((SERVICE, port) for port, _ in (*providers, *consumers)),
    ]
    interfaces = [
        *((p, "provided", i, each.interface) for (p, i), each in providers.items()),
        *((p, "required", i, each.interface) for (p, i), each in consumers.items()),
    ]
    return InstancePorts(
        registered_names(keys),
        {
            (port, polarity, instance): interface._descriptor_.name
            for port, polarity, instance, interface in interfaces
        },
    )


def _failed_end(
    system: runtime.System, connection: Connection
) -> tuple[Span, str | None]:
    """Return the place of a failed connection's error, the end without port, and a suggestion."""
    for end in (connection.source, connection.target):
        if end.instance not in system.instances:
            continue
        component = system.component(end.instance)
        services = (*component.providers, *component.consumers)
        names = {
            *component.in_ports,
            *component.out_ports,
            *(port for port, _ in services),
        }
        if end.port not in names and end.span is not None:
            near = nearest(end.port, sorted(names))
            return end.span, f"did you mean {near}?" if near else None
    return connection.span, None


def _raise_if_any(findings: Sequence[Diagnostic]) -> None:
    if has_errors(findings):
        raise InputError(findings)


def _findings(
    rule: Rule, span: Span | None, action: Callable[[], object]
) -> Iterator[Diagnostic]:
    """Yield diagnostics for the runtime's errors in an action."""
    try:
        action()
    except runtime.TransportError as error:
        raise ToolError(str(error)) from error
    except runtime.RtcError as error:
        match = _CHOICES.search(str(error))
        hint = guess(match[1], match[2].split(", ")) if match else None
        yield rule.at(span, str(error), hint=hint)


def _add(
    system: runtime.System,
    c: SystemComponent,
    factories: Factories,
    folder: Path,
    settings: Iterable[SetParameter],
    report: FailureReport,
) -> Iterator[Diagnostic]:
    try:
        factory = factories[c.type]
    except FactoryImportError as failed:
        report.cannot_import(failed, c.span)
        raise ReportedError(BAD_INPUT if failed.is_users else FAILED) from failed
    try:
        component = calling(c.instance, "__init__", factory, c.instance)
    except BaseException as error:
        report.cannot_make(c.instance, "__init__", error, c.span)
        return
    if not isinstance(component, runtime.Component):
        yield NO_COMPONENT.at(c.span, f"the factory of {c.type} returns no component")
        return
    component.folder = folder
    findings = [*_configure(component, c, folder, settings)]
    yield from findings
    if not findings:
        try:
            system.add(component, c.rate)
        except runtime.InitializationError as error:
            if error.__cause__ is None:
                yield NO_COMPONENT.at(c.span, str(error))
            else:
                report.cannot_make(c.instance, "on_initialize", error.__cause__, c.span)
        except (runtime.TransportError, runtime.CheckpointError) as error:
            raise ToolError(str(error)) from error
        except runtime.RtcError as error:
            yield NO_COMPONENT.at(c.span, str(error))


def _configure(
    component: runtime.Component,
    c: SystemComponent,
    folder: Path,
    settings: Iterable[SetParameter],
) -> Iterator[Diagnostic]:
    """Apply configuration values; later sources override earlier ones."""
    sets = component.configuration_sets
    for name in dict.fromkeys((c.type, c.instance)):
        file = folder / f"{name}.conf"
        if file.is_file():
            yield from _load_conf(sets, file)
    wrong: set[str] = set()
    for set_id, pairs in c.parameter_sets:
        if not pairs:
            sets.set_all({}, set_id)
        for parameter, text in pairs:
            span = c.places.get((set_id, parameter), c.span)
            change = partial(sets.set, parameter, text, set_id)
            if diagnostics := [*_findings(PARAMETER, span, change)]:
                wrong.add(set_id)
                yield from diagnostics
    # A set without a valid value is not created. Files name `default` where they choose none.
    is_chosen = c.active_set != runtime.DEFAULT_SET or any(
        dict(c.parameter_sets).values()
    )
    if is_chosen and c.active_set not in wrong:
        yield from _findings(PARAMETER, c.span, partial(sets.activate, c.active_set))
    for setting in settings:
        change = partial(sets.set, setting.parameter, setting.text, sets.active)
        yield from _findings(PARAMETER, None, change)


def _load_conf(sets: runtime.ConfigurationSets, file: Path) -> Iterator[Diagnostic]:
    """Load a `.conf` file, if all of it fits."""
    name = file.as_posix()
    try:
        conf = read_conf(file)
    except runtime.ConfFileError as error:
        yield PARAMETER.at(conf_span(name, error.line), error.reason)
        return
    wrong = False
    for set_id, texts in conf.sets.items():
        for parameter, text in texts.items():
            key = f"conf.{set_id}.{parameter}"
            span = conf_span(name, conf.lines[key], key)
            for finding in _findings(
                PARAMETER, span, partial(sets.check, parameter, text)
            ):
                wrong = True
                yield finding
    if not wrong:
        span = conf_span(name, conf.lines.get(ACTIVE_SET, 0), ACTIVE_SET)
        yield from _findings(PARAMETER, span, partial(sets.load, conf))


def _start(profile: System, system: runtime.System) -> Iterator[tuple[int, str]]:
    """Yield the activation times in ns; all components start at 0 unless the profile has an order.

    At the same time, providers of services are activated before their consumers.
    """
    instants: dict[int, list[str]] = {}
    if not profile.activation:
        instants[0] = [c.instance for c in profile.components]
    time = 0
    for step in profile.activation:
        time += step.wait_ms * _MILLISECOND
        instants.setdefault(time, []).append(step.instance)
    for instant, instances in instants.items():
        yield from ((instant, name) for name in system.activation_order(instances))


def _when(
    system: runtime.System,
    condition: Callable[[], bool],
    action: Callable[[], None],
    patience: float,
) -> Callable[[], None]:
    """Postpone the action until the condition holds, for at most `patience` seconds."""
    latest: int | None = None

    def perform() -> None:
        nonlocal latest
        now = system.time
        latest = now + round(patience * SECOND) if latest is None else latest
        if now < latest and not condition():
            system.at(now + _POLL_PERIOD, perform)
        else:
            action()

    return perform


def _activate(system: runtime.System, instance: str) -> None:
    """Activate a component at the start, unless it was removed before."""
    if instance in system.instances:
        system.activate(instance)


def _checking(system: runtime.System, action: SetParameter) -> Callable[[], object]:
    sets = system.component(action.instance).configuration_sets
    return partial(sets.check, action.parameter, action.text)


def _prepared(system: runtime.System, action: Call) -> JsonCall:
    """Return a call with its typed arguments. Raises RtcError."""
    call = action.text
    component = system.component(call.instance)
    provider = provider_of(component, call.port, call.operation)
    prepared = JsonCall(provider, call.operation, call.arguments)
    if action.raises:
        prepared.require_exception(action.raises)
    return prepared


def _performing(
    system: runtime.System,
    action: Action,
) -> Callable[[], None]:
    def perform() -> None:
        match action:
            case StateRequest("activate"):
                system.activate(action.instance)
            case StateRequest("deactivate"):
                system.deactivate(action.instance)
            case StateRequest("reset"):
                system.reset(action.instance)
            case Disconnect(name, others):
                names = {each.name for each in system.connectors}
                instances = (each for each in (name, *others) if each in names)
                system.disconnect(next(instances, name))
            case SetParameter():
                sets = system.component(action.instance).configuration_sets
                system.configure(
                    action.instance, action.parameter, action.text, sets.active
                )

    return perform


def _reporting(action: Callable[[], None]) -> Callable[[], None]:
    """Return the action, with errors of the transport turned into ToolErrors."""

    def perform() -> None:
        _raise_if_any([*_findings(CONNECTION, None, action)])

    return perform
