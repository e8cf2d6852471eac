"""Random definitions of types and changes of them, as IDL."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field
from random import Random

BASIC = (
    *("octet", "boolean", "char", "short", "unsigned short", "long", "unsigned long"),
    *("long long", "float", "double", "int8", "uint8"),
)
EXTENSIBILITIES = ("", "@appendable ", "@mutable ")


@dataclass
class Member:
    """A member or branch; `number` is an explicit id, `dimension` that of an array."""

    name: str
    type: str
    dimension: int = 0
    optional: bool = False
    number: int | None = None
    labels: tuple[int, ...] = ()

    def text(self) -> str:
        """Return the declaration in IDL."""
        number = "" if self.number is None else f"@id({self.number}) "
        optional = "@optional " * self.optional
        array = f"[{self.dimension}]" * bool(self.dimension)
        labels = "".join(f"case {label}: " for label in self.labels)
        return f"{labels}{number}{optional}{self.type} {self.name}{array};"


@dataclass
class Composite:
    """A struct, or a union that switches on a `long`."""

    name: str
    extensibility: str
    members: list[Member]
    union: bool = False

    def text(self) -> str:
        """Return the declaration in IDL."""
        inner = " ".join(member.text() for member in self.members)
        head = "union" if self.union else "struct"
        switch = " switch (long)" * self.union
        return f"{self.extensibility}{head} {self.name}{switch} {{ {inner} }};\n"


@dataclass
class Definitions:
    """An enum, a bitmask, and composites, which may use earlier ones."""

    enumerators: list[tuple[str, int]]
    bound: int
    composites: list[Composite] = field(default_factory=list)
    names: int = 0

    def text(self) -> str:
        """Return the definitions in IDL."""
        listed = ", ".join(f"@value({n}) {name}" for name, n in self.enumerators)
        head = f"@bit_bound({self.bound}) enum Mode {{ {listed} }};\n"
        return head + "".join(c.text() for c in self.composites)

    def fresh(self, prefix: str) -> str:
        """Return an unused name."""
        self.names += 1
        return f"{prefix}_{self.names}"


class Drawing:
    """Draws definitions and changes."""

    def __init__(self, random: Random) -> None:
        self._random = random

    def definitions(self) -> Definitions:
        """Return three structs and a union."""
        random = self._random
        made = Definitions(
            [("RED", 0), ("GREEN", 1), ("BLUE", 5)], random.choice((8, 16, 32))
        )
        for name, union in (("Inner", 0), ("Choice", 1), ("Middle", 0), ("Outer", 0)):
            ext = random.choice(EXTENSIBILITIES)
            composite = Composite(name, ext, [], bool(union))
            for _ in range(random.randint(1, 4)):
                composite.members.append(self.member(made, composite))
            made.composites.append(composite)
        return made

    def member(self, of: Definitions, composite: Composite) -> Member:
        """Return a member of previously declared types."""
        random = self._random
        name = of.fresh("m")
        dimension = random.choice((0, 0, 0, 0, 2, 3))
        if composite.union:
            used = {label for m in composite.members for label in m.labels}
            labels = random.sample([n for n in range(9) if n not in used], 1)
            return Member(name, self.type(of, composite), 0, labels=tuple(labels))
        optional = random.random() < 0.12
        number = None
        if composite.extensibility == "@mutable " and random.random() < 0.5:
            taken = {m.number for m in composite.members}
            number = random.choice([n for n in range(40, 90) if n not in taken])
        type_ = self.type(of, composite)
        return Member(name, type_, 0 if optional else dimension, optional, number)

    def type(self, of: Definitions, composite: Composite) -> str:
        """Return a type expression."""
        random = self._random
        known = [c.name for c in of.composites if c.name != composite.name]
        choice = random.random()
        if choice < 0.45:
            return random.choice(BASIC)
        if choice < 0.6:
            return random.choice(("string", "string<3>", "string<4>"))
        if choice < 0.7:
            return "Mode"
        if choice < 0.85 and known:
            return random.choice(known)
        bound = random.choice(("", "", ", 2", ", 3"))
        inner = random.choice([*BASIC, "string", "Mode", *known])
        return f"sequence<{inner}{bound}>"

    def changed(self, of: Definitions) -> Definitions:
        """Return the definitions with one to three changes."""
        made = deepcopy(of)
        for _ in range(self._random.choice((1, 1, 1, 2, 3))):
            self._change(made)
        return made

    def _change(self, of: Definitions) -> None:
        random = self._random
        composite = random.choice(of.composites)
        members = composite.members
        before = of.composites[: of.composites.index(composite)]
        member = random.choice(members)
        place = members.index(member)
        narrowed = Definitions(of.enumerators, of.bound, before, of.names)
        match random.choice(
            (
                *("append", "append", "append", "insert", "remove", "remove_last"),
                *("rename", "swap", "type", "type", "optional", "extensibility"),
                *("id", "enum", "bound", "dimension", "label"),
            )
        ):
            case "append":
                members.append(self.member(narrowed, composite))
            case "insert":
                members.insert(place, self.member(narrowed, composite))
            case "remove" if len(members) > 1:
                members.remove(member)
            case "remove_last" if len(members) > 1:
                members.pop()
            case "rename":
                member.name = narrowed.fresh("r")
            case "swap" if len(members) > 1:
                other = random.randrange(len(members))
                members[place], members[other] = members[other], members[place]
            case "type":
                member.type = self.type(narrowed, composite)
            case "optional" if not composite.union and not member.dimension:
                member.optional = not member.optional
            case "extensibility":
                composite.extensibility = random.choice(EXTENSIBILITIES)
            case "id" if not composite.union:
                taken = {m.number for m in members}
                member.number = random.choice(
                    [n for n in range(40, 90) if n not in taken]
                )
            case "enum":
                self._enum(of)
            case "bound":
                of.bound = random.choice((8, 16, 32))
            case "dimension" if not composite.union and not member.optional:
                member.dimension = random.choice((0, 2, 3))
            case "label" if composite.union:
                used = {label for m in members for label in m.labels}
                member.labels += (
                    random.choice([n for n in range(20) if n not in used]),
                )
        of.names = max(of.names, narrowed.names)

    def _enum(self, of: Definitions) -> None:
        random = self._random
        listed = of.enumerators
        match random.choice(("add", "remove", "rename", "number")):
            case "add":
                listed.append((of.fresh("E"), max(n for _, n in listed) + 1))
            case "remove" if len(listed) > 1:
                listed.pop(random.randrange(len(listed)))
            case "rename":
                place = random.randrange(len(listed))
                listed[place] = (of.fresh("E"), listed[place][1])
            case "number":
                listed[-1] = (listed[-1][0], listed[-1][1] + 1)
