"""PDO codecs: a function for each PDO and direction, from its layout.

Fields keep their names as parameters. All other names of a function start with an underscore,
which no field does, so a field called `error` or `Struct` hides nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rtgen.backends.kit.python_text import fit
from rtgen.backends.kit.quoting.python import docstring
from rtgen.layouts.pdo import Kind, Part, PdoField, PdoLayout, Slot

_TYPES = {
    Kind.BOOLEAN: "bool",
    Kind.SIGNED: "int",
    Kind.UNSIGNED: "int",
    Kind.REAL: "float",
    Kind.CHARACTER: "str",
    Kind.TEXT: "str",
    Kind.OCTETS: "bytes",
}
_BUILT_IN = ("OverflowError", "TypeError", "chr", "ord")
_ERRORS = "(_error, _OverflowError, _TypeError)"


@dataclass(frozen=True, slots=True)
class PdoCodec:
    """The codec of a PDO: `name` (`tpdo1`) is part of the functions' names."""

    name: str
    title: str
    layout: PdoLayout


IMPORTS = (
    ("struct", "Struct", "_Struct"),
    ("struct", "error", "_error"),
    ("rtgen.runtime.canopen", "pdo", "_pdo"),
)
"""The names used by codecs: the module, the name there, and the name in the text."""


def codecs_text(decoded: Sequence[PdoCodec], encoded: Sequence[PdoCodec]) -> str:
    """Functions for received and sent PDOs, after the imports of a module."""
    parts: list[str] = []
    for codec in decoded:
        parts += ["", "", *_decode(codec)]
    for codec in encoded:
        parts += ["", "", *_encode(codec)]
    body = "\n".join(parts)
    fields = {field.name for c in (*decoded, *encoded) for field in c.layout.fields}
    hidden = [name for name in _BUILT_IN if name in fields]
    for name in {*_BUILT_IN}.difference(hidden):
        body = re.sub(rf"\b_{name}\b", name, body)
    aliases = [f"_{name} = {name}" for name in hidden if f"_{name}" in body]
    structs = [
        fit(f'_{codec.name.upper()} = _Struct("{codec.layout.format}")')
        for codec in dict.fromkeys((*decoded, *encoded))
    ]
    return "\n".join([*aliases, *([""] if aliases else []), *structs, body])


def _decode(codec: PdoCodec) -> Iterator[str]:
    fields = codec.layout.fields
    types = ", ".join(_TYPES[f.kind] for f in fields) or "()"
    yield fit(f"def decode_{codec.name}(_data: bytes) -> tuple[{types}]:")
    size = codec.layout.size
    yield docstring(
        f"The fields of {codec.title}.\n\n"
        f"The data have {size} octets; further ones are ignored.\n"
        "Raises PdoError if there are less.",
        4,
    ).rstrip("\n")
    names = [
        name for n, slot in enumerate(codec.layout.slots) for name in _raw(n, slot)
    ]
    target = f"({names[0]},) = " if len(names) == 1 else ""
    target = f"{', '.join(names)} = " if len(names) > 1 else target
    yield "    try:"
    yield fit(f"{target}_{codec.name.upper()}.unpack_from(_data)", 8)
    yield "    except _error:"
    message = f'f"{codec.title} has {{len(_data)}} octets, not {size}"'
    yield fit(f"raise _pdo.PdoError({message}) from None", 8)
    values = []
    for n, slot in enumerate(codec.layout.slots):
        if len(slot.parts) > 1:
            yield fit(f"_s{n} = {_joined(n, slot.parts)}", 4)
        values += [_value(n, slot, field) for field in slot.fields]
    if len(values) > 1:
        yield fit(f"return ({', '.join(values)})", 4)
    else:
        yield fit(f"return ({''.join(f'{v},' for v in values)})", 4)


def _raw(n: int, slot: Slot) -> list[str]:
    """The names of the parts of a slot, without gaps."""
    if not slot.fields:
        return []
    if len(slot.parts) == 1:
        return [f"_s{n}"]
    return [f"_s{n}_{part}" for part in range(len(slot.parts))]


def _joined(n: int, parts: Sequence[Part]) -> str:
    terms, shift = [], 0
    for index, part in enumerate(parts):
        terms.append(f"_s{n}_{index}" + (f" << {shift}" if shift else ""))
        shift += part.bits
    return " | ".join(terms)


def _value(n: int, slot: Slot, field: PdoField) -> str:
    raw = f"_s{n}"
    if not slot.whole:
        raw = f"{raw} >> {field.shift}" if field.shift else raw
        mask = (1 << field.bits) - 1
        if field.kind is Kind.SIGNED:
            sign = 1 << field.bits - 1
            return f"({raw} & {mask} ^ {sign}) - {sign}"
        raw = f"{raw} & {mask}"
    match field.kind:
        case Kind.BOOLEAN:
            return f"{raw} != 0" if slot.whole else f"({raw}) != 0"
        case Kind.CHARACTER:
            return f"_chr({raw})"
        case Kind.TEXT:
            return f"_pdo.field_text({raw})"
        case Kind.REAL if not slot.whole:
            return f"_pdo.real{field.bits}({raw})"
    return raw


def _encode(codec: PdoCodec) -> Iterator[str]:
    fields = codec.layout.fields
    parameters = ", ".join(f"{f.name}: {_TYPES[f.kind]}" for f in fields)
    yield fit(f"def encode_{codec.name}({parameters}) -> bytes:")
    yield docstring(
        f"The data of {codec.title}: {codec.layout.size} octets.\n\n"
        "Raises PdoError for a value that does not fit.",
        4,
    ).rstrip("\n")
    values = [
        value for n, slot in enumerate(codec.layout.slots) for value in _packed(n, slot)
    ]
    yield "    try:"
    for indent, statement in _shares(codec.layout):
        yield fit(statement, 8 + indent)
    yield fit(f"return _{codec.name.upper()}.pack({', '.join(values)})", 8)
    yield f"    except {_ERRORS} as _reason:"
    message = f'f"{codec.title}: {{_reason}}"'
    yield fit(f"raise _pdo.PdoError({message}) from None", 8)


def _shares(layout: PdoLayout) -> Iterator[tuple[int, str]]:
    """The statements that assemble shared slots, with their indentation."""
    for n, slot in enumerate(layout.slots):
        if slot.whole:
            [field] = slot.fields or (None,)
            if field is not None and field.kind is Kind.BOOLEAN:
                yield 0, f"_s{n} = {field.name} and 1"
            elif field is not None and len(slot.parts) > 1:
                yield 0, f"_s{n} = {field.name}"
            continue
        first, *others = slot.fields
        yield from _checked(first)
        yield 0, f"_s{n} = {_bits(first)}{_shifted(first)}"
        for field in others:
            yield from _checked(field)
            yield 0, f"_s{n} |= {_bits(field)}{_shifted(field)}"


def _shifted(field: PdoField) -> str:
    return f" << {field.shift}" if field.shift else ""


def _checked(field: PdoField) -> Iterator[tuple[int, str]]:
    if field.kind not in (Kind.SIGNED, Kind.UNSIGNED):
        return
    low, high = 0, (1 << field.bits) - 1
    if field.kind is Kind.SIGNED:
        low, high = -(1 << field.bits - 1), (1 << field.bits - 1) - 1
    name = field.name
    yield 0, f"if not {low} <= {name} <= {high}:"
    yield 4, f'raise _pdo.outside("{name}", {name}, {low}, {high})'


def _bits(field: PdoField) -> str:
    """A field's bits as an unsigned number."""
    match field.kind:
        case Kind.BOOLEAN:
            bits = f"{field.name} and 1"
            return f"({bits})" if field.shift else bits
        case Kind.SIGNED:
            bits = f"{field.name} & {(1 << field.bits) - 1}"
            return f"({bits})" if field.shift else bits
        case Kind.CHARACTER:
            return f"_ord({field.name})"
        case Kind.REAL:
            return f"_pdo.real{field.bits}_bits({field.name})"
    return field.name


def _packed(n: int, slot: Slot) -> Iterator[str]:
    """The arguments of `pack` for a slot."""
    if not slot.fields:
        return
    source = f"_s{n}"
    field = slot.fields[0]
    if slot.whole and len(slot.parts) == 1 and field.kind is not Kind.BOOLEAN:
        source = _argument(field)
    shift, last = 0, len(slot.parts) - 1
    for index, part in enumerate(slot.parts):
        shifted = f"{source} >> {shift}" if shift else source
        yield shifted if index == last else f"{shifted} & {(1 << part.bits) - 1}"
        shift += part.bits


def _argument(field: PdoField) -> str:
    size = field.bits // 8
    match field.kind:
        case Kind.CHARACTER:
            return f"_ord({field.name})"
        case Kind.TEXT:
            return f'_pdo.text("{field.name}", {field.name}, {size})'
        case Kind.OCTETS:
            return f'_pdo.octets("{field.name}", {field.name}, {size})'
    return field.name
