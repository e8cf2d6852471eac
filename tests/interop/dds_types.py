"""Random sets of DDS types: as IDL for rtgen, as Python for cyclonedds, with random values.

A value is neutral: numbers, texts, lists, dicts; of a struct a dict by member name, of a union a
pair of discriminator and value, of an enum the name of a member, of a bitmask its number.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from hypothesis import strategies as st

INTEGERS = {
    "int8": ("int8", -(1 << 7), 1 << 7),
    "uint8": ("uint8", 0, 1 << 8),
    "octet": ("byte", 0, 1 << 8),
    "short": ("int16", -(1 << 15), 1 << 15),
    "unsigned short": ("uint16", 0, 1 << 16),
    "long": ("int32", -(1 << 31), 1 << 31),
    "unsigned long": ("uint32", 0, 1 << 32),
    "long long": ("int64", -(1 << 63), 1 << 63),
    "unsigned long long": ("uint64", 0, 1 << 64),
}
"""IDL name to cyclonedds's name and range."""

PRIMITIVES = {name: theirs for name, (theirs, _, _) in INTEGERS.items()} | {
    "float": "float32",
    "double": "float64",
    "boolean": "bool",
    "char": "char",
    "wchar": "wchar",
}
SWITCHES = ("boolean", "char", "short", "long", "unsigned long", "octet", "long long")


@dataclass(frozen=True)
class Basic:
    name: str


@dataclass(frozen=True)
class Text:
    bound: int | None = None


@dataclass(frozen=True)
class Sequence:
    element: Type
    bound: int | None = None


@dataclass(frozen=True)
class Array:
    element: Type
    dimensions: tuple[int, ...]


@dataclass(frozen=True)
class Map:
    key: Type
    value: Type


@dataclass(frozen=True)
class Enum:
    name: str
    members: tuple[str, ...]
    bound: int | None


@dataclass(frozen=True)
class Mask:
    name: str
    positions: tuple[int, ...]
    bound: int


@dataclass(frozen=True)
class Member:
    name: str
    type: Type
    id: int | None = None
    optional: bool = False
    key: bool = False
    must_understand: bool = False


@dataclass(frozen=True)
class Struct:
    name: str
    members: tuple[Member, ...]
    extensibility: str = "final"
    base: Struct | None = None
    hashed: bool = False

    @property
    def everything(self) -> tuple[Member, ...]:
        """The members, inherited ones first."""
        return (*(self.base.everything if self.base else ()), *self.members)


@dataclass(frozen=True)
class Case:
    labels: tuple[Any, ...]
    name: str
    type: Type


@dataclass(frozen=True)
class Union:
    name: str
    switch: Type
    cases: tuple[Case, ...]
    default: Case | None
    extensibility: str = "final"


@dataclass(frozen=True)
class Self:
    """The struct that contains the type."""

    name: str


Declared: TypeAlias = Enum | Mask | Struct | Union
Type: TypeAlias = Basic | Text | Sequence | Array | Map | Self | Declared


@dataclass
class Drawer:
    """Draws types that use previous declarations."""

    draw: Any
    declared: list[Declared] = field(default_factory=list)

    def one(self, *choices: Any) -> Any:
        return self.draw(st.sampled_from(choices))

    def flag(self, often: int = 2) -> bool:
        return bool(self.draw(st.integers(0, often - 1)) == 0)

    def number(self, low: int, high: int) -> int:
        return int(self.draw(st.integers(low, high)))

    def basic(self) -> Basic:
        return Basic(self.one(*PRIMITIVES))

    def type(self, depth: int = 2) -> Type:
        kinds = ["basic", "basic", "text"] + ["declared"] * (2 * bool(self.declared))
        if depth:
            kinds += ["sequence", "array", "map"]
        match self.one(*kinds):
            case "basic":
                return self.basic()
            case "text":
                return Text(self.one(None, 1, 5, 12))
            case "declared":
                declared: Declared = self.one(*self.declared)
                return declared
            case "sequence":
                return Sequence(self.type(depth - 1), self.one(None, None, 1, 4))
            case "array":
                dimensions = self.one((1,), (3,), (2, 2), (2, 1, 3))
                return Array(self.type(depth - 1), dimensions)
            case _:
                key = self.one("long", "short", "octet", "unsigned long long", "char")
                return Map(Basic(key), self.basic())

    def enum(self, name: str) -> Enum:
        members = tuple(f"{name}_{n}" for n in range(self.number(1, 5)))
        return Enum(name, members, self.one(None, 8, 16, 32))

    def mask(self, name: str) -> Mask:
        bound = self.one(4, 8, 12, 16, 20, 32, 64)
        flags = st.sets(st.integers(0, bound - 1), min_size=1, max_size=4)
        return Mask(name, tuple(sorted(self.draw(flags))), bound)

    def struct(self, name: str) -> Struct:
        extensibility = self.one("final", "appendable", "mutable")
        bases = [
            d
            for d in self.declared
            if isinstance(d, Struct)
            and d.extensibility == extensibility
            and not d.hashed
            and not any(_holds_self(m.type) for m in d.everything)
        ]
        base = self.one(*bases) if bases and self.flag(4) else None
        hashed = extensibility == "mutable" and base is None and self.flag(4)
        prefix = f"{name.lower()}_"
        members = [
            self.member(f"{prefix}{n}", extensibility, base is None)
            for n in range(self.number(1, 5))
        ]
        if extensibility == "mutable" and not hashed:
            members = self.identified(members, base)
        if base is None and self.flag(5):
            members.append(Member(f"{prefix}self", Sequence(Self(name), 2)))
        return Struct(name, tuple(members), extensibility, base, hashed)

    def member(self, name: str, extensibility: str, may_be_key: bool) -> Member:
        kind = self.one("plain", "plain", "plain", "optional", "key")
        return Member(
            name,
            self.type(),
            optional=kind == "optional",
            key=kind == "key" and may_be_key,
            must_understand=extensibility == "mutable" and self.flag(4),
        )

    def identified(self, members: list[Member], base: Struct | None) -> list[Member]:
        """Return the members, some with an explicit id; the ids rise, so that they are unique."""
        following = len(base.everything) * 1000 if base else 0
        numbered = []
        for member in members:
            if (base is not None and member is members[0]) or self.flag(3):
                following += self.number(0, 300)
                numbered.append(replace(member, id=following))
            else:
                numbered.append(member)
            following += 1
        return numbered

    def union(self, name: str) -> Union:
        enums = [d for d in self.declared if isinstance(d, Enum)]
        switch: Type = Basic(self.one(*SWITCHES))
        if enums and self.flag():
            switch = self.one(*enums)
        values = labels_of(switch)
        # cyclonedds needs a branch for each value of a boolean.
        number = self.number(
            1, 1 if switch == Basic("boolean") else min(4, len(values))
        )
        cases = []
        for n in range(number):
            taken = (values[n],)
            if n == number - 1 and len(values) > number + 1 and self.flag():
                taken = (values[n], values[n + 1])
            cases.append(Case(taken, f"{name.lower()}_{n}", self.type(1)))
        used = {label for case in cases for label in case.labels}
        default = None
        if any(value not in used for value in values) and self.flag():
            default = Case((), f"{name.lower()}_other", self.type(1))
        return Union(
            name, switch, tuple(cases), default, self.one("final", "appendable")
        )

    def declaration(self, name: str) -> Declared:
        kind = self.one("enum", "mask", "struct", "struct", "struct", "union", "union")
        made: Declared = getattr(self, kind)(name)
        return made


def _holds_self(type_: Type) -> bool:
    return isinstance(type_, Sequence) and isinstance(type_.element, Self)


@st.composite
def type_sets(draw: Any) -> tuple[Declared, ...]:
    """Draw a few declarations, each of which may use earlier ones; the last is a struct."""
    drawer = Drawer(draw)
    for n in range(draw(st.integers(2, 6))):
        drawer.declared.append(drawer.declaration(f"T{n}"))
    drawer.declared.append(drawer.struct("Last"))
    return tuple(drawer.declared)


def labels_of(switch: Type) -> list[Any]:
    """Return as many values of a discriminator as needed."""
    match switch:
        case Enum(members=members):
            return list(members)
        case Basic("boolean"):
            return [True, False]
        case Basic("char"):
            return list("abcxyz")
        case Basic("octet" | "unsigned long"):
            return [0, 1, 7, 200, 255]
    return [-3, 0, 1, 1000, 32767]


# IDL.


class Idl:
    """The text of a set of types."""

    def __init__(self, declared: tuple[Declared, ...]) -> None:
        self._aliases: list[str] = []
        self._lines: list[str] = []
        self._number = 0
        for declaration in declared:
            text = self._declaration(declaration)
            self._lines += [*self._aliases, text]
            self._aliases = []

    @property
    def text(self) -> str:
        return "\n".join(self._lines) + "\n"

    def _declaration(self, declared: Declared) -> str:
        match declared:
            case Enum(name, members, bound):
                head = "" if bound is None else f"@bit_bound({bound}) "
                return f"{head}enum {name} {{ {', '.join(members)} }};"
            case Mask(name, positions, bound):
                flags = ", ".join(f"@position({p}) {name}_{p}" for p in positions)
                return f"@bit_bound({bound}) bitmask {name} {{ {flags} }};"
            case Struct(name, members, extensibility, base, hashed):
                head = f"@{extensibility} " + "@autoid(HASH) " * hashed
                colon = f" : {base.name}" if base else ""
                body = " ".join(map(self._member, members))
                return f"struct {name};\n{head}struct {name}{colon} {{ {body} }};"
            case Union(name, switch, cases, default, extensibility):
                body = "".join(self._case(case, switch) for case in cases)
                if default is not None:
                    body += f"default: {self._declarator(default.type, default.name)}; "
                head = f"@{extensibility} union {name} switch ({self._name(switch)})"
                return f"{head} {{ {body}}};"

    def _member(self, member: Member) -> str:
        text = "" if member.id is None else f"@id({member.id}) "
        text += "@optional " * member.optional + "@key " * member.key
        text += "@must_understand " * member.must_understand
        return f"{text}{self._declarator(member.type, member.name)};"

    def _case(self, case: Case, switch: Type) -> str:
        labels = "".join(f"case {_label(switch, label)}: " for label in case.labels)
        return f"{labels}{self._declarator(case.type, case.name)}; "

    def _declarator(self, type_: Type, name: str) -> str:
        if isinstance(type_, Array):
            dimensions = "".join(f"[{n}]" for n in type_.dimensions)
            return f"{self._name(type_.element)} {name}{dimensions}"
        return f"{self._name(type_)} {name}"

    def _name(self, type_: Type) -> str:
        match type_:
            case Text(bound):
                return "string" if bound is None else f"string<{bound}>"
            case Sequence(element, bound):
                more = "" if bound is None else f", {bound}"
                return f"sequence<{self._name(element)}{more}>"
            case Map(key, value):
                return f"map<{self._name(key)}, {self._name(value)}>"
            case Array():
                self._number += 1
                alias = f"A{self._number}"
                self._aliases.append(f"typedef {self._declarator(type_, alias)};")
                return alias
        return type_.name


def _label(switch: Type, label: Any) -> str:
    if isinstance(switch, Enum):
        return str(label)
    if isinstance(label, bool):
        return "TRUE" if label else "FALSE"
    return f"'{label}'" if isinstance(label, str) else str(label)


# Python for cyclonedds.

_HEADER = """\
from dataclasses import dataclass
from typing import Dict, Optional
from cyclonedds.idl import IdlBitmask, IdlEnum, IdlStruct, IdlUnion
from cyclonedds.idl import annotations as a
from cyclonedds.idl import types as t

"""


def cyclone_text(declared: tuple[Declared, ...]) -> str:
    """Return a module with the same types for cyclonedds, as its compiler would write it."""
    return _HEADER + "\n".join(map(_cyclone_class, declared))


def _cyclone_class(declared: Declared) -> str:
    match declared:
        case Enum(name, members, bound):
            head = "" if bound is None else f"@a.bit_bound({bound})\n"
            body = [f"{member} = {n}" for n, member in enumerate(members)]
            return f"{head}class {name}(IdlEnum, typename='{name}'):{_body(body)}"
        case Mask(name, positions, bound):
            body = []
            for position in positions:
                body += [
                    f"{name}_{position}: bool = False",
                    f"a.position('{name}_{position}', {position})",
                ]
            # The bound must be known when the positions are checked.
            body.insert(0, f"__idl_annotations__['bit_bound'] = {bound}")
            head = f"@dataclass\nclass {name}(IdlBitmask, typename='{name}')"
            return f"{head}:{_body(body)}"
        case Struct(name, members, extensibility, base, hashed):
            head = f"@dataclass\n@a.{extensibility}\n"
            head += "@a.autoid('hash')\n" * hashed
            body = []
            for member in members:
                body += _cyclone_member(member)
            bases = base.name if base else "IdlStruct"
            return f"{head}class {name}({bases}, typename='{name}'):{_body(body)}"
        case Union(name, switch, cases, default, extensibility):
            body = []
            for case in cases:
                labels = ", ".join(
                    _cyclone_label(switch, label) for label in case.labels
                )
                kind = _cyclone_type(case.type)
                body.append(f"{case.name}: t.case[[{labels}], {kind}]")
            if default is not None:
                body.append(f"{default.name}: t.default[{_cyclone_type(default.type)}]")
            return (
                f"@a.{extensibility}\nclass {name}(IdlUnion, typename='{name}',"
                f" discriminator={_cyclone_type(switch)}):{_body(body)}"
            )


def _body(lines: list[str]) -> str:
    return "".join(f"\n    {line}" for line in lines) + "\n"


def _cyclone_member(member: Member) -> list[str]:
    kind = _cyclone_type(member.type)
    if member.optional:
        kind = f"Optional[{kind}]"
    lines = [f"{member.name}: {kind}"]
    if member.id is not None:
        lines.append(f"a.member_id('{member.name}', {member.id})")
    if member.key:
        lines.append(f"a.key('{member.name}')")
    if member.must_understand:
        lines.append(f"a.must_understand('{member.name}')")
    return lines


def _cyclone_type(type_: Type) -> str:
    match type_:
        case Basic("boolean"):
            return "bool"
        case Basic(name):
            return f"t.{PRIMITIVES[name]}"
        case Text(bound):
            return "str" if bound is None else f"t.bounded_str[{bound}]"
        case Sequence(element, bound):
            more = "" if bound is None else f", {bound}"
            return f"t.sequence[{_cyclone_type(element)}{more}]"
        case Array(element, dimensions):
            text = _cyclone_type(element)
            for length in reversed(dimensions):
                text = f"t.array[{text}, {length}]"
            return text
        case Map(key, value):
            return f"Dict[{_cyclone_type(key)}, {_cyclone_type(value)}]"
        case Self(name):
            return f"'{name}'"
    return type_.name


def _cyclone_label(switch: Type, label: Any) -> str:
    return f"{switch.name}.{label}" if isinstance(switch, Enum) else repr(label)


# Values.


class Values:
    """Draws neutral values of types, small ones mostly."""

    def __init__(self, draw: random.Random) -> None:
        self._random = draw

    def of(self, type_: Type, depth: int = 0, owner: Struct | None = None) -> Any:
        """Return a value; recursive types become smaller with the depth."""
        rand = self._random
        match type_:
            case Basic(name):
                return self._basic(name)
            case Text(bound):
                return self._text(bound)
            case Sequence(element, bound):
                most = 0 if depth > 3 else min(4 if bound is None else bound, 4)
                return [
                    self.of(element, depth + 1, owner)
                    for _ in range(rand.randint(0, most))
                ]
            case Array(element, dimensions):
                return self._array(element, dimensions, depth, owner)
            case Map(key, value):
                keys = {self._basic_key(key) for _ in range(rand.randint(0, 3))}
                return {k: self.of(value, depth + 1) for k in sorted(keys)}
            case Enum(members=members):
                return rand.choice(members)
            case Mask(positions=positions):
                return sum(1 << p for p in positions if rand.random() < 0.5)
            case Struct(members=members):
                return {
                    m.name: (
                        None
                        if m.optional and rand.random() < 0.4
                        else self.of(m.type, depth + 1, type_)
                    )
                    for m in type_.everything
                }
            case Union():
                return self._union(type_, depth)
            case Self():
                assert owner is not None
                return self.of(owner, depth + 1)

    def _basic(self, name: str) -> Any:
        rand = self._random
        if name in INTEGERS:
            _, low, beyond = INTEGERS[name]
            choices = (low, beyond - 1, 0, 1, rand.randrange(low, beyond))
            return max(low, rand.choice(choices))
        match name:
            case "boolean":
                return rand.random() < 0.5
            case "char":
                return chr(rand.randrange(128))
            case "wchar":
                return chr(rand.choice((0, 65, 0xE9, 0x3042, rand.randrange(0x8000))))
            case "float":
                number = rand.choice((0.0, -1.5, rand.uniform(-1e30, 1e30)))
                return struct.unpack("<f", struct.pack("<f", number))[0]
        return rand.choice((0.0, -2.5, float("inf"), rand.uniform(-1e300, 1e300)))

    def _basic_key(self, key: Type) -> Any:
        assert isinstance(key, Basic)
        return self._basic(key.name)

    def _text(self, bound: int | None) -> str:
        alphabet = "abc xyz" if bound is not None else "ab\u00e9\u3042\U0001f600"
        most = 6 if bound is None else bound
        return "".join(
            self._random.choice(alphabet) for _ in range(self._random.randint(0, most))
        )

    def _array(
        self, element: Type, dimensions: tuple[int, ...], depth: int, owner: Any
    ) -> Any:
        if not dimensions:
            return self.of(element, depth + 1, owner)
        return [
            self._array(element, dimensions[1:], depth, owner)
            for _ in range(dimensions[0])
        ]

    def _union(self, union: Union, depth: int) -> Any:
        used = {label: case for case in union.cases for label in case.labels}
        labels = labels_of(union.switch)
        if union.extensibility == "appendable" and union.default is None:
            # For any other discriminator, cyclonedds reads its default.
            labels = list(used)
        label = self._random.choice(labels)
        case = used.get(label, union.default)
        if case is None:
            return (label, None)
        return (label, self.of(case.type, depth + 1))


# Neutral values on either side.


def to_ours(type_: Type, value: Any, module: Any) -> Any:
    """Return the value as an instance of the generated class."""
    match type_:
        case Sequence(element) | Array(element, (_,)) if _is_text(element):
            return "".join(value) if element == Basic("char") else bytes(value)
        case Sequence(element):
            return [_ours(element, item, module, type_) for item in value]
        case Array(element, dimensions):
            inner = Array(element, dimensions[1:]) if dimensions[1:] else element
            return [to_ours(inner, item, module) for item in value]
        case Map(value=item):
            return {k: to_ours(item, v, module) for k, v in value.items()}
        case Enum(name):
            return getattr(module, name)[value]
        case Mask(name):
            return getattr(module, name)(value)
        case Struct(name):
            fields = {
                m.name: (
                    None
                    if value[m.name] is None
                    else _ours(m.type, value[m.name], module, type_)
                )
                for m in type_.everything
            }
            return getattr(module, name)(**fields)
        case Union(name, switch):
            label, content = value
            case = _case(type_, label)
            inner = None if case is None else to_ours(case.type, content, module)
            return getattr(module, name)(to_ours(switch, label, module), inner)
    return value


def to_theirs(type_: Type, value: Any, module: Any) -> Any:
    """Return the value as an instance of the class of cyclonedds."""
    match type_:
        case Basic("wchar"):
            return ord(value)
        case Sequence(element) if isinstance(element, Self):
            owner = module.__dict__["OWNERS"][element.name]
            return [to_theirs(owner, item, module) for item in value]
        case Sequence(element):
            return [to_theirs(element, item, module) for item in value]
        case Array(element, dimensions):
            inner = Array(element, dimensions[1:]) if dimensions[1:] else element
            return [to_theirs(inner, item, module) for item in value]
        case Map(key, item):
            return {
                to_theirs(key, k, module): to_theirs(item, v, module)
                for k, v in value.items()
            }
        case Enum(name):
            return getattr(module, name)[value]
        case Mask(name):
            return getattr(module, name).from_mask(value)
        case Struct(name):
            fields = {
                m.name: (
                    None
                    if value[m.name] is None
                    else to_theirs(m.type, value[m.name], module)
                )
                for m in type_.everything
            }
            return getattr(module, name)(**fields)
        case Union(name, switch):
            label, content = value
            case = _case(type_, label)
            inner = None if case is None else to_theirs(case.type, content, module)
            discriminator = to_theirs(switch, label, module)
            return getattr(module, name)(discriminator=discriminator, value=inner)
    return value


def from_theirs(type_: Type, value: Any, module: Any) -> Any:
    """Return the neutral value of an instance of cyclonedds."""
    match type_:
        case Basic("wchar"):
            return chr(value)
        case Sequence(element) if isinstance(element, Self):
            owner = module.__dict__["OWNERS"][element.name]
            return [from_theirs(owner, item, module) for item in value]
        case Sequence(element):
            return [from_theirs(element, item, module) for item in value]
        case Array(element, dimensions):
            inner = Array(element, dimensions[1:]) if dimensions[1:] else element
            return [from_theirs(inner, item, module) for item in value]
        case Map(key, item):
            return {
                from_theirs(key, k, module): from_theirs(item, v, module)
                for k, v in value.items()
            }
        case Enum():
            return value.name
        case Mask():
            return value.as_mask()
        case Struct():
            fields = {m: getattr(value, m.name) for m in type_.everything}
            return {
                m.name: None if item is None else from_theirs(m.type, item, module)
                for m, item in fields.items()
            }
        case Union(switch=switch):
            label = from_theirs(switch, value.discriminator, module)
            case = _case(type_, label)
            inner = (
                None if case is None else from_theirs(case.type, value.value, module)
            )
            return (label, inner)
    return value


def _ours(type_: Type, value: Any, module: Any, owner: Any) -> Any:
    if isinstance(type_, Sequence) and isinstance(type_.element, Self):
        return [to_ours(owner, item, module) for item in value]
    return to_ours(type_, value, module)


def _is_text(element: Type) -> bool:
    return element in (Basic("octet"), Basic("uint8"), Basic("char"))


def _case(union: Union, label: Any) -> Case | None:
    for case in union.cases:
        if label in case.labels:
            return case
    return union.default


def parts(type_: Any) -> Iterator[Any]:
    """Yield the type and every type in it."""
    yield type_
    match type_:
        case Sequence(element) | Array(element):
            yield from parts(element)
        case Map(key, value):
            yield from parts(key)
            yield from parts(value)
        case Struct():
            for member in type_.everything:
                yield from parts(member.type)
        case Union(switch=switch, cases=cases, default=default):
            yield from parts(switch)
            for case in (*cases, *([default] if default else [])):
                yield from parts(case.type)
