"""Prints the modules of the target small: types, packages, bases of components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.base_module import attribute_names, class_names
from rtgen.compiler.backends.components.locations import heading
from rtgen.compiler.backends.kit.python_text import fit_text
from rtgen.compiler.backends.kit.quoting.python import (
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.small.forms import Forms, members_of
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
    wanted = {name: identifier("_".join(name)) for name in used}
    free = set(wanted.values()) - taken
    chosen: dict[ScopedName, str] = {}
    for name, text in wanted.items():
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
    bodies = []
    for name in used:
        declaration = model.find(name)
        if isinstance(declaration, Enum):
            bodies.append(_enum(names, declaration, classes[name]))
        elif isinstance(declaration, Struct):
            bodies.append(_struct(model, names, declaration, classes[name], forms))
    body = "\n\n".join(bodies)
    helpers = [f"{h} as _{h}" for h in _HELPERS if f"_{h}(" in body]
    imports = f"from rtgen.runtime import {', '.join(helpers)}\n" if helpers else ""
    return fit_text(
        docstring("The types of the components' ports.", 0)
        + (f"\n{imports}" if imports else "")
        + f"\n\n{body}"
    )


def _enum(names: PythonNames, declaration: Enum, class_name: str) -> str:
    python_names = names.enumerators(declaration)
    lines = [f"class {class_name}:", *_doc(declaration.doc, 4, "An enumeration.")]
    lines.append("")
    lines += [f"    {python_names[m.name]} = {m.value}" for m in declaration.members]
    return "\n".join(lines) + "\n"


def _struct(
    model: Model,
    names: PythonNames,
    declaration: Struct,
    class_name: str,
    forms: Forms,
) -> str:
    python_names = _members(model, names, declaration)
    members = [
        (python_names[member.name], forms.form(member.type, member.initial))
        for member in members_of(model, declaration)
    ]
    parameters = ", ".join(
        f"{name}={'None' if form.mutable else form.made}" for name, form in members
    )
    lines = [f"class {class_name}:", *_doc(declaration.doc, 4, "A struct."), ""]
    lines.append(f"    __slots__ = {_slots([name for name, _ in members])}")
    own = "_self" if any(name == "self" for name, _ in members) else "self"
    lines += ["", f"    def __init__({', '.join(filter(None, (own, parameters)))}):"]
    lines += ["        pass"] * (not members)
    for name, form in members:
        lines.append(f"        {own}.{name} = {form.made if form.mutable else name}")
        if form.items:
            lines += [
                f"        if {name} is None:",
                f"            {name} = {form.items}",
            ]
        elif form.mutable:
            lines.append(f"        if {name} is not None:")
        if form.mutable:
            copied = form.copy.replace("{0}", f"{own}.{name}").replace("{1}", name)
            lines.append(f"{' ' * (8 if form.items else 12)}{copied}")
    for header, statements in (
        (
            "def _copy_(self, other):",
            [
                form.copy.replace("{0}", f"self.{n}").replace("{1}", f"other.{n}")
                for n, form in members
            ],
        ),
        (
            "def _put_(self, wire):",
            [s.replace("{0}", f"self.{n}") for n, form in members for s in form.put],
        ),
        (
            "def _take_(self, wire):",
            [s.replace("{0}", f"self.{n}") for n, form in members for s in form.take],
        ),
    ):
        lines += [
            "",
            f"    {header}",
            *(f"        {s}" for s in statements or ["pass"]),
        ]
    return "\n".join(lines) + "\n"


def _members(model: Model, names: PythonNames, declaration: Struct) -> dict[str, str]:
    inherited: dict[str, str] = {}
    if declaration.base is not None:
        base = model.find(declaration.base)
        assert isinstance(base, Struct)
        inherited = _members(model, names, base)
    return inherited | names.members(declaration)


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
        type_text = imports.text(*names.public(type_.name))
        add = "add_in_port" if port.kind is PortKind.INPORT else "add_out_port"
        ports.append(
            f"        self.{name} = self.{add}({string_literal(port.name)}, {type_text})"
        )
    fields = [
        f"        self.{name} = {_default(model, names, parameter)}"
        for parameter, name in attributes.configuration
    ]
    slots = _slots([name for _, name in attributes.configuration])
    lines = [docstring(heading(component), 0).rstrip("\n"), ""]
    lines += ["from rtgen.runtime import Component", *imports.lines()]
    if fields:
        lines += ["", "", f"class {configuration}:"]
        lines += [*_doc(f"The parameters of {component.name[-1]}.", 4), ""]
        lines += [f"    __slots__ = {slots}", "", "    def __init__(self):", *fields]
    lines += ["", "", f"class {base}(Component):"]
    lines += _doc(component.doc, 4, heading(component))
    lines += ["", f"    _type_name = {string_literal(component.name[-1])}"]
    lines += [
        f"    _rate = {number_literal(float(component.rate))}",
        f"    _buffer = {options.small[2]}",
    ]
    lines += ["", "    def __init__(self, instance_name=None):"]
    lines.append("        Component.__init__(self, instance_name)")
    if fields:
        lines.append(f"        self.config = {configuration}()")
    lines += ports
    return fit_text("\n".join(lines) + "\n")


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
            of, member = names.enumerator(name)
            declaration = model.find(of)
            assert isinstance(declaration, Enum)
            python_names = names.enumerators(declaration)
            values = (
                m.value for m in declaration.members if python_names[m.name] == member
            )
            return str(next(values))
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


def _doc(text: str, indent: int, otherwise: str = "") -> list[str]:
    return docstring(text, indent, otherwise).rstrip("\n").split("\n")


def _slots(names: Sequence[str]) -> str:
    literals = [string_literal(name) for name in names]
    return f"({literals[0]},)" if len(literals) == 1 else f"({', '.join(literals)})"
