"""Applies rtgen's additional facts in a profile to the lowered component.

A fact applies only while the attributes are those that rtgen writes for it, so that edited
attributes take precedence. Therefore a fact is applied, and the attributes written from the result
are compared.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Declaration,
    Interface,
    Port,
    PortKind,
    ScopedName,
    Type,
)
from rtgen.compiler.model.rtc_profile import (
    EVENT,
    EVENT_PORT,
    ProfileParameter,
    RtcProfile,
)
from rtgen.compiler.typemap.components.annotations import (
    WrittenAnnotation,
    annotations_from,
    same_event,
)
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.profiles import escapes as profile_escapes
from rtgen.compiler.typemap.profiles import facts as profile_facts
from rtgen.compiler.typemap.profiles import rules
from rtgen.compiler.typemap.type_parsing import names_in, parsed

Facts: TypeAlias = Mapping[str, Any]
_Item = TypeVar("_Item", Port, ConfigurationParameter, Component)


@dataclass(frozen=True)
class Definitions:
    """Applies facts; unusable ones are reported to `report`."""

    declared: Mapping[ScopedName, Declaration]
    parameters: Parameters
    report: Callable[[Diagnostic], None]

    # Ports.

    def port(
        self, lowered: Port, facts: Facts, events: Sequence[Annotation] = ()
    ) -> Port:
        """Return the port with its facts applied; `events` are an event port's, as annotations."""
        with self._passing_over(lowered.span):
            is_data = lowered.kind in (PortKind.INPORT, PortKind.OUTPORT)
            name = facts.get("name")
            if name and (not is_data or name.strip() == lowered.name):
                lowered = replace(lowered, name=name)
            port, instance = facts.get("port"), facts.get("instance")
            if port is not None and port.strip() == lowered.port:
                lowered = replace(lowered, port=port)
            if instance is not None and instance.strip() == lowered.instance:
                lowered = replace(lowered, instance=instance)
            lowered = _with_doc(lowered, facts)
        return self._annotated(lowered, facts, events)

    # Parameters.

    def type(self, parameter: ProfileParameter) -> Type | None:
        """Return the IDL type of a parameter; None if its attribute determines the type."""
        with self._passing_over(parameter.type_span):
            text = parameter.facts.get("type")
            if text is None:
                return None
            type_ = parsed(text)
            for named in names_in(type_):
                if named.name not in self.declared:
                    raise ValueError(f"{named} is not found")
            if not self.parameters.is_supported(type_):
                raise ValueError(f"{type_} cannot be the type of a parameter")
            word = self.parameters.profile_type(type_)
            return type_ if word == " ".join(parameter.type.split()) else None
        return None

    def default(
        self, lowered: ConfigurationParameter, parameter: ProfileParameter
    ) -> ConfigurationParameter:
        """Return the parameter with the default of its facts, if the attribute agrees."""
        if "default" not in parameter.facts:
            return lowered
        with self._passing_over(parameter.default_span):
            fact = parameter.facts["default"]
            default = None if fact is None else profile_facts.value_from_json(fact)
            tried = replace(lowered, default=default)
            if default is not None:
                self.parameters.check_value(lowered.type, default)
            if self.parameters.default_text(tried).strip() == parameter.default:
                return tried
        return lowered

    def parameter(
        self, lowered: ConfigurationParameter, parameter: ProfileParameter
    ) -> ConfigurationParameter:
        """Return the parameter with its remaining facts applied."""
        facts = parameter.facts
        with self._passing_over(lowered.span):
            name = facts.get("name")
            if name is not None and name.strip() == lowered.name:
                lowered = replace(lowered, name=name)
            if parameter.widget == "text" and facts.get("widget") == "text":
                lowered = replace(lowered, widget="text")
            lowered = _with_doc(lowered, facts)
            lowered = self._with_limits(lowered, parameter)
        return self._annotated(lowered, facts)

    def _with_limits(
        self, lowered: ConfigurationParameter, parameter: ProfileParameter
    ) -> ConfigurationParameter:
        """Return the parameter with bounds and its constraint as written. Raises ValueError."""
        facts = parameter.facts
        constraint = facts.get("constraint")
        tried = replace(
            lowered,
            minimum=self._bound(lowered, facts, "min"),
            maximum=self._bound(lowered, facts, "max"),
            constraint=lowered.constraint if constraint is None else constraint,
        )
        if tried == lowered:
            return lowered
        limit = self.parameters.constraint(tried)
        if limit != parameter.constraint:
            return lowered
        for each in (limit, self.parameters.bounds(tried)):
            if each and not self.parameters.is_default_allowed(tried, each):
                return lowered
        return tried

    def _bound(
        self, parameter: ConfigurationParameter, facts: Facts, key: str
    ) -> ConstantValue | None:
        if key not in facts:
            return None
        bound = profile_facts.value_from_json(facts[key])
        if not self.parameters.is_number(parameter.type):
            raise ValueError(f"{parameter.type} has no bounds")
        self.parameters.check_value(self.parameters.item_type(parameter.type), bound)
        return bound

    # The component.

    def name(self, profile: RtcProfile, last: str) -> ScopedName:
        """Return the scoped name; `last` is the component's unscoped name."""
        with self._passing_over(profile.span):
            text = profile.facts.get("name")
            if text is None:
                return (last,)
            *modules, _ = parts = text.split("::")
            if len(parts) > 20 or any(
                profile_escapes.word(p, "X") != p for p in modules
            ):
                raise ValueError(f"{text[:40]!r} is not a scoped name")
            for depth in range(1, len(parts)):
                if tuple(parts[:depth]) in self.declared:
                    raise ValueError(f"{'::'.join(parts[:depth])} is not a module")
            return (*modules, last)
        return (last,)

    def component(self, lowered: Component, profile: RtcProfile) -> Component:
        """Return the component with its facts applied."""
        facts = profile.facts
        with self._passing_over(lowered.span):
            for field, usual in profile_facts.WITH_USUAL.items():
                text = facts.get(field)
                if text is None:
                    continue
                if profile_facts.read_text(text, usual) == getattr(lowered, field):
                    changed: dict[str, Any] = {field: text}
                    lowered = replace(lowered, **changed)
            lowered = self._with_texts(lowered, facts)
            name = facts.get("name") or profile.name
            repository_id = facts.get("repository_id")
            if repository_id and name == lowered.scoped:
                lowered = replace(lowered, repository_id=repository_id)
            lowered = replace(
                lowered, ports=_in_order(lowered.ports, facts.get("order"))
            )
            lowered = replace(lowered, supports=tuple(self._supported(lowered, facts)))
            lowered = self._with_base(lowered, facts)
        return self._annotated(lowered, facts)

    def _with_texts(self, component: Component, facts: Facts) -> Component:
        doc, description = facts.get("doc"), facts.get("description")
        if doc is not None:
            text = component.description if description is None else description
            summary = profile_escapes.summary(text, doc)
            if profile_facts.read_doc(doc, summary) == component.doc:
                component = replace(component, doc=doc)
        if description is not None:
            summary = profile_escapes.summary(description, component.doc)
            if profile_escapes.one_line(summary) == component.description:
                component = replace(component, description=description)
        return component

    def _supported(self, component: Component, facts: Facts) -> Iterator[ScopedName]:
        for text in facts.get("supports") or ():
            name = tuple(str(text).split("::"))
            if isinstance(self.declared.get(name), Interface):
                yield name
            else:
                self._report_at(component.span, f"the interface {text} is not found")

    def _with_base(self, component: Component, facts: Facts) -> Component:
        """Return the component with its base, if it has all members of the base."""
        text = facts.get("base")
        if text is None:
            return component
        base = self.declared.get(tuple(text.split("::")))
        if not isinstance(base, Component):
            self._report_at(component.span, f"the component {text} is not found")
            return component
        ports = _inherited(component.ports, base.ports)
        configuration = _inherited(component.configuration, base.configuration)
        if ports is None or configuration is None:
            message = f"it is no longer a {text}: what it inherits was changed"
            self._report_at(component.span, message)
            return component
        return replace(
            component, base=base.name, ports=ports, configuration=configuration
        )

    # Annotations.

    def _annotated(
        self, item: _Item, facts: Facts, events: Sequence[Annotation] = ()
    ) -> _Item:
        entries: list[WrittenAnnotation] = []
        with self._passing_over(item.span):
            entries = profile_facts.annotations_from_json(
                facts.get("annotations") or []
            )
        usable = [each for each in entries if isinstance(each, Annotation)]
        superseded = [
            each
            for each in usable
            if each.name in (EVENT_PORT, EVENT)
            and not any(same_event(each, event) for event in events)
        ]
        entries = [each for each in entries if each not in superseded]
        new = [each for each in events if not any(same_event(each, k) for k in usable)]
        return replace(item, annotations=annotations_from(item, entries) + tuple(new))

    @contextmanager
    def _passing_over(self, span: Span) -> Iterator[None]:
        """Report unusable facts; those already applied are kept."""
        try:
            yield
        except ValueError as error:
            self._report_at(span, str(error))

    def _report_at(self, span: Span, message: str) -> None:
        text = f"the property {profile_facts.PROPERTY}: {message}"
        self.report(rules.FACTS.at(span, text))


def identifier_of(variable: str, facts: Facts) -> str | None:
    """Return the identifier in the facts, if the attribute matches."""
    identifier = facts.get("identifier")
    return variable if identifier == variable else None


def _with_doc(item: _Item, facts: Facts) -> _Item:
    doc = facts.get("doc")
    if doc is None or profile_facts.read_doc(doc) != item.doc:
        return item
    return replace(item, doc=doc)


def _in_order(ports: Sequence[Port], order: Sequence[Any] | None) -> tuple[Port, ...]:
    """Return the ports in the order of the definition; new ones are last."""
    if order is None:
        return tuple(ports)
    places = {str(name): place for place, name in enumerate(order)}
    return tuple(
        sorted(ports, key=lambda port: places.get(port.identifier, len(places)))
    )


_Part = TypeVar("_Part", Port, ConfigurationParameter)


def _inherited(
    own: Sequence[_Part], of_base: Sequence[_Part]
) -> tuple[_Part, ...] | None:
    """Return all items, the base's first and unchanged; None if one of those differs."""
    rest: list[_Part] = list(own)
    for item in of_base:
        same = [each for each in rest if replace(each, span=item.span) == item]
        if not same:
            return None
        rest.remove(same[0])
    return tuple(of_base) + tuple(rest)
