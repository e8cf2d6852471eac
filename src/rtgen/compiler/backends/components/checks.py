"""Checks of components before they are emitted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite

from rtgen.compiler.backends import Part
from rtgen.compiler.backends.components import rules
from rtgen.compiler.backends.components.locations import skeleton_location
from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.kit.xml_text import NOT_IN_XML
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Interface,
    Model,
    Port,
    PortKind,
    Struct,
    Union,
)
from rtgen.compiler.model.rtc_profile import EVENT, EVENT_ARGUMENTS
from rtgen.compiler.typemap.components.parameters import (
    Parameters,
    ValueMismatchError,
    value_text,
)
from rtgen.compiler.typemap.components.widgets import (
    is_widget,
    needs_range,
    needs_values,
)
from rtgen.compiler.typemap.profiles.dates import is_date
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts.activities import ACTIVITIES, EVENT_DRIVEN
from rtgen.facts.constraints import ConstraintError, is_enumeration, is_range, text_of

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,119}")
_VERSION = re.compile(r"[^\s:]+")
_BREAKS_ID = re.compile(r"[:\r\n\t]")
_COMPONENT_TYPES = ("STATIC", "UNIQUE", "COMMUTATIVE")
_KINDS = (
    *("DataFlowComponent", "FiniteStateMachine", "DataFlowFiniteStateMachine"),
    *("DataFlowMultiMode", "FiniteStateMachineMultiMode"),
    "DataFlowFiniteStateMachineMultiMode",
)
"""Kinds of components in RtcProfiles; others are possible."""
_CONTEXTS = (
    *("PeriodicExecutionContext", "ExtTrigExecutionContext"),
    *("OpenHRPExecutionContext", "SimulatorExecutionContext"),
)
"""Execution contexts of OpenRTM; others are possible."""
_WIDGETS = ("text", "slider", "spin", "radio", "checkbox", "ordered_list")
_DATA_PORTS = (PortKind.INPORT, PortKind.OUTPORT)


def components_of(model: Model) -> list[Component]:
    """The components of the given files, in order."""
    mains = {file.name for file in model.files if file.main}
    return [
        d for d in model.declarations if isinstance(d, Component) and d.file in mains
    ]


def own_components(model: Model) -> list[Component]:
    """Return the components that are in the generated package, not in another one."""
    elsewhere = {file.name for file in model.files if file.package}
    return [each for each in components_of(model) if each.file not in elsewhere]


def check(model: Model) -> list[Diagnostic]:
    """All diagnostics about the components to emit."""
    components = components_of(model)
    diagnostics = list(_module_clashes(components))
    for component in components:
        diagnostics += check_component(model, component)
    return diagnostics


def check_component(model: Model, component: Component) -> list[Diagnostic]:
    """Diagnostics about a single component."""
    return [
        *_identity(component),
        *_choices(component),
        *_triggers(component),
        *_facts(component),
        *_texts(component),
        *_ports(model, component),
        *_configuration(model, component),
    ]


def _module_clashes(components: list[Component]) -> Iterator[Diagnostic]:
    first: dict[str, Component] = {}
    for component in components:
        name = module_name(component.name[-1])
        earlier = first.setdefault(name, component)
        if earlier is not component:
            yield rules.SAME_MODULE.at(
                component.span,
                f"`{component.scoped}` and `{earlier.scoped}` both get the package `{name}`",
                related=[Related(earlier.span, "the other component")],
                hint="rename one of them",
            )


def check_skeletons(packages: Iterable[Part]) -> Iterator[Diagnostic]:
    """Yield diagnostics for components whose packages differ, but not their skeletons."""
    first: dict[str, Component] = {}
    skeletons = (
        (component, skeleton_location(component, part.options))
        for part in packages
        for component in own_components(part.model)
        if not component.factory
    )
    for component, name in skeletons:
        earlier = first.setdefault(name, component)
        if module_name(earlier.name[-1]) != module_name(component.name[-1]):
            yield rules.SAME_MODULE.at(
                component.span,
                f"`{component.scoped}` and `{earlier.scoped}` both get the skeleton `{name}`",
                related=[Related(earlier.span, "the other component")],
                hint="rename one of them",
            )


def _identity(component: Component) -> Iterator[Diagnostic]:
    span, name = component.span, component.name[-1]
    if not _IDENTIFIER.fullmatch(name):
        yield rules.NAME.at(span, f"a component cannot be called {name!r}")
    if not _VERSION.fullmatch(component.version):
        message = f"version {component.version!r} cannot be used"
        yield rules.VERSION.at(span, message, hint='write it like `version="1.2.0"`')
    for key, date in (("created", component.created), ("updated", component.updated)):
        if not is_date(date):
            message = f"`{key}` is {date!r}, which is not an xsd:dateTime"
            hint = f'write it like `{key}="2025-02-11T10:30:00+00:00"`'
            yield rules.DATE.at(span, message, hint=hint)


def _choices(component: Component) -> Iterator[Diagnostic]:
    for key, value, choices in (
        ("activity", component.activity, ACTIVITIES),
        ("component type", component.component_type, _COMPONENT_TYPES),
    ):
        if value not in choices:
            hint = f"{_suggestion(value, choices)}one of {', '.join(choices)}"
            message = f"unknown {key} {value!r}"
            yield rules.CHOICE.at(component.span, message, hint=hint)


def _triggers(component: Component) -> Iterator[Diagnostic]:
    in_ports = [p.name for p in component.ports if p.kind is PortKind.INPORT]
    for port in component.trigger_ports:
        if port not in in_ports:
            known = ", ".join(in_ports) or "none"
            hint = f"{_suggestion(port, in_ports)}InPorts: {known}"
            message = f"`triggers` names no InPort {port!r}"
            yield rules.CHOICE.at(component.span, message, hint=hint)
    if component.trigger_ports and component.activity in set(ACTIVITIES) - {
        EVENT_DRIVEN
    }:
        message = f"`triggers` has no effect: the activity is {component.activity}"
        hint = f'write activity="{EVENT_DRIVEN}"'
        yield rules.CHOICE.at(component.span, message, hint=hint)


def _facts(component: Component) -> Iterator[Diagnostic]:
    span = component.span
    usual: tuple[tuple[str, str, Sequence[str]], ...] = (
        ("kind", component.kind, _KINDS),
        ("kind of execution context", component.execution, _CONTEXTS),
    )
    for key, value, words in usual:
        near = _nearest(value, words)
        if near and value not in words:
            hint = f"did you mean {near}?"
            yield rules.MISSPELT_KIND.at(span, f"unknown {key} {value!r}", hint=hint)
    for key, value in (("vendor", component.vendor), ("category", component.category)):
        if _BREAKS_ID.search(value):
            message = f"{key} {value!r} would break the profile's id"
            yield rules.ID_PART.at(span, message)
    if not (isfinite(component.rate) and component.rate > 0):
        message = f"rate {component.rate} is not a frequency above 0 Hz"
        yield rules.NUMBER.at(span, message)
    if component.max_instances < 0:
        message = f"max_instances is {component.max_instances}"
        yield rules.NUMBER.at(span, message, hint="0: no limit")


def _suggestion(word: str, choices: Sequence[str]) -> str:
    near = _nearest(word, choices)
    return f"did you mean {near}? " if near else ""


def _nearest(word: str, choices: Sequence[str]) -> str | None:
    from difflib import get_close_matches

    folded = {each.lower(): each for each in choices}
    close = get_close_matches(word.lower(), folded, n=1, cutoff=0.8)
    return folded[close[0]] if close else None


def _texts(component: Component) -> Iterator[Diagnostic]:
    def finding(span: Span, owner: str, texts: tuple[str, ...]) -> Iterator[Diagnostic]:
        for text in texts:
            bad = NOT_IN_XML.search(text)
            if bad is not None:
                message = f"{owner} has the character U+{ord(bad[0]):04X}, which XML cannot hold"
                yield rules.TEXT.at(span, message)
                return

    own = (component.kind, component.category, component.vendor, component.version)
    yield from finding(
        component.span,
        f"component `{component.scoped}`",
        (
            *(*own, component.activity_type, component.description),
            component.triggers,
            *(component.execution, component.doc),
        ),
    )
    for port in component.ports:
        owner = f"port `{port.identifier}`"
        yield from finding(
            port.span, owner, (port.name, port.port, port.instance, port.unit)
        )
        events = (each for each in port.annotations if each.name == EVENT)
        of_events = (str(e.get(key) or "") for e in events for key in EVENT_ARGUMENTS)
        yield from finding(port.span, owner, (port.doc, *of_events))
    for item in component.configuration:
        default = "" if item.default is None else value_text(item.default)
        texts = (item.name, item.unit, item.constraint, item.widget, item.doc, default)
        yield from finding(item.span, f"parameter `{item.identifier}`", texts)


def _ports(model: Model, component: Component) -> Iterator[Diagnostic]:
    named: dict[tuple[PortKind, str], Port] = {}
    offered: dict[tuple[PortKind, str, str], Port] = {}
    for port in component.ports:
        declaration = model.declared(port.type)
        if port.kind in _DATA_PORTS:
            if not isinstance(declaration, Struct | Union):
                yield rules.DATA_TYPE.at(
                    port.span,
                    f"port `{port.identifier}` is of type `{port.type}`, no struct or union",
                )
            earlier = named.setdefault((port.kind, port.name), port)
            if earlier is not port:
                direction = "InPorts" if port.kind is PortKind.INPORT else "OutPorts"
                yield rules.SAME_PORT.at(
                    port.span,
                    f"two {direction} have the outside name {port.name!r}",
                    related=[Related(earlier.span, "the other port")],
                    hint='give one of them another name: `@name("...")`',
                )
        else:
            if not isinstance(declaration, Interface) or declaration.local:
                verb = "provides" if port.kind is PortKind.PROVIDER else "uses"
                yield rules.INTERFACE.at(
                    port.span,
                    f"`{verb}` needs an interface, and `{port.type}` is not one",
                )
            key = (port.kind, port.port, port.instance)
            earlier = offered.setdefault(key, port)
            if earlier is not port:
                yield rules.SAME_INTERFACE.at(
                    port.span,
                    f"service port {port.port!r} has two interfaces called {port.instance!r}",
                    related=[Related(earlier.span, "the other one")],
                    hint='tell them apart by `@instance("...")`, or by `@port("...")`',
                )


def _configuration(model: Model, component: Component) -> Iterator[Diagnostic]:
    parameters = Parameters(model)
    first: dict[str, ConfigurationParameter] = {}
    for parameter in component.configuration:
        earlier = first.setdefault(parameter.name, parameter)
        if earlier is not parameter:
            yield rules.SAME_PARAMETER.at(
                parameter.span,
                f"two parameters have the outside name {parameter.name!r}",
                related=[Related(earlier.span, "the other parameter")],
                hint='give one of them another name: `@name("...")`',
            )
        if parameters.is_supported(parameter.type):
            yield from _values(parameters, parameter)
        else:
            yield rules.PARAMETER_TYPE.at(
                parameter.span,
                f"`{parameter.type}` cannot be the type of a parameter",
                hint="numbers, boolean, string, sequences of them, and enums can",
            )


def _values(
    parameters: Parameters, parameter: ConfigurationParameter
) -> Iterator[Diagnostic]:
    span, name = parameter.span, parameter.name
    problems = list(_bounds(parameters, parameter))
    fits = True
    if parameter.default is not None:
        try:
            parameters.check_value(parameter.type, parameter.default)
        except ValueMismatchError as reason:
            fits = False
            type_ = parameters.canonical_type(parameter.type)
            yield rules.DEFAULT_TYPE.at(
                span, f"default of {name!r} ({type_}): {reason}"
            )
    yield from problems
    if problems:
        return
    try:
        limit = parameters.constraint(parameter)
    except ConstraintError as reason:
        message = f"constraint of {name!r} cannot be read: {reason}"
        yield rules.CONSTRAINT.at(
            span, message, hint="for example `0.0<x<=2.0` or `(a,b)`"
        )
        return
    bounds = parameters.bounds(parameter)
    for allowed in dict.fromkeys((bounds, limit)):
        if allowed and fits and not parameters.is_default_allowed(parameter, allowed):
            written = "" if parameter.default is not None else "zero value, "
            text = parameters.default_text(parameter)
            message = f"default of {name!r} ({written}{text!r}) does not meet {text_of(allowed)}"
            hint = (
                None
                if parameter.default is not None
                else "give a default: `@default(...)`"
            )
            yield rules.DEFAULT_RANGE.at(span, message, hint=hint)
    yield from _widget(parameter, is_range(limit), is_enumeration(limit))


def _bounds(
    parameters: Parameters, parameter: ConfigurationParameter
) -> Iterator[Diagnostic]:
    low, high = parameter.minimum, parameter.maximum
    item = parameters.item_type(parameter.type)
    sound = True
    for key, bound in (("@min", low), ("@max", high)):
        if bound is None:
            continue
        try:
            if not parameters.is_number(item):
                raise ValueMismatchError(f"{item} has no bounds")
            parameters.check_value(item, bound)
        except ValueMismatchError as reason:
            sound = False
            yield rules.BOUNDS.at(
                parameter.span, f"{key} of {parameter.name!r}: {reason}"
            )
    if not sound or low is None or high is None:
        return
    if float(value_text(low)) > float(value_text(high)):
        yield rules.BOUNDS.at(
            parameter.span,
            f"@min of {parameter.name!r} ({low}) is above its @max ({high})",
        )


def _widget_hint(widget: str) -> str:
    kind, dot, step = widget.partition(".")
    near = _nearest(kind, _WIDGETS)
    meant = f"did you mean {near}{dot}{step}? " if near and near != kind else ""
    return f"{meant}text, slider.<step>, spin, spin.<step>, radio, checkbox or ordered_list"


def _widget(
    parameter: ConfigurationParameter, has_range: bool, has_values: bool
) -> Iterator[Diagnostic]:
    widget = parameter.widget
    if not is_widget(widget):
        yield rules.WIDGET.at(
            parameter.span,
            f"unknown widget {widget!r} for {parameter.name!r}",
            hint=_widget_hint(widget),
        )
    elif needs_range(widget) and not has_range:
        kind = widget.partition(".")[0]
        message = f"a {kind} for {parameter.name!r} needs a lower and an upper bound"
        yield rules.WIDGET_NEEDS.at(parameter.span, message)
    elif needs_values(widget) and not has_values:
        message = f"{widget} for {parameter.name!r} needs an enumeration of its values"
        yield rules.WIDGET_NEEDS.at(parameter.span, message)
