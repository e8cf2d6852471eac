"""Output of `rtgen inspect` for a model: JSON (`rtgen-inspect/1`) or a text tree."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rtgen.compiler.backends.kit.idl_text.literals import default_text, readable
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.diagnostics.report import as_json
from rtgen.compiler.inspection import indented_json
from rtgen.compiler.inspection.facts import FIELDS, Json, facts, kind_of, plain
from rtgen.compiler.model import (
    Attribute,
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    Component,
    ConfigurationParameter,
    Connection,
    Const,
    ConstantValue,
    Declaration,
    Enum,
    Enumerator,
    EnumeratorName,
    ExceptionDecl,
    Home,
    InitialValue,
    Interface,
    Member,
    Model,
    Native,
    Operation,
    Parameter,
    Port,
    Primitive,
    PrimitiveType,
    StateMember,
    Struct,
    System,
    SystemComponent,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.initial import default_of, discriminator
from rtgen.facts.ros import INTERFACE_SUFFIXES

if TYPE_CHECKING:
    from rtgen.compiler.model.tecs import TecsDeclaration

FORMAT = "rtgen-inspect/1"


def inspect(
    model: Model, diagnostics: Sequence[Diagnostic], of_ros: Json | None = None
) -> Json:
    """Return the model and the diagnostics as one JSON object.

    `of_ros` has what boards are in ROS 2: `ros_services`, `ros_nodes`.
    """
    declarations = [_declaration(d, model) for d in defined(model.declarations)]
    return {
        "format": FORMAT,
        "files": [f.name for f in model.files]
        + [d.file for d in model.devices]
        + [b.file for b in model.buses]
        + [s.file for s in model.systems],
        "declarations": [
            *declarations,
            *_of_other_languages(model),
            *map(_system, model.systems),
        ],
        **(of_ros or {}),
        "diagnostics": [as_json(d) for d in diagnostics],
    }


def _of_other_languages(model: Model) -> Iterator[Json]:
    """Yield the declarations of CDL, EDS and bus files; their modules are imported lazily."""
    if model.tecs:
        from rtgen.compiler.inspection import tecs

        yield from map(tecs.declaration, tecs.shown(model.tecs))
    if model.devices:
        from rtgen.compiler.inspection import devices

        yield from map(devices.declaration, model.devices)
    if model.buses:
        from rtgen.compiler.inspection import buses

        yield from map(buses.declaration, model.buses)


def defined(declarations: Iterable[Declaration]) -> list[Declaration]:
    """Return the declarations without forward declarations."""
    return [
        d
        for d in declarations
        if not (isinstance(d, Interface | Valuetype) and d.forward)
    ]


def json_text(
    model: Model, diagnostics: Sequence[Diagnostic], of_ros: Json | None = None
) -> str:
    """Return the result of `inspect` as indented text."""
    return indented_json.dumps(inspect(model, diagnostics, of_ros)) + "\n"


FIELDS.update(
    {
        Struct: "repository_id base:: members",
        ExceptionDecl: "repository_id base members",
        Union: "repository_id switch initial cases",
        Enum: "repository_id members initial=initial.name",
        Bitset: "repository_id members",
        Bitmask: "repository_id members",
        Typedef: "repository_id type initial",
        ValueBox: "repository_id type",
        Const: "type value",
        Interface: "repository_id bases::* abstract attributes operations local",
        Valuetype: "repository_id bases::* abstract attributes operations local custom"
        " truncatable supports::* state factories",
        Component: "repository_id base:: supports::* ports configuration",
        Home: "repository_id manages::",
        Native: "repository_id",
        Member: "name type optional key id initial",
        StateMember: "name type public optional key id initial",
        Case: "labels name type initial",
        Bitfield: "name bits type initial",
        Enumerator: "name position=value type",
        Attribute: "name type readonly get_raises::* set_raises::*",
        Operation: "name oneway returns parameters raises::* context",
        Parameter: "direction name type",
        Port: "kind name type python_name port",
        ConfigurationParameter: "name type default unit min=minimum max=maximum"
        " constraint python_name",
        System: "kind name file line components connections doc=abstract annotations",
        SystemComponent: "instance type configuration",
        Connection: "from=source to=target properties",
    }
)
"""The fields of IDL's declarations and of systems; `_resolved` returns the others."""


def _declaration(d: Declaration, model: Model) -> Json:
    head = {"kind": kind_of(d), "name": d.scoped, "file": d.file, "line": d.span.line}
    return head | facts(d, **_resolved(d, model))


def _resolved(d: Declaration, model: Model) -> Json:
    """Return the facts that depend on the model, or that a kind has for another one's sake."""
    match d:
        case Struct():
            members = [_initialised(m, model) for m in d.members]
            return {"members": members} | _ros(d, model)
        case ExceptionDecl():
            members = [_initialised(m, model) for m in d.members]
            return {"base": None, "members": members}
        case Valuetype():
            state = [_initialised(m, model) for m in d.state]
            return {"local": False, "state": state}
        case Union():
            switch = model.unalias(d.switch)
            initial = _label(discriminator(model, d), switch)
            cases = [
                _initialised(c, model, labels=labels_of(c, switch)) for c in d.cases
            ]
            return {"initial": initial, "cases": cases}
        case Enum():
            return {"members": [m.name for m in d.members]}
        case Bitmask():
            return {"members": [facts(m, type=None) for m in d.members]}
        case Bitset():
            return {"members": [*map(_bitfield, d.members)]}
        case Typedef():
            return {"initial": plain(default_of(model, d.type, d.initial))}
        case Component():
            return _component(d)
    return {}


def _initialised(entry: Member | Case, model: Model, **known: Any) -> Json:
    """Return a member or branch with its default or that of its typedef."""
    optional = isinstance(entry, Member) and entry.optional
    initial = None if optional else default_of(model, entry.type, entry.initial)
    return facts(entry, initial=plain(initial), **known)


def labels_of(case: Case, switch: Type) -> list[str]:
    """Return the labels of a branch in IDL, with `default`."""
    return [_label(label, switch) for label in case.labels] + ["default"] * case.default


def _bitfield(m: Bitfield) -> Json:
    initial = None if isinstance(m.initial, tuple) else plain(m.initial)
    return facts(m, initial=initial)


def _component(d: Component) -> Json:
    from rtgen.compiler.backends.components.members import attributes_of

    attributes = attributes_of(d)
    return {
        "ports": [
            facts(p, python_name=name, port=p.port or p.name)
            for p, name in attributes.ports
        ],
        "configuration": [
            facts(c, python_name=name) for c, name in attributes.configuration
        ],
    }


def _system(s: System) -> Json:
    components = [
        facts(c, configuration={key: dict(values) for key, values in c.configuration})
        for c in s.components
    ]
    connections = [facts(c, properties=dict(c.properties)) for c in s.connections]
    return facts(
        s,
        kind="system",
        line=1,
        components=components,
        connections=connections,
        annotations=[],
    )


def _ros(d: Struct, model: Model) -> Json:
    """Return the hash of a type that a ROS 2 interface file defines."""
    if not d.file.lower().endswith(INTERFACE_SUFFIXES):
        return {}
    from rtgen.compiler.layouts.ros_types import type_hash

    return {"ros_type_hash": type_hash(model, d)}


def _label(value: ConstantValue, switch: Type) -> str:
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case EnumeratorName():
            return "::".join(value.name)
        case str():
            wide = switch == PrimitiveType(Primitive.WCHAR)
            return _character(value, wide)
    return str(value)


_ESCAPES = {
    "\n": "\\n",
    "\t": "\\t",
    "\v": "\\v",
    "\b": "\\b",
    "\r": "\\r",
    "\f": "\\f",
    "\a": "\\a",
    "\\": "\\\\",
    "'": "\\'",
}


def _character(value: str, wide: bool) -> str:
    """Return a character literal (OMG IDL 4.2, table 7-9)."""
    if value in _ESCAPES:
        text = _ESCAPES[value]
    elif " " <= value <= "~":
        text = value
    else:
        text = f"\\u{ord(value):04x}" if wide else f"\\x{ord(value):02x}"
    return f"'{text}'"


def tree(model: Model, of_ros: Json | None = None) -> str:
    """Return the model as text: one line for each declaration and member, by file.

    `of_ros` is as in `inspect`.
    """
    from rtgen.compiler.inspection import buses, devices, tecs

    lines: list[str] = []
    components: dict[str, list[TecsDeclaration]] = {}
    for component in tecs.shown(model.tecs):
        components.setdefault(component.file, []).append(component)
    for file in model.files:
        lines.append(file.name)
        for d in defined(model.of_file(file.name)):
            lines += _indented(_declaration_lines(d, model))
        for t in components.get(file.name, ()):
            lines += _indented(tecs.lines(t))
    for described in model.devices:
        lines += [described.file, *_indented(devices.lines(described))]
    for bus in model.buses:
        lines += [bus.file, *_indented(buses.lines(bus))]
    for system in model.systems:
        lines += [system.file, f"  system {system.name}"]
        lines += [f"    {c.instance}: {c.type}" for c in system.components]
        lines += [f"    {c.source} -> {c.target}" for c in system.connections]
    for service in (of_ros or {}).get("ros_services", ()):
        lines += [f"service {service['name']}: {service['type']}"]
        lines += [f"  {service['hash']}"]
    for node in (of_ros or {}).get("ros_nodes", ()):
        lines += [f"node {node['node']}"]
        topics, parameters = node["topics"], node["parameters"]
        lines += [f"  {t['direction']} {t['name']}: {t['type']}" for t in topics]
        lines += [f"  parameter {each['name']}" for each in parameters]
    return "".join(f"{line}\n" for line in lines)


def _declaration_lines(d: Declaration, model: Model) -> Iterator[str]:
    head = f"{kind_of(d)} {d.scoped}"
    match d:
        case Const():
            yield f"{head}: {d.type} = {readable(model, d.type, d.value)}"
        case Typedef():
            default = default_of(model, d.type, d.initial)
            shown = (
                ""
                if default is None
                else f" (default {readable(model, d.type, default)})"
            )
            yield f"{head} = {d.type}{shown}"
        case ValueBox():
            yield f"{head} = {d.type}"
        case Union():
            yield f"{head} switch ({d.switch})"
        case Struct(base=base) | Bitset(base=base) if base is not None:
            yield f"{head}: {'::'.join(base)}"
        case Interface(bases=bases) | Valuetype(bases=bases) if bases:
            yield f"{head}: {', '.join('::'.join(b) for b in bases)}"
        case _:
            yield head
    yield from _indented(_member_lines(d, model))


def _member_lines(d: Declaration, model: Model) -> Iterator[str]:
    if isinstance(d, Enum):
        for enumerator in d.members:
            first = enumerator is d.initial is not d.members[0]
            yield f"{enumerator.name}{' (default)' * first}"
    elif isinstance(d, Bitmask):
        yield from (f"{m.name} ({m.value})" for m in d.members)
    elif isinstance(d, Bitset):
        for field in d.members:
            value = "" if field.initial is None else f" = {default_text(field.initial)}"
            yield f"{field.name or '(padding)'}: {field.bits} bits{value}"
    elif isinstance(d, Union):
        switch = model.unalias(d.switch)
        for case in d.cases:
            default = _default(model, case.type, case.initial)
            yield f"{', '.join(labels_of(case, switch))}: {case.type} {case.name}{default}"
    else:
        members: Iterable[Member] = getattr(d, "members", getattr(d, "state", ()))
        for m in members:
            default = "" if m.optional else _default(model, m.type, m.initial)
            yield f"{m.name}: {m.type}{default}"
        for a in getattr(d, "attributes", ()):
            yield f"{'readonly ' * a.readonly}attribute {a.name}: {a.type}"
        for o in (*getattr(d, "factories", ()), *getattr(d, "operations", ())):
            parameters = (f"{p.direction} {p.name}: {p.type}" for p in o.parameters)
            yield f"{'oneway ' * o.oneway}{o.name}({', '.join(parameters)}): {o.returns}"
        for p in getattr(d, "ports", ()):
            yield f"{p.kind} {p.name}: {p.type}"
        for c in getattr(d, "configuration", ()):
            given = c.default is not None
            default = f" = {readable(model, c.type, c.default)}" if given else ""
            unit = f" [{c.unit}]" if c.unit else ""
            yield f"parameter {c.name}: {c.type}{default}{unit}"


def _default(model: Model, type_: Type, own: InitialValue | None) -> str:
    """Return ` = value`, with the value in IDL; nothing without a default."""
    found = default_of(model, type_, own)
    return "" if found is None else f" = {readable(model, type_, found)}"


def _indented(lines: Iterable[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)
