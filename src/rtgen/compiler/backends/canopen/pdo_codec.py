"""PDO codecs: the expressions of the functions for each PDO and direction, from its layout."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from rtgen.compiler.backends.canopen.literals import items
from rtgen.compiler.backends.kit.quoting.python import Python
from rtgen.compiler.layouts.pdo import Kind, Part, PdoField, PdoLayout, Slot

_TYPES = {
    Kind.BOOLEAN: "bool",
    Kind.SIGNED: "int",
    Kind.UNSIGNED: "int",
    Kind.REAL: "float",
    Kind.CHARACTER: "str",
    Kind.TEXT: "str",
    Kind.OCTETS: "bytes",
}


@dataclass(frozen=True, slots=True)
class PdoCodec:
    """The codec of a PDO: `name` (`tpdo1`) is part of the functions' names."""

    name: str
    title: str
    layout: PdoLayout

    @property
    def has_characters(self) -> bool:
        """Whether a value is a character."""
        return any(field.kind is Kind.CHARACTER for field in self.layout.fields)


class Codecs:
    """Values of the template `canopen/pdo_codecs.py.j2`.

    A built-in name that is also one of a field is `hidden`: functions use it with `_` before it.
    """

    def __init__(
        self, decoded: Sequence[PdoCodec], encoded: Sequence[PdoCodec]
    ) -> None:
        self.all = [
            {"name": codec.name, "format": codec.layout.format}
            for codec in dict.fromkeys((*decoded, *encoded))
        ]
        used = ["OverflowError", "TypeError"] if encoded else []
        used += ["chr"] * any(codec.has_characters for codec in decoded)
        used += ["ord"] * any(codec.has_characters for codec in encoded)
        fields = {f.name for c in (*decoded, *encoded) for f in c.layout.fields}
        self.hidden = [name for name in used if name in fields]
        self.names = {name: "_" * (name in fields) + name for name in used}
        self.decoded = [_decoder(codec, self.names) for codec in decoded]
        self.encoded = [_encoder(codec, self.names) for codec in encoded]


def _decoder(codec: PdoCodec, names: Mapping[str, str]) -> dict[str, object]:
    layout = codec.layout
    raw = [name for n, slot in enumerate(layout.slots) for name in _raw(n, slot)]
    target = f"({raw[0]},) = " if len(raw) == 1 else ""
    values = [
        _value(n, slot, field, names)
        for n, slot in enumerate(layout.slots)
        for field in slot.fields
    ]
    return {
        "name": codec.name,
        "title": Python(codec.title),
        "size": layout.size,
        "types": Python(", ".join(_TYPES[f.kind] for f in layout.fields) or "()"),
        "targets": Python(f"{', '.join(raw)} = " if len(raw) > 1 else target),
        "joined": [
            (f"_s{n}", Python(_joined(n, slot.parts)))
            for n, slot in enumerate(layout.slots)
            if len(slot.parts) > 1
        ],
        "results": items(values),
    }


def _encoder(codec: PdoCodec, names: Mapping[str, str]) -> dict[str, object]:
    layout = codec.layout
    parameters = (f"{f.name}: {_TYPES[f.kind]}" for f in layout.fields)
    return {
        "name": codec.name,
        "title": Python(codec.title),
        "size": layout.size,
        "parameters": Python(", ".join(parameters)),
        "statements": [Python(statement) for statement in _shares(layout, names)],
        "packed": [
            Python(value)
            for n, slot in enumerate(layout.slots)
            for value in _packed(n, slot, names)
        ],
    }


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


def _value(n: int, slot: Slot, field: PdoField, names: Mapping[str, str]) -> str:
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
            return f"{names['chr']}({raw})"
        case Kind.TEXT:
            return f"_pdo.field_text({raw})"
        case Kind.REAL if not slot.whole:
            return f"_pdo.real{field.bits}({raw})"
    return raw


def _shares(layout: PdoLayout, names: Mapping[str, str]) -> Iterator[str]:
    """The statements that assemble shared slots, indented."""
    for n, slot in enumerate(layout.slots):
        if slot.whole:
            [field] = slot.fields or (None,)
            if field is not None and field.kind is Kind.BOOLEAN:
                yield f"_s{n} = {field.name} and 1"
            elif field is not None and len(slot.parts) > 1:
                yield f"_s{n} = {field.name}"
            continue
        first, *others = slot.fields
        yield from _checked(first)
        yield f"_s{n} = {_bits(first, names)}{_shifted(first)}"
        for field in others:
            yield from _checked(field)
            yield f"_s{n} |= {_bits(field, names)}{_shifted(field)}"


def _shifted(field: PdoField) -> str:
    return f" << {field.shift}" if field.shift else ""


def _checked(field: PdoField) -> Iterator[str]:
    if field.kind not in (Kind.SIGNED, Kind.UNSIGNED):
        return
    low, high = 0, (1 << field.bits) - 1
    if field.kind is Kind.SIGNED:
        low, high = -(1 << field.bits - 1), (1 << field.bits - 1) - 1
    name = field.name
    yield f"if not {low} <= {name} <= {high}:"
    yield f'    raise _pdo.outside("{name}", {name}, {low}, {high})'


def _bits(field: PdoField, names: Mapping[str, str]) -> str:
    """A field's bits as an unsigned number."""
    match field.kind:
        case Kind.BOOLEAN:
            bits = f"{field.name} and 1"
            return f"({bits})" if field.shift else bits
        case Kind.SIGNED:
            bits = f"{field.name} & {(1 << field.bits) - 1}"
            return f"({bits})" if field.shift else bits
        case Kind.CHARACTER:
            return f"{names['ord']}({field.name})"
        case Kind.REAL:
            return f"_pdo.real{field.bits}_bits({field.name})"
    return field.name


def _packed(n: int, slot: Slot, names: Mapping[str, str]) -> Iterator[str]:
    """The arguments of `pack` for a slot."""
    if not slot.fields:
        return
    source = f"_s{n}"
    field = slot.fields[0]
    if slot.whole and len(slot.parts) == 1 and field.kind is not Kind.BOOLEAN:
        source = _argument(field, names)
    shift, last = 0, len(slot.parts) - 1
    for index, part in enumerate(slot.parts):
        shifted = f"{source} >> {shift}" if shift else source
        yield shifted if index == last else f"{shifted} & {(1 << part.bits) - 1}"
        shift += part.bits


def _argument(field: PdoField, names: Mapping[str, str]) -> str:
    size = field.bits // 8
    match field.kind:
        case Kind.CHARACTER:
            return f"{names['ord']}({field.name})"
        case Kind.TEXT:
            return f'_pdo.text("{field.name}", {field.name}, {size})'
        case Kind.OCTETS:
            return f'_pdo.octets("{field.name}", {field.name}, {size})'
    return field.name
