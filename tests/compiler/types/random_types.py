"""Random definitions with every construct of CORBA's own data types, in one module.

A seed gives the same text on every machine. Values are drawn from the generated descriptors,
extreme values often; values of valuetypes are shared, and refer to each other in cycles.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    NULL,
    AliasDescriptor,
    ArrayDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    class_of,
    plain,
)
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.values import AnyValue

BITS = {"short": 16, "long": 32, "long long": 64, "octet": 8}
BITS |= {f"unsigned {name}": bits for name, bits in BITS.items() if bits > 8}
_BASIC = (*BITS, "float", "double", "boolean", "char", "string", "wstring")
_SWITCHES = (*(name for name in BITS if name != "octet"), "char", "boolean")
_NAMED_SWITCHES = {
    "Wide": "wchar",
    "Narrow": "char",
    "Truth": "boolean",
    "Number": "short",
}
_LONG = (64, 255)
_DYNAMIC = ("any", "CORBA::TypeCode", "Object", "ValueBase", "::{module}::Thing")
_EDGES = (
    0.0,
    -0.0,
    1.5,
    1e-45,
    -3.4028234663852886e38,
    2.0**-1074,
    1.7976931348623157e308,
)
_TEXT = "abcxyz09 .é\xff\x7f\n漢ж"
_DEEPEST = 3


class Definitions:
    """Draws the text of a module."""

    def __init__(self, draw: random.Random, module: str) -> None:
        self._random = draw
        self._module = module
        self._names: list[str] = []
        self._enums: dict[str, list[str]] = {}
        self._values: list[str] = []
        self._count = 0

    def text(self, size: int) -> str:
        """Return a module with about `size` types."""
        makers: list[tuple[int, Callable[[], str]]] = [
            (6, self._struct),
            (4, self._union),
            (2, self._enum),
            (3, self._typedef),
            (1, self._exception),
            (1, self._tree),
            (1, self._branching),
            (2, self._valuetype),
            (1, self._box),
        ]
        lines = ["interface Thing {};", "abstract interface Maybe {};"]
        lines += [f"typedef {kind} {name};" for name, kind in _NAMED_SWITCHES.items()]
        lines += [self._enum(), self._struct(), self._valuetype(), self._box()]
        while self._count < size:
            chosen = self._random.choices(
                [make for _, make in makers], [weight for weight, _ in makers]
            )
            lines.append(chosen[0]())
        body = "\n  ".join(lines)
        return f"module {self._module} {{\n  {body}\n}};\n"

    def _name(self, letter: str) -> str:
        self._count += 1
        return f"{letter}{self._count}"

    def _known(self, name: str) -> str:
        return f"::{self._module}::{name}"

    def _basic(self) -> str:
        draw = self._random
        kind = draw.choice((*_BASIC, "bounded", "wide", "fixed", "wchar"))
        if kind == "bounded":
            return f"string<{draw.randint(1, 9)}>"
        if kind == "wide":
            return f"wstring<{draw.randint(1, 9)}>"
        if kind == "fixed":
            digits = draw.randint(1, 31)
            return f"fixed<{digits},{draw.randint(0, digits)}>"
        return kind if kind != "wchar" or draw.random() < 0.3 else "long"

    def _type(self) -> str:
        draw = self._random
        chance = draw.random()
        if chance < 0.45 or not self._names:
            return self._basic()
        if chance < 0.7:
            return self._known(draw.choice(self._names))
        if chance < 0.8:
            return draw.choice(_DYNAMIC).format(module=self._module)
        if chance < 0.85:
            return draw.choice(("any", self._known("Maybe")))
        inner = self._type()
        if chance < 0.93:
            return f"sequence<{inner} >"
        return f"sequence<{inner}, {draw.randint(1, 5)}>"

    def _declared(self, name: str, type_: str) -> str:
        """Return a declarator, sometimes of an array."""
        draw = self._random
        lengths = [
            draw.randint(1, 3) for _ in range(draw.choice((0, 0, 0, 0, 1, 1, 2, 3)))
        ]
        return f"{type_} {name}" + "".join(f"[{length}]" for length in lengths)

    def _members(self, least: int = 1) -> str:
        count = self._random.randint(least, 6)
        members = [self._declared(f"m{i}", self._type()) for i in range(count)]
        return "".join(f"{member}; " for member in members)

    def _struct(self) -> str:
        name = self._name("S")
        text = f"struct {name} {{ {self._members()}}};"
        self._names.append(name)
        return text

    def _exception(self) -> str:
        return f"exception {self._name('X')} {{ {self._members(0)}}};"

    def _enum(self) -> str:
        name = self._name("E")
        items = [f"e{self._count}_{i}" for i in range(self._random.randint(1, 5))]
        self._names.append(name)
        self._enums[name] = items
        return f"enum {name} {{ {', '.join(items)} }};"

    def _typedef(self) -> str:
        name = self._name("T")
        text = f"typedef {self._declared(name, self._type())};"
        self._names.append(name)
        return text

    def _tree(self) -> str:
        name = self._name("N")
        list_ = f"{name}List"
        text = f"struct {name}; typedef sequence<{name}> {list_};"
        text += (
            f" struct {name} {{ {self._members()}::{self._module}::{list_} kids; }};"
        )
        self._names += [name, list_]
        return text

    def _branching(self) -> str:
        name = self._name("B")
        list_ = f"{name}List"
        text = f"union {name}; typedef sequence<{name}> {list_}; union {name} switch (long) {{"
        text += f" case 1: ::{self._module}::{list_} kids; default: {self._type()} leaf; }};"
        self._names += [name, list_]
        return text

    def _valuetype(self) -> str:
        name = self._name("V")
        draw = self._random
        base = ""
        if self._values and draw.random() < 0.6:
            truncatable = "truncatable " if draw.random() < 0.5 else ""
            base = f" : {truncatable}{self._known(draw.choice(self._values))}"
        members = [
            self._declared(f"m{self._count}_{i}", self._type())
            for i in range(draw.randint(0, 3))
        ]
        if draw.random() < 0.7:
            other = draw.choice([name, *self._values])
            members.append(f"{self._known(other)} m{self._count}_next")
        state = "".join(f"{draw.choice(('public', 'private'))} {m}; " for m in members)
        self._names.append(name)
        self._values.append(name)
        return f"valuetype {name}; valuetype {name}{base} {{ {state}}};"

    def _box(self) -> str:
        """Return a box whose values are never one Python object for two values."""
        name = self._name("Q")
        structs = [self._known(n) for n in self._names if n[0] == "S"]
        kinds = ["string", "sequence<long>", *structs[:1]]
        text = f"valuetype {name} {self._random.choice(kinds)};"
        self._names.append(name)
        return text

    def _union(self) -> str:
        draw = self._random
        name = self._name("U")
        switch = draw.choice((*_SWITCHES, "enum", "enum", "inline", "named"))
        enum = draw.choice(list(self._enums))
        kind = written = switch
        match switch:
            case "enum":
                written, labels = self._known(enum), list(self._enums[enum])
            case "inline":
                labels = [f"i{self._count}_{i}" for i in range(draw.randint(1, 4))]
                written = f"enum {name}Kind {{ {', '.join(labels)} }}"
            case "named":
                alias = draw.choice(list(_NAMED_SWITCHES))
                written, kind = self._known(alias), _NAMED_SWITCHES[alias]
                labels = self._labels(kind)
            case _:
                labels = self._labels(kind)
        every = len(labels) if kind in ("enum", "inline", "boolean") else None
        draw.shuffle(labels)
        labels = labels[: draw.randint(1, 5)]
        may_have_default = every is None or len(labels) < every
        cases = []
        while labels:
            count = draw.choice((1, 1, 2))
            own, labels = labels[:count], labels[count:]
            cases.append("".join(f"case {label}: " for label in own))
        if may_have_default and draw.random() < 0.5:
            cases[-1] = (cases[-1] if draw.random() < 0.5 else "") + "default: "
        branches = [
            f"{labels_}{self._declared(f'm{i}', self._type())}; "
            for i, labels_ in enumerate(cases)
        ]
        text = f"union {name} switch ({written}) {{ {''.join(branches)}}};"
        self._names.append(name)
        return text

    def _labels(self, switch: str) -> list[str]:
        if switch == "boolean":
            return ["TRUE", "FALSE"]
        if switch == "char":
            return [r"'a'", r"'\0'", r"'\377'", r"'\n'", r"'z'", r"'\x80'"]
        if switch == "wchar":
            return ["L'a'", r"L'\u6f22'", r"L'\xff'", "L'z'"]
        bits = BITS[switch]
        if switch.startswith("unsigned"):
            return [str(n) for n in (0, 1, 2, 7, (1 << bits) - 1, 1 << bits - 1)]
        return [
            str(n) for n in (0, 1, -1, 7, (1 << bits - 1) - 1, -(1 << bits - 1) + 1)
        ]


class Values:
    """Draws values of descriptors.

    `anys` are the types that an `any` may hold, `references` the object references, beside nil.
    Without `state` all values of valuetypes are null. The number of parts is bounded.
    """

    def __init__(
        self,
        draw: random.Random,
        anys: list[Descriptor],
        *,
        state: bool = True,
        references: Sequence[ObjectReference] = (),
    ) -> None:
        self._random = draw
        self._references = (None, *references)
        self._state = state
        self._anys = anys
        self._shared: dict[str, list[Any]] = {}

    def value(self, descriptor: Descriptor, depth: int = 0) -> Any:
        """Return a value; it shares nothing with values drawn by another object."""
        draw = self._random
        match descriptor:
            case LinkDescriptor() | AliasDescriptor():
                return self.value(plain(descriptor), depth)
            case PrimitiveDescriptor(name):
                return self._primitive(name, depth)
            case StringDescriptor(wide, bound):
                return self._text(wide, 6 if bound is None else bound)
            case FixedDescriptor(digits, scale):
                most = 10 ** draw.choice((1, digits)) - 1
                number = draw.choice((0, most, -most, draw.randint(-most, most)))
                figures = tuple(map(int, str(abs(number))))
                return Decimal((int(number < 0), figures, -scale))
            case EnumDescriptor(members=members):
                return class_of(descriptor)(draw.choice(members)[1])
            case SequenceDescriptor(element, bound):
                most = 0 if depth > _DEEPEST else min(bound or 3, 3)
                count = draw.randint(0, most)
                items = self._items(element, count, depth)
                if bound is None and count and draw.random() < 0.03:
                    return self._repeated(element, items)
                return items
            case ArrayDescriptor(element, dimensions):
                return self._array(element, dimensions, depth)
            case StructDescriptor() | ExceptionDescriptor():
                parts = [self.value(m.type, depth + 1) for m in descriptor.members]
                return class_of(descriptor)(*parts)
            case UnionDescriptor():
                return self._union(descriptor, depth)
            case InterfaceDescriptor():
                return draw.choice(self._references)
            case ValueDescriptor():
                return self._valued(descriptor, depth)
            case BoxDescriptor(target=target):
                if depth > _DEEPEST or draw.random() < 0.2:
                    return None
                held = self.value(target, depth + 1)
                return self._reused(
                    descriptor, class_of(descriptor)(self._distinct(held))
                )
        raise TypeError(descriptor)

    def _distinct(self, held: Any) -> Any:
        """Texts of fewer than two characters are the same object in Python."""
        return f"{held}--" if isinstance(held, str) else held

    def _primitive(self, name: str, depth: int) -> Any:
        draw = self._random
        if name in BITS:
            bits = BITS[name]
            unsigned = name == "octet" or name.startswith("unsigned")
            low, high = (
                (0, (1 << bits) - 1)
                if unsigned
                else (-(1 << bits - 1), (1 << bits - 1) - 1)
            )
            return draw.choice((low, high, 0, 1, draw.randint(low, high)))
        match name:
            case "float":
                number = draw.choice((*_EDGES[:5], draw.uniform(-1e9, 1e9)))
                return struct.unpack("<f", struct.pack("<f", number))[0]
            case "double":
                return draw.choice((*_EDGES, float("inf"), draw.uniform(-1e300, 1e300)))
            case "boolean":
                return draw.random() < 0.5
            case "char":
                return draw.choice("\0aZ~\x80\xff")
            case "wchar":
                return draw.choice("aé漢\uffff")
            case "any":
                type_ = NULL if depth > _DEEPEST else draw.choice(self._anys)
                return AnyValue(type_, self.value(type_, depth + 1))
            case "CORBA::TypeCode":
                return draw.choice(self._anys)
            case "ValueBase":
                values = [t for t in self._anys if isinstance(t, ValueDescriptor)]
                return self._valued(draw.choice(values), depth) if values else None
            case "Object":
                return draw.choice(self._references)
        return None

    def _text(self, wide: bool, most: int) -> str:
        draw = self._random
        text = "".join(draw.choices(_TEXT, k=draw.randint(0, most)))
        while len(text.encode("utf-16-le" if wide else "utf-8")) // (1 + wide) > most:
            text = text[1:]
        return text

    def _items(self, element: Descriptor, count: int, depth: int) -> Any:
        items = [self.value(element, depth + 1) for _ in range(count)]
        match plain(element):
            case PrimitiveDescriptor("octet"):
                return bytes(items)
            case PrimitiveDescriptor("char"):
                return "".join(items)
            case PrimitiveDescriptor("unsigned long long"):
                # omniORBpy raises for larger ones in a sequence.
                return [item & (1 << 63) - 1 for item in items]
        return items

    def _repeated(self, element: Descriptor, items: Any) -> Any:
        """Return many items, unless they are objects that may be shared."""
        match plain(element):
            case PrimitiveDescriptor(name) if name not in ("any", "ValueBase"):
                return items * self._random.choice(_LONG)
            case StringDescriptor() | EnumDescriptor():
                return items * self._random.choice(_LONG)
        return items

    def _array(
        self, element: Descriptor, dimensions: tuple[int, ...], depth: int
    ) -> Any:
        first, *rest = dimensions
        if not rest:
            return self._items(element, first, depth)
        return [self._array(element, tuple(rest), depth) for _ in range(first)]

    def _union(self, descriptor: UnionDescriptor, depth: int) -> Any:
        draw = self._random
        labels = [label for branch in descriptor.branches for label in branch.labels]
        chosen = draw.choice([*labels, self.value(descriptor.switch)])
        if depth > _DEEPEST and descriptor.branches[0].name == "kids":
            chosen = 2
        branch = descriptor.branch(chosen)
        value = None if branch is None else self.value(branch.type, depth + 1)
        return class_of(descriptor)(chosen, value)

    def _reused(self, descriptor: Descriptor, made: Any) -> Any:
        """Return a previously drawn value, often."""
        pool = self._shared.setdefault(str(descriptor), [])
        if pool and self._random.random() < 0.3:
            return self._random.choice(pool)
        pool.append(made)
        return made

    def _valued(self, formal: ValueDescriptor, depth: int) -> Any:
        draw = self._random
        pool = self._shared.setdefault("values", [])
        fitting = [v for v in pool if v.described().is_a(formal.repository_id)]
        if fitting and draw.random() < 0.3:
            return draw.choice(fitting)
        if not self._state or depth > _DEEPEST or draw.random() < 0.15:
            return None
        derived = [
            t
            for t in self._anys
            if isinstance(t, ValueDescriptor) and t.is_a(formal.repository_id)
        ]
        chosen = draw.choice([formal, *derived])
        made = class_of(chosen)()
        pool.append(made)
        for member in chosen.all_members():
            setattr(made, member.attribute, self.value(member.type, depth + 1))
        return made
