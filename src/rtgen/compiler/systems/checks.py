"""Validates a system against the definitions of its components (codes RTC058x)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Severity, Span
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.model import (
    ConfigurationParameter,
    ConstantValue,
    Model,
    System,
    SystemComponent,
)
from rtgen.compiler.model.system_links import Known
from rtgen.compiler.systems import conditions, connections
from rtgen.compiler.systems.connection_rules import (
    CONFIGURED_IN_VAIN,
    OTHER_DEFINITION,
    SYSTEM_PARAMETER,
    UNKNOWN_COMPONENT,
)
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.runtime.errors import ConfFileError, ConfigurationError
from rtgen.runtime.rtc.conf_file import ACTIVE_SET, parse
from rtgen.runtime.rtc.configuration import DEFAULT_SET
from rtgen.runtime.rtc.parameter_values import Converter
from rtgen.runtime.rtc.profiles import ParameterProfile

_ASCENDING = (Severity.NOTE, Severity.WARNING, Severity.ERROR)


def check(system: System, components: Mapping[str, Known]) -> list[Diagnostic]:
    """Return all diagnostics about a system; `components` maps type names to definitions."""
    diagnostics = [
        *conditions.check_properties(system),
        *connections.findings(system, components),
    ]
    for c in system.components:
        diagnostics += _component(c, components)
    return diagnostics


def as_warnings(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics as warnings, for commands that only read and write a system."""
    return [
        replace(f, severity=min(f.severity, Severity.WARNING, key=_ASCENDING.index))
        for f in findings
    ]


def check_properties(system: System) -> Iterator[Diagnostic]:
    """Yield diagnostics about properties, which require no definitions."""
    yield from conditions.check_properties(system)
    yield from connections.findings(system, {})


def _component(
    c: SystemComponent, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    definition = components.get(c.type)
    if definition is None:
        hint = guess(c.type, components) or "give its definition as a source"
        message = f"the component {c.type!r} of {c.instance} is not defined"
        yield UNKNOWN_COMPONENT.at(c.span, message, hint=hint)
        return
    id_ = definition.component.profile_id
    if c.id not in (id_, _dotted(id_)):
        message = f"the id of {c.instance} is {c.id!r}, its definition's {id_!r}"
        yield OTHER_DEFINITION.at(c.span, message)
    yield from _configuration(c, definition)


def configurations(
    system: System, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    """Yield diagnostics about the configuration of the components that are defined."""
    for c in system.components:
        if c.type in components:
            yield from _configuration(c, components[c.type])


def _configuration(c: SystemComponent, definition: Known) -> Iterator[Diagnostic]:
    for set_id, values in c.parameter_sets:
        for name, text in values:
            problem = parameter_problem(c, name, text, definition)
            if problem is not None:
                span = c.places.get((set_id, name), c.span)
                yield SYSTEM_PARAMETER.at(span, problem[0], hint=problem[1])
    known = {DEFAULT_SET}
    for name, content in c.conf_files:
        file = _displayed(c, name)
        try:
            conf = parse(content, file)
        except ConfFileError as error:
            span = conf_span(file, error.line)
            yield CONFIGURED_IN_VAIN.at(span, error.reason)
            return  # Its sets are not known.
        for set_id, texts in conf.sets.items():
            for parameter, text in texts.items():
                problem = parameter_problem(c, parameter, text, definition)
                if problem is not None:
                    key = f"conf.{set_id}.{parameter}"
                    span = conf_span(file, conf.lines[key], key)
                    yield CONFIGURED_IN_VAIN.at(span, problem[0], hint=problem[1])
        known |= conf.sets.keys()
        if conf.active_set is not None:
            span = conf_span(file, conf.lines[ACTIVE_SET], ACTIVE_SET)
            yield from _active_set(c, conf.active_set, known, span)
    known |= {id_ for id_, _ in c.parameter_sets}
    yield from _active_set(c, c.active_set, known, c.span)


def _active_set(
    c: SystemComponent, active: str, known: Set[str], span: Span
) -> Iterator[Diagnostic]:
    if active not in known:
        message = f"{c.instance} has no configuration set {active!r}"
        hint = guess(active, known) or f"it has {', '.join(sorted(known))}"
        yield CONFIGURED_IN_VAIN.at(span, message, hint=hint)


def conf_sources(system: System) -> dict[str, str]:
    """Return the `.conf` files of a system: displayed paths and texts."""
    return {
        _displayed(c, name): text
        for c in system.components
        for name, text in c.conf_files
    }


def conf_span(file: str, line: int, key: str = "") -> Span:
    """Return the place of a key in a `.conf` file; `line` is 0 for the whole file."""
    return Span(file, max(line, 1), 1, max(line, 1), 1 + len(key or " "))


def _displayed(c: SystemComponent, name: str) -> str:
    return Path(c.span.file).with_name(name).as_posix()


def parameter_problem(
    c: SystemComponent, name: str, text: str, definition: Known
) -> tuple[str, str | None] | None:
    """Return why a parameter cannot have a value, and a hint; None if it can."""
    parameters = {p.name: p for p in definition.component.configuration}
    parameter = parameters.get(name)
    if parameter is None:
        hint = guess(name, parameters) or f"it has {', '.join(parameters) or 'none'}"
        return f"{c.type} has no parameter {name!r}", hint
    problem = _value_problem(definition.model, parameter, text)
    if problem is None:
        return None
    return f"{c.instance}.{name} cannot be {text[:80]!r}: {problem}", None


def _dotted(id_: str) -> str:
    """Return the older form of a component's id, `RTC:vendor.category.type:version`."""
    head, *parts, version = id_.split(":")
    return f"{head}:{'.'.join(parts)}:{version}"


def _value_problem(
    model: Model, parameter: ConfigurationParameter, text: str
) -> str | None:
    """Return why a text is no value of a parameter, as the runtime judges it; None if it is one."""
    reader = Parameters(model)
    names = reader.enumerators(parameter.type)
    if names:
        is_known = text.strip().rpartition("::")[2] in names
        return None if is_known else f"it must be one of {', '.join(names)}"
    profile = ParameterProfile(
        parameter.name,
        parameter.identifier,
        reader.canonical_type(parameter.type),
        minimum=_bound(parameter.minimum),
        maximum=_bound(parameter.maximum),
        unit=parameter.unit,
        constraint=parameter.constraint,
    )
    try:
        return Converter(profile, None).problem(text)
    except ConfigurationError:
        return (
            None  # The constraint is malformed, which is a finding of the definition.
        )


def _bound(value: ConstantValue | None) -> float | int | None:
    return value if isinstance(value, float | int) else None
