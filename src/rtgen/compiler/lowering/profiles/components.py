"""Lowers profiles to components of the model: resolves types, makes identifiers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule, Span
from rtgen.compiler.lowering.profiles.definitions import Definitions, identifier_of
from rtgen.compiler.lowering.profiles.disagreements import disagreements
from rtgen.compiler.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Declaration,
    Interface,
    Model,
    NamedType,
    Port,
    PortKind,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
    default_id,
)
from rtgen.compiler.model.declarations import OPAQUE
from rtgen.compiler.model.rtc_profile import (
    EVENT,
    EVENT_PORT,
    ProfileDataPort,
    ProfileInterface,
    ProfileParameter,
    RtcProfile,
)
from rtgen.compiler.typemap.components.parameter_types import type_of
from rtgen.compiler.typemap.components.parameters import Parameters, ValueMismatchError
from rtgen.compiler.typemap.components.widgets import is_widget
from rtgen.compiler.typemap.profiles import escapes as profile_escapes
from rtgen.compiler.typemap.profiles import rules
from rtgen.facts.constraints import Constraint, text_of

_DATA = (Struct, Union)
_BREAKS_ID = re.compile(r"[:\r\n\t]")
_BREAKS_VERSION = re.compile(r"[:\s]+")
_REPOSITORY_ID = re.compile(r"IDL:(.*?)(?::[\d.]*)?")
_TYPE_NAME = re.compile(r"\w+(?:::\w+)*")
"""The valid form of a type name: components do not register other forms, such as repository ids."""
_MAX_NAME_LENGTH = 100


@dataclass
class Lowering:
    """Lowers profiles to components, with the types of a model, and placeholders for unknown ones.

    `given` are the definition files given by the user. A component found through a profile belongs
    to that profile.
    """

    model: Model
    given: frozenset[str] = frozenset()
    diagnostics: list[Diagnostic] = field(default_factory=list)
    placeholders: dict[ScopedName, Declaration] = field(default_factory=dict)
    _stand_ins: dict[tuple[ScopedName, bool], ScopedName] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._by_name = {d.name: d for d in self.model.declarations}
        self._bound: set[ScopedName] = set()
        self._types: set[ScopedName] = set()
        for name in self._by_name:
            self._take(name)
        self._parameters = Parameters(self.model)
        self._definitions = Definitions(
            self._by_name, self._parameters, self.diagnostics.append
        )

    def component(self, profile: RtcProfile) -> Component:
        """Lower a profile, whose names are reserved for later ones."""
        taken: set[str] = set()
        ports = [self._data_port(profile, port, taken) for port in profile.data_ports]
        for service in profile.service_ports:
            for interface in service.interfaces:
                ports.append(self._interface(profile, service.name, interface, taken))
        parameter_names: set[str] = set()
        parameters = [self._parameter(p, parameter_names) for p in profile.parameters]
        name = self._name(profile)
        other = self._by_name.get(name)
        lowered = Component(
            name=name,
            repository_id=default_id(name),
            file=profile.file,
            span=profile.span,
            doc=profile.doc,
            ports=tuple(_beside(name[-1], port, taken) for port in ports),
            configuration=tuple(
                _beside(name[-1], p, parameter_names) for p in parameters
            ),
            kind=profile.kind,
            category=self._id_part(profile, profile.category, _BREAKS_ID),
            vendor=self._id_part(profile, profile.vendor, _BREAKS_ID),
            version=self._id_part(profile, profile.version, _BREAKS_VERSION),
            description=profile.description,
            rate=1000.0 if profile.rate is None else profile.rate,
            max_instances=profile.max_instances,
            activity=profile.activity,
            component_type=profile.component_type,
            activity_type=profile.activity_type,
            triggers=profile.triggers,
            execution=profile.execution,
            created=profile.created,
            updated=profile.updated,
            language=profile.language,
            other_file="" if other is None else other.file,
        )
        lowered = self._definitions.component(lowered, profile)
        before = self._by_name.get(lowered.name)
        other_file = isinstance(before, Component) and before.file != lowered.file
        if isinstance(before, Component) and other_file and not profile.implements:
            self.diagnostics += disagreements(lowered, before)
        self._by_name[lowered.name] = lowered
        return lowered

    def _report_at(
        self, rule: Rule, span: Span, message: str, hint: str | None = None
    ) -> None:
        self.diagnostics.append(rule.at(span, message, hint=hint))

    def _name(self, profile: RtcProfile) -> ScopedName:
        """Return the component's name, with a diagnostic if it was changed."""
        last = profile_escapes.word(profile.name, "Component")[:_MAX_NAME_LENGTH]
        why = "is not an identifier" if len(last) < _MAX_NAME_LENGTH else "is too long"
        name = self._definitions.name(profile, last)
        other = self._by_name.get(name)
        if isinstance(other, Component):
            is_given = other.file in self.given and not profile.implements
            if is_given or other.file == profile.file:
                message = f"there is a component {other.scoped} already"
                related = [Related(other.span, "the other one")]
                diagnostic = rules.SAME_COMPONENT.at(
                    profile.span, message, related=related
                )
                self.diagnostics.append(diagnostic)
        elif self._is_taken(name):
            last, why = f"{last}Component", "is the name of a type or module, too"
            name = (*name[:-1], last)
        if last != profile.name:
            message = f"{profile.name!r} {why}; the component is {last}"
            self._report_at(rules.NAME, profile.span, message)
        return name

    def _id_part(
        self, profile: RtcProfile, text: str, breaking: re.Pattern[str]
    ) -> str:
        """Return a part of the profile's id, with a diagnostic if it was changed."""
        mended = breaking.sub("_", text)
        if mended != text:
            message = f"{text!r} would break the profile's id; {mended!r} is taken"
            self._report_at(rules.NAME, profile.span, message)
        return mended

    def _outside_name(self, span: Span, text: str) -> str:
        """Return a port's, interface's or parameter's name, with a diagnostic if it was changed."""
        mended = "".join(c if c.isprintable() else "_" for c in text)
        mended = mended if mended.strip() else "_"
        if mended != text:
            message = f"{text!r} cannot be printed; {mended!r} is taken"
            self._report_at(rules.NAME, span, message)
        return mended

    def _is_taken(self, name: ScopedName) -> bool:
        """Return whether the name, in any case, is that of a type or module, or used in a type."""
        scopes = tuple(_scopes(name))
        return scopes[-1] in self._bound or not self._types.isdisjoint(scopes)

    def _take(self, name: ScopedName) -> None:
        *_, whole = scopes = tuple(_scopes(name))
        self._bound.update(scopes)
        self._types.add(whole)

    # Ports.

    def _data_port(
        self, profile: RtcProfile, port: ProfileDataPort, taken: set[str]
    ) -> Port:
        type_ = self._type(profile, port, service=False)
        kind = PortKind.OUTPORT if port.output else PortKind.INPORT
        lowered = Port(
            kind=kind,
            name=self._outside_name(port.span, port.name),
            identifier=_identifier(port, kind.value, taken),
            type=type_,
            span=port.span,
            doc=port.doc,
            unit=port.unit,
        )
        events: list[Annotation] = []
        if port.for_events:
            occurrences = (Annotation(EVENT, event) for event in port.events)
            events = [Annotation(EVENT_PORT), *occurrences]
        return self._definitions.port(lowered, port.facts, events)

    def _interface(
        self,
        profile: RtcProfile,
        service: str,
        interface: ProfileInterface,
        taken: set[str],
    ) -> Port:
        type_ = self._type(profile, interface, service=True)
        identifier = _identifier(interface, "service", taken)
        port = Port(
            kind=PortKind.PROVIDER if interface.provided else PortKind.CONSUMER,
            name=identifier,
            identifier=identifier,
            type=type_,
            port=self._outside_name(interface.span, service),
            instance=self._outside_name(interface.span, interface.name),
            type_name=_type_name(interface, type_),
            span=interface.span,
            doc=interface.doc,
        )
        return self._definitions.port(port, interface.facts)

    def _type(
        self,
        profile: RtcProfile,
        port: ProfileDataPort | ProfileInterface,
        *,
        service: bool,
    ) -> Type:
        """Return the type of a port in the model, or a placeholder."""
        facts = port.facts if port.facts.get("type_name") == port.type else {}
        written = _scoped(facts.get("type", port.type))
        if isinstance(port, ProfileDataPort) and port.data_type != port.type:
            if not port.data_type:
                return self._stand_in(profile, port, ("Any",), service)
            written = _scoped(port.data_type)
        name = self._declared_name(written, service)
        if name is None:
            return self._placeholder(profile, port, written, service)
        type_ = NamedType(name)
        plain = self.model.unalias(type_)
        declaration = (
            self._by_name[plain.name] if isinstance(plain, NamedType) else None
        )
        if isinstance(declaration, Interface if service else _DATA):
            return type_
        expectation = "an interface" if service else "a struct or union"
        message = f"{port.type} is not {expectation}; it stays opaque"
        self._report_at(rules.WRONG_TYPE, port.type_span, message)
        return self._stand_in(profile, port, written, service)

    def _declared_name(self, written: ScopedName, service: bool) -> ScopedName | None:
        """Return the declared name; without a scope, it is searched for in all modules."""
        if written in self._by_name:
            return written
        if len(written) != 1:
            return None
        if ("RTC", *written) in self._by_name:
            return ("RTC", *written)
        kinds = Interface if service else _DATA
        others = [
            name
            for name, declaration in self._by_name.items()
            if name[-1:] == written and isinstance(declaration, kinds)
        ]
        return others[0] if len(others) == 1 else None

    def _placeholder(
        self,
        profile: RtcProfile,
        port: ProfileDataPort | ProfileInterface,
        written: ScopedName,
        service: bool,
    ) -> Type:
        if (written, service) not in self._stand_ins:
            if (written, not service) in self._stand_ins:
                kind = "data" if service else "a service"
                message = f"{port.type} is {kind} elsewhere; it stays opaque"
                self._report_at(rules.WRONG_TYPE, port.type_span, message)
            else:
                declared = f", which {port.idl_file} declares," if port.idl_file else ""
                plain = not port.facts and written == _scoped(port.type)
                shown = port.type if plain else "::".join(written)
                shown = shown or "the type"
                message = f"{shown}{declared} is not found; it stays opaque"
                hint = "name its IDL file as a source, or its folder with -I"
                self._report_at(rules.UNKNOWN_TYPE, port.type_span, message, hint)
        return self._stand_in(profile, port, written, service)

    def _stand_in(
        self,
        profile: RtcProfile,
        port: ProfileDataPort | ProfileInterface,
        written: ScopedName,
        service: bool,
    ) -> Type:
        """Return the placeholder for a name, with the same name if it is free."""
        name = self._stand_ins.get((written, service))
        if name is None:
            parts = [profile_escapes.word(part, "Unknown") for part in written]
            name = tuple(parts) or ("Unknown",)
            if self._is_taken(name):
                name = ("_".join(parts),)
            while self._is_taken(name):
                name = (f"{name[0]}_",)
            self._stand_ins[written, service] = name
            placeholder = _opaque(name, service, profile.file, port.type_span)
            self.placeholders[name] = placeholder
            self._take(name)
        return NamedType(name)

    # Parameters.

    def _parameter(
        self, parameter: ProfileParameter, taken: set[str]
    ) -> ConfigurationParameter:
        type_ = self._definitions.type(parameter) or type_of(parameter.type)
        if type_ is None:
            message = f"the type {parameter.type!r} is not known; string is taken"
            hint = "int, double, bool, string, std::vector<double>, ..."
            self._report_at(rules.PARAMETER_TYPE, parameter.type_span, message, hint)
            type_ = StringType()
        lowered = ConfigurationParameter(
            name=self._outside_name(parameter.span, parameter.name),
            identifier=_identifier(parameter, "value", taken),
            type=type_,
            span=parameter.span,
            doc=parameter.doc,
            unit=parameter.unit,
            widget=self._widget(parameter),
        )
        lowered = self._with_default(lowered, parameter)
        lowered = self._definitions.default(lowered, parameter)
        lowered = self._with_constraint(lowered, parameter)
        return self._definitions.parameter(lowered, parameter)

    def _widget(self, parameter: ProfileParameter) -> str:
        widget = parameter.widget.strip()
        if is_widget(widget):
            return "" if widget == "text" else widget
        message = f"the widget of {parameter.name} is {widget!r}; text is taken"
        self._report_at(rules.BAD_WIDGET, parameter.span, message)
        return ""

    def _with_default(
        self, lowered: ConfigurationParameter, parameter: ProfileParameter
    ) -> ConfigurationParameter:
        text = parameter.default
        plain = self.model.unalias(lowered.type)
        if not text and not isinstance(plain, StringType | SequenceType):
            return lowered
        try:
            default: ConstantValue = (
                text
                if isinstance(plain, SequenceType)
                else self._parameters.parse_item(plain, text)
            )
            self._parameters.check_value(plain, default)
        except ValueMismatchError as error:
            message = f"the default of {parameter.name}: {error}"
            self._report_at(rules.PARAMETER_VALUE, parameter.default_span, message)
            return lowered
        return replace(lowered, default=default)

    def _with_constraint(
        self, lowered: ConfigurationParameter, parameter: ProfileParameter
    ) -> ConfigurationParameter:
        if parameter.constraint is None:
            return lowered
        tried = replace(lowered, constraint=text_of(parameter.constraint))
        try:
            limit = self._parameters.constraint(tried)
        except ValueError as error:
            message = f"the constraint of {parameter.name} is left out: {error}"
            self._report_at(rules.CONSTRAINT, parameter.span, message)
            return lowered
        if limit is not None and not self._allowed(tried, limit):
            message = (
                f"the constraint of {parameter.name} is left out: "
                "its default does not meet it"
            )
            self._report_at(rules.CONSTRAINT, parameter.span, message)
            return lowered
        return tried

    def _allowed(self, parameter: ConfigurationParameter, limit: Constraint) -> bool:
        return self._parameters.is_default_allowed(parameter, limit)


def _scopes(name: ScopedName) -> Iterator[ScopedName]:
    """Yield the name and its scopes, outermost first, in lower case."""
    small = tuple(part.lower() for part in name)
    for depth in range(1, len(name) + 1):
        yield small[:depth]


def _scoped(text: str) -> ScopedName:
    """Parse a type's name in its variants: IDL, repository id, with dots or slashes."""
    text = text.strip()
    if (match := _REPOSITORY_ID.fullmatch(text)) is not None:
        text = match[1]
    if "::" not in text:
        text = text.replace("/", "::").replace(".", "::")
    return tuple(part.strip() for part in text.split("::") if part.strip())


def _type_name(interface: ProfileInterface, type_: Type) -> str:
    """Return an interface's type name in a profile, if it is not the scoped name."""
    written = interface.type.strip()
    is_name = _TYPE_NAME.fullmatch(written) or interface.facts.get("type_name")
    return written if is_name and written != str(type_) else ""


def _opaque(name: ScopedName, service: bool, file: str, span: Span) -> Declaration:
    """Return a placeholder: an interface, or a struct."""
    repository_id = default_id(name)
    annotations = (Annotation(OPAQUE),)
    if service:
        return Interface(
            name=name,
            repository_id=repository_id,
            file=file,
            span=span,
            annotations=annotations,
        )
    return Struct(
        name=name,
        repository_id=repository_id,
        file=file,
        span=span,
        annotations=annotations,
        members=(),
    )


_Item = TypeVar("_Item", Port, ConfigurationParameter)


def _beside(component: str, item: _Item, taken: set[str]) -> _Item:
    """Return the item, renamed if it has the component's identifier, which IDL forbids."""
    if item.identifier.lower() != component.lower():
        return item
    name, number = item.identifier, 1
    while name.lower() in taken:
        number += 1
        name = f"{item.identifier}_{number}"
    return replace(item, identifier=name)


def _identifier(
    item: ProfileDataPort | ProfileInterface | ProfileParameter,
    otherwise: str,
    taken: set[str],
) -> str:
    """Return an identifier that is unique in the component, ignoring case."""
    text = profile_escapes.identifier(item.variable or item.name, otherwise)
    base = name = identifier_of(item.variable, item.facts) or text
    number = 1
    while name.lower() in taken:
        number += 1
        name = f"{base}_{number}"
    taken.add(name.lower())
    return name


def components(
    profiles: Sequence[RtcProfile],
    model: Model,
    given_files: frozenset[str] = frozenset(),
) -> tuple[tuple[Declaration, ...], tuple[Diagnostic, ...]]:
    """Return the placeholders, then the components of profiles, and the diagnostics."""
    lowering = Lowering(model, given_files)
    lowered = [lowering.component(profile) for profile in _bases_first(profiles)]
    return (*lowering.placeholders.values(), *lowered), tuple(lowering.diagnostics)


def _bases_first(profiles: Sequence[RtcProfile]) -> list[RtcProfile]:
    """Return the profiles, each after its base's."""
    rest = list(profiles)
    ordered: list[RtcProfile] = []
    while rest:
        names = {p.facts.get("name") or p.name for p in rest}
        ready = [p for p in rest if p.facts.get("base") not in names]
        ordered += ready or rest
        rest = [p for p in rest if p not in ready] if ready else []
    return ordered
