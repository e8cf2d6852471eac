"""Lowers the component construct (CORBA 3) to an RTC's ports, configuration and profile."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.frontends.idl.lowering.common_fields import CommonFields
from rtgen.compiler.frontends.idl.meaning.annotations import (
    Annotations,
    contradictions,
    text,
    value,
)
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import annotations as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import (
    Annotation,
    ArrayType,
    Component,
    ConfigurationParameter,
    ConstantValue,
    EnumeratorName,
    InitialValue,
    NamedType,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Type,
    Typedef,
    limits,
)
from rtgen.facts import parameter_texts
from rtgen.facts.comments import first_sentence

_KINDS = {
    "consumes": PortKind.INPORT,
    "publishes": PortKind.OUTPORT,
    "emits": PortKind.OUTPORT,
    "provides": PortKind.PROVIDER,
    "uses": PortKind.CONSUMER,
    "uses multiple": PortKind.CONSUMER,
}
_DATA = (PortKind.INPORT, PortKind.OUTPORT)
_NO_TEXT_FORM = frozenset(
    (
        *(Primitive.ANY, Primitive.OBJECT, Primitive.VALUE_BASE, Primitive.TYPE_CODE),
        Primitive.VOID,
    )
)
_DATE = re.compile(
    r"-?\d{4,}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])T([01]\d|2[0-3]):[0-5]\d:[0-5]\d(\.\d+)?"
    r"(Z|[+-]\d\d:\d\d)"
)
_DATES = ("created", "updated")


class Components(msgspec.Struct, eq=False):
    """Lowers components to the model; diagnostics go to `report`."""

    _types: Types
    _fields: CommonFields
    _typedefs: Mapping[ScopedName, Typedef]
    _report: Callable[[Diagnostic], None]
    _made: dict[Entity, Component] = {}

    def declaration(
        self, entity: Entity, node: tree.Component, annotations: Annotations
    ) -> Component:
        """Lower a component with its inherited members."""
        unit = entity.unit
        common = self._fields.common(entity)
        base = self._base(node)
        ports = list(base.ports) if base else []
        configuration = list(base.configuration) if base else []
        for item in node.body.items:
            match item.node:
                case tree.PortItem():
                    port = self._port(item, item.node, unit, annotations)
                    if port is not None and self._is_new(port, ports):
                        ports.append(port)
                case tree.Attribute():
                    for parameter in self._parameters(
                        item, item.node, unit, annotations
                    ):
                        if self._is_new(parameter, configuration):
                            configuration.append(parameter)
        references = self._types.tables.references
        supported = (references.get(name) for name in node.supports)
        component = Component(
            **common,
            **self._profile(common, entity),
            ports=tuple(ports),
            configuration=tuple(configuration),
            base=base.name if base else None,
            supports=tuple(s.path for s in supported if isinstance(s, Entity)),
        )
        self.keep(entity, component)
        return component

    def keep(self, entity: Entity, component: Component) -> None:
        """Store a component, which others may be derived from."""
        self._made[entity] = component

    def _base(self, node: tree.Component) -> Component | None:
        if node.base is None:
            return None
        base = self._types.tables.references.get(node.base)
        return self._made.get(base) if isinstance(base, Entity) else None

    def _profile(self, common: dict[str, Any], entity: Entity) -> dict[str, Any]:
        """Return the arguments of `@rtc`; the description defaults to the first line of the doc."""
        profile: dict[str, Any] = {}
        for annotation in common["annotations"]:
            if annotation.name == "rtc":
                profile.update(annotation.arguments)
        fields = Component.__struct_fields__
        profile = {key: value for key, value in profile.items() if key in fields}
        for key in _DATES:
            if key in profile and not _DATE.fullmatch(profile[key]):
                message = f'"{profile[key]}" is not a date with a time zone'
                hint = "write 2011-09-26T10:00:00+09:00"
                self._report(rules.BAD_DATE.at(entity.span, message, hint=hint))
                del profile[key]
        if profile.get("rate", 1.0) <= 0:
            message = "the rate is not positive"
            hint = "write the rate in Hz, such as rate=100.0"
            self._report(rules.BAD_ARGUMENT.at(entity.span, message, hint=hint))
            del profile["rate"]
        if common["doc"]:
            profile.setdefault("description", first_sentence(common["doc"]))
        return profile

    def _is_new(
        self,
        new: Port | ConfigurationParameter,
        others: list[Port] | list[ConfigurationParameter],
    ) -> bool:
        for other in others:
            if _slot(new) == _slot(other):
                related = [Related(other.span, "declared here")]
                message = f"{new.name} is declared twice"
                self._report(
                    rules.DUPLICATE_PORT.at(
                        new.span, message, related=related, hint="rename one of them"
                    )
                )
                return False
        return True

    def _outside(
        self,
        annotations: tuple[Annotation, ...],
        key: str,
        default: str,
        entity: Entity,
    ) -> str:
        name = text(annotations, key)
        if name is None:
            return default
        if not name.strip() or not name.isprintable():
            message = f"@{key} is empty or holds a character that cannot be printed"
            hint = f'write @{key}("...") with a printable name, or leave it out'
            self._report(rules.BAD_NAME.at(entity.span, message, hint=hint))
            return default
        return name

    def _port(
        self, item: tree.Item, node: tree.PortItem, unit: Unit, annotations: Annotations
    ) -> Port | None:
        entity = self._types.tables.entities[node.name]
        if node.keyword not in _KINDS or node.keyword.endswith("multiple"):
            message = f"'{node.keyword}' is read only"
            hint = "rtgen generates nothing for it"
            self._report(rules.PASSED_OVER.at(entity.span, message, hint=hint))
            if node.keyword not in _KINDS:
                return None
        type_ = self._types.of_node(node.type, unit)
        if type_ is None:
            return None
        kind = _KINDS[node.keyword]
        if not self._fits(kind, type_, node, unit):
            return None
        attached = annotations.of(item.annotations, "port", unit, type_)
        name = self._outside(attached, "name", node.name.text, entity)
        service = kind not in _DATA
        interface = str(type_).rpartition("::")[2]
        type_name = self._outside(attached, "type_name", "", entity) if service else ""
        return Port(
            span=entity.span,
            doc=self._fields.doc(item, unit),
            annotations=attached,
            kind=kind,
            name=name,
            identifier=node.name.text,
            type=type_,
            port=self._outside(attached, "port", name, entity) if service else "",
            instance=(
                self._outside(attached, "instance", interface, entity)
                if service
                else ""
            ),
            unit=text(attached, "unit") or "",
            type_name="" if type_name == str(type_) else type_name,
        )

    def _fits(
        self, kind: PortKind, type_: Type, node: tree.PortItem, unit: Unit
    ) -> bool:
        plain = self._types.unaliased(type_)
        if plain is None:
            return False
        type_kind = self._types.kind_of(plain)
        if kind in _DATA:
            good = type_kind in (Kind.STRUCT, Kind.UNION, Kind.VALUETYPE)
            expectation = "a struct or union"
        else:
            good = type_kind is Kind.INTERFACE or plain == PrimitiveType(
                Primitive.OBJECT
            )
            expectation = "an interface"
        if not good:
            span = unit.span(node.type.start, node.type.end)
            message = f"'{node.keyword}' takes {expectation}, not {type_}"
            related = []
            if isinstance(type_, NamedType):
                entity = self._types.entity(type_.name)
                related = [Related(entity.span, "declared here")] if entity else []
            hint = (
                "wrap it into a struct, such as one with a Time tm and the data"
                if kind in _DATA
                else "name an interface; data goes through consumes and publishes"
            )
            self._report(
                rules.BAD_PORT_TYPE.at(span, message, related=related, hint=hint)
            )
        return good

    def _parameters(
        self,
        item: tree.Item,
        node: tree.Attribute,
        unit: Unit,
        annotations: Annotations,
    ) -> list[ConfigurationParameter]:
        type_ = self._types.of_node(node.type, unit)
        if type_ is None:
            return []
        span = unit.span(node.type.start, node.type.end)
        if node.readonly:
            message = "a read-only attribute is not a configuration parameter"
            hint = "leave readonly out"
            self._report(rules.PASSED_OVER.at(span, message, hint=hint))
            return []
        if not self._has_text_form(type_):
            message = f"{type_} cannot be the type of a configuration parameter"
            hint = (
                "it is a number, boolean, string, enum, or a sequence or array of these"
            )
            self._report(rules.BAD_PARAMETER_TYPE.at(span, message, hint=hint))
            return []
        attached = annotations.of(item.annotations, "configuration", unit, type_)
        doc = self._fields.doc(item, unit)
        parameters = []
        for name in node.names:
            entity = self._types.tables.entities[name]
            parameters.append(self._parameter(entity, type_, attached, doc))
        return parameters

    def _parameter(
        self, entity: Entity, type_: Type, attached: tuple[Annotation, ...], doc: str
    ) -> ConfigurationParameter:
        aliases = [*self._aliases(type_)]
        low, high = limits(chain(attached, *(each.annotations for each in aliases)))
        default = value(attached, "default")
        if default is None:
            inherited = (each.initial for each in aliases if each.initial is not None)
            default = next(map(_text_form, inherited), None)
        for message in contradictions((low, high), default):
            hint = "correct @default, @min or @max"
            self._report(rules.DEFAULT_RANGE.at(entity.span, message, hint=hint))
        return ConfigurationParameter(
            span=entity.span,
            doc=doc,
            annotations=attached,
            name=self._outside(attached, "name", entity.name, entity),
            identifier=entity.name,
            type=type_,
            default=default,
            minimum=low,
            maximum=high,
            unit=text(attached, "unit") or "",
            constraint=text(attached, "constraint") or "",
            widget=text(attached, "widget") or "",
        )

    def _aliases(self, type_: Type) -> Iterator[Typedef]:
        """Yield the typedefs of a type, the nearest first."""
        while isinstance(type_, NamedType) and type_.name in self._typedefs:
            typedef = self._typedefs[type_.name]
            yield typedef
            type_ = typedef.type

    def _has_text_form(self, type_: Type) -> bool:
        plain = self._types.unaliased(type_)
        if isinstance(plain, SequenceType | ArrayType):
            plain = self._types.unaliased(plain.element)
            if isinstance(plain, SequenceType | ArrayType):
                return False
        match plain:
            case PrimitiveType(kind):
                return kind not in _NO_TEXT_FORM
            case StringType():
                return True
            case NamedType(name):
                return self._types.is_enum(name)
        return False


def _text_form(initial: InitialValue) -> ConstantValue | None:
    """Return a default as that of a parameter: a text for a list, None if it has none."""
    if not isinstance(initial, tuple):
        return initial
    items = [i.name[-1] if isinstance(i, EnumeratorName) else i for i in initial]
    try:
        return parameter_texts.text_of(items)
    except ValueError:
        return None


def _slot(item: Port | ConfigurationParameter) -> tuple[str, ...]:
    """Return the key of a port or parameter, unique in a component."""
    if isinstance(item, ConfigurationParameter):
        return (item.name,)
    if item.kind in _DATA:
        return (item.kind, item.name)
    return (item.kind, item.port, item.instance, item.name)
