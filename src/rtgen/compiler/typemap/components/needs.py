"""The declarations that a component's definition depends on."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Declaration,
    Documented,
    Enum,
    EnumeratorName,
    Model,
    Port,
    ScopedName,
)
from rtgen.compiler.typemap.type_parsing import names_in


def declarations_of(model: Model, component: Component) -> list[Declaration]:
    """Return the declarations of a component's types, base, interfaces and named enumerators."""
    items: list[Port | ConfigurationParameter]
    items = [*component.ports, *component.configuration]
    names = [each.name for item in items for each in names_in(item.type)]
    names += [component.base] if component.base is not None else []
    names += component.supports
    named = [name for item in (component, *items) for name in _enumerators(item)]
    if named:
        enumerators = {
            (*each.name[:-1], member.name): each.name
            for each in model.declarations
            if isinstance(each, Enum)
            for member in each.members
        }
        names += [enumerators[name] for name in named if name in enumerators]
    return [model.find(name) for name in dict.fromkeys(names)]


def _enumerators(item: Documented) -> Iterator[ScopedName]:
    for annotation in item.annotations:
        for _, value in annotation.arguments:
            if isinstance(value, EnumeratorName):
                yield value.name
