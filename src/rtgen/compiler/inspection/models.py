"""Output of `rtgen inspect` for a model: JSON (`rtgen-inspect/1`) or a text tree."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any, TypeAlias

from rtgen.compiler.backends.kit.idl_text.literals import default_text, readable
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.diagnostics.report import as_json
from rtgen.compiler.inspection import indented_json
from rtgen.compiler.model import (
    Attribute,
    Bitmask,
    Bitset,
    Case,
    Component,
    Const,
    ConstantValue,
    Declaration,
    Documented,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Home,
    InitialValue,
    Interface,
    Member,
    Model,
    Native,
    Operation,
    Primitive,
    PrimitiveType,
    ScopedName,
    StateMember,
    Struct,
    System,
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

Json: TypeAlias = dict[str, Any]


def inspect(model: Model, diagnostics: Sequence[Diagnostic]) -> Json:
    """Return the model and the diagnostics as one JSON object."""
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


def json_text(model: Model, diagnostics: Sequence[Diagnostic]) -> str:
    """Return the result of `inspect` as indented text."""
    return indented_json.dumps(inspect(model, diagnostics)) + "\n"


def _declaration(d: Declaration, model: Model) -> Json:
    head = {"kind": _kind(d), "name": d.scoped, "file": d.file, "line": d.span.line}
    return head | _body(d, model) | _documented(d)


def _kind(d: Declaration) -> str:
    match d:
        case ExceptionDecl():
            return "exception"
        case Valuetype(eventtype=True):
            return "eventtype"
    return type(d).__name__.lower()


def _body(d: Declaration, model: Model) -> Json:
    identity = {"repository_id": d.repository_id}
    match d:
        case Struct():
            members = [_member(m, model) for m in d.members]
            body = {"base": _scoped(d.base), "members": members}
            return identity | body | _ros(d, model)
        case ExceptionDecl():
            members = [_member(m, model) for m in d.members]
            return identity | {"base": None, "members": members}
        case Union():
            switch = model.unalias(d.switch)
            return identity | {
                "switch": str(d.switch),
                "initial": _label(discriminator(model, d), switch),
                "cases": [_case(c, switch, model) for c in d.cases],
            }
        case Enum():
            names = [m.name for m in d.members]
            return identity | {"members": names, "initial": d.initial.name}
        case Bitset():
            return identity | {"members": [*_bitfields(d)]}
        case Bitmask():
            bits = [
                {"name": m.name, "position": m.value, "type": None} for m in d.members
            ]
            documents = map(_documented, d.members)
            return identity | {
                "members": [b | text for b, text in zip(bits, documents, strict=True)]
            }
        case Typedef():
            initial = _initial(model, d.type, d.initial)
            return identity | {"type": str(d.type), "initial": initial}
        case ValueBox():
            return identity | {"type": str(d.type)}
        case Const():
            return {"type": str(d.type), "value": _value(d.value)}
        case Valuetype():
            return identity | _valuetype(d, model)
        case Interface():
            return identity | _interface(d) | {"local": d.local}
        case Component():
            return identity | _component(d)
        case Home():
            return identity | {"manages": _scoped(d.manages)}
        case Native():
            return identity
    raise AssertionError(f"no JSON for {type(d).__name__}")


def _member(m: Member, model: Model) -> Json:
    body: Json = {"name": m.name, "type": str(m.type)}
    if isinstance(m, StateMember):
        body |= {"public": m.public}
    body |= {"optional": m.optional, "key": m.key, "id": m.id}
    initial = None if m.optional else _initial(model, m.type, m.initial)
    return body | {"initial": initial} | _documented(m)


def _case(c: Case, switch: Type, model: Model) -> Json:
    labels = [_label(label, switch) for label in c.labels] + ["default"] * c.default
    body = {"labels": labels, "name": c.name, "type": str(c.type)}
    initial = _initial(model, c.type, c.initial)
    return body | {"initial": initial} | _documented(c)


def _initial(model: Model, type_: Type, own: InitialValue | None) -> Any:
    """Return the default of a member or of its typedef; null for the implicit value."""
    found = default_of(model, type_, own)
    if isinstance(found, tuple):
        return [*map(_value, found)]
    return _optional(found)


def _bitfields(d: Bitset) -> Iterator[Json]:
    for m in d.members:
        type_ = None if m.type is None else str(m.type)
        initial = m.initial if not isinstance(m.initial, tuple) else None
        body = {"name": m.name, "bits": m.bits, "type": type_}
        yield body | {"initial": _optional(initial)} | _documented(m)


def _interface(d: Interface | Valuetype) -> Json:
    return {
        "bases": [*map(_scoped, d.bases)],
        "abstract": d.abstract,
        "attributes": [*map(_attribute, d.attributes)],
        "operations": [*map(_operation, d.operations)],
    }


def _valuetype(d: Valuetype, model: Model) -> Json:
    return _interface(d) | {
        "local": False,
        "custom": d.custom,
        "truncatable": d.truncatable,
        "supports": [*map(_scoped, d.supports)],
        "state": [_member(m, model) for m in d.state],
        "factories": [*map(_operation, d.factories)],
    }


def _attribute(a: Attribute) -> Json:
    return {
        "name": a.name,
        "type": str(a.type),
        "readonly": a.readonly,
        "get_raises": [*map(_scoped, a.get_raises)],
        "set_raises": [*map(_scoped, a.set_raises)],
    } | _documented(a)


def _operation(o: Operation) -> Json:
    return {
        "name": o.name,
        "oneway": o.oneway,
        "returns": str(o.returns),
        "parameters": [
            {"direction": p.direction.value, "name": p.name, "type": str(p.type)}
            | _documented(p)
            for p in o.parameters
        ],
        "raises": [*map(_scoped, o.raises)],
        "context": list(o.context),
    } | _documented(o)


def _component(d: Component) -> Json:
    from rtgen.compiler.backends.components.members import attributes_of

    attributes = attributes_of(d)
    return {
        "base": _scoped(d.base),
        "supports": [*map(_scoped, d.supports)],
        "ports": [
            {
                "kind": p.kind.value,
                "name": p.name,
                "type": str(p.type),
                "python_name": python_name,
                "port": p.port or p.name,
            }
            | _documented(p)
            for p, python_name in attributes.ports
        ],
        "configuration": [
            {
                "name": c.name,
                "type": str(c.type),
                "default": _optional(c.default),
                "unit": c.unit,
                "min": _optional(c.minimum),
                "max": _optional(c.maximum),
                "constraint": c.constraint,
                "python_name": python_name,
            }
            | _documented(c)
            for c, python_name in attributes.configuration
        ],
    }


def _system(s: System) -> Json:
    return {
        "kind": "system",
        "name": s.name,
        "file": s.file,
        "line": 1,
        "components": [
            {
                "instance": c.instance,
                "type": c.type,
                "configuration": {
                    set_id: dict(values) for set_id, values in c.configuration
                },
            }
            for c in s.components
        ],
        "connections": [
            {
                "from": str(c.source),
                "to": str(c.target),
                "properties": dict(c.properties),
            }
            for c in s.connections
        ],
        "doc": s.abstract,
        "annotations": [],
    }


def _ros(d: Struct, model: Model) -> Json:
    """Return the hash of a type that a ROS 2 interface file defines."""
    if not d.file.lower().endswith(INTERFACE_SUFFIXES):
        return {}
    from rtgen.compiler.layouts.ros_types import type_hash

    return {"ros_type_hash": type_hash(model, d)}


def _documented(d: Documented) -> Json:
    annotations = [
        {
            "name": a.name,
            "arguments": {key: _value(value) for key, value in a.arguments},
        }
        for a in d.annotations
    ]
    return {"doc": d.doc, "annotations": annotations}


def _scoped(name: ScopedName | None) -> str | None:
    return None if name is None else "::".join(name)


def _optional(value: ConstantValue | None) -> Any:
    return None if value is None else _value(value)


def _value(value: ConstantValue) -> Any:
    match value:
        case EnumeratorName():
            return _scoped(value.name)
        case Decimal():
            return format(value, "f")
        case float() if not math.isfinite(value):
            return str(value)
    return value


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


def tree(model: Model) -> str:
    """Return the model as text: one line for each declaration and member, by file."""
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
    return "".join(f"{line}\n" for line in lines)


def _declaration_lines(d: Declaration, model: Model) -> Iterator[str]:
    body = _declaration(d, model)
    head = f"{body['kind']} {d.scoped}"
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
            yield f"{head}: {_scoped(base)}"
        case Interface(bases=bases) | Valuetype(bases=bases) if bases:
            yield f"{head}: {', '.join('::'.join(b) for b in bases)}"
        case _:
            yield head
    yield from _indented(_member_lines(d, body, model))


def _member_lines(d: Declaration, body: Json, model: Model) -> Iterator[str]:
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
        for case, c in zip(d.cases, body["cases"], strict=True):
            default = _default(model, case.type, case.initial)
            yield f"{', '.join(c['labels'])}: {case.type} {case.name}{default}"
    else:
        members: Iterable[Member] = getattr(d, "members", getattr(d, "state", ()))
        for m in members:
            default = "" if m.optional else _default(model, m.type, m.initial)
            yield f"{m.name}: {m.type}{default}"
        for a in body.get("attributes", ()):
            yield f"{'readonly ' * a['readonly']}attribute {a['name']}: {a['type']}"
        for o in (*body.get("factories", ()), *body.get("operations", ())):
            parameters = (
                f"{p['direction']} {p['name']}: {p['type']}" for p in o["parameters"]
            )
            yield f"{'oneway ' * o['oneway']}{o['name']}({', '.join(parameters)}): {o['returns']}"
        for p in body.get("ports", ()):
            yield f"{p['kind']} {p['name']}: {p['type']}"
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
