"""Random types with defaults, in IDL, and the values with which they start.

Values are in a normal form: enumerators are names, flags numbers, octets lists, characters texts,
structs dicts, unions `[discriminator, branch or None, value]`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import count
from math import prod
from random import Random
from typing import Any

_INTEGERS = {
    "short": (-(2**15), 2**15 - 1),
    "unsigned short": (0, 2**16 - 1),
    "long": (-(2**31), 2**31 - 1),
    "unsigned long": (0, 2**32 - 1),
    "long long": (-(2**63), 2**63 - 1),
    "unsigned long long": (0, 2**64 - 1),
    "octet": (0, 255),
    "int8": (-128, 127),
    "uint8": (0, 255),
}
_LETTERS = "abcXYZ 01,.'_"


@dataclass(frozen=True)
class Kind:
    """A type: its text before and after the name of a member, and the value it starts with.

    `literal` draws a default as `(annotation's argument, item of a text, value)`; None if the type
    can have none. `joined`: an array of it is a text. `character`: so is the default of one.
    `portable`: it has a codec in TypeScript.
    """

    text: str
    initial: Any
    literal: Callable[[], tuple[str, str, Any]] | None = None
    dimensions: str = ""
    joined: bool = False
    character: bool = False
    portable: bool = True
    basic: bool = True
    named_list: bool = False


@dataclass(frozen=True)
class Member:
    """A member or a branch: its declaration, name, and what it starts with."""

    text: str
    name: str
    initial: Any
    portable: bool


@dataclass(frozen=True)
class Struct:
    """A struct of the test; `old` are the members that its older version has."""

    name: str
    extensibility: str
    members: tuple[Member, ...]
    old: tuple[Member, ...]
    portable: bool

    @property
    def initial(self) -> dict[str, Any]:
        return {member.name: member.initial for member in self.members}


@dataclass
class Definitions:
    """IDL, drawn declaration by declaration."""

    random: Random
    lines: list[str] = field(default_factory=list)
    structs: list[Struct] = field(default_factory=list)
    _kinds: list[Kind] = field(default_factory=list)
    _numbers: Any = field(default_factory=count)

    def draw(self, structs: int) -> None:
        """Add types up to that many structs."""
        while len(self.structs) < structs:
            self.random.choice(
                (self._enum, self._mask, self._typedef, self._union)
                + (self._struct,) * 4
            )()

    @property
    def idl(self) -> str:
        return "\n".join(self.lines) + "\n"

    def _name(self, prefix: str) -> str:
        return f"{prefix}{next(self._numbers)}"

    # Types.

    def _scalar(self) -> Kind:
        draw = self.random
        known = [kind for kind in self._kinds if kind.literal and kind.basic]
        if known and draw.random() < 0.4:
            return draw.choice(known)
        match draw.randrange(6):
            case 0:
                text = draw.choice(["float", "double"])
                return Kind(text, 0.0, self._real)
            case 1:
                return Kind("boolean", False, self._boolean)
            case 2:
                wide = draw.random() < 0.3
                text = "wchar" if wide else "char"
                return Kind(
                    text,
                    "\0",
                    lambda: self._character(wide),
                    joined=not wide,
                    character=True,
                )
            case 3:
                wide, bound = draw.random() < 0.3, draw.choice(["", "<12>"])
                text = ("wstring" if wide else "string") + bound
                return Kind(text, "", lambda: self._string(wide))
        text = draw.choice([*_INTEGERS])
        return Kind(text, 0, lambda: self._integer(*_INTEGERS[text]))

    def _integer(self, low: int, high: int) -> tuple[str, str, int]:
        near = self.random.randint(max(low, -9), min(high, 9))
        value = self.random.choice([low, high, near, near])
        return str(value), str(value), value

    def _real(self) -> tuple[str, str, float]:
        value = self.random.randint(-64, 64) / 4
        return str(value), str(value), value

    def _boolean(self) -> tuple[str, str, bool]:
        value = self.random.random() < 0.5
        return str(value).upper(), self.random.choice([str(value), f"{value:d}"]), value

    def _character(self, wide: bool) -> tuple[str, str, str]:
        value = self.random.choice("abcxyz09")
        return f"{'L' * wide}'{value}'", value, value

    def _string(self, wide: bool) -> tuple[str, str, str]:
        value = "".join(self.random.choices(_LETTERS, k=self.random.randint(0, 9)))
        literal = f'{"L" * wide}"{value}"'
        quoted = "'" + value.replace("'", "\\\\'") + "'"
        return literal, quoted, value

    def _list(self) -> Kind:
        """A sequence or array of scalars, with a text as its default."""
        draw, element = self.random, self._scalar()
        shape = [draw.randint(1, 3) for _ in range(draw.choice([1, 1, 2]))]
        is_sequence = draw.random() < 0.5
        if is_sequence:
            bound = draw.choice(["", ", 4"])
            text, dimensions = f"sequence<{element.text}{bound} >", ""
            initial: Any = "" if element.joined else []
        else:
            text, dimensions = element.text, "".join(f"[{n}]" for n in shape)
            initial = _nested([element.initial] * prod(shape), shape, element.joined)

        def literal() -> tuple[str, str, Any]:
            assert element.literal is not None
            size = draw.randint(0, 4) if is_sequence else prod(shape)
            drawn = [element.literal() for _ in range(size)]
            values = [value for *_, value in drawn]
            nest = [size] if is_sequence else shape
            value = _nested(values, nest, element.joined)
            if element.character:
                return f'"{"".join(values)}"', "", value
            inner = draw.choice([", ", ","]).join(item for _, item, _ in drawn)
            opened, closed = draw.choice(["", "()", "[]"]) or (" ", " ")
            return f'"{opened}{inner}{closed}"', "", value

        return Kind(
            text,
            initial,
            literal,
            dimensions,
            portable=element.portable,
            basic=False,
        )

    def _composite(self) -> Kind:
        """A list of structs, an array of lists, a map, or a struct itself."""
        draw = self.random
        known = self._kinds
        if draw.random() < 0.3:
            known = [kind for kind in known if kind.named_list]
        if not known:
            return self._list()
        element = draw.choice(known)
        match draw.randrange(4):
            case 0:
                size = draw.randint(1, 3)
                initial = _nested([element.initial] * size, [size], element.joined)
                return Kind(
                    element.text,
                    initial,
                    None,
                    f"[{size}]",
                    portable=element.portable,
                )
            case 1:
                text = f"sequence<{element.text} >"
                start: Any = "" if element.joined else []
                return Kind(text, start, None, portable=element.portable)
            case 2:
                text = f"map<long, {element.text} >"
                return Kind(text, [], None, portable=element.portable)
        return element

    def _kind(self) -> Kind:
        return self.random.choice((self._scalar, self._list, self._composite))()

    # Declarations.

    def _enum(self) -> None:
        draw, name = self.random, self._name("E")
        names = [f"{name}_{letter}" for letter in "ABCD"[: draw.randint(1, 4)]]
        marked = draw.choice([None, *names])
        words = [f"{'@default_literal ' * (n == marked)}{n}" for n in names]
        self.lines.append(f"enum {name} {{ {', '.join(words)} }};")

        def literal() -> tuple[str, str, str]:
            value = draw.choice(names)
            return value, draw.choice([value, f"R::{value}"]), value

        self._kinds.append(Kind(f"R::{name}", marked or names[0], literal))

    def _mask(self) -> None:
        draw, name = self.random, self._name("M")
        flags = {f"{name}_{letter}": place for place, letter in enumerate("ABC")}
        bits = draw.choice([3, 8, 16, 32, 64])
        self.lines.append(
            f"@bit_bound({bits}) bitmask {name} {{ {', '.join(flags)} }};"
        )

        def literal() -> tuple[str, str, int]:
            chosen = draw.sample([*flags], draw.randint(1, 3))
            number = sum(1 << flags[each] for each in chosen)
            text = draw.choice([" | ".join(chosen), str(number)])
            return text, text, number

        self._kinds.append(Kind(f"R::{name}", 0, literal))

    def _typedef(self) -> None:
        kind, name = self._kind(), self._name("T")
        given, initial = self._default(kind)
        self.lines.append(f"{given}typedef {kind.text} {name}{kind.dimensions};")
        self._kinds.append(
            Kind(
                f"R::{name}",
                initial,
                kind.literal,
                joined=kind.joined,
                character=kind.character,
                portable=kind.portable,
                basic=kind.basic and kind.literal is not None,
                named_list=not kind.basic and kind.literal is not None,
            )
        )

    def _default(self, kind: Kind, chance: float = 0.6) -> tuple[str, Any]:
        """Return the annotation of a default, or nothing, and the value started with."""
        if kind.literal is None or self.random.random() > chance:
            return "", kind.initial
        literal, _, value = kind.literal()
        key = self.random.choice(["", "", "value="])
        return f"@default({key}{literal}) ", value

    def _member(self, name: str, optional: bool = False) -> Member:
        kind = self._kind()
        given, initial = ("@optional ", None) if optional else self._default(kind)
        text = f"{given}{kind.text} {name}{kind.dimensions};"
        return Member(text, name, initial, kind.portable)

    def _bitset(self) -> Kind:
        draw, name = self.random, self._name("B")
        fields, initial = [], {}
        for number in range(draw.randint(1, 4)):
            bits, signed = draw.randint(2, 8), draw.random() < 0.5
            low = -(1 << bits - 1) if signed else 0
            value = draw.choice([0, low, low + (1 << bits) - 1])
            given = f"@default({value}) " if value or draw.random() < 0.5 else ""
            type_ = ",short" if signed else ""
            fields.append(f"{given}bitfield<{bits}{type_}> f{number};")
            initial[f"f{number}"] = value
        self.lines.append(f"bitset {name} {{ {' '.join(fields)} }};")
        return Kind(f"R::{name}", initial, None, portable=False, basic=False)

    def _union(self) -> None:
        draw, name = self.random, self._name("U")
        choices: list[tuple[str, list[str], list[Any], Any]] = [
            ("long", ["0", "1", "2", "7"], [0, 1, 2, 7], 0),
            ("boolean", ["FALSE", "TRUE"], [False, True], False),
            ("char", ["'a'", "'\\0'", "'b'"], ["a", "\0", "b"], "\0"),
        ]
        enums = [k for k in self._kinds if "::E" in k.text]
        if enums:
            enum = draw.choice(enums)
            stem = enum.text.partition("::")[2]
            names = [
                f"{stem}_{letter}"
                for letter in "ABCD"
                if any(f"{stem}_{letter}" in line for line in self.lines)
            ]
            choices.append((enum.text, names, names, enum.initial))
        switch, texts, values, first = draw.choice(choices)
        order = draw.sample(range(len(texts)), draw.randint(1, len(texts)))
        rest = draw.random() < 0.4 and len(order) < len(texts)
        branches, found = [], [first, None, None]
        members = [self._member(f"b{number}") for number in range(len(order))]
        for place, member in zip(order, members, strict=True):
            branches.append(f"case {texts[place]}: {member.text}")
            if values[place] == first:
                found = [first, member.name, member.initial]
        if rest:
            members.append(self._member("other"))
            branches.append(f"default: {members[-1].text}")
            if found[1] is None:
                found = [first, "other", members[-1].initial]
        evolving = draw.choice(["@final", "@appendable"])
        body = " ".join(branches)
        self.lines.append(f"{evolving} union {name} switch ({switch}) {{ {body} }};")
        portable = all(member.portable for member in members)
        self._kinds.append(
            Kind(f"R::{name}", found, None, portable=portable, basic=False)
        )

    def _struct(self) -> None:
        draw, name = self.random, self._name("S")
        extensibility = draw.choice(["final", "appendable", "appendable", "mutable"])
        members: list[Member] = []
        for number in range(draw.randint(1, 7)):
            optional = draw.random() < 0.1
            member = self._member(f"m{number}", optional)
            if draw.random() < 0.05:
                kind = self._bitset()
                text = f"{kind.text} {member.name};"
                member = Member(text, member.name, kind.initial, False)
            members.append(member)
        kept = draw.randint(0, len(members))
        old = tuple(members[:kept])
        portable = extensibility != "mutable" and all(m.portable for m in members)
        hashed = "@autoid(HASH) "
        if extensibility == "mutable":
            old = tuple(m for m in members if draw.random() < 0.5)
        base = ""
        split = draw.randint(0, len(members))
        if draw.random() < 0.2:
            parent = self._name("P")
            head = "".join(m.text for m in members[:split])
            self.lines.append(f"{hashed}@{extensibility} struct {parent} {{ {head} }};")
            base = f" : {parent}"
        body = "".join(m.text for m in members[split if base else 0 :])
        self.lines.append(f"{hashed}@{extensibility} struct {name}{base} {{ {body} }};")
        before = "".join(m.text for m in old)
        self.lines.append(f"{hashed}@{extensibility} struct {name}Old {{ {before} }};")
        made = Struct(name, extensibility, tuple(members), old, portable)
        self.structs.append(made)
        self._kinds.append(
            Kind(f"R::{name}", made.initial, None, portable=portable, basic=False)
        )


def _nested(items: Sequence[Any], dimensions: Sequence[int], joined: bool) -> Any:
    """Nest items that are in a row; those of the last dimension are a text if `joined`."""
    if len(dimensions) == 1:
        return "".join(items) if joined else list(items)
    step = len(items) // dimensions[0]
    return [
        _nested(items[at : at + step], dimensions[1:], joined)
        for at in range(0, len(items), step)
    ]
