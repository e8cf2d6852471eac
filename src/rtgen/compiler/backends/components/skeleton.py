"""Prints the skeleton, which the user completes: callbacks and servants, created once."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rtgen.compiler.backends import Options, Owner
from rtgen.compiler.backends.components.base_module import class_names
from rtgen.compiler.backends.components.imports import Imports
from rtgen.compiler.backends.components.locations import (
    SKELETON_NAMES,
    base_location,
    heading,
    skeleton_class,
    source_of,
)
from rtgen.compiler.backends.components.members import attributes_of
from rtgen.compiler.backends.kit.member_texts import member_text, operation_text
from rtgen.compiler.backends.kit.python_module import import_blocks, imports_from
from rtgen.compiler.backends.kit.python_text import fit_text, header_comment
from rtgen.compiler.backends.kit.quoting.python import docstring
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model import (
    Attribute,
    Component,
    Interface,
    Model,
    Operation,
    Port,
    PortKind,
    Valuetype,
)
from rtgen.compiler.typemap.components.actions import skeleton_actions
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.names import identifier


class _Attribute(msgspec.Struct, frozen=True):
    name: str
    type: str
    readonly: bool
    docstring: str


class _Operation(msgspec.Struct, frozen=True):
    name: str
    parameters: tuple[str, ...]
    result: str
    docstring: str


class _Servant(msgspec.Struct, frozen=True):
    """The servant class of a provider; `attribute` is the provider's."""

    name: str
    interface: str
    facet: str
    attribute: str
    attributes: tuple[_Attribute, ...]
    operations: tuple[_Operation, ...]


def skeleton_module(
    model: Model, names: PythonNames, component: Component, options: Options
) -> str:
    """The whole module of a component without errors."""
    source = source_of(model, component)
    name = skeleton_class(component)
    base, _ = class_names(component)
    taken = {*SKELETON_NAMES, name, base}
    providers: list[tuple[Port, str, str]] = []
    for port, attribute in attributes_of(component).ports:
        if port.kind is PortKind.PROVIDER:
            class_name = identifier(_servant_name(attribute), taken)
            taken.add(class_name)
            providers.append((port, attribute, class_name))
    hidden = {n for port, *_ in providers for n in _attribute_names(model, port)}
    imports = Imports(model, names, taken, hidden=hidden)
    servants = [_servant(model, imports, *provider) for provider in providers]
    property_ = imports.spell("", "property")
    runtime = imports_from("rtgen.runtime", ["RTC_OK", "ReturnCode_t"])
    own = imports_from(base_location(options.package, component), [base])
    text = render(
        "components/skeleton.py.j2",
        header=header_comment(options.version, [source.key], Owner.USER),
        docstring=docstring(heading(component), 0),
        imports=import_blocks([*imports.imports(), *runtime, *own]),
        servants=servants,
        property=property_,
        name=name,
        base=base,
        class_docstring=docstring(component.doc, 4, heading(component)),
        actions=skeleton_actions(component.activity),
    )
    return fit_text(text)


def _servant_name(attribute: str) -> str:
    """`left_brake` to `LeftBrakeServant`."""
    words = (f"{word[:1].upper()}{word[1:]}" for word in attribute.split("_"))
    return f"{''.join(words)}Servant"


def _interfaces(model: Model, port: Port) -> list[Interface | Valuetype]:
    """Return the interface of a port, after its bases."""
    interface = model.declared(port.type)
    assert isinstance(interface, Interface), "checked before anything is emitted"
    return [*model.bases(interface), interface]


def _attribute_names(model: Model, port: Port) -> Iterator[str]:
    """Yield the names of the methods and properties of a provider's servant."""
    for interface in _interfaces(model, port):
        yield from (identifier(each.name) for each in interface.attributes)
        yield from (identifier(each.name) for each in interface.operations)


def _servant(
    model: Model, imports: Imports, port: Port, attribute: str, name: str
) -> _Servant:
    interfaces = _interfaces(model, port)
    attributes = {a.name: a for each in interfaces for a in each.attributes}
    operations = {o.name: o for each in interfaces for o in each.operations}
    return _Servant(
        name=name,
        interface=imports.type_name(interfaces[-1].name),
        facet=port.name,
        attribute=attribute,
        attributes=tuple(_attribute(imports, each) for each in attributes.values()),
        operations=tuple(_operation(imports, each) for each in operations.values()),
    )


def _attribute(imports: Imports, attribute: Attribute) -> _Attribute:
    return _Attribute(
        name=identifier(attribute.name),
        type=imports.mapping.annotation(attribute.type),
        readonly=attribute.readonly,
        docstring=docstring(member_text(attribute), 8),
    )


def _operation(imports: Imports, operation: Operation) -> _Operation:
    result = imports.mapping.result(operation)
    return _Operation(
        name=identifier(operation.name),
        parameters=imports.mapping.parameters(operation),
        result=result,
        docstring=docstring(operation_text(operation), 8),
    )
