"""Describes definitions in Markdown: type, wire layout, unit, limits, documentation."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends.kit.idl_text.literals import default_text
from rtgen.compiler.backends.kit.member_texts import operation_text
from rtgen.compiler.inspection import tecs as tecs_text
from rtgen.compiler.inspection.facts import kind_of
from rtgen.compiler.layouts import offsets
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.layouts.tdr import TransferError, size_of
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model import (
    Attribute,
    Case,
    ConfigurationParameter,
    Const,
    Declaration,
    Documented,
    Enum,
    Enumerator,
    Interface,
    Limits,
    Member,
    Model,
    Operation,
    Parameter,
    Port,
    ScopedName,
    Struct,
    Type,
    Typedef,
    Union,
    limits,
)
from rtgen.compiler.model.canopen import Device, Object, Variable
from rtgen.compiler.model.initial import default_of
from rtgen.compiler.model.tecs import Signature, TecsDeclaration, TecsUnit
from rtgen.compiler.typemap.member_units import annotated_unit
from rtgen.tools.indexing.cdl import file_and_name
from rtgen.tools.indexing.devices import object_of
from rtgen.tools.indexing.index import path_of
from rtgen.tools.lsp.analysis import Analysis

_MAX_ROWS = 40
_GROUPS = (
    *("members", "cases", "operations", "attributes", "state", "ports"),
    "configuration",
)


def described(analysis: Analysis, key: str) -> str | None:
    """Return the description of a key's definition; None if it is not in the model."""
    language, _, name = key.partition(" ")
    match language:
        case "idl":
            return idl(analysis, tuple(name.split("::")))
        case "cdl":
            return _cdl(analysis.model, key)
        case "eds":
            return _eds(analysis.model, key)
        case "file":
            return f"`{name}`"
    definition = analysis.index.definition(key)
    if definition is None:
        return None
    detail = f": {definition.detail}" if definition.detail else ""
    return _code("idl", f"{definition.kind} {definition.name}{detail}")


# IDL


def representations_of(analysis: Analysis) -> Representations:
    """Return the data representations of the project's types."""
    project = analysis.project
    return Representations(
        analysis.model, project.representation == "xcdr2", project.extensibility
    )


def find(model: Model, name: ScopedName) -> Declaration | None:
    """Return a declaration by its scoped name."""
    try:
        return model.find(name)
    except KeyError:
        return None


def idl(analysis: Analysis, name: ScopedName) -> str | None:
    """Return the description of an IDL declaration, or of a part of one."""
    model = analysis.model
    declaration = find(model, name)
    if declaration is not None:
        return _declaration(analysis, declaration)
    for length in (len(name) - 1, len(name) - 2):
        holder = find(model, name[:length]) if length > 0 else None
        if holder is not None:
            return _part(analysis, holder, name[length:])
    enum = next(
        (
            d
            for d in model.declarations
            if isinstance(d, Enum)
            and d.name[:-1] == name[:-1]
            and any(m.name == name[-1] for m in d.members)
        ),
        None,
    )
    if enum is not None:
        return _part(analysis, enum, name[-1:])
    return _code("idl", f"module {'::'.join(name)}")


def _declaration(analysis: Analysis, d: Declaration) -> str:
    model = analysis.model
    lines, layout = [_head(d)], ""
    match d:
        case Struct():
            layout = _layout(analysis, d)
        case Typedef(type=type_):
            lines.append(f"// {_resolved(model, type_)}")
        case _:
            lines += [f"  {_line(p)}" for _, p in parts_of(d)][:_MAX_ROWS]
    return _joined(_code("idl", *lines), layout, *_value_notes(d), d.doc)


def _head(d: Declaration) -> str:
    name = d.scoped
    match d:
        case Typedef(type=type_):
            return f"typedef {type_} {name}"
        case Const(type=type_, value=value):
            return f"const {type_} {name} = {value}"
        case Union(switch=switch):
            name += f" switch ({switch})"
        case Struct(base=base) if base is not None:
            name += f" : {'::'.join(base)}"
        case Interface(bases=bases) if bases:
            name += f" : {', '.join('::'.join(b) for b in bases)}"
    return f"{kind_of(d)} {name}"


def parts_of(d: Declaration) -> Iterator[tuple[str, Documented]]:
    """Yield the named parts of a declaration."""
    for group in _GROUPS:
        for part in getattr(d, group, ()):
            yield getattr(part, "identifier", part.name), part


def _line(part: Documented, scope: str = "") -> str:
    """Return a part as in IDL; `scope` precedes the name of a member, branch or attribute."""
    match part:
        case Member(name=name, type=type_) | Case(name=name, type=type_):
            return f"{type_} {scope}{name}"
        case Attribute(name=name, type=type_, readonly=readonly):
            return f"{'readonly ' * readonly}attribute {type_} {scope}{name}"
        case Enumerator(name=name, value=value):
            return f"{name} = {value}"
        case Operation():
            parameters = ", ".join(map(_line, part.parameters))
            return f"{'oneway ' * part.oneway}{part.returns} {part.name}({parameters})"
        case Parameter(name=name, type=type_, direction=word):
            return f"{word} {type_} {name}"
        case Port(name=name, type=type_, kind=word):
            return f"{word} {type_} {name}"
        case ConfigurationParameter(name=name, type=type_):
            return f"parameter {type_} {name}"
    return str(getattr(part, "name", ""))


def _part(analysis: Analysis, holder: Declaration, way: ScopedName) -> str | None:
    found = dict(parts_of(holder)).get(way[0])
    if len(way) == 2 and isinstance(found, Operation):
        found = next((p for p in found.parameters if p.name == way[1]), None)
    if found is None:
        return None
    lines = [_line(found, f"{holder.scoped}::")]
    notes: list[str] = []
    match found:
        case Member():
            notes.append(_member_note(analysis, holder, found))
            notes.append(_default_note(analysis.model, found))
        case Case():
            notes.append(_default_note(analysis.model, found))
        case Enumerator():
            lines[0] += f"  // {holder.scoped}"
        case Port(unit=unit):
            notes.append(f"unit: {unit}" if unit else "")
        case ConfigurationParameter():
            notes += _parameter_notes(found)
    if isinstance(found, Member | Case | Attribute | Parameter | Port):
        resolved = _resolved(analysis.model, found.type)
        if resolved != str(found.type):
            lines.append(f"// {resolved}")
        if not isinstance(found, Port):
            notes += _value_notes(found)
    doc = operation_text(found) if isinstance(found, Operation) else found.doc
    return _joined(_code("idl", *lines), *notes, doc)


def _parameter_notes(parameter: ConfigurationParameter) -> list[str]:
    default, constraint = parameter.default, parameter.constraint
    return [
        *([] if default is None else [f"default: {default_text(default)}"]),
        *_limit_notes((parameter.minimum, parameter.maximum)),
        *[f"unit: {parameter.unit}"] * bool(parameter.unit),
        *[f"constraint: {constraint}"] * bool(constraint),
    ]


def _value_notes(entry: Documented) -> list[str]:
    """Return what annotations say of the values of a member or a declaration."""
    unit = annotated_unit(entry)
    return [
        *_limit_notes(limits(entry.annotations)),
        *([] if unit is None else [f"unit: {unit}"]),
    ]


def _limit_notes(within: Limits) -> list[str]:
    words = zip(("least", "most"), within, strict=True)
    return [f"{word}: {default_text(v)}" for word, v in words if v is not None]


def _resolved(model: Model, type_: Type) -> str:
    """Return the type with typedefs resolved."""
    try:
        return str(model.unalias(type_))
    except KeyError:
        return str(type_)


def _member_note(analysis: Analysis, holder: Declaration, member: Member) -> str:
    if not isinstance(holder, Struct):
        return ""
    for place in layout_of_struct(analysis, holder):
        if place.member is member:
            return place_text(place)
    return ""


def _default_note(model: Model, entry: Member | Case) -> str:
    """Return the value with which a member or branch starts, if the definition gives one."""
    found = default_of(model, entry.type, entry.initial)
    return "" if found is None else f"default: {default_text(found)}"


def place_text(place: offsets.MemberPlace) -> str:
    """Return the place of a member: `offset 8, 4 octets`."""
    size = _octets(place.size)
    return size if place.offset is None else f"offset {place.offset}, {size}"


def _octets(count: int | None) -> str:
    if count is None:
        return "variable"
    return f"{count} octet{'s' * (count != 1)}"


def layout_of_struct(
    analysis: Analysis, struct: Struct
) -> tuple[offsets.MemberPlace, ...]:
    """Return the places of a struct's members; none if a type is missing, or nested too deeply."""
    made = _laid_out(analysis, struct)
    return () if made is None else made.members


def _laid_out(analysis: Analysis, struct: Struct) -> offsets.StructLayout | None:
    try:
        return offsets.Layouts(analysis.model, representations_of(analysis)).of(struct)
    except (KeyError, RecursionError):
        return None


def _layout(analysis: Analysis, struct: Struct) -> str:
    made = _laid_out(analysis, struct)
    if made is None or not made.members:
        return ""
    rows = ["| offset | size | member | type |", "|--:|--:|---|---|"]
    for place in made.members[:_MAX_ROWS]:
        offset = "" if place.offset is None else place.offset
        size = "" if place.size is None else place.size
        type_ = str(place.member.type).replace("|", "\\|")
        rows.append(f"| {offset} | {size} | {place.member.name} | `{type_}` |")
    if len(made.members) > _MAX_ROWS:
        rows.append(f"| | | {len(made.members) - _MAX_ROWS} more | |")
    rows += ["", f"{'XCDR2' if made.xcdr2 else 'CDR'}: {_octets(made.size)}"]
    return "\n".join(rows)


# CDL


def _cdl(model: Model, key: str) -> str | None:
    file, name = file_and_name(key)
    for length in (len(name), len(name) - 1, len(name) - 2):
        for unit in model.tecs:
            for d in unit.declarations:
                if d.name == name[:length] and path_of(d.file) == file:
                    return _tecs(unit, d, name[length:])
    return None


def _tecs(unit: TecsUnit, d: TecsDeclaration, way: ScopedName) -> str:
    if isinstance(d, Signature) and way:
        function = next((f for f in d.functions if f.name == way[0]), None)
        if function is not None:
            return _joined(
                _code("cdl", tecs_text.prototype(function)),
                f"function id {function.id}",
                _message(unit, d, function.name),
                function.doc,
            )
    lines = list(tecs_text.lines(d))
    if way:
        lines = [line for line in lines if way[-1] in line] or lines[:1]
    return _joined(_code("cdl", *lines[:_MAX_ROWS]), d.doc)


def _message(unit: TecsUnit, signature: Signature, name: str) -> str:
    """Return the layout of an OpaqueRPC request: its values and their octets."""
    try:
        made = layout_of(unit, signature)
    except TransferError as error:
        return f"OpaqueRPC cannot carry it: {error}"
    function = next(f for f in made.functions if f.function.name == name)
    rows = [
        f"| {item.name} | {item.direction.value} | {_octets(size_of(item.node))} |"
        for item in function.items
        if item.direction is not None
    ]
    if not rows:
        return ""
    return "\n".join(["| argument | direction | TDR |", "|---|---|---|", *rows])


# CANopen


def _eds(model: Model, key: str) -> str | None:
    file, index, subindex = object_of(key)
    devices = [*model.devices, *(k.device for b in model.buses for k in b.kinds)]
    for device in devices:
        if path_of(device.file) == file:
            entry = next((o for o in device.objects if o.index == index), None)
            if entry is not None:
                return _entry(device, entry, subindex)
    return None


def _entry(device: Device, entry: Object, subindex: int | None) -> str:
    if subindex is None and len(entry.variables) > 1:
        rows = [
            f"| {v.subindex} | {v.name} | {_type(v)} | {v.access} |"
            for v in entry.variables[:_MAX_ROWS]
        ]
        head = f"**{entry.index:04X}h {entry.name}** ({entry.type.name})"
        table = ["| sub | name | type | access |", "|--:|---|---|---|", *rows]
        return _joined(head, "\n".join(table), _mappings(device, entry.index, None))
    variable = device.find(entry.index, subindex or 0)
    if variable is None:
        return f"**{entry.index:04X}h {entry.name}**"
    facts = [f"{_type(variable)}, {variable.access}"]
    values = (
        ("default", variable.default),
        ("value", variable.value),
        ("low", variable.low),
        ("high", variable.high),
        ("unit", variable.unit or None),
        ("factor", variable.factor),
    )
    facts += [f"{name}: {value!s}" for name, value in values if value is not None]
    sub = "" if subindex is None else f":{subindex}"
    head = f"**{entry.index:04X}h{sub} {variable.name}**"
    return _joined(
        head,
        "  \n".join(facts),
        variable.description,
        _mappings(device, entry.index, subindex or 0),
    )


def _type(variable: Variable) -> str:
    name, bits = variable.type_name, variable.bits
    return name if bits is None else f"{name}, {bits} bits"


def _mappings(device: Device, index: int, subindex: int | None) -> str:
    """Return the PDOs that map an object, with its bit offset."""
    return "  \n".join(
        f"{pdo.direction.value.upper()} {pdo.number}: bit {first}, {entry.bits} bits"
        for pdo in device.pdos
        for first, entry in pdo.places
        if entry.index == index and subindex in (None, entry.subindex)
    )


def _code(language: str, *lines: str) -> str:
    return "\n".join([f"```{language}", *lines, "```"])


def _joined(*parts: str) -> str:
    return "\n\n".join(part for part in parts if part)
