"""Prints the modules of the target small: types, packages, bases of components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.base_module import attribute_names, class_names
from rtgen.compiler.backends.components.locations import heading
from rtgen.compiler.backends.kit.python_text import fit_text, tuple_of
from rtgen.compiler.backends.kit.quoting.python import (
    Python,
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.small.forms import Forms
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Const,
    Enum,
    EnumeratorName,
    Model,
    NamedType,
    PortKind,
    Primitive,
    PrimitiveType,
    ScopedName,
    StringType,
    Struct,
)
from rtgen.compiler.typemap.python.idl_names import PythonNames, package_path
from rtgen.compiler.typemap.python.names import identifier
from rtgen.facts.activities import EVENT_DRIVEN

_HELPERS = (*("Numbers", "Values", "bounded", "copy_array", "copy_items", "exactly"),)
"""Names imported with a leading `_`, which names of definitions never have."""
_USED = frozenset({"bytes", "chr", "len", "ord", "range"})
"""Python names used by the methods, which classes cannot have."""
_FLOATING = (PrimitiveType(Primitive.FLOAT), PrimitiveType(Primitive.DOUBLE))


def type_names(
    model: Model, names: PythonNames, used: Sequence[ScopedName]
) -> dict[ScopedName, str]:
    """Return the classes of all types: unique, and not hidden by parameters."""
    taken = set(_USED)
    for name in used:
        declaration = model.find(name)
        if isinstance(declaration, Struct):
            taken.update(_members(model, names, declaration).values())
    identifiers = {name: identifier("_".join(name)) for name in used}
    free = set(identifiers.values()) - taken
    chosen: dict[ScopedName, str] = {}
    for name, text in identifiers.items():
        candidate = text
        while candidate in taken or (candidate != text and candidate in free):
            candidate += "_"
        taken.add(candidate)
        chosen[name] = candidate
    return chosen


def types_module(
    model: Model,
    names: PythonNames,
    used: Iterable[ScopedName],
    classes: Mapping[ScopedName, str],
    forms: Forms,
) -> str:
    """Return the module of all structs and enums of the components, in order of declaration."""
    types = []
    for name in used:
        declaration = model.find(name)
        if isinstance(declaration, Enum):
            types.append(_enum(names, declaration, classes[name]))
        elif isinstance(declaration, Struct):
            types.append(_struct(model, names, declaration, classes[name], forms))
    text = str(types)
    helpers = [Python(f"{h} as _{h}") for h in _HELPERS if f"_{h}(" in text]
    return fit_text(render("small/types.py.j2", types=types, helpers=helpers))


def _enum(names: PythonNames, declaration: Enum, class_name: str) -> dict[str, Any]:
    python_names = names.enumerators(declaration)
    return {
        "name": class_name,
        "docstring": docstring(declaration.doc, 4, "An enumeration."),
        "enumerators": [(python_names[m.name], m.value) for m in declaration.members],
    }


def _struct(
    model: Model,
    names: PythonNames,
    declaration: Struct,
    class_name: str,
    forms: Forms,
) -> dict[str, Any]:
    python_names = _members(model, names, declaration)
    members = [
        (python_names[member.name], forms.form(member.type, member.initial))
        for member in model.members(declaration)
    ]
    own = "_self" if any(name == "self" for name, _ in members) else "self"
    return {
        "name": class_name,
        "docstring": docstring(declaration.doc, 4, "A struct."),
        "enumerators": (),
        "slots": _slots([name for name, _ in members]),
        "own": own,
        "parameters": [
            Python(own),
            *(
                Python(f"{name}={'None' if form.mutable else form.made}")
                for name, form in members
            ),
        ],
        "members": [
            {
                "name": name,
                "initial": form.made if form.mutable else name,
                "storage": form.items,
                "copying": (
                    _fill(form.copy, f"{own}.{name}", name) if form.mutable else ""
                ),
            }
            for name, form in members
        ],
        "copying": [_fill(f.copy, f"self.{n}", f"other.{n}") for n, f in members],
        "put": [_fill(s, f"self.{n}") for n, form in members for s in form.put],
        "take": [_fill(s, f"self.{n}") for n, form in members for s in form.take],
    }


def _fill(statement: str, target: str, source: str = "{1}") -> str:
    """Return a statement of a form with its two places filled in."""
    return statement.replace("{0}", target).replace("{1}", source)


def _members(model: Model, names: PythonNames, declaration: Struct) -> dict[str, str]:
    named = (names.members(each).items() for each in model.lineage(declaration))
    return dict(chain.from_iterable(named))


def package(
    names: PythonNames,
    scope: ScopedName,
    classes: Mapping[ScopedName, str],
    constants: Sequence[Const],
) -> str:
    """Return the types and constants of an IDL module."""
    title = (
        f"The IDL module `{'::'.join(scope)}`." if scope else "The global scope of IDL."
    )
    text: str = docstring(title, 0)
    dots = "." * (len(package_path(scope)) + 1)
    if classes:
        items = ", ".join(
            f"{local} as {names.attribute(name)}" for name, local in classes.items()
        )
        text += f"\nfrom {dots}_types import {items}\n"
    lines = []
    for constant in constants:
        value = constant.value
        if isinstance(value, bool | int | float | str):
            lines.append(f"{names.attribute(constant.name)} = {value!r}")
    text += "".join(f"\n{line}" for line in lines) + ("\n" if lines else "")
    return fit_text(text)


def component_module(
    model: Model,
    names: PythonNames,
    component: Component,
    options: Options,
) -> str:
    """Return the configuration class and the base class of a component."""
    base, configuration = class_names(component)
    attributes = attribute_names(model, names, component)
    imports = _PackageImports(
        {"Component", "self", "instance_name", base, configuration}
    )
    ports = []
    for port, name in attributes.ports:
        type_ = model.unalias(port.type)
        assert isinstance(type_, NamedType), "checked before"
        received = port.kind is PortKind.INPORT
        ports.append(
            {
                "attribute": name,
                "add": "add_in_port" if received else "add_out_port",
                "name": port.name,
                "type": imports.text(*names.public(type_.name)),
            }
        )
    is_event_driven = component.activity == EVENT_DRIVEN
    text = render(
        "small/component.py.j2",
        docstring=docstring(heading(component), 0),
        class_docstring=docstring(component.doc, 4, heading(component)),
        component=component.name[-1],
        base=base,
        configuration=configuration,
        imports=imports.lines(),
        fields=[
            (name, _default(model, names, parameter))
            for parameter, name in attributes.configuration
        ],
        slots=_slots([name for _, name in attributes.configuration]),
        rate=number_literal(float(component.rate)),
        buffer=options.small[2],
        triggers=_slots(component.trigger_ports) if is_event_driven else None,
        ports=ports,
    )
    return fit_text(text)


class _PackageImports:
    """Imports of the types of ports, under names that hide no others."""

    def __init__(self, taken: set[str]) -> None:
        self._taken = taken
        self._names: dict[tuple[tuple[str, ...], str], str] = {}

    def text(self, path: tuple[str, ...], attribute: str) -> str:
        """Return the type as an expression."""
        if not path:
            return self._local((), attribute)
        return f"{self._local(path[:-1], path[-1])}.{attribute}"

    def lines(self) -> list[str]:
        """Return the statements."""
        return sorted(
            f"from ..{'.'.join(folder)} import {name}"
            + (f" as {local}" if local != name else "")
            for (folder, name), local in self._names.items()
        )

    def _local(self, folder: tuple[str, ...], name: str) -> str:
        if (folder, name) not in self._names:
            local = name
            while local in self._taken:
                local = f"_{local}"
            self._taken.add(local)
            self._names[folder, name] = local
        return self._names[folder, name]


def _default(
    model: Model, names: PythonNames, parameter: ConfigurationParameter
) -> str:
    type_ = model.unalias(parameter.type)
    match parameter.default:
        case EnumeratorName(name):
            return str(model.enumerator(name).value)
        case None:
            if type_ == PrimitiveType(Primitive.BOOLEAN):
                return "False"
            if isinstance(type_, StringType):
                return '""'
            if isinstance(type_, NamedType):
                enum = model.find(type_.name)
                assert isinstance(enum, Enum), "checked before"
                return str(enum.initial.value)
            return "0.0" if type_ in _FLOATING else "0"
        case str() as text:
            return string_literal(text)
        case int() | float() as number if type_ in _FLOATING:
            return number_literal(float(number))
        case value:
            return repr(value)


def _slots(names: Sequence[str]) -> str:
    return tuple_of([*map(string_literal, names)]).flat
